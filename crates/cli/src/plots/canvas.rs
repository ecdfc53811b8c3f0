//! A drawing surface in figure units (one unit is one pixel of the finished PNG).

use std::sync::OnceLock;

use plotters::coord::Shift;
use plotters::prelude::{
    BLACK, Circle, Color, DrawingArea, DrawingBackend, FontTransform, IntoFont, PathElement,
    Polygon, RGBColor, ShapeStyle, Text, TextStyle, WHITE,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontStyle, register_font};

use super::palette::Marker;
use super::plot_error::PlotError;

/// The font families of the SVG, in order of preference. The first two have the same letter widths
/// as the font in PNG files.
const FAMILY: &str = "DejaVu Sans, Verdana, sans-serif";
/// The ratio of a font's size in the drawing library to the height of its em.
const SIZE_PER_EM: f64 = 1.24;

/// A colour, an opacity in [0, 1] and a line width in figure units.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pen {
    pub(super) colour: RGBColor,
    pub(super) opacity: f64,
    pub(super) width: f64,
}

impl Pen {
    /// Returns an opaque pen.
    pub(super) fn new(colour: RGBColor, width: f64) -> Self {
        Self { colour, opacity: 1.0, width }
    }
}

/// A surface of the drawing library that multiplies every coordinate by `zoom`: the library uses
/// whole pixels, and the zoom makes them smaller than the eye can resolve.
pub(super) struct Canvas<DB: DrawingBackend> {
    area: DrawingArea<DB, Shift>,
    zoom: f64,
    text_drop: f64,
}

impl<DB: DrawingBackend> Canvas<DB> {
    /// Returns a white canvas. `text_drop` is the distance, in ems, by which the backend places the
    /// middle of a line of text below the middle of its digits.
    pub(super) fn new(
        area: DrawingArea<DB, Shift>,
        zoom: f64,
        text_drop: f64,
    ) -> Result<Self, PlotError> {
        ensure_font()?;
        area.fill(&WHITE).map_err(drawing)?;
        Ok(Self { area, zoom, text_drop })
    }

    /// Completes the image.
    pub(super) fn finish(self) -> Result<(), PlotError> {
        self.area.present().map_err(drawing)
    }

