//! Values on a grid, shown as colours between two axes.

use std::path::Path;

use image::{Rgb, RgbImage, imageops};
use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::HPos;

use super::axis::Axis;
use super::canvas::{Canvas, Pen};
use super::chart_layout::{EDGE, LABEL, LEADING, NOTE, TICK, TICK_GAP, TITLE, with_power};
use super::figure::{self, Figure};
use super::palette::{GREY, INK};
use super::plane::Frame;
use super::plot_error::PlotError;
use crate::files::AtomicFile;

/// Values on a grid, row by row from the top.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct HeatMap {
    /// The heading.
    pub(crate) title: String,
    /// Small lines at the foot.
    pub(crate) notes: Vec<String>,
    /// Columns and rows, at least 1.
    pub(crate) size: [usize; 2],
    /// The values; values that are not finite stay white.
    pub(crate) values: Vec<f64>,
    /// The quantity, shown beside the colour scale.
    pub(crate) label: String,
    /// The colours.
    pub(crate) colours: Colours,
    /// Quantity from left to right, with the values at the left and right edges.
    pub(crate) x: Edges,
    /// Quantity from top to bottom, with the values at the top and bottom edges.
    pub(crate) y: Edges,
    /// Centres of rings around cells of interest, in values of x and y.
    pub(crate) rings: Vec<(f64, f64)>,
}

/// A side of the grid.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Edges {
    /// The quantity.
    pub(crate) label: String,
    /// Its values at the first and the last edge.
    pub(crate) range: (f64, f64),
}

/// The colour scale.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Colours {
    /// Dark for 0 to bright yellow for the largest value.
    Heat,
    /// Black for 0 to white for the largest value.
    Grey,
    /// Red for minus the largest magnitude over white for 0 to blue for the largest magnitude.
    Signed,
}

impl Colours {
    /// Returns the values of the first and last colour.
    fn range(self, values: &[f64]) -> (f64, f64) {
        let finite = || values.iter().filter(|x| x.is_finite());
        let size = match self {
            Self::Heat | Self::Grey => finite().fold(0.0, |a: f64, &b| a.max(b)),
            Self::Signed => finite().fold(0.0, |a: f64, &b| a.max(b.abs())),
        };
        let size = if size > 0.0 { size } else { 1.0 };
        match self {
            Self::Heat | Self::Grey => (0.0, size),
            Self::Signed => (-size, size),
        }
    }

    /// Returns the colour at a position from 0 to 1.
    fn at(self, place: f64) -> Rgb<u8> {
        let gradient = match self {
            Self::Heat => colorous::INFERNO,
            // The gradient of that name runs from white to black.
            Self::Grey => colorous::GREYS,
            Self::Signed => colorous::RED_BLUE,
        };
        let place = if self == Self::Grey { 1.0 - place } else { place };
        Rgb(gradient.eval_continuous(place.clamp(0.0, 1.0)).into_array())
    }
}

/// The maximum width and height of a map, in pixels.
const MAX_SIZE: (f64, f64) = (620.0, 600.0);
/// The minimum width of a figure, which headings need.
const MIN_WIDTH: f64 = 640.0;
/// The width of the colour scale, and its distance from the map.
const BAR: (f64, f64) = (22.0, 22.0);
/// The space for the labels of the scale.
const BAR_LABELS: f64 = 96.0;
/// The number of rows of the colour scale.
const STEPS: u32 = 256;
/// The radius and width of rings, in pixels.
const RING: (f64, f64) = (7.0, 2.0);
/// Orange, legible on all scales.
const RING_COLOUR: [u8; 3] = [0xff, 0x8c, 0x00];

impl HeatMap {
    /// Writes the map as PNG.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub(crate) fn render(&self, path: &Path) -> Result<(), PlotError> {
        Ok(AtomicFile::write_whole(path, &figure::encoded(&self.raster()?)?)?)
    }

    /// Returns the finished picture: the map keeps its pixels, and only lines and letters are
    /// smoothed.
    pub(super) fn raster(&self) -> Result<RgbImage, PlotError> {
        let range = self.colours.range(&self.values);
        let place = |value: f64| (value - range.0) / (range.1 - range.0);
        let layout = Layout::new(self);
        let mut sheet = figure::raster(&Scaffold { map: self, layout: &layout, range })?;
        let [columns, rows] = self.size.map(whole);
        let cells = RgbImage::from_fn(columns, rows, |x, y| {
            let value = self.values.get(y as usize * self.size[0] + x as usize);
            match value.filter(|x| x.is_finite()) {
                Some(&value) => self.colours.at(place(value)),
                None => Rgb([255; 3]),
            }
        });
        let bar = RgbImage::from_fn(1, STEPS, |_, y| {
            self.colours.at(1.0 - f64::from(y) / f64::from(STEPS - 1))
        });
        for (cells, frame) in [(cells, layout.map), (bar, layout.bar)] {
            let [left, top, right, bottom] =
                [frame.left, frame.top, frame.right, frame.bottom].map(pixel);
            let size = ((right - left).max(1), (bottom - top).max(1));
            // Cells larger than a pixel have sharp borders; a pixel that covers smaller ones shows
            // their mean.
            let shrinks = cells.width() > size.0 || cells.height() > size.1;
            let filter = if shrinks {
                imageops::FilterType::Triangle
            } else {
                imageops::FilterType::Nearest
            };
            let filled = imageops::resize(&cells, size.0, size.1, filter);
            imageops::replace(&mut sheet, &filled, left.into(), top.into());
        }
        for &(x, y) in &self.rings {
            let along = |at: f64, (first, last): (f64, f64)| (at - first) / (last - first);
            let (x, y) = (along(x, self.x.range), along(y, self.y.range));
            let frame = layout.map;
            // Rows go down, as in the frame's coordinates.
            draw_ring(&mut sheet, (frame.x(x), frame.y(1.0 - y)));
        }
        Ok(sheet)
    }
}

