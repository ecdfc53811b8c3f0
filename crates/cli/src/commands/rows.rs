//! Rows of predicted and measured variance, for `variance` and `compare`.

use std::ops::Range;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sphvar_integrands::{Energy, Integrand};
use sphvar_samplers::{Domain, Pattern, Progress as _, Sampler, Share};
use sphvar_spectrum::{Method, Resolution, SpectrumAccumulator};
use sphvar_variance::{
    Comparison, Experiment, IntegrationSpace, JointTrials, LargestSeen, Precision, PredictedPoint,
    Prediction, PredictionBudget, PredictionSums, Predictor, PredictorOn, SpectrumOptions, Trials,
    WarpedExperiment, check_degree as check_settled, prediction_degree, settled_degree, trial_work,
};

use super::adapted_rows::AdaptedDensities;
use super::cases::{AdaptedCase, Case, DirectionCase};
use super::power_chart::{BandTexts, ShownBands, largest_radius};
use super::warped_rows::{WarpedIntegrals, WarpedPredictors};
use crate::error::CliError;
use crate::flags::missing_count;
use crate::integrands::{Integral, Integrals, NamedIntegrand, check_domain};
use crate::memory::{check_degree, check_memory, check_transform};
use crate::patterns::{BandsOf, PredictedPattern, SamplerName, n_effective};
use crate::progress::Progress;
use crate::session::Session;
use crate::shards::Divided;

/// The settings of a run for all patterns and numbers of points.
pub(super) struct Plan<'a> {
    /// The integrand of rates and charts, the last integral.
    pub(super) integrand: &'a NamedIntegrand<'a>,
    pub(super) integrals: &'a Integrals<'a>,
    pub(super) domain: Domain,
    pub(super) effort: Effort<'a>,
}

/// The settings of predictions and measurements, for integrands of any space.
#[derive(Clone, Copy)]
pub(super) struct Effort<'a> {
    pub(super) seed: u64,
    /// The number of trials, or the initial one, if the user gave one.
    pub(super) trials: Option<u64>,
    /// The requested precision of measured variances.
    pub(super) until: Option<Precision>,
    /// The user's settings for spectra.
    pub(super) spectra: SpectrumOptions,
    /// Whether spectra extend to 4 sqrt(N) even if the integrand needs less, because they are
    /// shown.
    pub(super) whole_spectra: bool,
    pub(super) parts: Parts,
    pub(super) session: &'a Session,
}

/// What a run computes of every case.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Parts {
    /// Predicted and measured variances.
    #[default]
    Both,
    /// Predictions without trials.
    Predicted,
    /// Trials without spectra.
    Measured,
}

/// The results of one case for one integral.
#[derive(Debug)]
pub(super) struct Row {
    /// The integrand as it was written.
    pub(super) integrand: String,
    /// The name of the integral in tables, if there are several.
    pub(super) integral: Option<String>,
    /// Whether it is the integral of rates and charts.
    pub(super) is_main: bool,
    /// The name of the space.
    pub(super) domain: String,
    pub(super) sampler: SamplerName,
    /// The requested number of points.
    pub(super) requested: usize,
    pub(super) comparison: Comparison,
    /// The largest degree or frequency of the spectrum.
    pub(super) lmax: usize,
    /// The realizations from which the spectrum was estimated; 0 for a closed form.
    pub(super) realizations: u64,
    /// Radius, power and its standard error; empty if spectra are not shown.
    pub(super) power: Vec<(usize, f64, f64)>,
    /// The variance of independent uniform points.
    pub(super) white_variance: f64,
    /// The effective number of points, if they have weights.
    pub(super) n_effective: Option<f64>,
    /// The largest ratio of integrand and density, of a warped pattern.
    pub(super) largest: Option<LargestSeen>,
    /// Whether nothing predicts the variance of its sampler.
    pub(super) is_unpredictable: bool,
}

impl Row {
    /// Returns whether the sampler samples a density: whether it is a warped pattern or has no
    /// prediction.
    pub(super) fn is_warped(&self) -> bool {
        self.largest.is_some() || self.is_unpredictable
    }
}

