//! Values on a grid, shown as colours between two axes.

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::{Rgb, RgbImage, imageops};
use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::HPos;

use super::axis::Scale;
use super::canvas::{Canvas, Pen};
use super::chart_layout::{EDGE, LABEL, LEADING, NOTE, TICK, TICK_GAP, TITLE, with_power};
use super::colour_scale::{ColourScale, Colours, Ruler};
use super::figure::{self, Figure, ImageFormat};
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
    /// The scale of the colours; a logarithmic one spans six decades below the largest value at most,
    /// and smaller values have the first colour.
    pub(crate) scale: Scale,
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
    /// Writes the map as `.svg`, in which the cells are an embedded picture, or as `.png`.
    ///
    /// # Errors
    /// When the extension is another one or the file cannot be written.
    pub(crate) fn render(&self, path: &Path) -> Result<(), PlotError> {
        let bytes = match ImageFormat::of_path(path) {
            Some(ImageFormat::Svg) => self.svg()?.into_bytes(),
            Some(ImageFormat::Png) => figure::encoded(&self.raster()?)?,
            None => return Err(PlotError::UnknownExtension { path: path.display().to_string() }),
        };
        Ok(AtomicFile::write_whole(path, &bytes)?)
    }

    /// Returns the finished picture: the map keeps its pixels, and only lines and letters are
    /// smoothed.
    pub(super) fn raster(&self) -> Result<RgbImage, PlotError> {
        let layout = Layout::new(self);
        let legend = ColourScale::new(&self.values, self.colours, self.scale);
        let mut sheet = figure::raster(&Scaffold { map: self, layout: &layout, legend: &legend })?;
        for (cells, frame) in self.pictures(&layout, &legend) {
            let (place, size) = (frame.corner(), frame.size());
            // Cells larger than a pixel have sharp borders; a pixel that covers smaller ones shows
            // their mean.
            let filter = if shrinks(&cells, size) {
                imageops::FilterType::Triangle
            } else {
                imageops::FilterType::Nearest
            };
            let filled = imageops::resize(&cells, size.0, size.1, filter);
            imageops::replace(&mut sheet, &filled, place.0.into(), place.1.into());
        }
        for &ring in &self.rings {
            draw_ring(&mut sheet, self.place(ring, layout.map));
        }
        Ok(sheet)
    }

    /// Returns the document with the cells as pictures.
    pub(super) fn svg(&self) -> Result<String, PlotError> {
        let layout = Layout::new(self);
        let legend = ColourScale::new(&self.values, self.colours, self.scale);
        let document = figure::svg(&Scaffold { map: self, layout: &layout, legend: &legend })?;
        let zoom = figure::SVG_ZOOM;
        let mut parts = String::new();
        for (cells, frame) in self.pictures(&layout, &legend) {
            let ((x, y), size) = (frame.corner(), frame.size());
            let rendering = if shrinks(&cells, size) { "auto" } else { "pixelated" };
            parts += &format!(
                "<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\" \
                 style=\"image-rendering:{rendering}\" href=\"data:image/png;base64,{}\"/>\n",
                x * zoom,
                y * zoom,
                size.0 * zoom,
                size.1 * zoom,
                STANDARD.encode(figure::encoded(&cells)?),
            );
        }
        let [red, green, blue] = RING_COLOUR;
        for &ring in &self.rings {
            let ((x, y), zoom) = (self.place(ring, layout.map), f64::from(zoom));
            parts += &format!(
                "<circle cx=\"{:.0}\" cy=\"{:.0}\" r=\"{:.0}\" fill=\"none\" \
                 stroke=\"#{red:02x}{green:02x}{blue:02x}\" stroke-width=\"{:.0}\"/>\n",
                x * zoom,
                y * zoom,
                RING.0 * zoom,
                RING.1 * zoom,
            );
        }
        Ok(document.replacen("</svg>", &(parts + "</svg>"), 1))
    }

    /// Returns width and height of the figure.
    pub(super) fn size_in_units(&self) -> (u32, u32) {
        Layout::new(self).size_in_pixels()
    }

    /// Returns the cells of the map and of the colour scale, a pixel each, with their frames.
    fn pictures(&self, layout: &Layout, legend: &ColourScale) -> [(RgbImage, Frame); 2] {
        let [columns, rows] = self.size.map(whole);
        let cells = RgbImage::from_fn(columns, rows, |x, y| {
            let value = self.values.get(y as usize * self.size[0] + x as usize);
            match value.filter(|x| x.is_finite()) {
                Some(&value) => self.colours.at(legend.place(value)),
                None => Rgb([255; 3]),
            }
        });
        let bar = RgbImage::from_fn(1, STEPS, |_, y| {
            self.colours.at(1.0 - f64::from(y) / f64::from(STEPS - 1))
        });
        [(cells, layout.map), (bar, layout.bar)]
    }

    /// Returns the position of values of x and y in the frame of the map.
    fn place(&self, (x, y): (f64, f64), frame: Frame) -> (f64, f64) {
        let along = |at: f64, (first, last): (f64, f64)| (at - first) / (last - first);
        // Rows go down, as in the frame's coordinates.
        (frame.x(along(x, self.x.range)), frame.y(1.0 - along(y, self.y.range)))
    }
}

/// Returns whether a picture has more pixels than the size in which it is shown.
fn shrinks(cells: &RgbImage, size: (u32, u32)) -> bool {
    cells.width() > size.0 || cells.height() > size.1
}

impl Frame {
    /// Returns the upper left pixel.
    fn corner(&self) -> (u32, u32) {
        (pixel(self.left), pixel(self.top))
    }

    /// Returns width and height in pixels, at least 1.
    fn size(&self) -> (u32, u32) {
        let extent = |first: f64, last: f64| (pixel(last).saturating_sub(pixel(first))).max(1);
        (extent(self.left, self.right), extent(self.top, self.bottom))
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

    fn size_in_pixels(&self) -> (u32, u32) {
        (pixel(self.size.0), pixel(self.size.1))
    }
}

/// All parts except the colours.
struct Scaffold<'a> {
    map: &'a HeatMap,
    layout: &'a Layout,
    legend: &'a ColourScale,
}

impl Figure for Scaffold<'_> {
    fn size(&self) -> (u32, u32) {
        self.layout.size_in_pixels()
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
        let x = Ruler::new(self.map.x.range);
        for (at, label) in &x.ticks {
            let at = frame.left + at * (frame.right - frame.left);
            let foot = frame.bottom + 1.0;
            canvas.line(&[(at, foot), (at, foot + 5.0)], Pen::new(INK, 1.0))?;
            let y = foot + TICK_GAP + 0.5 * TICK;
            canvas.text(label, (at, y), TICK, INK, HPos::Center)?;
        }
        let y = Ruler::new(self.map.y.range);
        for (at, label) in &y.ticks {
            let at = frame.top + at * (frame.bottom - frame.top);
            let side = frame.left - 1.0;
            canvas.line(&[(side, at), (side - 5.0, at)], Pen::new(INK, 1.0))?;
            canvas.text(label, (side - TICK_GAP, at), TICK, INK, HPos::Right)?;
        }
        let colours = &self.legend.ruler;
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

    use super::{Colours, Edges, HeatMap, RING_COLOUR, Scale};

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
            scale: Scale::Linear,
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