/// Draws a ring with smooth edges; pixels outside the sheet are omitted.
fn draw_ring(sheet: &mut RgbImage, (x, y): (f64, f64)) {
    let reach = RING.0 + RING.1;
    let span = |at: f64| pixel(at - reach)..=pixel(at + reach);
    for (column, row) in span(x).flat_map(|column| span(y).map(move |row| (column, row))) {
        let from_centre = (f64::from(column) + 0.5 - x).hypot(f64::from(row) + 0.5 - y);
        let cover = (0.5 + 0.5 * RING.1 - (from_centre - RING.0).abs()).clamp(0.0, 1.0);
        if let Some(Rgb(below)) = sheet.get_pixel_mut_checked(column, row) {
            for (channel, ring) in below.iter_mut().zip(RING_COLOUR) {
                let mixed = f64::from(*channel) * (1.0 - cover) + f64::from(ring) * cover;
                *channel = u8::try_from(pixel(mixed)).unwrap_or(u8::MAX);
            }
        }
    }
}

/// The positions of the map and the colour scale.
struct Layout {
    map: Frame,
    bar: Frame,
    /// Width and height of the whole figure.
    size: (f64, f64),
}

impl Layout {
    fn new(map: &HeatMap) -> Self {
        let left = EDGE + LABEL * LEADING + 4.0 + 56.0 + TICK_GAP;
        // The space suffices for two lines of heading and two of remarks.
        let top = EDGE + 2.0 * TITLE * LEADING + 6.0;
        let [columns, rows] = map.size.map(|n| n.max(1) as f64);
        let cell = (MAX_SIZE.0 / columns).min(MAX_SIZE.1 / rows);
        // Cells of whole pixels have equal sizes.
        let cell = if cell >= 1.0 { cell.floor() } else { cell };
        let frame = Frame {
            left,
            right: left + (cell * columns).round(),
            top: top.round(),
            bottom: top.round() + (cell * rows).round(),
        };
        let left = frame.right + BAR.1;
        let bar = Frame { left, right: left + BAR.0, ..frame };
        let below = TICK_GAP + TICK * LEADING + LABEL * LEADING + 14.0 + 2.0 * NOTE * LEADING;
        let width = (bar.right + BAR_LABELS + LABEL + EDGE).max(MIN_WIDTH);
        Self { map: frame, bar, size: (width, frame.bottom + below + EDGE) }
    }
}

/// All parts except the colours.
struct Scaffold<'a> {
    map: &'a HeatMap,
    layout: &'a Layout,
    range: (f64, f64),
}