/// What rows contain of a prediction.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Predicted {
    /// `None` if nothing was predicted.
    prediction: Option<Prediction>,
    /// The largest degree or frequency of the spectrum.
    lmax: usize,
    realizations: u64,
    n_effective: Option<f64>,
    /// Radius, power and its standard error, if the spectrum is shown.
    power: Vec<(usize, f64, f64)>,
}

impl Predicted {
    /// Returns the predicted variance, of which nothing is known if it was not predicted.
    pub(super) fn prediction(&self) -> Prediction {
        self.prediction.unwrap_or(Prediction::UNKNOWN)
    }
}

impl<P: PredictedPattern<Bands: ShownBands>> Case<P> {
    /// Returns what a row contains of a prediction for this case, with the spectrum if it is shown.
    pub(super) fn predicted(
        &self,
        point: &PredictedPoint<BandsOf<P>>,
        is_shown: bool,
    ) -> Predicted {
        let PredictedPoint { spectrum, prediction } = point;
        Predicted {
            prediction: Some(*prediction),
            lmax: largest_radius(spectrum),
            realizations: spectrum.realizations(),
            n_effective: n_effective::<P>(self.sampler(), spectrum),
            power: if is_shown { <BandsOf<P>>::power_by_radius(spectrum) } else { Vec::new() },
        }
    }

    /// Returns the results for the only integral.
    pub(super) fn row(
        &self,
        integrand: String,
        predictor: &PredictorOn<'_, P::Space>,
        predicted: Predicted,
        comparison: Comparison,
    ) -> Row {
        let Predicted { lmax, realizations, n_effective, power, .. } = predicted;
        Row {
            integrand,
            integral: None,
            is_main: true,
            domain: predictor.space().to_string(),
            sampler: SamplerName::of(&self.pattern),
            requested: self.requested,
            lmax,
            realizations,
            power,
            white_variance: predictor.white_variance(comparison.n_points),
            n_effective,
            comparison,
            largest: None,
            is_unpredictable: false,
        }
    }
}

/// The energies of the main integrand, for charts.
pub(super) struct ShownEnergy {
    pub(super) by_radius: Vec<f64>,
    pub(super) total: f64,
    pub(super) texts: &'static BandTexts,
}

/// What follows from the energies of the integrands. All energies of a run are computed in one place,
/// because their roundings depend on the highest degree so far.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Known<E> {
    /// What is known of the trials of each case.
    pub(super) experiments: Vec<E>,
    by_radius: Vec<f64>,
    total: f64,
}

impl<E> Known<E> {
    /// Returns what is known of the trials, with the energies of the main integrand.
    pub(super) fn new<B: ShownBands>(experiments: Vec<E>, energy: &Energy<B>) -> Self {
        Self { experiments, by_radius: B::energy_by_radius(energy), total: energy.total() }
    }

    /// Returns the energies for charts.
    pub(super) fn shown<B: ShownBands>(self) -> ShownEnergy {
        ShownEnergy { by_radius: self.by_radius, total: self.total, texts: B::TEXTS }
    }
}

/// What is known of the trials of a case, for each integral.
#[derive(Debug, Serialize, Deserialize)]
pub(super) enum CaseExperiments {
    Single(Vec<Experiment>),
    Warped(Vec<WarpedExperiment>),
}

