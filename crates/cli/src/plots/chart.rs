//! A chart of one or more series over a common axis.

use std::path::Path;

use super::axis::Scale;
use super::figure::{self, Figure};
use super::plot_error::PlotError;

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Style {
    /// A line; errors as a band.
    Line,
    /// Markers; errors as bars.
    Markers,
}

/// One named series.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Series {
    /// The entry in the legend; an empty one has no entry.
    pub(crate) label: String,
    /// The points in the order in which a line joins them. A point that cannot be drawn (not finite,
    /// or not positive on a logarithmic axis) is left out and breaks the line.
    pub(crate) points: Vec<(f64, f64)>,
    /// One standard error of y for each point; missing or unusable ones are left out.
    pub(crate) error: Option<Vec<f64>>,
    /// How it is drawn.
    pub(crate) style: Style,
    /// Which colour and marker it has: a line and its markers share an index.
    pub(crate) colour: usize,
}

/// A chart. Every field may be empty.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Chart {
    /// The heading.
    pub(crate) title: String,
    /// The quantity (and unit) along x.
    pub(crate) x_label: String,
    /// The quantity (and unit) along y.
    pub(crate) y_label: String,
    /// The scale of x.
    pub(crate) x_scale: Scale,
    /// The scale of y.
    pub(crate) y_scale: Scale,
    /// What is drawn, the later over the earlier.
    pub(crate) series: Vec<Series>,
    /// Small lines at the foot, for conventions and provenance.
    pub(crate) notes: Vec<String>,
}

impl Chart {
    /// Width and height in pixels.
    pub(crate) const SIZE: (u32, u32) = (1200, 800);

    /// Writes the chart; `.svg` and `.png` are known, `-` is SVG on standard output.
    ///
    /// # Errors
    /// When the extension is another one or the file cannot be written.
    pub(crate) fn render(&self, path: &Path) -> Result<(), PlotError> {
        figure::write(self, path)
    }
}

impl Figure for Chart {
    fn size(&self) -> (u32, u32) {
        Self::SIZE
    }

    fn draw<DB: plotters::prelude::DrawingBackend>(
        &self,
        canvas: &super::canvas::Canvas<DB>,
    ) -> Result<(), PlotError> {
        super::chart_layout::draw(self, canvas)
    }
}