    #[expect(
        clippy::cast_possible_truncation,
        reason = "a cast from float to integer saturates, and figures are some thousand units wide"
    )]
    fn whole(&self, length: f64) -> i32 {
        (length * self.zoom).round() as i32
    }

    fn pixel(&self, (x, y): (f64, f64)) -> (i32, i32) {
        (self.whole(x), self.whole(y))
    }

    fn pixels(&self, points: &[(f64, f64)]) -> Vec<(i32, i32)> {
        let mut pixels: Vec<_> = points.iter().map(|&point| self.pixel(point)).collect();
        pixels.dedup();
        pixels
    }

    fn stroke(&self, pen: Pen) -> ShapeStyle {
        ShapeStyle {
            color: pen.colour.mix(pen.opacity),
            filled: false,
            stroke_width: self.whole(pen.width).max(1).unsigned_abs(),
        }
    }

    /// Draws a line through the points; a single point draws nothing.
    pub(super) fn line(&self, points: &[(f64, f64)], pen: Pen) -> Result<(), PlotError> {
        let mut pixels = self.pixels(points);
        pixels.dedup();
        for piece in split_at_sharp_bends(&pixels) {
            self.area.draw(&PathElement::new(piece.to_vec(), self.stroke(pen))).map_err(drawing)?;
        }
        Ok(())
    }

    /// Fills a polygon.
    pub(super) fn polygon(&self, points: &[(f64, f64)], pen: Pen) -> Result<(), PlotError> {
        let pixels = self.pixels(points);
        if pixels.len() < 3 {
            return Ok(());
        }
        self.area.draw(&Polygon::new(pixels, pen.colour.mix(pen.opacity))).map_err(drawing)
    }

    /// Fills a disc.
    pub(super) fn disc(&self, centre: (f64, f64), radius: f64, pen: Pen) -> Result<(), PlotError> {
        let style = ShapeStyle { filled: true, ..self.stroke(pen) };
        let radius = self.whole(radius).max(1);
        self.area.draw(&Circle::new(self.pixel(centre), radius, style)).map_err(drawing)
    }

    /// Fills a marker.
    pub(super) fn marker(
        &self,
        centre: (f64, f64),
        radius: f64,
        marker: Marker,
        pen: Pen,
    ) -> Result<(), PlotError> {
        let Marker::Polygon(corners) = marker else {
            return self.disc(centre, radius, pen);
        };
        let percent = radius / 100.0;
        let corners: Vec<_> = corners
            .iter()
            .map(|&(x, y)| (centre.0 + percent * f64::from(x), centre.1 + percent * f64::from(y)))
            .collect();
        self.polygon(&corners, pen)
    }

    fn text_style(&self, size: f64, colour: RGBColor) -> TextStyle<'static> {
        let font = (FAMILY, size * SIZE_PER_EM * self.zoom).into_font();
        let mut style = TextStyle::from(font);
        style.color = colour.to_backend_color();
        style
    }

    /// Writes one line of text with its digits vertically centred at `at`; `size` is the height of
    /// an em, and `side` selects the end of the line that is at `at`.
    pub(super) fn text(
        &self,
        text: &str,
        at: (f64, f64),
        size: f64,
        colour: RGBColor,
        side: HPos,
    ) -> Result<(), PlotError> {
        let style = self.text_style(size, colour).pos(Pos::new(side, VPos::Center));
        let at = self.pixel((at.0, at.1 + self.text_drop * size));
        self.area.draw(&Text::new(printable(text), at, style)).map_err(drawing)
    }

    /// Writes one line of text upwards, centred at `at`.
    pub(super) fn text_upwards(
        &self,
        text: &str,
        at: (f64, f64),
        size: f64,
        colour: RGBColor,
    ) -> Result<(), PlotError> {
        let style = self
            .text_style(size, colour)
            .transform(FontTransform::Rotate270)
            .pos(Pos::new(HPos::Center, VPos::Center));
        // The bottom of the letters points to the right.
        let at = self.pixel((at.0 + self.text_drop * size, at.1));
        self.area.draw(&Text::new(printable(text), at, style)).map_err(drawing)
    }

    /// Returns the width of a line of text in the embedded font.
    pub(super) fn text_width(&self, text: &str, size: f64) -> Result<f64, PlotError> {
        let style = self.text_style(size, BLACK);
        let (width, _) = self.area.estimate_text_size(&printable(text), &style).map_err(drawing)?;
        Ok(f64::from(width) / self.zoom)
    }

    /// Returns the text in lines no wider than `width`, broken at spaces where possible.
    pub(super) fn wrap(&self, text: &str, size: f64, width: f64) -> Result<Vec<String>, PlotError> {
        let mut lines = Vec::new();
        let mut line = String::new();
        for word in text.split_whitespace() {
            let joined = if line.is_empty() { word.to_owned() } else { format!("{line} {word}") };
            if self.text_width(&joined, size)? <= width {
                line = joined;
                continue;
            }
            if !line.is_empty() {
                lines.push(std::mem::take(&mut line));
            }
            for character in word.chars() {
                line.push(character);
                if line.chars().count() > 1 && self.text_width(&line, size)? > width {
                    line.pop();
                    lines.push(std::mem::replace(&mut line, character.to_string()));
                }
            }
        }
        if !line.is_empty() {
            lines.push(line);
        }
        Ok(lines)
    }
}

/// Returns the text without control characters, which XML forbids and fonts cannot draw.
fn printable(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

fn drawing(error: impl std::fmt::Display) -> PlotError {
    PlotError::Drawing { reason: error.to_string() }
}

/// Registers the embedded font, once per process.
fn ensure_font() -> Result<(), PlotError> {
    static REGISTERED: OnceLock<bool> = OnceLock::new();
    let registered = *REGISTERED
        .get_or_init(|| register_font(FAMILY, FontStyle::Normal, dejavu::sans::regular()).is_ok());
    if registered { Ok(()) } else { Err(drawing("the embedded font cannot be read")) }
}

/// Returns the parts of a polyline between bends of more than a right angle, each of two points or
/// more; a mitred joint at such a bend would be a long spike.
fn split_at_sharp_bends(points: &[(i32, i32)]) -> impl Iterator<Item = &[(i32, i32)]> {
    let mut rest = points;
    std::iter::from_fn(move || {
        if rest.len() < 2 {
            return None;
        }
        let towards = |a: (i32, i32), b: (i32, i32)| (i64::from(b.0 - a.0), i64::from(b.1 - a.1));
        let is_sharp = |corner: &[(i32, i32)]| {
            let (before, after) = (towards(corner[0], corner[1]), towards(corner[1], corner[2]));
            before.0 * after.0 + before.1 * after.1 < 0
        };
        let bend = rest.windows(3).position(is_sharp).map_or(rest.len() - 1, |i| i + 1);
        let piece = &rest[..=bend];
        rest = &rest[bend..];
        Some(piece)
    })
}