impl Effort<'_> {
    /// Returns the trials of a sampler: the user's number or the default.
    pub(super) fn trials_of<S: IntegrationSpace>(&self, sampler: S::SamplerRef<'_>) -> Trials {
        self.trials_or(|| Trials::default_of::<S>(sampler))
    }

    /// Returns whether this run does all of the work, neither a part nor a merge of parts.
    pub(super) fn does_all(&self) -> bool {
        !self.session.tasks().is_part() && !self.session.tasks().is_merge()
    }

    /// Returns what follows from energies; `None` if another part has it.
    pub(super) fn known<E: Serialize + DeserializeOwned>(
        &self,
        mut compute: impl FnMut() -> Result<Known<E>, CliError>,
    ) -> Result<Option<Known<E>>, CliError> {
        let tasks = self.session.tasks();
        match tasks.once("energies", &mut compute)? {
            // The part that has them is missing from a partial merge.
            None if tasks.is_merge() => compute().map(Some),
            known => Ok(known),
        }
    }

    /// Returns the prediction of a case; `None` if another part has it.
    pub(super) fn predicted<T: Serialize + DeserializeOwned>(
        &self,
        case: &str,
        compute: impl FnOnce() -> Result<T, CliError>,
    ) -> Result<Option<T>, CliError> {
        self.session.tasks().once(&format!("prediction of {case}"), compute)
    }

    /// Announces the work of a prediction, which the expected work of a part does not contain.
    pub(super) fn expect(&self, progress: &Progress, work: f64) {
        if !self.does_all() {
            progress.expect(work);
        }
    }

    /// Returns the share of the progress that predictions of some work have.
    pub(super) fn share<'p>(&self, progress: &'p Progress, work: f64) -> Share<'p> {
        self.expect(progress, work);
        Share::new(progress, work)
    }

    /// Returns whether the run has results to report: not if it keeps only a part of the work.
    ///
    /// # Errors
    ///
    /// If the parts of a partial merge have no complete row.
    pub(super) fn has_rows<T>(&self, rows: &[T]) -> Result<bool, CliError> {
        if self.session.tasks().is_part() {
            return Ok(false);
        }
        if rows.is_empty() {
            let message = "the given parts have no row with its prediction and some of its trials; add other parts";
            return Err(CliError::File(message.to_owned()));
        }
        Ok(true)
    }

    /// Returns the estimates of a number of trials of a case, each of nominal work `work`; `None` if
    /// this run keeps only a part of them. `append` adds those of the trials that follow.
    pub(super) fn estimates<T: Serialize + DeserializeOwned>(
        &self,
        case: &str,
        (count, work): (u64, f64),
        progress: &Progress,
        append: impl Fn(&mut T, T),
        compute: impl FnMut(Range<u64>) -> Result<T, CliError>,
    ) -> Result<Option<T>, CliError> {
        let task = Divided { name: &format!("trials of {case}"), count, work };
        let append = |all: &mut T, next: T| {
            append(all, next);
            Ok(())
        };
        self.session.tasks().divided(task, progress, append, compute)
    }

    /// Returns whether variances are predicted.
    pub(super) fn is_predicted(&self) -> bool {
        self.parts != Parts::Measured
    }

    /// Returns the user's number of trials or the default; none if variances are only predicted.
    pub(super) fn trials_or(&self, default: impl FnOnce() -> Trials) -> Trials {
        if self.parts == Parts::Predicted {
            return Trials::new(0);
        }
        let count = self.trials.unwrap_or_else(|| default().count);
        let max_trials = self.until.map_or(u64::MAX, |precision| precision.max_trials);
        Trials { count: count.min(max_trials), until: self.until }
    }

    /// Rejects numbers of realizations without an error, and numbers of trials whose estimates of
    /// all integrals do not fit in memory.
    pub(super) fn check(&self, integrals: usize) -> Result<(), CliError> {
        if self.spectra.realizations == Some(1) {
            return Err(CliError::Usage(
                "--spectrum-realizations must be at least 2 for an error of the prediction, got 1"
                    .to_owned(),
            ));
        }
        let min_trials = self.trials.unwrap_or(Precision::MIN_TRIALS);
        let (what, max_trials) = match self.until {
            Some(Precision { max_trials, .. }) if max_trials < min_trials => {
                return Err(CliError::Usage(format!(
                    "--max-realizations must be at least {min_trials}, the initial number of trials, got {max_trials}"
                )));
            }
            Some(Precision { max_trials, .. }) => ("--max-realizations", max_trials),
            None => ("-m", self.trials.unwrap_or(Trials::DEFAULT)),
        };
        let bytes = 8.0 * integrals as f64 * max_trials as f64;
        check_memory(&format!("{what} {max_trials}"), bytes)
    }
}

