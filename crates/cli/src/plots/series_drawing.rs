//! Draws one series on the plane of a chart.

use plotters::prelude::DrawingBackend;

use super::canvas::{Canvas, Pen};
use super::chart::{Series, Style};
use super::chart_layout::Plane;
use super::palette::{colour, marker};
use super::plot_error::PlotError;

pub(super) const LINE: f64 = 2.2;
pub(super) const THIN_LINE: f64 = 1.3;
pub(super) const BAND_OPACITY: f64 = 0.2;
pub(super) const MARKER: f64 = 5.2;
/// Half the width of the caps of an error bar.
const CAP: f64 = 4.5;

/// A point on the canvas, with the ends of its error.
#[derive(Debug, Clone, Copy)]
struct Placed {
    at: (f64, f64),
    error: Option<(f64, f64)>,
}

/// Draws band or bars, then line, then markers.
pub(super) fn draw_series<DB: DrawingBackend>(
    series: &Series,
    plane: &Plane,
    canvas: &Canvas<DB>,
) -> Result<(), PlotError> {
    let runs = unbroken_runs(series, plane);
    let ink = colour(series.colour);
    if series.style == Style::Line {
        for run in &runs {
            let upper = run.iter().filter_map(|point| Some((point.at.0, point.error?.1)));
            let lower = run.iter().rev().filter_map(|point| Some((point.at.0, point.error?.0)));
            let outline: Vec<_> = upper.chain(lower).collect();
            canvas.polygon(&outline, Pen { colour: ink, opacity: BAND_OPACITY, width: 1.0 })?;
        }
    } else {
        let pen = Pen::new(ink, THIN_LINE);
        for &Placed { at: (x, _), error } in runs.iter().flatten() {
            if let Some((low, high)) = error {
                canvas.line(&[(x, low), (x, high)], pen)?;
                canvas.line(&[(x - CAP, low), (x + CAP, low)], pen)?;
                canvas.line(&[(x - CAP, high), (x + CAP, high)], pen)?;
            }
        }
    }
    for run in &runs {
        let points: Vec<_> = run.iter().map(|point| point.at).collect();
        // A line of one point would not show at all.
        if series.style == Style::Line && points.len() > 1 {
            canvas.line(&points, Pen::new(ink, LINE))?;
        } else {
            for point in points {
                canvas.marker(point, MARKER, marker(series.colour), Pen::new(ink, 1.0))?;
            }
        }
    }
    Ok(())
}

/// Returns the points that can be drawn, divided where one cannot.
fn unbroken_runs(series: &Series, plane: &Plane) -> Vec<Vec<Placed>> {
    let mut runs = vec![Vec::new()];
    for (index, &point) in series.points.iter().enumerate() {
        let Some(at) = plane.place(point) else {
            runs.push(Vec::new());
            continue;
        };
        let error = series.error.as_ref().and_then(|errors| errors.get(index));
        let error = error.and_then(|&error| plane.bar(point.1, error));
        if let Some(run) = runs.last_mut() {
            run.push(Placed { at, error });
        }
    }
    runs.retain(|run| !run.is_empty());
    runs
}
