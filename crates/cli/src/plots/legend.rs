//! The legend, which stands beside the data and so never covers any.

use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::HPos;

use super::canvas::{Canvas, Pen};
use super::chart::{Series, Style};
use super::palette::{INK, colour, marker};
use super::plot_error::PlotError;
use super::series_drawing::{BAND_OPACITY, LINE, MARKER, THIN_LINE};

const TEXT: f64 = 17.0;
const LEADING: f64 = 1.3;
/// Between entries, in ems.
const PAUSE: f64 = 0.45;
const SAMPLE: f64 = 38.0;
const SAMPLE_GAP: f64 = 10.0;
/// Longer labels are broken into lines.
const WIDEST_LABEL: f64 = 260.0;

/// The entries of a legend, measured.
#[derive(Debug)]
pub(super) struct Legend<'a> {
    entries: Vec<(&'a Series, Vec<String>)>,
    label_width: f64,
}

impl<'a> Legend<'a> {
    /// Returns the legend of the series that have a label; `None` when there is none.
    pub(super) fn of<DB: DrawingBackend>(
        series: &'a [Series],
        canvas: &Canvas<DB>,
    ) -> Result<Option<Self>, PlotError> {
        let mut legend = Self { entries: Vec::new(), label_width: 0.0 };
        for series in series {
            let lines = canvas.wrap(&series.label, TEXT, WIDEST_LABEL)?;
            for line in &lines {
                legend.label_width = legend.label_width.max(canvas.text_width(line, TEXT)?);
            }
            if !lines.is_empty() {
                legend.entries.push((series, lines));
            }
        }
        Ok((!legend.entries.is_empty()).then_some(legend))
    }

    /// Returns the width in units.
    pub(super) fn width(&self) -> f64 {
        SAMPLE + SAMPLE_GAP + self.label_width
    }

    /// Draws the entries from `corner` (left, top) downwards, smaller when they would not fit.
    pub(super) fn draw<DB: DrawingBackend>(
        &self,
        corner: (f64, f64),
        height: f64,
        canvas: &Canvas<DB>,
    ) -> Result<(), PlotError> {
        let ems: f64 = self.entries.iter().map(|(_, lines)| entry_ems(lines)).sum();
        let size = TEXT.min(height / ems);
        let mut top = corner.1;
        for (series, lines) in &self.entries {
            let mut y = top + 0.5 * LEADING * size;
            draw_sample(series, (corner.0, y), size / TEXT, canvas)?;
            for line in lines {
                let at = (corner.0 + SAMPLE + SAMPLE_GAP, y);
                canvas.text(line, at, size, INK, HPos::Left)?;
                y += LEADING * size;
            }
            top += entry_ems(lines) * size;
        }
        Ok(())
    }
}

fn entry_ems(lines: &[String]) -> f64 {
    f64::from(u32::try_from(lines.len()).unwrap_or(u32::MAX)) * LEADING + PAUSE
}

fn draw_sample<DB: DrawingBackend>(
    series: &Series,
    (x, y): (f64, f64),
    shrink: f64,
    canvas: &Canvas<DB>,
) -> Result<(), PlotError> {
    let ink = colour(series.colour);
    let ends = [(x, y), (x + SAMPLE, y)];
    let half = 8.0 * shrink;
    if series.error.is_some() && series.style == Style::Line {
        let band = [(x, y - half), (x + SAMPLE, y - half), (x + SAMPLE, y + half), (x, y + half)];
        canvas.polygon(&band, Pen { colour: ink, opacity: BAND_OPACITY, width: 1.0 })?;
    }
    if series.style == Style::Line {
        return canvas.line(&ends, Pen::new(ink, LINE));
    }
    let centre = (x + 0.5 * SAMPLE, y);
    if series.error.is_some() {
        let bar = [(centre.0, y - 1.3 * half), (centre.0, y + 1.3 * half)];
        canvas.line(&bar, Pen::new(ink, THIN_LINE))?;
    }
    canvas.marker(centre, MARKER * shrink, marker(series.colour), Pen::new(ink, 1.0))
}
