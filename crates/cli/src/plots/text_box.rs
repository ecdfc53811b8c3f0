//! A line of text with its extent.

use plotters::prelude::DrawingBackend;
use plotters::style::RGBColor;
use plotters::style::text_anchor::HPos;

use super::canvas::Canvas;
use super::plane::Frame;
use super::plot_error::PlotError;

/// A line of text at its position.
#[derive(Clone)]
pub(super) struct TextBox {
    pub(super) text: String,
    /// The end or middle of the line that `side` selects, at half height; for upward text, the
    /// middle.
    at: (f64, f64),
    size: f64,
    colour: RGBColor,
    side: HPos,
    is_upward: bool,
    width: f64,
}

impl TextBox {
    /// Returns a line from left to right; `size` is the height of an em.
    pub(super) fn new<DB: DrawingBackend>(
        text: &str,
        at: (f64, f64),
        size: f64,
        (colour, side): (RGBColor, HPos),
        canvas: &Canvas<DB>,
    ) -> Result<Self, PlotError> {
        let width = canvas.text_width(text, size)?;
        Ok(Self { text: text.to_owned(), at, size, colour, side, is_upward: false, width })
    }

    /// Returns a line centred at `at`, reduced in size if it is longer than `length`.
    pub(super) fn within<DB: DrawingBackend>(
        text: &str,
        at: (f64, f64),
        (size, length): (f64, f64),
        colour: RGBColor,
        canvas: &Canvas<DB>,
    ) -> Result<Self, PlotError> {
        let width = canvas.text_width(text, size)?;
        let size = if width > length { size * length / width } else { size };
        Self::new(text, at, size, (colour, HPos::Center), canvas)
    }

    /// Returns the same line, written from bottom to top and centred.
    pub(super) fn upward(self) -> Self {
        Self { is_upward: true, side: HPos::Center, ..self }
    }

    /// Returns the rectangle of the letters.
    pub(super) fn bounds(&self) -> Frame {
        let (x, y) = self.at;
        let half = 0.5 * self.size;
        if self.is_upward {
            let length = 0.5 * self.width;
            return Frame { left: x - half, right: x + half, top: y - length, bottom: y + length };
        }
        let left = match self.side {
            HPos::Left => x,
            HPos::Center => x - 0.5 * self.width,
            HPos::Right => x - self.width,
        };
        Frame { left, right: left + self.width, top: y - half, bottom: y + half }
    }

    pub(super) fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Result<(), PlotError> {
        if self.is_upward {
            canvas.text_upwards(&self.text, self.at, self.size, self.colour)
        } else {
            canvas.text(&self.text, self.at, self.size, self.colour, self.side)
        }
    }
}
