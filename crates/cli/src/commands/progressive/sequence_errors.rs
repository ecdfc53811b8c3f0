//! The errors of all prefixes of a sequence.

use sphvar_variance::{
    Factors, PredictedVariance, ProgressiveCurve, ProgressivePoint, VariancePoint, fit_exact_rate,
    fit_rate,
};

use super::prefixes::Prefixes;
use super::record::{PrefixRecord, SequenceRecord};
use super::reference::Reference;
use crate::integrands::IntegralName;
use crate::patterns::SamplerName;

/// The smallest number of points to which rates, mean and largest factors refer, unless all prefixes
/// are shorter.
const FIRST_N: usize = 16;

/// The errors of all prefixes of a sequence on one integrand.
pub(super) struct SequenceErrors {
    pub(super) sampler: SamplerName,
    pub(super) prefixes: Prefixes,
    pub(super) rows: Vec<PrefixRecord>,
    pub(super) summary: SequenceRecord,
}

/// What is known of a sequence besides the errors of its prefixes.
pub(super) struct Origin<'a> {
    pub(super) sampler: SamplerName,
    pub(super) prefixes: &'a Prefixes,
    pub(super) integral: &'a IntegralName,
    /// The name of the space.
    pub(super) domain: String,
    pub(super) exact: Option<f64>,
}

impl SequenceErrors {
    pub(super) fn new(origin: Origin<'_>, curve: &ProgressiveCurve, reference: &Reference) -> Self {
        let Origin { sampler, prefixes, integral, domain, exact } = origin;
        let record = |point: &ProgressivePoint| {
            let mut record = PrefixRecord::new(&sampler, &integral.name, point);
            record.factor = record.factor_to(reference.variance_at(point.n_points));
            record
        };
        let rows: Vec<PrefixRecord> = curve.points.iter().map(record).collect();
        let n = rows.last().map_or(0, |row| row.n);
        let first_n = if n >= FIRST_N { FIRST_N } else { 1 };
        let variances = rows.iter().filter_map(|row| Some((row.n, row.predicted?)));
        let references = rows.iter().filter_map(|row| Some((row.n, reference.variance_at(row.n)?)));
        let factors = Factors::of(variances, references, first_n);
        let is_predicted = rows.iter().any(|row| row.predicted.is_some());
        let shown: Vec<VariancePoint> = curve
            .points
            .iter()
            .filter(|point| point.n_points >= first_n && prefixes.shown.contains(&point.n_points))
            .filter_map(variance_point)
            .filter(|point| point.variance > 0.0)
            .collect();
        let fit = if is_predicted { fit_exact_rate(&shown) } else { fit_rate(&shown) };
        let interval = fit.map(|fit| fit.interval);
        let measured = curve.points.iter().filter_map(|point| point.measurement);
        let summary = SequenceRecord {
            sampler: sampler.text.clone(),
            label: sampler.label.clone(),
            integrand: integral.name.clone(),
            domain,
            exact,
            basis: if is_predicted { "predicted" } else { "measured" },
            realizations: curve.realizations,
            trials: measured.map(|m| m.trials).min().unwrap_or(0),
            n,
            rate: fit.map(|fit| fit.slope),
            rate_interval: interval.filter(|ends| ends.0.is_finite() && ends.1.is_finite()),
            first_n,
            factor: rows.last().and_then(|row| row.factor),
            factors: factors.map_or(0, |factors| factors.count),
            mean_factor: factors.map(|factors| factors.mean),
            worst_factor: factors.map(|factors| factors.worst),
            worst_n: factors.map(|factors| factors.worst_at),
            remark: remark(curve),
        };
        Self { sampler, prefixes: prefixes.clone(), rows, summary }
    }

    /// Returns the rows of a table.
    pub(super) fn in_table(&self, sequences: usize) -> impl Iterator<Item = &PrefixRecord> {
        let shown = self.prefixes.in_table(sequences);
        self.rows.iter().filter(move |row| shown.contains(&row.n))
    }
}

/// Returns the predicted variance or, if it is unknown, the measured one, for rates.
fn variance_point(point: &ProgressivePoint) -> Option<VariancePoint> {
    if !point.prediction.is_unknown() {
        return Some(point.variance_point());
    }
    let measured = point.measurement?;
    let (variance, stderr) = (measured.variance, measured.stderr);
    Some(VariancePoint { n_points: point.n_points as f64, variance, stderr })
}

/// Returns why numbers are missing.
fn remark(curve: &ProgressiveCurve) -> Option<&'static str> {
    let measured = || curve.points.iter().filter_map(|point| point.measurement);
    if measured().any(|m| m.has_too_few_hits) {
        return Some("too few trials hit the support of the integrand");
    }
    let is_unknown = curve.points.iter().any(|point| point.prediction.is_unknown());
    is_unknown.then_some(
        "without rotations or shifts the sets are not homogeneous, so no spectrum predicts their variance;\n\
            references are predicted over rotations or shifts, so there is no factor",
    )
}
