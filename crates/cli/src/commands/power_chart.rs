//! Charts of angular power, for `spectrum`, `compare` and `bounds`.

use sphvar_spectrum::Spectrum;

use crate::plots::{Binned, Chart, Ink, Panel, Scale, Series, Spread, Style};

/// Power below this is 0 to rounding and cannot be drawn on a logarithmic axis.
const ROUNDING: f64 = 1e-20;
/// With more curves than this, the bands would cover each other.
const MAX_BANDS: usize = 3;

/// One spectrum of a chart.
#[derive(Debug)]
pub(super) struct PowerCurve {
    /// Its name; may be empty.
    pub(super) label: String,
    pub(super) n_points: usize,
    /// Degree, power and its standard error.
    pub(super) rows: Vec<(usize, f64, f64)>,
    pub(super) ink: Ink,
}

impl PowerCurve {
    /// Returns the curve of the degrees l >= 1 up to `max_frequency` sqrt(N).
    pub(super) fn new(
        label: impl Into<String>,
        spectrum: &Spectrum,
        max_frequency: f64,
        ink: Ink,
    ) -> Self {
        let n_points = spectrum.n_points();
        let last = max_frequency * (n_points as f64).sqrt();
        let rows = spectrum.rows().skip(1).filter(|row| row.0 as f64 <= last).collect();
        Self { label: label.into(), n_points, rows, ink }
    }
}

/// Returns the chart of spectra against l/sqrt(N) beneath other series over the same axes, with
/// notes on the curves; the caller sets the title. Degrees whose power is 0 to rounding are
/// skipped.
pub(super) fn power_chart(curves: &[PowerCurve], over: Vec<Series>) -> Chart {
    let has_bands = curves.len() <= MAX_BANDS;
    let (mut is_binned, mut has_errors) = (false, false);
    let mut series = Vec::new();
    for curve in curves {
        let scale = (curve.n_points as f64).sqrt();
        let points: Vec<_> = curve.rows.iter().map(|row| (row.0 as f64, row.1)).collect();
        let Binned { points, ranges } = Binned::new(&points, ROUNDING);
        is_binned |= ranges.is_some();
        let spread = match ranges {
            _ if !has_bands => Spread::None,
            Some(ranges) => Spread::Ranges(ranges),
            None => {
                let shown = curve.rows.iter().filter(|row| row.1 > ROUNDING);
                let errors: Vec<f64> = shown.map(|row| row.2).collect();
                has_errors |= errors.iter().any(|&error| error > 0.0);
                Spread::Errors(errors)
            }
        };
        series.push(Series {
            label: curve.label.clone(),
            points: points.into_iter().map(|(l, power)| (l / scale, power)).collect(),
            spread,
            style: Style::Line,
            ink: curve.ink,
        });
    }
    series.extend(over);
    let notes = [
        (is_binned && has_bands).then_some(Binned::NOTE),
        (is_binned && !has_bands).then_some(Binned::NOTE_OF_MEANS),
        has_errors.then_some("Bands: one standard error to either side."),
    ];
    Chart {
        title: String::new(),
        x_label: "frequency l / \u{221a}N".to_owned(),
        x_scale: Scale::Log,
        panels: vec![Panel::log("power P(l), white noise = 1", series)],
        notes: notes.into_iter().flatten().map(str::to_owned).collect(),
    }
}
