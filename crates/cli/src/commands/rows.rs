//! Rows of predicted and measured variance, for `variance` and `compare`.

use sphvar_integrands::{Energy, Integrand};
use sphvar_samplers::{Domain, Pattern, Sampler, Share};
use sphvar_spectrum::{Method, Resolution, Spectrum};
use sphvar_variance::{
    Comparison, IntegrationSpace, JointTrials, LargestSeen, Precision, PredictedPoint, Prediction,
    PredictionBudget, Predictor, PredictorOn, SpectrumOptions, Trials,
    check_degree as check_settled, prediction_degree, settled_degree,
};

use super::adapted_rows::AdaptedDensities;
use super::cases::{Case, DirectionCase};
use super::power_chart::{BandTexts, ShownBands, largest_radius};
use super::warped_rows::WarpedIntegrals;
use crate::error::CliError;
use crate::flags::missing_count;
use crate::integrands::{Integral, Integrals, NamedIntegrand, check_domain};
use crate::memory::{check_degree, check_memory, check_transform};
use crate::patterns::{BandsOf, PredictedPattern, SamplerName, n_effective};
use crate::progress::Progress;
use crate::session::Session;

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

impl<P: PredictedPattern<Bands: ShownBands>> Case<P> {
    /// Returns the results for the only integral; without a spectrum, if none was computed.
    pub(super) fn row(
        &self,
        integrand: String,
        predictor: &PredictorOn<'_, P::Space>,
        spectrum: Option<&Spectrum<BandsOf<P>>>,
        comparison: Comparison,
        is_shown: bool,
    ) -> Row {
        let shown = spectrum.filter(|_| is_shown);
        Row {
            integrand,
            integral: None,
            is_main: true,
            domain: predictor.space().to_string(),
            sampler: SamplerName::of(&self.pattern),
            requested: self.requested,
            lmax: spectrum.map_or(0, largest_radius),
            realizations: spectrum.map_or(0, Spectrum::realizations),
            power: shown.map_or_else(Vec::new, <BandsOf<P>>::power_by_radius),
            white_variance: predictor.white_variance(comparison.n_points),
            n_effective: spectrum.and_then(|s| n_effective::<P>(self.sampler(), s)),
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

impl ShownEnergy {
    pub(super) fn new<B: ShownBands>(energy: &Energy<B>) -> Self {
        Self { by_radius: B::energy_by_radius(energy), total: energy.total(), texts: B::TEXTS }
    }
}

impl Effort<'_> {
    /// Returns the trials of a sampler: the user's number or the default.
    pub(super) fn trials_of<S: IntegrationSpace>(&self, sampler: S::SamplerRef<'_>) -> Trials {
        self.trials_or(|| Trials::default_of::<S>(sampler))
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
/// all integrals for each, with the energies of the last integral.
pub(super) fn run(
    plan: &Plan<'_>,
    cases: &[DirectionCase],
) -> Result<(Vec<Row>, ShownEnergy), CliError> {
    check(plan, cases)?;
    let warped = cases.iter().filter_map(DirectionCase::warped).map(|case| &case.pattern);
    let pulled_back =
        WarpedIntegrals::new(plan.integrals, plan.domain, plan.effort.session, warped)?;
    let mut warped = pulled_back.predictors(&plan.effort)?;
    let adapted = AdaptedDensities::new(plan, cases)?;
    let announce = |integral: &'_ Integral<'_>, lmax: usize| {
        if integral.is_announced() {
            integral.integrand.announce_energies(plan.domain, lmax, plan.effort.session);
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
        work += match case {
            DirectionCase::Uniform(case) => {
                let sampler = case.sampler();
                let predicted = if plan.effort.is_predicted() { joint.work(sampler)? } else { 0.0 };
                predicted + plan.effort.trials_of::<Domain>(sampler).work(sampler)
            }
            DirectionCase::Warped(case) => warped.work(case, &plan.effort)?,
            DirectionCase::Adapted(case) => adapted.work(case, &plan.effort),
        };
    }
    let progress = Progress::new(work, plan.effort.session);
    let mut rows = Vec::new();
    for case in cases {
        progress.stage(&case.stage());
        rows.extend(match case {
            DirectionCase::Uniform(case) => plan.rows(&mut joint, case, &progress)?,
            DirectionCase::Warped(case) => {
                let white: Vec<f64> =
                    joint.predictors().map(|p| p.white_variance(case.n_points)).collect();
                warped.rows(plan, case, &white, &progress)?
            }
            DirectionCase::Adapted(case) => adapted.rows(plan, case, &mut joint, &progress)?,
        });
    }
    let mut predictors: Vec<_> = joint.predictors().collect();
    let Some(predictor) = predictors.pop() else { return Err(missing_count()) };
    if plan.effort.whole_spectra {
        let max_points = cases.iter().map(DirectionCase::n_points).max().unwrap_or(0);
        predictor.energy_to(Resolution::natural_degree(max_points))?;
    }
    Ok((rows, ShownEnergy::new(predictor.energy())))
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

    /// Returns the rows of a case, one for each integral.
    fn rows(
        &self,
        joint: &mut JointTrials<'_>,
        case: &Case,
        progress: &Progress,
    ) -> Result<Vec<Row>, CliError> {
        let predicted: Vec<Option<PredictedPoint>> = if self.effort.is_predicted() {
            self.predict(joint, case, progress)?.into_iter().map(Some).collect()
        } else {
            vec![None; joint.predictors().count()]
        };
        let trials = self.effort.trials_of::<Domain>(case.sampler());
        let prediction = |point: &PredictedPoint| point.prediction;
        let predictions: Vec<_> = predicted
            .iter()
            .map(|point| point.as_ref().map_or(Prediction::UNKNOWN, prediction))
            .collect();
        let comparisons = joint.measure(&predictions, case.sampler(), trials, progress)?;
        let results = predicted.iter().zip(comparisons).zip(joint.predictors());
        let mut rows = Vec::new();
        for (integral, ((point, comparison), predictor)) in self.integrals.in_rows().zip(results) {
            let is_shown = self.effort.whole_spectra && integral.is_main;
            let spectrum = point.as_ref().map(|point| &point.spectrum);
            let row = case.row(integral.name, predictor, spectrum, comparison, is_shown);
            rows.push(Row { integral: integral.label, is_main: integral.is_main, ..row });
        }
        Ok(rows)
    }

    /// Returns the predictions for a case, with the spectrum as far as it is shown.
    fn predict(
        &self,
        joint: &mut JointTrials<'_>,
        case: &Case,
        progress: &Progress,
    ) -> Result<Vec<PredictedPoint>, CliError> {
        let share = Share::new(progress, joint.work(case.sampler())?);
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
        Ok(points)
    }

    /// Returns the maximum degree that a spectrum needs.
    fn needed_degree(&self, case: &Case) -> usize {
        let needed = prediction_degree(case.sampler(), &*self.integrand.function);
        let shown =
            if self.effort.whole_spectra { Resolution::natural_degree(case.n_points()) } else { 0 };
        needed.max(shown)
    }
}
