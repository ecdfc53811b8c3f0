//! Points of the unit square.

use std::path::Path;

use plotters::prelude::DrawingBackend;

use super::canvas::{Canvas, Pen};
use super::figure::{self, Figure};
use super::headings::{EDGE, draw_headings};
use super::palette::{GREY, Ink};
use super::plot_error::PlotError;

/// A picture of the unit square, u to the right and v upwards, with points as dots.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SquareView {
    /// The heading; may be empty.
    pub(crate) title: String,
    /// Small lines at the foot, for provenance.
    pub(crate) notes: Vec<String>,
}

/// The radius of a dot relative to the mean distance of points, `1/sqrt(N)`.
const DOT: f64 = 0.14;

impl SquareView {
    /// Width and height in units.
    const SIZE: (u32, u32) = (900, 960);

    /// Writes the points as `.svg` or `.png`; `-` is SVG on standard output. Points that are not
    /// finite are omitted.
    ///
    /// # Errors
    ///
    /// If the extension is another one or the file cannot be written.
    pub(crate) fn render(&self, points: &[[f64; 2]], path: &Path) -> Result<(), PlotError> {
        figure::write(&SquarePoints { view: self, points }, path)
    }
}

/// A view together with its points.
pub(super) struct SquarePoints<'a> {
    pub(super) view: &'a SquareView,
    pub(super) points: &'a [[f64; 2]],
}

impl Figure for SquarePoints<'_> {
    fn size(&self) -> (u32, u32) {
        SquareView::SIZE
    }

    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Result<(), PlotError> {
        let width = f64::from(self.size().0);
        let (top, bottom) = draw_headings(&self.view.title, &self.view.notes, self.size(), canvas)?;
        let side = (bottom - top - 8.0).min(width - 2.0 * EDGE).max(100.0);
        let (left, foot) = (0.5 * (width - side), f64::midpoint(top, bottom) + 0.5 * side);
        let at = |u: f64, v: f64| (left + side * u, foot - side * v);
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0)];
        canvas.line(&corners.map(|(u, v)| at(u, v)), Pen::new(GREY, 1.5))?;

        let dot = (DOT * side / (self.points.len().max(1) as f64).sqrt()).clamp(0.8, 8.0);
        for &[u, v] in self.points {
            if u.is_finite() && v.is_finite() {
                canvas.disc(at(u, v), dot, Pen::new(Ink::Rank(0).colour(), 1.0))?;
            }
        }
        Ok(())
    }
}
