//! Draws one series on the plane of a panel.

use plotters::prelude::DrawingBackend;
use plotters::style::RGBColor;

use super::canvas::{Canvas, Pen};
use super::chart::Series;
use super::dashes::{Pattern, dashes};
use super::palette::Ink;
use super::plane::{Placed, Plane};
use super::plot_error::PlotError;

const LINE: f64 = 2.0;
/// The width of grey lines, error bars and leaders.
pub(super) const THIN_LINE: f64 = 1.2;
const BAND_OPACITY: f64 = 0.18;
const MARKER: f64 = 4.6;
/// The width of the white edge of markers, which separates them from the lines beneath.
const HALO: f64 = 1.1;
/// Half the width of the caps of an error bar.
const CAP: f64 = 3.5;
/// Half the length of the horizontal line that replaces a line through one point.
const LONE_POINT: f64 = 10.0;
const WHITE: RGBColor = RGBColor(0xff, 0xff, 0xff);

/// A series with the properties that distinguish it from the others of its panel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Look<'a> {
    pub(super) series: &'a Series,
    /// The dashes of its line.
    pub(super) pattern: Pattern,
    /// Its shift to the right, in units.
    pub(super) shift: f64,
}

/// Draws band or bars, then line, then markers.
pub(super) fn draw_series<DB: DrawingBackend>(
    look: &Look<'_>,
    plane: &Plane,
    canvas: &Canvas<DB>,
) -> Result<(), PlotError> {
    let Look { series, pattern, shift } = *look;
    let mut runs = plane.unbroken_runs(series);
    runs.iter_mut().flatten().for_each(|point| point.at.0 += shift);
    let ink = series.ink.colour();
    if series.style.has_markers() {
        let pen = Pen::new(ink, THIN_LINE);
        for &Placed { at: (x, _), ends } in runs.iter().flatten() {
            if let Some((low, high)) = ends {
                canvas.line(&[(x, low), (x, high)], pen)?;
                canvas.line(&[(x - CAP, low), (x + CAP, low)], pen)?;
                canvas.line(&[(x - CAP, high), (x + CAP, high)], pen)?;
            }
        }
    } else {
        for run in &runs {
            // Where a point has no spread, the band is as thin as the line.
            let ends = |point: &Placed| point.ends.unwrap_or((point.at.1, point.at.1));
            let upper = run.iter().map(|point| (point.at.0, ends(point).1));
            let lower = run.iter().rev().map(|point| (point.at.0, ends(point).0));
            if run.iter().any(|point| point.ends.is_some()) {
                let outline: Vec<_> = upper.chain(lower).collect();
                canvas.polygon(&outline, Pen { colour: ink, opacity: BAND_OPACITY, width: 1.0 })?;
            }
        }
    }
    for run in &runs {
        let points: Vec<_> = run.iter().map(|point| point.at).collect();
        if series.style.has_line() {
            let pen = Pen::new(ink, line_width(series.ink));
            for dash in dashes(&points, pattern) {
                canvas.line(&dash, pen)?;
            }
            // A line through one point would be invisible.
            if let &[(x, y)] = points.as_slice() {
                canvas.line(&[(x - LONE_POINT, y), (x + LONE_POINT, y)], pen)?;
            }
        }
        if series.style.has_markers() {
            for point in points {
                draw_marker(series.ink, point, series.ink.size() * MARKER, canvas)?;
            }
        }
    }
    Ok(())
}

/// Returns the width of a line; grey ones are thinner.
fn line_width(ink: Ink) -> f64 {
    if ink.is_hollow() { THIN_LINE } else { ink.size() * LINE }
}

/// Draws one marker.
fn draw_marker<DB: DrawingBackend>(
    ink: Ink,
    at: (f64, f64),
    radius: f64,
    canvas: &Canvas<DB>,
) -> Result<(), PlotError> {
    let fill = |radius, colour| canvas.marker(at, radius, ink.marker(), Pen::new(colour, 1.0));
    fill(radius + HALO, WHITE)?;
    fill(radius, ink.colour())?;
    if ink.is_hollow() {
        fill(0.55 * radius, WHITE)?;
    }
    Ok(())
}

/// An example of a series beside its name.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample<'a> {
    look: Look<'a>,
    /// Whether the sample shows markers, of the series or of an unnamed one in the same ink.
    has_markers: bool,
    /// The left end, and the width.
    at: (f64, f64),
    width: f64,
}

impl<'a> Sample<'a> {
    /// Returns the sample of a series among those of its panel, with its left end at `at`.
    pub(super) fn new(look: Look<'a>, all: &[Look<'_>], at: (f64, f64), width: f64) -> Self {
        let is_same = |other: &Series| other.ink == look.series.ink && other.label.is_empty();
        let has_markers = look.series.style.has_markers()
            || all.iter().any(|l| is_same(l.series) && l.series.style.has_markers());
        Self { look, has_markers, at, width }
    }

    /// Returns the dashes of the series, short enough that the sample shows two.
    fn pattern(&self) -> Vec<f64> {
        let period: f64 = self.look.pattern.iter().sum();
        let first = self.look.pattern.first().unwrap_or(&0.0);
        let scale = (self.width / (period + first)).min(1.0);
        self.look.pattern.iter().map(|length| scale * length).collect()
    }

    pub(super) fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Result<(), PlotError> {
        const HALF: f64 = 6.0;
        let (x, y) = self.at;
        let Series { ink, style, points, spread, .. } = self.look.series;
        let right = x + self.width;
        let has_spread = points.iter().enumerate().any(|(i, p)| spread.ends(i, p.1).is_some());
        if has_spread && !style.has_markers() {
            let band = [(x, y - HALF), (right, y - HALF), (right, y + HALF), (x, y + HALF)];
            let pen = Pen { colour: ink.colour(), opacity: BAND_OPACITY, width: 1.0 };
            canvas.polygon(&band, pen)?;
        }
        if style.has_line() {
            for dash in dashes(&[(x, y), (right, y)], &self.pattern()) {
                canvas.line(&dash, Pen::new(ink.colour(), line_width(*ink)))?;
            }
        }
        if self.has_markers {
            draw_marker(*ink, (x + 0.5 * self.width, y), ink.size() * MARKER, canvas)?;
        }
        Ok(())
    }
}
