//! The patterns with which sequences are compared, made for each number of points.

use sphvar_samplers::Progress;
use sphvar_variance::{
    IntegrationSpace, PredictedVariance, ProgressivePoint, ProgressivePredictor, ProgressiveSpace,
    VariancePoint,
};

use super::prefixes::Prefixes;
use super::record::ReferenceRecord;
use crate::error::CliError;
use crate::patterns::{self, PredictedPattern, SamplerName, SamplerRef, parse_patterns};
use crate::session::Session;

/// The text for no reference.
const NONE: &str = "none";

/// The samplers of a pattern at numbers of points.
pub(super) struct ReferencePattern<P: PredictedPattern> {
    pub(super) name: SamplerName,
    /// By number of points, which are distinct.
    samplers: Vec<Box<P::Sampler>>,
    /// Whether they are predicted together, at many numbers of points.
    pub(super) is_together: bool,
}

impl<P: PredictedPattern> ReferencePattern<P> {
    /// Returns the patterns of a list, none for `none`, at their largest valid counts up to each of
    /// `counts`.
    pub(super) fn all(
        text: &str,
        counts: &ReferenceCounts,
        space: P::Space,
        session: &Session,
    ) -> Result<Vec<Self>, CliError> {
        if text == NONE {
            return Ok(Vec::new());
        }
        let patterns = parse_patterns::<P>(text, session)?;
        let all = patterns.iter().map(|pattern| Self::new(pattern, &counts.few, space));
        let all: Vec<Self> = all.collect::<Result<_, _>>()?;
        // All have the same numbers of points, or a smaller set would stand for a valid one.
        let Some(many) = counts.many.as_ref().filter(|_| all.iter().all(Self::is_inexpensive))
        else {
            return Ok(all);
        };
        let together = |pattern| Ok(Self { is_together: true, ..Self::new(pattern, many, space)? });
        patterns.iter().map(together).collect()
    }

    fn new(pattern: &P, counts: &[usize], space: P::Space) -> Result<Self, CliError> {
        let valid = counts.iter().filter_map(|&n| largest_count(pattern, n, space));
        let mut valid: Vec<usize> = valid.collect();
        valid.dedup();
        let build = |&n: &usize| patterns::build(pattern, n, space, true);
        let samplers = valid.iter().map(build).collect::<Result<_, _>>()?;
        Ok(Self { name: SamplerName::of(pattern), samplers, is_together: false })
    }

    /// Returns whether the pattern is a fixed set that takes no more work than its points.
    fn is_inexpensive(&self) -> bool {
        self.samplers().last().is_some_and(|&sampler| {
            let is_fixed = !P::Space::distribution(sampler).is_random();
            is_fixed && P::Space::nominal_work(sampler) <= P::Space::n_points(sampler) as f64
        })
    }

    fn samplers(&self) -> Vec<SamplerRef<'_, P>> {
        self.samplers.iter().map(|sampler| P::Space::sampler(sampler)).collect()
    }
}

impl<P: PredictedPattern<Space: ProgressiveSpace>> ReferencePattern<P> {
    /// Returns the maximum nominal work of the predictions.
    pub(super) fn work(
        &self,
        predictor: &mut ProgressivePredictor<'_, P::Space>,
    ) -> Result<f64, CliError> {
        let samplers = self.samplers();
        if self.is_together {
            return Ok(predictor.work_of_sets(&samplers)?);
        }
        samplers.into_iter().map(|sampler| Ok(predictor.of_sets().work(sampler)?)).sum()
    }

    /// Returns the predicted variances at all numbers of points.
    pub(super) fn points(
        &self,
        predictor: &mut ProgressivePredictor<'_, P::Space>,
        progress: &dyn Progress,
    ) -> Result<Vec<ProgressivePoint>, CliError> {
        let samplers = self.samplers();
        if self.is_together {
            return Ok(predictor.predict_sets(&samplers, progress)?);
        }
        let predict = |sampler| {
            let point = predictor.of_sets().predict(sampler, progress)?;
            let (n_points, prediction) = (point.n_points(), point.prediction);
            Ok(ProgressivePoint { n_points, prediction, measurement: None })
        };
        samplers.into_iter().map(predict).collect()
    }

    /// Returns the curve of predicted variances.
    pub(super) fn curve(&self, points: &[ProgressivePoint]) -> ReferenceCurve {
        let points = points.iter().map(PredictedVariance::variance_point).collect();
        ReferenceCurve { name: self.name.clone(), points }
    }
}

/// Returns the largest valid number of points up to `n`.
fn largest_count<P: PredictedPattern>(pattern: &P, n: usize, space: P::Space) -> Option<usize> {
    let nearest = |n: usize| pattern.nearest_count(n, space);
    // The nearest valid number does not decrease with n: of the numbers up to n, the last one whose
    // nearest number is not larger than n.
    let (mut low, mut high) = (0, n);
    if nearest(n) <= n {
        return Some(nearest(n));
    }
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if nearest(middle) <= n { low = middle } else { high = middle }
    }
    (low > 0).then(|| nearest(low))
}

/// The numbers of points at which sequences are compared with references.
pub(super) struct ReferenceCounts {
    /// Those of every reference.
    few: Vec<usize>,
    /// Those of patterns whose sets are inexpensive, if every prefix is computed.
    many: Option<Vec<usize>>,
}

impl ReferenceCounts {
    /// Returns the numbers of points for sequences of some prefixes.
    pub(super) fn of<'a>(prefixes: impl Iterator<Item = &'a Prefixes> + Clone) -> Self {
        let union = |of: fn(&Prefixes) -> Vec<usize>| {
            let mut all: Vec<usize> = prefixes.clone().flat_map(of).collect();
            all.sort_unstable();
            all.dedup();
            all
        };
        let is_every = prefixes.clone().any(|p| !p.are_listed && !p.has_gaps());
        Self { few: union(|p| p.shown.clone()), many: is_every.then(|| union(Prefixes::compared)) }
    }

    /// Returns the numbers at which all references are predicted, if one of them is at many.
    pub(super) fn all(&self, is_many: bool) -> Vec<usize> {
        self.many.clone().filter(|_| is_many).unwrap_or_else(|| self.few.clone())
    }
}

/// The predicted variances of one pattern.
pub(super) struct ReferenceCurve {
    pub(super) name: SamplerName,
    /// By number of points, which are distinct.
    pub(super) points: Vec<VariancePoint>,
}

/// The predicted variances of all reference patterns.
#[derive(Default)]
pub(super) struct Reference {
    pub(super) curves: Vec<ReferenceCurve>,
    /// The numbers of points of the comparison, in increasing order.
    pub(super) counts: Vec<usize>,
}

impl Reference {
    /// Returns the least variance of the patterns with the largest number of points up to `n` that
    /// they have; `None` if n is not compared, and where all variances are 0.
    pub(super) fn variance_at(&self, n: usize) -> Option<f64> {
        self.counts.binary_search(&n).ok()?;
        let of_curve = |curve: &ReferenceCurve| {
            let above = curve.points.partition_point(|point| point.n_points <= n as f64);
            Some(curve.points[..above].last()?.variance).filter(|variance| *variance > 0.0)
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
