//! Rows of tessellations for a density, which are measured only.

use sphvar_integrands::{Strategy, WarpExpression};
use sphvar_samplers::Share;
use sphvar_variance::JointTrials;

use super::cases::{AdaptedCase, DirectionCase};
use super::rows::{Effort, Parts, Plan, Row};
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

    /// Returns the rows of a case, one for each integral, all from the same directions.
    pub(super) fn rows(
        &self,
        plan: &Plan<'_>,
        case: &AdaptedCase,
        joint: &mut JointTrials<'_>,
        progress: &Progress,
    ) -> Result<Vec<Row>, CliError> {
        let AdaptedCase { pattern, n_points } = case;
        let trials = case.trials(&plan.effort);
        let own = self.densities.iter().find(|(warp, _)| *warp == pattern.density);
        let Some((_, strategy)) = own else { return Ok(Vec::new()) };
        let mut rows = Vec::new();
        for (integral, predictor) in plan.integrals.in_rows().zip(joint.predictors()) {
            let share = Share::new(progress, trials.count as f64 * pattern.trial_work(*n_points));
            let comparison = predictor
                .measure_adapted(pattern, strategy, *n_points, trials, &share)
                .map_err(|e| CliError::Failed(format!("{pattern}: {e}")))?;
            share.finish().map_err(CliError::failed)?;
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
