//! The title above a view and the notes below it.

use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::HPos;

use super::canvas::Canvas;
use super::palette::{GREY, INK};
use super::plot_error::PlotError;

/// The margin of a view.
pub(super) const EDGE: f64 = 22.0;
const TITLE: f64 = 24.0;
const NOTE: f64 = 13.0;
const LEADING: f64 = 1.35;

/// Draws the title and the notes on a canvas of this size, and returns the upper and lower limit of
/// the space between them.
pub(super) fn draw_headings<DB: DrawingBackend>(
    title: &str,
    notes: &[String],
    (width, height): (u32, u32),
    canvas: &Canvas<DB>,
) -> Result<(f64, f64), PlotError> {
    let (width, height) = (f64::from(width), f64::from(height));
    let mut top = EDGE;
    for line in &canvas.wrap(title, TITLE, width - 2.0 * EDGE)? {
        let at = (0.5 * width, top + 0.5 * TITLE);
        canvas.text(line, at, TITLE, INK, HPos::Center)?;
        top += LEADING * TITLE;
    }
    let mut lines = Vec::new();
    for note in notes {
        lines.extend(canvas.wrap(note, NOTE, width - 2.0 * EDGE)?);
    }
    let mut bottom = height - EDGE;
    for line in lines.iter().rev() {
        let at = (EDGE, bottom - 0.5 * NOTE);
        canvas.text(line, at, NOTE, GREY, HPos::Left)?;
        bottom -= LEADING * NOTE;
    }
    Ok((top, bottom))
}