/// Runs all cases, with one progress bar, and returns the rows in the order of the cases, those of
/// all integrals for each, with the energies of the last integral; `None` if this run keeps only a
/// part of the work.
pub(super) fn run(
    plan: &Plan<'_>,
    cases: &[DirectionCase],
) -> Result<Option<(Vec<Row>, ShownEnergy)>, CliError> {
    check(plan, cases)?;
    let effort = &plan.effort;
    let warped = cases.iter().filter_map(DirectionCase::warped).map(|case| &case.pattern);
    let pulled_back = WarpedIntegrals::new(plan.integrals, plan.domain, effort.session, warped)?;
    let mut warped = pulled_back.predictors(effort)?;
    let adapted = AdaptedDensities::new(plan, cases)?;
    let announce = |integral: &'_ Integral<'_>, lmax: usize| {
        if integral.is_announced() {
            integral.integrand.announce_energies(plan.domain, lmax, effort.session);
        }
    };
    let integrals = plan.integrals.all().iter();
    let on_energies: Vec<_> = integrals.map(|i| move |lmax: usize| announce(i, lmax)).collect();
    let mut each = on_energies.iter();
    let mut joint = plan.integrals.trials(|integral| {
        let predictor = plan.predictor_of(&*integral.integrand.function, plan.domain)?;
        Ok(match each.next() {
            Some(on_energies) => predictor.on_energies(on_energies),
            None => predictor,
        })
    })?;
    let mut work = 0.0;
    for case in cases {
        if effort.does_all() {
            work += predicted_work(case, effort, &mut joint, &mut warped)?;
        }
        work += match case {
            DirectionCase::Uniform(case) => {
                effort.trials_of::<Domain>(case.sampler()).work(case.sampler())
            }
            DirectionCase::Warped(case) => pulled_back.trials_work(case, effort),
            DirectionCase::Adapted(case) => adapted.work(case, effort),
        };
    }
    let progress = Progress::new(work, effort.session);
    let known = effort.known(|| plan.known(cases, &mut joint, &mut warped))?;
    let mut rows = Vec::new();
    for (i, case) in cases.iter().enumerate() {
        progress.stage(&case.stage());
        let experiments = known.as_ref().and_then(|known| known.experiments.get(i));
        rows.extend(match case {
            DirectionCase::Uniform(case) => plan.rows(&mut joint, case, experiments, &progress)?,
            DirectionCase::Warped(case) => {
                let white: Vec<f64> =
                    joint.predictors().map(|p| p.white_variance(case.n_points)).collect();
                warped.rows(plan, case, experiments, &white, &progress)?
            }
            DirectionCase::Adapted(case) => {
                adapted.rows(plan, case, experiments, &mut joint, &progress)?
            }
        });
    }
    finished(rows, known.map(Known::shown::<Domain>), effort)
}

/// Returns the results of a run; `None` if it keeps only a part of the work.
pub(super) fn finished(
    rows: Vec<Row>,
    energy: Option<ShownEnergy>,
    effort: &Effort<'_>,
) -> Result<Option<(Vec<Row>, ShownEnergy)>, CliError> {
    let has_rows = effort.has_rows(&rows)?;
    Ok(energy.filter(|_| has_rows).map(|energy| (rows, energy)))
}

/// Returns what follows from the energies of the only integrand of cases on the sphere or the square,
/// whose variances are predicted.
pub(super) fn known_of<P: PredictedPattern<Bands: ShownBands>>(
    predictor: &mut PredictorOn<'_, P::Space>,
    effort: &Effort<'_>,
    cases: &[&Case<P>],
) -> Result<Known<Experiment>, CliError> {
    if effort.is_predicted() && !effort.does_all() {
        // These computed the first energies of a run that does all of the work.
        for case in cases {
            predictor.work(case.sampler())?;
        }
    }
    let mut experiments = Vec::new();
    for case in cases {
        if effort.is_predicted() {
            predictor.prepare(case.sampler())?;
        }
        experiments.push(predictor.experiment(case.sampler()));
    }
    Ok(Known::new(experiments, predictor.energy()))
}

