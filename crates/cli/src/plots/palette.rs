//! Colours and marker shapes that are distinguishable with every kind of colour vision on white
//! paper.

use plotters::style::RGBColor;

/// Colours with a contrast to white of at least 3, so that thin lines and letters are legible. The
/// first three are from Okabe and Ito, "Color Universal Design" (2008); the others maximize the
/// smallest distance between any two, for normal, protan and deutan colour vision.
pub(super) const COLOURS: [RGBColor; 7] = [
    RGBColor(0x00, 0x72, 0xb2),
    RGBColor(0xd5, 0x5e, 0x00),
    RGBColor(0x00, 0x9e, 0x73),
    RGBColor(0xd6, 0x5c, 0xe8),
    RGBColor(0x72, 0x4f, 0x00),
    RGBColor(0xa2, 0x00, 0x6e),
    RGBColor(0x4a, 0x12, 0xd0),
];

/// The number of curves of a chart that have a colour each.
pub(crate) const MAX_COLOURS: usize = COLOURS.len();

/// The size of lines and markers of the user's patterns.
const USER_SIZE: f64 = 1.4;

/// Text and frame.
pub(super) const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
/// Notes and outlines.
pub(super) const GREY: RGBColor = RGBColor(0x66, 0x66, 0x66);
/// Curves beyond those that have colours.
pub(super) const OTHERS: RGBColor = RGBColor(0x84, 0x84, 0x84);
/// Grid lines at labelled ticks.
pub(super) const GRID: RGBColor = RGBColor(0xe2, 0xe2, 0xe2);

/// The colour and marker of a series.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ink {
    /// The importance from 0: the first seven have a colour each, the others are grey with hollow
    /// markers.
    Rank(usize),
    /// The number from 0 among the user's own patterns: black with thick lines and large markers.
    User(usize),
    /// Black, for series outside of a family of curves.
    Black,
}

impl Ink {
    /// Returns the colour.
    pub(super) fn colour(self) -> RGBColor {
        match self {
            Self::Rank(rank) => COLOURS.get(rank).copied().unwrap_or(OTHERS),
            Self::User(_) | Self::Black => INK,
        }
    }

    /// Returns the shape of markers.
    pub(super) fn marker(self) -> Marker {
        match self {
            Self::Rank(rank) => MARKERS[rank % MARKERS.len()],
            // From the star, which no other curve has unless there are eight.
            Self::User(number) => MARKERS[MARKERS.len() - 1 - number % MARKERS.len()],
            Self::Black => Marker::Disc,
        }
    }

    /// Returns the size of lines and markers relative to those of other curves.
    pub(super) fn size(self) -> f64 {
        if matches!(self, Self::User(_)) { USER_SIZE } else { 1.0 }
    }

    /// Returns whether markers are outlines.
    pub(super) fn is_hollow(self) -> bool {
        matches!(self, Self::Rank(rank) if rank >= COLOURS.len())
    }
}

/// Returns a rank for each value, for [`Ink::Rank`]: the position in the list, unless there are
/// more values than colours; then the smallest values have the first ranks. NaN is greater than all
/// numbers.
fn ranks(values: &[f64]) -> Vec<usize> {
    let mut by_value: Vec<usize> = (0..values.len()).collect();
    // The sign of a NaN has no meaning.
    let key = |i: usize| if values[i].is_nan() { f64::INFINITY } else { values[i] };
    by_value.sort_by(|&a, &b| key(a).total_cmp(&key(b)));
    let mut has_colour = vec![false; values.len()];
    for &place in by_value.iter().take(COLOURS.len()) {
        has_colour[place] = true;
    }
    let (mut next, mut next_grey) = (0, COLOURS.len());
    let rank = |has_colour| {
        let counter = if has_colour { &mut next } else { &mut next_grey };
        *counter += 1;
        *counter - 1
    };
    has_colour.into_iter().map(rank).collect()
}

