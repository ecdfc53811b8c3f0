//! Maps values to positions on the canvas.

use super::axis::{Axis, Scale};
use super::chart::{Panel, Series, Spread};

/// Error bars extend a logarithmic axis below the lowest point by at most this factor: a bar that
/// nearly reaches zero would compress the rest of the chart.
const BAR_REACH: f64 = 10.0;
/// The same limit for bands of ranges.
const RANGE_REACH: f64 = 100.0;
/// Error bars extend a linear axis by at most this multiple of the range of points.
const LINEAR_REACH: f64 = 2.0;

/// The rectangle of the data, in figure units with y pointing down.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    pub(super) left: f64,
    pub(super) right: f64,
    pub(super) top: f64,
    pub(super) bottom: f64,
}

impl Frame {
    pub(super) fn x(&self, at: f64) -> f64 {
        self.left + at * (self.right - self.left)
    }

    pub(super) fn y(&self, at: f64) -> f64 {
        self.bottom - at * (self.bottom - self.top)
    }
}

/// A frame with both axes.
#[derive(Debug)]
pub(super) struct Plane {
    pub(super) frame: Frame,
    pub(super) x: Axis,
    pub(super) y: Axis,
}

/// A point on the canvas, with the ends of its spread (low, high) cut at the frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Placed {
    pub(super) at: (f64, f64),
    pub(super) ends: Option<(f64, f64)>,
}

impl Plane {
    /// Returns the position of a point, or `None` if it cannot be drawn.
    pub(super) fn place(&self, (x, y): (f64, f64)) -> Option<(f64, f64)> {
        Some((self.frame.x(self.x.position(x)?), self.frame.y(self.y.position(y)?)))
    }

    /// Returns the drawable points, split where one cannot be drawn.
    pub(super) fn unbroken_runs(&self, series: &Series) -> Vec<Vec<Placed>> {
        let mut runs = vec![Vec::new()];
        for (index, &point) in series.points.iter().enumerate() {
            let Some(at) = self.place(point) else {
                runs.push(Vec::new());
                continue;
            };
            let cut = |value: f64, otherwise: f64| {
                self.frame.y(self.y.position(value).unwrap_or(otherwise).clamp(0.0, 1.0))
            };
            // The lower end may be zero or negative on a logarithmic axis; it then counts as below
            // the frame.
            let ends = series.spread.ends(index, point.1);
            let ends = ends.map(|(low, high)| (cut(low, 0.0), cut(high, 1.0)));
            if let Some(run) = runs.last_mut() {
                run.push(Placed { at, ends });
            }
        }
        runs.retain(|run| !run.is_empty());
        runs
    }

    /// Returns the position of the point with the largest x, or `None` if none can be drawn.
    pub(super) fn end(&self, series: &Series) -> Option<(f64, f64)> {
        let places = series.points.iter().filter_map(|&point| self.place(point));
        places.max_by(|a, b| a.0.total_cmp(&b.0))
    }
}

/// Returns the x of the drawable points of a panel.
pub(super) fn drawable_x(panel: &Panel, x_scale: Scale) -> Vec<f64> {
    panel.series.iter().flat_map(|s| drawable(s, x_scale, panel.y_scale)).map(|p| p.1.0).collect()
}

/// Returns the y of the drawable points of a panel, with the visible ends of their spread, and the
/// reference.
pub(super) fn drawable_y(panel: &Panel, x_scale: Scale) -> Vec<f64> {
    let points = |s| drawable(s, x_scale, panel.y_scale);
    let mut values: Vec<f64> =
        panel.series.iter().flat_map(points).map(|p| p.1.1).chain(panel.reference).collect();
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    for series in &panel.series {
        let (floor, ceiling) = match (panel.y_scale, &series.spread) {
            (Scale::Log, Spread::Ranges(_)) => (low / RANGE_REACH, f64::INFINITY),
            (Scale::Log, _) => (low / BAR_REACH, f64::INFINITY),
            // Ranges are results of their own, errors may exceed them by far.
            (Scale::Linear | Scale::Names(_), Spread::Ranges(_)) => {
                (f64::NEG_INFINITY, f64::INFINITY)
            }
            (Scale::Linear | Scale::Names(_), _) if high > low => {
                let reach = LINEAR_REACH * (high - low);
                (low - reach, high + reach)
            }
            (Scale::Linear | Scale::Names(_), _) => (f64::NEG_INFINITY, f64::INFINITY),
        };
        for (index, (_, y)) in drawable(series, x_scale, panel.y_scale) {
            if let Some((low, high)) = series.spread.ends(index, y) {
                values.extend([low.max(floor), high.min(ceiling)]);
            }
        }
    }
    values
}

fn drawable(
    series: &Series,
    x_scale: Scale,
    y_scale: Scale,
) -> impl Iterator<Item = (usize, (f64, f64))> {
    let can_be_drawn =
        move |(x, y): (f64, f64)| x_scale.place(x).is_some() && y_scale.place(y).is_some();
    series.points.iter().copied().enumerate().filter(move |p| can_be_drawn(p.1))
}
