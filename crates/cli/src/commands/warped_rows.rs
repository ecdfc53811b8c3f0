//! Rows of warped patterns, for `variance` and `compare`.

use serde::{Deserialize, Serialize};
use sphvar_integrands::{Heuristic, PulledBack, WarpExpression};
use sphvar_samplers::Domain;
use sphvar_variance::{
    Prediction, PredictionBudget, WarpedEstimates, WarpedExperiment, WarpedPattern, WarpedPoint,
    WarpedPredictor,
};

use super::cases::WarpedCase;
use super::power_chart::largest_frequency;
use super::rows::{CaseExperiments, Effort, Plan, Row};
use crate::error::CliError;
use crate::integrands::{Integral, Integrals, strategies_of};
use crate::patterns::DirectionSampler;
use crate::progress::Progress;
use crate::session::Session;

/// All integrals pulled back by the warps of all cases, each distinct warp once.
pub(super) struct WarpedIntegrals<'a> {
    warps: Vec<WarpedIntegral<'a>>,
}

/// All integrals pulled back by one warp.
struct WarpedIntegral<'a> {
    warp: WarpExpression,
    heuristic: Heuristic,
    /// For every integral its exact value and the functions of all strategies.
    integrals: Vec<(Option<f64>, Vec<PulledBack<'a>>)>,
}

impl WarpedIntegral<'_> {
    fn is_of(&self, pattern: &WarpedPattern) -> bool {
        (&self.warp, self.heuristic) == (&pattern.warp, pattern.heuristic)
    }
}

impl<'a> WarpedIntegrals<'a> {
    /// Reads the files of the warps of patterns and pulls back the integrands on a domain.
    pub(super) fn new<'p>(
        integrals: &Integrals<'a>,
        domain: Domain,
        session: &Session,
        patterns: impl Iterator<Item = &'p WarpedPattern>,
    ) -> Result<Self, CliError> {
        let mut distinct: Vec<&WarpedPattern> = Vec::new();
        for pattern in patterns {
            let same =
                |p: &&WarpedPattern| (&p.warp, p.heuristic) == (&pattern.warp, pattern.heuristic);
            if !distinct.iter().any(same) {
                distinct.push(pattern);
            }
        }
        if let Some(pattern) = distinct.first()
            && integrals.all().iter().any(Integral::is_irradiance)
        {
            return Err(CliError::Usage(format!(
                "--project does not apply to {pattern}; name a coefficient as \"f * ylm:l=2,m=1\""
            )));
        }
        let warps: Vec<&WarpExpression> = distinct.iter().map(|pattern| &pattern.warp).collect();
        let strategies = strategies_of(&warps, domain, session)?;
        let pulled_back = |(pattern, strategies): (&WarpedPattern, Vec<_>)| {
            let (warp, heuristic) = (pattern.warp.clone(), pattern.heuristic);
            let of_integral = |integral: &Integral<'a>| {
                let function = &*integral.integrand.function;
                let tolerance = PulledBack::TOLERANCE;
                PulledBack::of_strategies(function, domain, &strategies, heuristic, tolerance)
                    .map(|functions| (function.exact(domain), functions))
                    .map_err(|e| CliError::Failed(format!("{pattern}: {e}")))
            };
            let integrals = integrals.all().iter().map(of_integral);
            Ok(WarpedIntegral { warp, heuristic, integrals: integrals.collect::<Result<_, _>>()? })
        };
        let warps = distinct.into_iter().zip(strategies).map(pulled_back);
        Ok(Self { warps: warps.collect::<Result<_, CliError>>()? })
    }

    /// Returns integral `at` pulled back by the warp of a pattern with one strategy.
    pub(super) fn only_strategy(
        &self,
        pattern: &WarpedPattern,
        at: usize,
    ) -> Option<&PulledBack<'a>> {
        let warp = self.warps.iter().find(|warp| warp.is_of(pattern))?;
        warp.integrals.get(at)?.1.first()
    }

    /// Returns the nominal work of the trials of a case.
    pub(super) fn trials_work(&self, case: &WarpedCase, effort: &Effort<'_>) -> f64 {
        let of_one = case.trials(effort).count as f64 * case.pattern.trial_work(case.n_points);
        let warp = self.warps.iter().find(|warp| warp.is_of(&case.pattern));
        warp.map_or(0, |warp| warp.integrals.len()) as f64 * of_one
    }

    /// Returns the predictors of all integrals.
    pub(super) fn predictors(&self, effort: &Effort<'_>) -> Result<WarpedPredictors<'_>, CliError> {
        let mut warps = Vec::new();
        for warp in &self.warps {
            let mut predictors = Vec::new();
            for (exact, functions) in &warp.integrals {
                let budget = PredictionBudget::DEFAULT;
                let predictor =
                    WarpedPredictor::new(functions, effort.seed, budget)?.without_spectra();
                predictors.push(predictor.with_options(effort.spectra).with_integral(*exact));
            }
            warps.push((warp, predictors));
        }
        Ok(WarpedPredictors { warps })
    }
}

