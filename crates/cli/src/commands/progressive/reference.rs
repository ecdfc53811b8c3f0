//! The patterns with which sequences are compared, made for each number of points.

use sphvar_samplers::Progress;
use sphvar_variance::{
    IntegrationSpace, PredictedVariance, PredictorOn, VariancePoint, interpolate_variance,
};

use super::record::ReferenceRecord;
use crate::error::CliError;
use crate::patterns::{self, PredictedPattern, SamplerName, SamplerRef, parse_patterns};

/// The text for no reference.
const NONE: &str = "none";

/// The samplers of a pattern at numbers of points.
pub(super) struct ReferencePattern<P: PredictedPattern> {
    pub(super) name: SamplerName,
    /// By number of points, which are distinct.
    samplers: Vec<Box<P::Sampler>>,
}

impl<P: PredictedPattern> ReferencePattern<P> {
    /// Returns the patterns of a list, none for `none`, at their valid counts nearest to `counts`.
    pub(super) fn all(
        text: &str,
        counts: &[usize],
        space: P::Space,
        quiet: bool,
    ) -> Result<Vec<Self>, CliError> {
        if text == NONE {
            return Ok(Vec::new());
        }
        let patterns = parse_patterns::<P>(text, quiet)?;
        patterns.iter().map(|pattern| Self::new(pattern, counts, space)).collect()
    }

    fn new(pattern: &P, counts: &[usize], space: P::Space) -> Result<Self, CliError> {
        let mut valid: Vec<usize> =
            counts.iter().map(|&n| pattern.nearest_count(n, space)).collect();
        valid.sort_unstable();
        valid.dedup();
        let build = |&n: &usize| patterns::build(pattern, n, space, true);
        let samplers = valid.iter().map(build).collect::<Result<_, _>>()?;
        Ok(Self { name: SamplerName::of(pattern), samplers })
    }

    fn samplers(&self) -> impl Iterator<Item = SamplerRef<'_, P>> {
        self.samplers.iter().map(|sampler| P::Space::sampler(sampler))
    }

    /// Returns the maximum nominal work of the predictions.
    pub(super) fn work(&self, predictor: &mut PredictorOn<'_, P::Space>) -> Result<f64, CliError> {
        self.samplers().map(|sampler| Ok(predictor.work(sampler)?)).sum()
    }

    /// Returns the predicted variances at all numbers of points.
    pub(super) fn curve(
        &self,
        predictor: &mut PredictorOn<'_, P::Space>,
        progress: &dyn Progress,
    ) -> Result<ReferenceCurve, CliError> {
        let predict = |sampler| Ok(predictor.predict(sampler, progress)?.variance_point());
        let points = self.samplers().map(predict).collect::<Result<_, CliError>>()?;
        Ok(ReferenceCurve { name: self.name.clone(), points })
    }
}

/// The predicted variances of one pattern.
pub(super) struct ReferenceCurve {
    pub(super) name: SamplerName,
    /// By number of points, which are distinct.
    pub(super) points: Vec<VariancePoint>,
}

/// The predicted variances of all reference patterns.
pub(super) struct Reference {
    pub(super) curves: Vec<ReferenceCurve>,
}

impl Reference {
    /// Returns the least variance of a pattern with `n` points, interpolated between the numbers of
    /// points of its predictions; `None` outside of these, and where all variances are 0.
    pub(super) fn variance_at(&self, n: usize) -> Option<f64> {
        let of_curve = |curve: &ReferenceCurve| {
            let positive: Vec<VariancePoint> =
                curve.points.iter().filter(|point| point.variance > 0.0).copied().collect();
            interpolate_variance(&positive, n as f64)
        };
        self.curves.iter().filter_map(of_curve).reduce(f64::min)
    }

    /// Returns the name in tables and charts; `None` without patterns.
    pub(super) fn name(&self) -> Option<String> {
        match &*self.curves {
            [] => None,
            [only] => Some(only.name.label.clone()),
            several => {
                let labels: Vec<&str> = several.iter().map(|curve| &*curve.name.label).collect();
                Some(format!("the best of {}", labels.join(", ")))
            }
        }
    }

    /// Returns the records of all predictions.
    pub(super) fn records(&self, integrand: &str) -> Vec<ReferenceRecord> {
        let of_curve = |curve: &ReferenceCurve| {
            let record = |point: &VariancePoint| ReferenceRecord {
                sampler: curve.name.text.clone(),
                integrand: integrand.to_owned(),
                n: whole(point.n_points),
                predicted: point.variance,
                predicted_stderr: point.stderr,
            };
            curve.points.iter().map(record).collect::<Vec<_>>()
        };
        self.curves.iter().flat_map(of_curve).collect()
    }
}

/// Returns a number of points as an integer.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a number of points")]
fn whole(n: f64) -> usize {
    n as usize
}
