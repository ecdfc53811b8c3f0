//! Rows of tessellations for a density, which are measured only.

use std::ops::Range;

use sphvar_integrands::{Strategy, WarpExpression};
use sphvar_samplers::{Progress as SamplerProgress, Share};
use sphvar_variance::{JointTrials, Measurement, Prediction};

use super::cases::{AdaptedCase, DirectionCase};
use super::rows::{CaseExperiments, Effort, Parts, Plan, Row};
use crate::error::CliError;
use crate::integrands::{Integral, strategies_of};
use crate::patterns::{DirectionSampler, UNPREDICTED};
use crate::progress::Progress;

/// The densities of all cases, each distinct one once.
pub(super) struct AdaptedDensities {
    densities: Vec<(WarpExpression, Strategy)>,
    n_integrals: usize,
}

impl AdaptedDensities {
    /// Reads the files of the densities.
    pub(super) fn new(plan: &Plan<'_>, cases: &[DirectionCase]) -> Result<Self, CliError> {
        let adapted = cases.iter().filter_map(|case| match case {
            DirectionCase::Adapted(case) => Some(&case.pattern),
            _ => None,
        });
        let mut distinct: Vec<&WarpExpression> = Vec::new();
        for pattern in adapted {
            if plan.effort.parts == Parts::Predicted {
                let message = format!("--predict-only does not apply to {pattern}: {UNPREDICTED}");
                return Err(CliError::Usage(message));
            }
            if plan.integrals.all().iter().any(Integral::is_irradiance) {
                return Err(CliError::Usage(format!(
                    "--project does not apply to {pattern}; name a coefficient as \"f * ylm:l=2,m=1\""
                )));
            }
            if !distinct.contains(&&pattern.density) {
                distinct.push(&pattern.density);
            }
        }
        let strategies = strategies_of(&distinct, plan.domain, plan.effort.session)?;
        let pairs = distinct.into_iter().cloned().zip(strategies.into_iter().flatten());
        Ok(Self { densities: pairs.collect(), n_integrals: plan.integrals.all().len() })
    }

    /// Returns the maximum nominal work of a case.
    pub(super) fn work(&self, case: &AdaptedCase, effort: &Effort<'_>) -> f64 {
        let AdaptedCase { pattern, n_points } = case;
        let count = case.trials(effort).count as f64;
        self.n_integrals as f64 * count * pattern.trial_work(*n_points)
    }

    /// Returns the rows of a case, one for each integral, all from the same directions; none if this
    /// run does not have all results.
    pub(super) fn rows(
        &self,
        plan: &Plan<'_>,
        case: &AdaptedCase,
        experiments: Option<&CaseExperiments>,
        joint: &mut JointTrials<'_>,
        progress: &Progress,
    ) -> Result<Vec<Row>, CliError> {
        let AdaptedCase { pattern, n_points } = case;
        let trials = case.trials(&plan.effort);
        let own = self.densities.iter().find(|(warp, _)| *warp == pattern.density);
        let Some((_, strategy)) = own else { return Ok(Vec::new()) };
        let experiment = |i: usize| match experiments {
            Some(CaseExperiments::Single(each)) => each.get(i),
            _ => None,
        };
        let work = pattern.trial_work(*n_points);
        let mut rows = Vec::new();
        for (i, (integral, predictor)) in
            plan.integrals.in_rows().zip(joint.predictors()).enumerate()
        {
            let estimates = |range, progress: &dyn SamplerProgress| {
                predictor.adapted_estimates(pattern, strategy, *n_points, range, progress)
            };
            let failed = |e| CliError::Failed(format!("{pattern}: {e}"));
            let name = format!("{} of {}", integral.name, case.name());
            let compute = |range: Range<u64>| {
                let share = Share::new(progress, (range.end - range.start) as f64 * work);
                let estimates = estimates(range, &share).map_err(failed)?;
                share.finish().map_err(CliError::failed)?;
                Ok(estimates)
            };
            let size = (trials.count, work);
            let known = match trials.until {
                Some(_) => None,
                None => plan.effort.estimates(&name, size, progress, Vec::extend, compute)?,
            };
            let Some(experiment) = experiment(i) else { continue };
            let comparison = match (known, trials.until) {
                (Some(known), _) => {
                    experiment.comparison(Prediction::UNKNOWN, Measurement::new(known))
                }
                (None, Some(_)) => {
                    let share = Share::new(progress, trials.count as f64 * work);
                    let mut source = |range| estimates(range, &share);
                    let measured =
                        experiment.measure(&mut source, Prediction::UNKNOWN, trials, &share);
                    let comparison = measured.map_err(failed)?;
                    share.finish().map_err(CliError::failed)?;
                    comparison
                }
                (None, None) => continue,
            };
            rows.push(Row {
                integrand: integral.name,
                integral: integral.label,
                is_main: integral.is_main,
                domain: plan.domain.to_string(),
                sampler: DirectionSampler::Adapted(pattern.clone()).name(),
                requested: *n_points,
                comparison,
                lmax: 0,
                realizations: 0,
                power: Vec::new(),
                white_variance: predictor.white_variance(*n_points),
                n_effective: None,
                largest: None,
                is_unpredictable: true,
            });
        }
        Ok(rows)
    }
}