impl Figure for Scaffold<'_> {
    fn size(&self) -> (u32, u32) {
        (pixel(self.layout.size.0), pixel(self.layout.size.1))
    }

    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Result<(), PlotError> {
        let Layout { map: frame, bar, size: (width, height) } = self.layout;
        for (row, line) in
            (0_u8..).zip(canvas.wrap(&self.map.title, TITLE, width - 2.0 * EDGE)?.iter().take(2))
        {
            let y = EDGE + TITLE * (0.5 + LEADING * f64::from(row));
            canvas.text(line, (0.5 * width, y), TITLE, INK, HPos::Center)?;
        }
        let mut notes = Vec::new();
        for note in &self.map.notes {
            notes.extend(canvas.wrap(note, NOTE, width - 2.0 * EDGE)?);
        }
        let first = height - EDGE - NOTE * LEADING * (notes.len() as f64 - 0.5);
        for (row, line) in (0_u8..).zip(&notes) {
            let y = first + NOTE * LEADING * f64::from(row);
            canvas.text(line, (EDGE, y), NOTE, GREY, HPos::Left)?;
        }
        for area in [frame, bar] {
            let Frame { left, right, top, bottom } = *area;
            let (left, right) = (left - 1.0, right + 1.0);
            let (top, bottom) = (top - 1.0, bottom + 1.0);
            let corners = [(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
            for side in corners.windows(2) {
                canvas.line(side, Pen::new(INK, 1.0))?;
            }
        }
        let x = Ruler::new(self.map.x.range, 7);
        for (at, label) in &x.ticks {
            let at = frame.left + at * (frame.right - frame.left);
            let foot = frame.bottom + 1.0;
            canvas.line(&[(at, foot), (at, foot + 5.0)], Pen::new(INK, 1.0))?;
            let y = foot + TICK_GAP + 0.5 * TICK;
            canvas.text(label, (at, y), TICK, INK, HPos::Center)?;
        }
        let y = Ruler::new(self.map.y.range, 7);
        for (at, label) in &y.ticks {
            let at = frame.top + at * (frame.bottom - frame.top);
            let side = frame.left - 1.0;
            canvas.line(&[(side, at), (side - 5.0, at)], Pen::new(INK, 1.0))?;
            canvas.text(label, (side - TICK_GAP, at), TICK, INK, HPos::Right)?;
        }
        let colours = Ruler::new((self.range.1, self.range.0), 7);
        for (at, label) in &colours.ticks {
            let at = bar.top + at * (bar.bottom - bar.top);
            let side = bar.right + 1.0;
            canvas.line(&[(side, at), (side + 5.0, at)], Pen::new(INK, 1.0))?;
            canvas.text(label, (side + TICK_GAP, at), TICK, INK, HPos::Left)?;
        }
        let middle = f64::midpoint(frame.left, frame.right);
        let below = frame.bottom + TICK_GAP + TICK * LEADING + LABEL * 0.5 + 4.0;
        let label = with_power(&self.map.x.label, x.power);
        canvas.text(&label, (middle, below), LABEL, INK, HPos::Center)?;
        let middle = f64::midpoint(frame.top, frame.bottom);
        let label = with_power(&self.map.y.label, y.power);
        canvas.text_upwards(&label, (EDGE + 0.5 * LABEL, middle), LABEL, INK)?;
        let label = with_power(&self.map.label, colours.power);
        let beside = bar.right + BAR_LABELS;
        canvas.text_upwards(&label, (beside, middle), LABEL, INK)
    }
}

/// Labelled ticks between two values in either order.
struct Ruler {
    /// Positions from 0 (the first value) to 1.
    ticks: Vec<(f64, String)>,
    power: Option<i32>,
}

impl Ruler {
    fn new((first, last): (f64, f64), max_labels: u32) -> Self {
        let (low, high) = (first.min(last), first.max(last));
        if !(low.is_finite() && high > low) {
            return Self { ticks: Vec::new(), power: None };
        }
        let axis = Axis::between(low, high, max_labels);
        let place = |at: f64| if first < last { at } else { 1.0 - at };
        let ticks = axis.ticks.into_iter().map(|tick| (place(tick.at), tick.label)).collect();
        Self { ticks, power: axis.power }
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a place on the sheet, which is some hundred pixels wide"
)]
fn pixel(at: f64) -> u32 {
    at.max(0.0).round() as u32
}

/// Returns the number of columns or rows of a map, cut to the largest size that fits.
fn whole(n: usize) -> u32 {
    u32::try_from(n).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use image::Rgb;

    use super::{Colours, Edges, HeatMap, RING_COLOUR};

    /// Returns a black map of 4 x 4 cells over x and y from -2 to 2, y upwards.
    fn map(rings: Vec<(f64, f64)>) -> HeatMap {
        let edges = |range| Edges { label: String::new(), range };
        HeatMap {
            title: String::new(),
            notes: Vec::new(),
            size: [4, 4],
            values: vec![0.0; 16],
            label: String::new(),
            colours: Colours::Grey,
            x: edges((-2.0, 2.0)),
            y: edges((2.0, -2.0)),
            rings,
        }
    }

    /// Returns the mean position of the pixels of rings.
    fn centre(map: &HeatMap) -> Option<(f64, f64)> {
        let sheet = map.raster().unwrap();
        let of_ring = sheet.enumerate_pixels().filter(|p| *p.2 == Rgb(RING_COLOUR));
        let places: Vec<_> = of_ring.map(|(x, y, _)| (f64::from(x), f64::from(y))).collect();
        let n = places.len() as f64;
        let sum = places.iter().fold((0.0, 0.0), |sum, p| (sum.0 + p.0, sum.1 + p.1));
        (n > 0.0).then_some((sum.0 / n, sum.1 / n))
    }

    #[test]
    fn rings_are_around_their_values() {
        assert_eq!(centre(&map(Vec::new())), None);
        let middle = centre(&map(vec![(0.0, 0.0)])).unwrap();
        // Cells of 150 pixels, up to a pixel.
        let moved = centre(&map(vec![(1.0, 1.5)])).unwrap();
        let (right, up) = (moved.0 - middle.0, middle.1 - moved.1);
        assert!((right - 150.0).abs() < 1.0 && (up - 225.0).abs() < 1.0, "{right} {up}");
        // Outside of the sheet nothing is drawn.
        assert_eq!(centre(&map(vec![(1e9, 0.0), (f64::NAN, 0.0)])), None);
    }
}
