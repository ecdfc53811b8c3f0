//! Colours and marker shapes that stay apart for every kind of colour vision and in grey.

use plotters::style::RGBColor;

/// The colours of Okabe and Ito, "Color Universal Design" (2008), the darkest first; yellow comes
/// last because a thin yellow line is hard to see on white.
const COLOURS: [RGBColor; 8] = [
    RGBColor(0x00, 0x72, 0xb2),
    RGBColor(0xd5, 0x5e, 0x00),
    RGBColor(0x00, 0x9e, 0x73),
    RGBColor(0xcc, 0x79, 0xa7),
    RGBColor(0x00, 0x00, 0x00),
    RGBColor(0x56, 0xb4, 0xe9),
    RGBColor(0xe6, 0x9f, 0x00),
    RGBColor(0xf0, 0xe4, 0x42),
];

/// Text and frame.
pub(super) const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
/// Notes and outlines.
pub(super) const GREY: RGBColor = RGBColor(0x66, 0x66, 0x66);
/// Grid lines at labelled ticks.
pub(super) const GRID: RGBColor = RGBColor(0xd9, 0xd9, 0xd9);
/// Grid lines between labelled ticks.
pub(super) const FINE_GRID: RGBColor = RGBColor(0xef, 0xef, 0xef);

/// The outline of a marker around the origin, with half a side of about 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Marker {
    /// A filled circle.
    Disc,
    /// A filled polygon.
    Polygon(&'static [(i8, i8)]),
}

/// The filled polygons, in percent of the marker's radius; y points down.
const MARKERS: [Marker; 8] = [
    Marker::Disc,
    Marker::Polygon(&[(-90, -90), (90, -90), (90, 90), (-90, 90)]),
    Marker::Polygon(&[(0, -120), (112, 80), (-112, 80)]),
    Marker::Polygon(&[(0, -127), (100, 0), (0, 127), (-100, 0)]),
    Marker::Polygon(&[(0, 120), (112, -80), (-112, -80)]),
    Marker::Polygon(&[
        (-35, -115),
        (35, -115),
        (35, -35),
        (115, -35),
        (115, 35),
        (35, 35),
        (35, 115),
        (-35, 115),
        (-35, 35),
        (-115, 35),
        (-115, -35),
        (-35, -35),
    ]),
    Marker::Polygon(&[(0, -120), (114, -37), (71, 97), (-71, 97), (-114, -37)]),
    Marker::Polygon(&[
        (0, -127),
        (32, -44),
        (121, -39),
        (51, 17),
        (75, 103),
        (0, 54),
        (-75, 103),
        (-51, 17),
        (-121, -39),
        (-32, -44),
    ]),
];

/// Returns the colour of an index; after eight they repeat.
pub(super) fn colour(index: usize) -> RGBColor {
    COLOURS[index % COLOURS.len()]
}

/// Returns the marker of an index; the second eight colours meet other markers than the first.
pub(super) fn marker(index: usize) -> Marker {
    MARKERS[(index + index / COLOURS.len()) % MARKERS.len()]
}
