//! A chart of series over a common axis, in one or more panels.

use std::path::Path;

use super::axis::Scale;
use super::chart_layout::Layout;
use super::figure;
use super::palette::Ink;
use super::plot_error::PlotError;

/// The style of a series.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Style {
    /// A line with gaps where it covers another one; its spread as a band.
    Line,
    /// A line without gaps; its spread as a band.
    Solid,
    /// A dashed line; its spread as a band.
    Dashed,
    /// A line with a marker at every point; its spread as bars.
    Joined,
    /// Markers; their spread as bars.
    Markers,
}

impl Style {
    /// Returns whether the points are connected.
    pub(super) fn has_line(self) -> bool {
        self != Self::Markers
    }

    /// Returns whether points have markers.
    pub(super) fn has_markers(self) -> bool {
        matches!(self, Self::Joined | Self::Markers)
    }
}

/// The spread of the values.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Spread {
    /// Nothing.
    None,
    /// One standard error for each point; NaN where it is unknown.
    Errors(Vec<f64>),
    /// The smallest and the largest value for each point.
    Ranges(Vec<(f64, f64)>),
}

impl Spread {
    /// Returns both ends at a point with this value, or `None` if it has no spread.
    pub(super) fn ends(&self, index: usize, value: f64) -> Option<(f64, f64)> {
        let (low, high) = match self {
            Self::None => return None,
            Self::Errors(errors) => {
                let error = *errors.get(index)?;
                (value - error, value + error)
            }
            Self::Ranges(ranges) => *ranges.get(index)?,
        };
        (low < high && high.is_finite()).then_some((low, high))
    }
}

/// One series.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Series {
    /// Its name, shown at its end or in the legend; hidden if empty.
    pub(crate) label: String,
    /// The points in the order in which a line connects them. A point that cannot be drawn (not
    /// finite, or not positive on a logarithmic axis) is omitted and interrupts the line.
    pub(crate) points: Vec<(f64, f64)>,
    /// Errors or ranges of y.
    pub(crate) spread: Spread,
    /// The style.
    pub(crate) style: Style,
    /// Its colour and marker; related series share them.
    pub(crate) ink: Ink,
}

/// A frame with series.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Panel {
    /// The quantity (and unit) along y.
    pub(crate) y_label: String,
    /// The scale of y.
    pub(crate) y_scale: Scale,
    /// The series; later ones are drawn over earlier ones.
    pub(crate) series: Vec<Series>,
    /// A value marked by a horizontal line and always within the axis.
    pub(crate) reference: Option<f64>,
    /// Whether markers at the same x are placed side by side.
    pub(crate) side_by_side: bool,
}

impl Panel {
    /// Returns a panel of series with a logarithmic axis and no reference.
    pub(crate) fn log(y_label: impl Into<String>, series: Vec<Series>) -> Self {
        Self {
            y_label: y_label.into(),
            y_scale: Scale::Log,
            series,
            reference: None,
            side_by_side: false,
        }
    }
}

/// A chart. Every field may be empty.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Chart {
    /// The heading.
    pub(crate) title: String,
    /// The quantity (and unit) along x.
    pub(crate) x_label: String,
    /// The scale of x.
    pub(crate) x_scale: Scale,
    /// The panels from top to bottom, with the same x; the first is the largest and has the labels.
    pub(crate) panels: Vec<Panel>,
    /// Small lines at the foot, for conventions and provenance.
    pub(crate) notes: Vec<String>,
}

impl Chart {
    /// Width in units; the height follows from the content.
    pub(crate) const WIDTH: f64 = 960.0;

    /// Returns the chart with another line at the foot.
    pub(crate) fn with_note(mut self, note: impl Into<String>) -> Self {
        self.notes.push(note.into());
        self
    }

    /// Writes the chart; `.svg` and `.png` are known, `-` is SVG on standard output.
    ///
    /// # Errors
    /// When the extension is another one or the file cannot be written.
    pub(crate) fn render(&self, path: &Path) -> Result<(), PlotError> {
        figure::write(&self.layout(Self::WIDTH)?, path)
    }

    /// Returns the layout in a figure of this width.
    pub(super) fn layout(&self, width: f64) -> Result<Layout<'_>, PlotError> {
        figure::measured(|canvas| Layout::new(self, width, canvas))
    }
}