/// Returns the maximum nominal work of the predictions of a case.
fn predicted_work(
    case: &DirectionCase,
    effort: &Effort<'_>,
    joint: &mut JointTrials<'_>,
    warped: &mut WarpedPredictors<'_>,
) -> Result<f64, CliError> {
    match case {
        DirectionCase::Uniform(case) if effort.is_predicted() => Ok(joint.work(case.sampler())?),
        DirectionCase::Warped(case) if effort.is_predicted() => warped.work(case),
        _ => Ok(0.0),
    }
}

/// Rejects cases that cannot be run.
pub(super) fn check(plan: &Plan<'_>, cases: &[DirectionCase]) -> Result<(), CliError> {
    if plan.effort.spectra.lmax.is_some() {
        let why = "its prediction is a sum over frequencies of the unit square";
        DirectionCase::all_uniform(cases, "--lmax", why)?;
    }
    let has_uniform = cases.iter().any(|case| case.uniform().is_some());
    if plan.effort.spectra.method != Method::Auto && !has_uniform {
        let why = "its transform on the unit square is fast (--epsilon)";
        DirectionCase::all_uniform(cases, "--method", why)?;
    }
    check_uniform(plan, &cases.iter().filter_map(DirectionCase::uniform).collect::<Vec<_>>())
}

/// Rejects cases of uniform patterns that cannot be run.
pub(super) fn check_uniform(plan: &Plan<'_>, cases: &[&Case]) -> Result<(), CliError> {
    check_domain(plan.integrand, plan.domain)?;
    plan.integrand.announce_bias(plan.domain, plan.effort.session);
    let SpectrumOptions { method, epsilon, .. } = plan.effort.spectra;
    for case in cases {
        let n_points = case.n_points();
        let lmax = plan.effort.spectra.lmax.unwrap_or_else(|| plan.needed_degree(case));
        check_degree("the spectra (--lmax)", lmax)?;
        let resolution = Resolution { lmax, n_points, method, epsilon };
        check_transform(resolution, plan.spectrum_realizations(case.sampler(), lmax))?;
    }
    plan.effort.check(plan.integrals.all().len())?;
    check_cut_sum(plan, cases)
}

/// Rejects a user's largest degree at which predictions would not depend on the pattern. White
/// noise is the only pattern whose power is 1 in every degree, the value assumed beyond the largest
/// one.
fn check_cut_sum(plan: &Plan<'_>, cases: &[&Case]) -> Result<(), CliError> {
    let Some(lmax) = plan.effort.spectra.lmax else {
        return Ok(());
    };
    let low: Vec<&Case> = cases
        .iter()
        .copied()
        .filter(|c| c.pattern != Pattern::WhiteNoise && lmax < settled_degree(c.sampler()))
        .collect();
    let Some(highest) = low.iter().map(|c| settled_degree(c.sampler())).max() else {
        return Ok(());
    };
    check_degree("the integrand's energies", highest)?;
    let energy = plan.integrand.function.energy(plan.domain, highest)?;
    for case in low {
        check_settled(case.sampler(), &energy, lmax)
            .map_err(|e| CliError::Usage(format!("--lmax {lmax}, {}: {e}", case.pattern)))?;
    }
    Ok(())
}