/// The predictors of all integrals for every warp.
pub(super) struct WarpedPredictors<'a> {
    warps: Vec<(&'a WarpedIntegral<'a>, Vec<WarpedPredictor<'a>>)>,
}

impl<'a> WarpedPredictors<'a> {
    fn of(&mut self, case: &WarpedCase) -> impl Iterator<Item = &mut WarpedPredictor<'a>> {
        let own = self.warps.iter_mut().filter(|(warp, _)| warp.is_of(&case.pattern));
        own.flat_map(|(_, predictors)| predictors)
    }

    /// Returns the maximum nominal work of the predictions of a case.
    pub(super) fn work(&mut self, case: &WarpedCase) -> Result<f64, CliError> {
        let WarpedCase { pattern, n_points, .. } = case;
        self.of(case).map(|predictor| Ok(predictor.work(pattern, *n_points)?)).sum()
    }

    /// Returns what is known of the trials of a case for each integral, after the energies of its
    /// predictions have been computed.
    pub(super) fn experiments(
        &mut self,
        case: &WarpedCase,
        effort: &Effort<'_>,
    ) -> Result<Vec<WarpedExperiment>, CliError> {
        let WarpedCase { pattern, n_points, .. } = case;
        let of_one = |predictor: &mut WarpedPredictor<'_>| {
            if effort.is_predicted() {
                predictor.prepare(pattern, *n_points)?;
            }
            Ok(predictor.experiment(pattern, *n_points)?)
        };
        self.of(case).map(of_one).collect()
    }

    /// Returns the rows of a case, one for each integral, all from the same directions; none if this
    /// run does not have all results. `white` are the variances of independent uniform directions.
    pub(super) fn rows(
        &mut self,
        plan: &Plan<'_>,
        case: &WarpedCase,
        experiments: Option<&CaseExperiments>,
        white: &[f64],
        progress: &Progress,
    ) -> Result<Vec<Row>, CliError> {
        let WarpedCase { pattern, requested, n_points } = case;
        let (effort, trials) = (&plan.effort, case.trials(&plan.effort));
        let experiment = |i: usize| match experiments {
            Some(CaseExperiments::Warped(each)) => each.get(i),
            _ => None,
        };
        let mut rows = Vec::new();
        let integrals = plan.integrals.in_rows().zip(white).zip(self.of(case));
        for (i, ((integral, white), predictor)) in integrals.enumerate() {
            let name = format!("{} of {}", integral.name, case.name());
            let predicted = if effort.is_predicted() {
                effort.predicted(&name, || {
                    let share = effort.share(progress, predictor.work(pattern, *n_points)?);
                    let point = predictor.predict(pattern, *n_points, &share)?;
                    share.finish().map_err(CliError::failed)?;
                    Ok(WarpedPrediction::new(&point))
                })?
            } else {
                Some(WarpedPrediction::UNKNOWN)
            };
            let mut compute = |range| predictor.estimates(pattern, *n_points, range, progress);
            let size = (trials.count, pattern.trial_work(*n_points));
            let estimates = match trials.until {
                Some(_) => None,
                None => {
                    effort.estimates(&name, size, progress, WarpedEstimates::append, |range| {
                        Ok(compute(range)?)
                    })?
                }
            };
            let (Some(experiment), Some(predicted)) = (experiment(i), predicted) else { continue };
            let WarpedPrediction { prediction, lmax, realizations } = predicted;
            let measured = match (estimates, trials.until) {
                (Some(estimates), _) => experiment.comparison(prediction, estimates),
                (None, Some(_)) => {
                    experiment.measure(&mut compute, prediction, trials, progress)?
                }
                (None, None) => continue,
            };
            rows.push(Row {
                integrand: integral.name,
                integral: integral.label,
                is_main: integral.is_main,
                domain: plan.domain.to_string(),
                sampler: DirectionSampler::Warped(pattern.clone()).name(),
                requested: *requested,
                comparison: measured.comparison,
                lmax,
                realizations,
                power: Vec::new(),
                white_variance: *white,
                n_effective: None,
                largest: Some(measured.largest),
                is_unpredictable: false,
            });
        }
        Ok(rows)
    }
}

/// What rows contain of a prediction.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct WarpedPrediction {
    prediction: Prediction,
    /// The largest frequency of the spectra.
    lmax: usize,
    realizations: u64,
}

impl WarpedPrediction {
    const UNKNOWN: Self = Self { prediction: Prediction::UNKNOWN, lmax: 0, realizations: 0 };

    fn new(point: &WarpedPoint) -> Self {
        let spectra = || point.strategies.iter().map(|strategy| &strategy.spectrum);
        Self {
            prediction: point.prediction,
            lmax: spectra().map(largest_frequency).max().unwrap_or(0),
            realizations: spectra().map(|s| s.realizations()).max().unwrap_or(0),
        }
    }
}
