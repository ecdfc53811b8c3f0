//! Rows of predicted and measured variance, for `variance` and `compare`.

use sphvar_integrands::{Energy, Integrand};
use sphvar_samplers::{Domain, Pattern, Sampler, Share};
use sphvar_spectrum::Resolution;
use sphvar_variance::{
    Comparison, JointTrials, Method, Precision, PredictedPoint, PredictionBudget, Predictor,
    SpectrumOptions, Trials, check_degree as check_settled, prediction_degree, settled_degree,
};

use crate::error::CliError;
use crate::flags::missing_count;
use crate::integrands::{Integral, Integrals, NamedIntegrand, check_domain};
use crate::memory::{check_degree, check_memory, check_transform};
use crate::patterns;
use crate::point_sets::n_effective;
use crate::progress::Progress;

/// The settings of a run for all patterns and numbers of points.
pub(super) struct Plan<'a> {
    /// The integrand of rates and charts, the last integral.
    pub(super) integrand: &'a NamedIntegrand<'a>,
    pub(super) integrals: &'a Integrals<'a>,
    pub(super) domain: Domain,
    pub(super) seed: u64,
    /// The number of trials, or the initial one, if the user gave one.
    pub(super) trials: Option<u64>,
    /// The requested precision of measured variances.
    pub(super) until: Option<Precision>,
    /// The number of realizations of a spectrum, if the user states it.
    pub(super) realizations: Option<u64>,
    /// The largest degree of a spectrum, if the user states it.
    pub(super) lmax: Option<usize>,
    /// The method and accuracy of spectra.
    pub(super) method: Method,
    pub(super) epsilon: f64,
    /// Whether spectra extend to 4 sqrt(N) even if the integrand needs less, because they are
    /// shown.
    pub(super) whole_spectra: bool,
    pub(super) quiet: bool,
}

/// One pattern at one number of points.
pub(super) struct Case {
    pub(super) pattern: Pattern,
    /// The requested number of points.
    pub(super) requested: usize,
    sampler: Box<dyn Sampler>,
}

impl Case {
    /// Returns the pattern with `requested` points, or with the nearest valid count.
    pub(super) fn new(
        pattern: Pattern,
        requested: usize,
        domain: Domain,
        nearest: bool,
    ) -> Result<Self, CliError> {
        let sampler = patterns::build(&pattern, requested, domain, nearest)?;
        Ok(Self { pattern, requested, sampler })
    }

    /// Returns every pattern at every number of points, each case once. A single file has one case,
    /// at its own number.
    pub(super) fn all(
        patterns: &[Pattern],
        counts: &[usize],
        domain: Domain,
        nearest: bool,
    ) -> Result<Vec<Self>, CliError> {
        let mut cases: Vec<Self> = Vec::new();
        for pattern in patterns {
            let own = pattern.own_count();
            if own.is_none() && counts.is_empty() {
                return Err(missing_count());
            }
            let counts = own.as_ref().map_or(counts, std::slice::from_ref);
            for &n in counts {
                let case = Self::new(pattern.clone(), n, domain, nearest)?;
                let same = |c: &Self| c.pattern == *pattern && c.n_points() == case.n_points();
                if !cases.iter().any(same) {
                    cases.push(case);
                }
            }
        }
        Ok(cases)
    }

    pub(super) fn sampler(&self) -> &dyn Sampler {
        &*self.sampler
    }

    pub(super) fn n_points(&self) -> usize {
        self.sampler.n_points()
    }
}

/// The results of one case for one integral.
pub(super) struct Row {
    /// The place of the integral among those of the plan.
    pub(super) integral: usize,
    /// Whether it is the integral of rates and charts.
    pub(super) is_main: bool,
    pub(super) pattern: Pattern,
    pub(super) requested: usize,
    pub(super) comparison: Comparison,
    /// The effective number of points, if they have weights.
    pub(super) n_effective: Option<f64>,
}