impl Plan<'_> {
    /// Returns what is estimated, for titles.
    pub(super) fn subject(&self) -> String {
        let is_irradiance = self.integrals.all().last().is_some_and(Integral::is_irradiance);
        let verb = if is_irradiance { "the" } else { "integrating" };
        format!("{verb} {}", self.integrand.name)
    }

    /// Returns the predictor for this integrand and others of the same run.
    pub(super) fn predictor_of<'a>(
        &self,
        integrand: &'a dyn Integrand,
        domain: Domain,
    ) -> Result<Predictor<'a>, sphvar_variance::Error> {
        let Effort { seed, spectra, .. } = self.effort;
        let predictor = Predictor::new(integrand, domain, seed, PredictionBudget::DEFAULT)?;
        Ok(predictor.with_options(spectra))
    }

    /// Returns the maximum number of realizations from which a pattern's spectrum is estimated.
    pub(super) fn spectrum_realizations(&self, sampler: &dyn Sampler, lmax: usize) -> u64 {
        let budget = PredictionBudget::DEFAULT;
        let chosen = self.effort.spectra.realizations;
        chosen.unwrap_or_else(|| budget.realizations(sampler, lmax))
    }

    /// Returns what follows from the energies of the integrands.
    fn known(
        &self,
        cases: &[DirectionCase],
        joint: &mut JointTrials<'_>,
        warped: &mut WarpedPredictors<'_>,
    ) -> Result<Known<CaseExperiments>, CliError> {
        let effort = &self.effort;
        if !effort.does_all() {
            // These computed the first energies of a run that does all of the work.
            for case in cases {
                predicted_work(case, effort, joint, warped)?;
            }
        }
        let mut experiments = Vec::new();
        for case in cases {
            experiments.push(match case {
                DirectionCase::Uniform(case) => {
                    if effort.is_predicted() {
                        joint.prepare(case.sampler())?;
                    }
                    CaseExperiments::Single(joint.experiments(case.sampler()))
                }
                DirectionCase::Warped(case) => {
                    CaseExperiments::Warped(warped.experiments(case, effort)?)
                }
                DirectionCase::Adapted(AdaptedCase { pattern, n_points }) => {
                    let each = joint.predictors();
                    let each = each.map(|p| p.adapted_experiment(pattern, *n_points));
                    CaseExperiments::Single(each.collect())
                }
            });
        }
        let Some(predictor) = joint.predictors().last() else { return Err(missing_count()) };
        if effort.whole_spectra {
            let max_points = cases.iter().map(DirectionCase::n_points).max().unwrap_or(0);
            predictor.energy_to(Resolution::natural_degree(max_points))?;
        }
        Ok(Known::new(experiments, predictor.energy()))
    }

    /// Returns the rows of a case, one for each integral; none if this run does not have all results.
    fn rows(
        &self,
        joint: &mut JointTrials<'_>,
        case: &Case,
        experiments: Option<&CaseExperiments>,
        progress: &Progress,
    ) -> Result<Vec<Row>, CliError> {
        let (name, sampler) = (case.name(), case.sampler());
        let fixed = joint.predictors().next().and_then(|p| p.fixed_realizations(sampler));
        let predicted = match fixed {
            _ if !self.effort.is_predicted() => {
                Some(vec![Predicted::default(); self.integrals.all().len()])
            }
            Some(count) => self.predict_from(count, joint, case, progress)?,
            None => self.effort.predicted(&name, || self.predict(joint, case, progress))?,
        };
        let trials = self.effort.trials_of::<Domain>(sampler);
        let estimates = match trials.until {
            Some(_) => None,
            None => {
                let size = (trials.count, trial_work(sampler));
                let compute = |range| Ok(joint.estimates(sampler, range, progress)?);
                let estimates =
                    self.effort.estimates(&name, size, progress, Vec::extend, compute)?;
                let Some(estimates) = estimates else { return Ok(Vec::new()) };
                Some(estimates)
            }
        };
        let (Some(CaseExperiments::Single(experiments)), Some(predicted)) =
            (experiments, predicted)
        else {
            return Ok(Vec::new());
        };
        let predictions: Vec<Prediction> = predicted.iter().map(Predicted::prediction).collect();
        let comparisons = match estimates {
            Some(estimates) => joint.comparisons(experiments, &predictions, &estimates),
            None => joint.measure_known(experiments, &predictions, sampler, trials, progress)?,
        };
        let results = predicted.into_iter().zip(comparisons).zip(joint.predictors());
        let mut rows = Vec::new();
        for (integral, ((predicted, comparison), predictor)) in
            self.integrals.in_rows().zip(results)
        {
            let row = case.row(integral.name, predictor, predicted, comparison);
            rows.push(Row { integral: integral.label, is_main: integral.is_main, ..row });
        }
        Ok(rows)
    }

    /// Returns what rows contain of the predictions for a case, with the spectrum if it is shown.
    fn predict(
        &self,
        joint: &mut JointTrials<'_>,
        case: &Case,
        progress: &Progress,
    ) -> Result<Vec<Predicted>, CliError> {
        let share = self.effort.share(progress, joint.work(case.sampler())?);
        let mut points = joint.predict(case.sampler(), &share)?;
        share.finish().map_err(CliError::failed)?;
        let natural = Resolution::natural_degree(case.n_points());
        if let (Some(point), Some(predictor)) = (points.last_mut(), joint.predictors().last())
            && self.effort.whole_spectra
            && self.effort.spectra.lmax.is_none()
            && point.spectrum.lmax() < natural
        {
            point.spectrum = predictor.spectrum_to(case.sampler(), point, &natural)?;
        }
        Ok(self.in_rows(case, &points))
    }

    /// Returns what rows contain of the predictions for a random pattern from a number of realizations,
    /// which this run may have only in part.
    fn predict_from(
        &self,
        count: u64,
        joint: &mut JointTrials<'_>,
        case: &Case,
        progress: &Progress,
    ) -> Result<Option<Vec<Predicted>>, CliError> {
        let (sampler, tasks) = (case.sampler(), self.effort.session.tasks());
        let work = joint.work(sampler)? / count.max(1) as f64;
        let name = format!("spectrum of {}", case.name());
        let task = Divided { name: &name, count, work };
        let append = |sums: &mut PredictionSums, next: PredictionSums| Ok(sums.merge(&next)?);
        let sums = tasks.divided(task, progress, append, |range| {
            let share = self.effort.share(progress, work * (range.end - range.start) as f64);
            let sums = joint.prediction_sums(sampler, range, &share)?;
            share.finish().map_err(CliError::failed)?;
            Ok(sums)
        })?;
        let natural = Resolution::natural_degree(case.n_points());
        let Some(predictor) = joint.predictors().last() else { return Err(missing_count()) };
        let is_extended = self.effort.whole_spectra
            && self.effort.spectra.lmax.is_none()
            && predictor.spectrum_degree(sampler)? < natural;
        let shown = if is_extended {
            let name = format!("{name} to degree {natural}");
            let task = Divided { name: &name, count, work };
            let append = |sums: &mut SpectrumAccumulator, next| Ok(sums.try_merge(&next)?);
            let compute = |range| Ok(predictor.spectrum_sums(sampler, natural, range, &())?);
            Some(tasks.divided(task, progress, append, compute)?)
        } else {
            None
        };
        let Some(sums) = sums else { return Ok(None) };
        let mut points = joint.predict_from(sampler, &sums)?;
        match shown {
            Some(None) => return Ok(None),
            Some(Some(shown)) => {
                if let Some(point) = points.last_mut() {
                    point.spectrum = shown.finish()?;
                }
            }
            None => {}
        }
        Ok(Some(self.in_rows(case, &points)))
    }

    /// Returns what the rows of a case contain of its predictions.
    fn in_rows(&self, case: &Case, points: &[PredictedPoint]) -> Vec<Predicted> {
        let named = points.iter().zip(self.integrals.in_rows());
        let predicted = named.map(|(point, integral)| {
            case.predicted(point, self.effort.whole_spectra && integral.is_main)
        });
        predicted.collect()
    }

    /// Returns the maximum degree that a spectrum needs.
    fn needed_degree(&self, case: &Case) -> usize {
        let needed = prediction_degree(case.sampler(), &*self.integrand.function);
        let shown =
            if self.effort.whole_spectra { Resolution::natural_degree(case.n_points()) } else { 0 };
        needed.max(shown)
    }
}
