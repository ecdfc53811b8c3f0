//! The rows of one pattern and the quantities derived from all of them.

use sphvar_variance::{Comparison, RateFit, VariancePoint, fit_exact_rate, fit_rate};

use super::record::SamplerRecord;
use crate::commands::rows::Row;
use crate::patterns::SamplerName;

/// The rows of one sampler for the main integral, by number of points.
pub(in crate::commands) struct Curve<'a> {
    pub(super) sampler: &'a SamplerName,
    pub(super) rows: Vec<&'a Row>,
}

impl<'a> Curve<'a> {
    /// Returns the curves of all samplers, in the order of the rows.
    pub(in crate::commands) fn all(rows: &'a [Row]) -> Vec<Self> {
        let mut curves: Vec<Self> = Vec::new();
        for row in rows.iter().filter(|row| row.is_main) {
            match curves.iter_mut().find(|curve| *curve.sampler == row.sampler) {
                Some(curve) => curve.rows.push(row),
                None => curves.push(Self { sampler: &row.sampler, rows: vec![row] }),
            }
        }
        curves.iter_mut().for_each(|c| c.rows.sort_by_key(|r| r.comparison.n_points));
        curves
    }

    pub(super) fn measured(&self) -> Vec<VariancePoint> {
        self.rows.iter().map(|r| r.comparison.measured_point()).collect()
    }

    pub(super) fn predicted(&self) -> Vec<VariancePoint> {
        self.rows.iter().map(|r| r.comparison.predicted_point()).collect()
    }

    /// Returns the more precise of both variances at every number of points, where its error is
    /// known.
    pub(super) fn best(&self) -> Vec<VariancePoint> {
        let points = self.rows.iter().map(|r| r.comparison.best_point());
        points.filter(|p| p.stderr.is_finite()).collect()
    }

    pub(super) fn summary(&self) -> Option<SamplerRecord> {
        let last = self.rows.last()?;
        let white = last.white_variance;
        let by_prediction = |c: &Comparison| c.is_prediction_more_precise();
        let n_predicted = self.rows.iter().filter(|r| by_prediction(&r.comparison)).count();
        let (basis, fit) = match n_predicted {
            0 => ("measured", fit_rate(&self.best())),
            all if all == self.rows.len() => ("predicted", fit_exact_rate(&self.best())),
            _ => ("both", fit_rate(&self.best())),
        };
        let measured: Option<RateFit> = fit_rate(&self.measured());
        let reduction = |point: VariancePoint| {
            let ratio = white / point.variance;
            let stderr = ratio * point.stderr / point.variance;
            (ratio.is_finite() && stderr.is_finite()).then_some((ratio, stderr))
        };
        // A variance without a prediction is that of biased estimates.
        let is_biased = last.comparison.prediction.is_unknown();
        let reduction = |point| reduction(point).filter(|_| !is_biased);
        let best_reduction = reduction(last.comparison.best_point());
        let measured_reduction = reduction(last.comparison.measured_point());
        let known = |x: Option<f64>| x.filter(|x| x.is_finite());
        let finite = |i: Option<(f64, f64)>| i.filter(|i| i.0.is_finite() && i.1.is_finite());
        Some(SamplerRecord {
            sampler: self.sampler.text.clone(),
            label: self.sampler.label.clone(),
            is_warped: last.is_warped(),
            basis,
            rate: fit.map(|f| f.slope),
            rate_interval: finite(fit.map(|f| f.interval)),
            rate_change: known(fit.map(|f| f.slope_change)),
            rate_change_p: known(fit.map(|f| f.slope_change_p)),
            pre_asymptotic: fit.is_some_and(|f| f.is_pre_asymptotic()),
            predicted_rate: fit_exact_rate(&self.predicted()).map(|f| f.slope),
            measured_rate: measured.map(|f| f.slope),
            measured_rate_interval: finite(measured.map(|f| f.interval)),
            n: last.comparison.n_points,
            variance_reduction: best_reduction.map(|g| g.0),
            variance_reduction_stderr: best_reduction.map(|g| g.1),
            measured_variance_reduction: measured_reduction.map(|g| g.0),
            measured_variance_reduction_stderr: measured_reduction.map(|g| g.1),
            effective_power: last.comparison.predicted_point().variance / white,
        })
    }
}