/// Runs all cases, with one progress bar, and returns the rows in the order of the cases, those of
/// all integrals for each, with the energies of the last integral.
pub(super) fn run(plan: &Plan<'_>, cases: &[Case]) -> Result<(Vec<Row>, Energy), CliError> {
    check(plan, cases)?;
    let announce = |integral: &'_ Integral<'_>, lmax: usize| {
        if integral.is_announced() {
            integral.integrand.announce_energies(plan.domain, lmax, plan.quiet);
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
        work += joint.work(&*case.sampler)? + plan.trials_of(&*case.sampler).work(&*case.sampler);
    }
    let progress = Progress::new(work, plan.quiet);
    let mut rows = Vec::new();
    for case in cases {
        progress.stage(&format!("{} N = {}", case.pattern.label(), case.n_points()));
        let predicted = plan.predict(&mut joint, case, &progress)?;
        let trials = plan.trials_of(&*case.sampler);
        let comparisons = joint.measure(predicted, &*case.sampler, trials, &progress)?;
        let main = comparisons.len().saturating_sub(1);
        for (integral, comparison) in comparisons.into_iter().enumerate() {
            let n_effective = n_effective(&*case.sampler, &comparison.predicted.spectrum);
            let (pattern, requested) = (case.pattern.clone(), case.requested);
            let is_main = integral == main;
            rows.push(Row { integral, is_main, pattern, requested, comparison, n_effective });
        }
    }
    let mut predictors: Vec<_> = joint.predictors().collect();
    let Some(predictor) = predictors.pop() else { return Err(missing_count()) };
    if plan.whole_spectra {
        let max_points = cases.iter().map(Case::n_points).max().unwrap_or(0);
        predictor.energy_to(Resolution::natural_degree(max_points))?;
    }
    Ok((rows, predictor.energy().clone()))
}

/// Rejects cases that cannot be run.
pub(super) fn check(plan: &Plan<'_>, cases: &[Case]) -> Result<(), CliError> {
    check_domain(plan.integrand, plan.domain)?;
    plan.integrand.announce_bias(plan.domain, plan.quiet);
    if plan.realizations == Some(1) {
        return Err(CliError::Usage(
            "--spectrum-realizations must be at least 2 for an error of the prediction, got 1"
                .to_owned(),
        ));
    }
    for case in cases {
        let n_points = case.n_points();
        let lmax = plan.lmax.unwrap_or_else(|| plan.needed_degree(case));
        check_degree("the spectra (--lmax)", lmax)?;
        let Plan { method, epsilon, .. } = *plan;
        let resolution = Resolution { lmax, n_points, method, epsilon };
        check_transform(resolution, plan.spectrum_realizations(&*case.sampler, lmax))?;
    }
    check_trials(plan)?;
    check_cut_sum(plan, cases)
}

/// Rejects numbers of trials whose estimates do not fit in memory.
fn check_trials(plan: &Plan<'_>) -> Result<(), CliError> {
    let min_trials = plan.trials.unwrap_or(Precision::MIN_TRIALS);
    let (what, max_trials) = match plan.until {
        Some(Precision { max_trials, .. }) if max_trials < min_trials => {
            return Err(CliError::Usage(format!(
                "--max-realizations must be at least {min_trials}, the initial number of trials, got {max_trials}"
            )));
        }
        Some(Precision { max_trials, .. }) => ("--max-realizations", max_trials),
        None => ("-m", plan.trials.unwrap_or(Trials::DEFAULT)),
    };
    let integrals = plan.integrals.all().len() as f64;
    check_memory(&format!("{what} {max_trials}"), 8.0 * integrals * max_trials as f64)
}

/// Rejects a user's largest degree at which predictions would not depend on the pattern. White
/// noise is the only pattern whose power is 1 in every degree, the value assumed beyond the largest
/// one.
fn check_cut_sum(plan: &Plan<'_>, cases: &[Case]) -> Result<(), CliError> {
    let Some(lmax) = plan.lmax else {
        return Ok(());
    };
    let low: Vec<&Case> = cases
        .iter()
        .filter(|c| c.pattern != Pattern::WhiteNoise && lmax < settled_degree(&*c.sampler))
        .collect();
    let Some(highest) = low.iter().map(|c| settled_degree(&*c.sampler)).max() else {
        return Ok(());
    };
    check_degree("the integrand's energies", highest)?;
    let energy = plan.integrand.function.energy(plan.domain, highest)?;
    for case in low {
        check_settled(&*case.sampler, &energy, lmax)
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
        let predictor = Predictor::new(integrand, domain, self.seed, PredictionBudget::DEFAULT)?;
        let Self { lmax, realizations, method, epsilon, .. } = *self;
        Ok(predictor.with_options(SpectrumOptions { lmax, realizations, method, epsilon }))
    }

    /// Returns the trials of a sampler: the user's number or the default.
    pub(super) fn trials_of(&self, sampler: &dyn Sampler) -> Trials {
        let count = self.trials.unwrap_or_else(|| Trials::default_for(sampler).count);
        let max_trials = self.until.map_or(u64::MAX, |precision| precision.max_trials);
        Trials { count: count.min(max_trials), until: self.until }
    }

    /// Returns the maximum number of realizations from which a pattern's spectrum is estimated.
    pub(super) fn spectrum_realizations(&self, sampler: &dyn Sampler, lmax: usize) -> u64 {
        let budget = PredictionBudget::DEFAULT;
        self.realizations.unwrap_or_else(|| budget.realizations(sampler, lmax))
    }

    /// Returns the predictions for a case, with the spectrum as far as it is shown.
    fn predict(
        &self,
        joint: &mut JointTrials<'_>,
        case: &Case,
        progress: &Progress,
    ) -> Result<Vec<PredictedPoint>, CliError> {
        let share = Share::new(progress, joint.work(&*case.sampler)?);
        let mut points = joint.predict(&*case.sampler, &share)?;
        share.finish().map_err(CliError::failed)?;
        let natural = Resolution::natural_degree(case.n_points());
        if let (Some(point), Some(predictor)) = (points.last_mut(), joint.predictors().last())
            && self.whole_spectra
            && self.lmax.is_none()
            && point.spectrum.lmax() < natural
        {
            point.spectrum = predictor.spectrum_to(&*case.sampler, point, &natural)?;
        }
        Ok(points)
    }

    /// Returns the maximum degree that a spectrum needs.
    fn needed_degree(&self, case: &Case) -> usize {
        let needed = prediction_degree(&*case.sampler, &*self.integrand.function);
        let shown =
            if self.whole_spectra { Resolution::natural_degree(case.n_points()) } else { 0 };
        needed.max(shown)
    }
}