/// Returns the ink of each curve: the user's own, marked in `are_own`, have a style apart, and the
/// others the [`ranks`] of their values.
pub(crate) fn inks(values: &[f64], are_own: &[bool]) -> Vec<Ink> {
    let of_others = values.iter().zip(are_own).filter(|(_, is_own)| !**is_own);
    let mut others = ranks(&of_others.map(|(value, _)| *value).collect::<Vec<_>>()).into_iter();
    let mut own = 0..;
    let mut ink = |is_own: &bool| {
        let next = if *is_own { own.next().map(Ink::User) } else { others.next().map(Ink::Rank) };
        next.unwrap_or(Ink::Black)
    };
    are_own.iter().map(&mut ink).collect()
}

/// The note on charts with the user's own patterns.
pub(crate) const NOTE_OF_OWN: &str = "Black: points from files.";

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

#[cfg(test)]
mod tests {
    use super::*;

    /// Linear red, green and blue.
    fn linear(colour: RGBColor) -> [f64; 3] {
        [colour.0, colour.1, colour.2].map(|c| {
            let c = f64::from(c) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        })
    }

    fn times(matrix: [[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
        matrix.map(|row| row.iter().zip(v).map(|(a, b)| a * b).sum())
    }

    /// Returns the distance in Oklab, in which differences of about 0.02 are just noticeable.
    fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
        let lab = |rgb| {
            let lms = times(
                [
                    [0.4122214708, 0.5363325363, 0.0514459929],
                    [0.2119034982, 0.6806995451, 0.1073969566],
                    [0.0883024619, 0.2817188376, 0.6299787005],
                ],
                rgb,
            );
            times(
                [
                    [0.2104542553, 0.7936177850, -0.0040720468],
                    [1.9779984951, -2.4285922050, 0.4505937099],
                    [0.0259040371, 0.7827717662, -0.8086757660],
                ],
                lms.map(|x: f64| x.max(0.0).cbrt()),
            )
        };
        let (a, b) = (lab(a), lab(b));
        a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    }

    #[test]
    fn curves_contrast_with_paper() {
        for colour in COLOURS.into_iter().chain([OTHERS, INK, GREY]) {
            let [r, g, b] = linear(colour);
            let contrast = 1.05 / (0.2126 * r + 0.7152 * g + 0.0722 * b + 0.05);
            assert!(contrast >= 3.0, "{colour:?}: {contrast}");
        }
    }

    #[test]
    fn colours_differ_for_every_kind_of_vision() {
        // Machado, Oliveira and Fernandes (2009), severity 1: none, protanopia, deuteranopia.
        let visions = [
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            [
                [0.152286, 1.052583, -0.204868],
                [0.114503, 0.786281, 0.099216],
                [-0.003882, -0.048116, 1.051998],
            ],
            [
                [0.367322, 0.860646, -0.227968],
                [0.280085, 0.672501, 0.047413],
                [-0.011820, 0.042940, 0.968881],
            ],
        ];
        for vision in visions {
            let seen = COLOURS.map(|c| times(vision, linear(c)).map(|x| x.clamp(0.0, 1.0)));
            for (i, &a) in seen.iter().enumerate() {
                for &b in &seen[..i] {
                    assert!(distance(a, b) > 0.08, "{a:?} and {b:?}: {}", distance(a, b));
                }
            }
        }
    }

    #[test]
    fn own_patterns_do_not_take_colours() {
        let values = [3.0, 0.1, 1.0, 0.2, 2.0];
        let expected = [Ink::Rank(0), Ink::User(0), Ink::Rank(1), Ink::User(1), Ink::Rank(2)];
        assert_eq!(inks(&values, &[false, true, false, true, false]), expected);
        assert!(Ink::User(0).marker() != Ink::User(1).marker() && !Ink::User(9).is_hollow());
    }

    #[test]
    fn smallest_values_have_colours() {
        assert_eq!(ranks(&[3.0, f64::NAN, 1.0]), [0, 1, 2]);
        let values = [9.0, 1.0, f64::NAN, 2.0, 8.0, 3.0, 4.0, 5.0, 6.0];
        assert_eq!(ranks(&values), [7, 0, 8, 1, 2, 3, 4, 5, 6]);
        for rank in ranks(&values) {
            let is_grey = Ink::Rank(rank).colour() == OTHERS;
            assert_eq!(is_grey, Ink::Rank(rank).is_hollow());
        }
    }
}
