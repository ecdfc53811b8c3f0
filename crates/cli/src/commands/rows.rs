//! Rows of predicted and measured variance, as `variance` and `compare` show them.

use clap::Args;
use serde::Serialize;
use sphvar_integrands::{Energy, Integrand};
use sphvar_samplers::{Domain, Pattern, Sampler, Share};
use sphvar_spectrum::Resolution;
use sphvar_variance::{
    Comparison, Method, Precision, PredictedPoint, PredictionBudget, Predictor, SpectrumOptions,
    Trials, check_degree as check_settled, prediction_degree, settled_degree,
};

use crate::error::CliError;
use crate::global::Global;
use crate::integrands::{NamedIntegrand, check_domain};
use crate::memory::{check_degree, check_memory, check_transform};
use crate::patterns;
use crate::progress::Progress;
use crate::report::{full, short};
use crate::share::parse_share;
use crate::transforms::TransformArgs;

/// Flags that say how variances are predicted and measured.
#[derive(Debug, Args)]
pub(crate) struct EffortArgs {
    /// Trials from which each variance is measured; with --until-rel, those to begin with
    #[arg(short = 'm', long, default_value_t = 1000, value_name = "M")]
    pub(crate) realizations: u64,
    /// Double the trials until the relative standard error of each variance is at most this, such as
    /// 2% or 0.02
    #[arg(long, value_name = "E", value_parser = parse_share, allow_negative_numbers = true)]
    pub(crate) until_rel: Option<f64>,
    /// Trials at which --until-rel gives up
    #[arg(long, default_value_t = 1_000_000, value_name = "M", requires = "until_rel")]
    pub(crate) max_realizations: u64,
    /// Realizations per estimated spectrum [default: none where a closed form is available; otherwise
    /// until the prediction is known to 2 %, within a fixed budget]
    #[arg(long, value_name = "R")]
    pub(crate) spectrum_realizations: Option<u64>,
    /// Largest degree of the spectra [default: 4 sqrt(N), for lattices 40 sqrt(N)]
    #[arg(long)]
    pub(crate) lmax: Option<usize>,
    #[command(flatten)]
    pub(crate) transform: TransformArgs,
    /// Integrate over the hemisphere z >= 0
    #[arg(long)]
    pub(crate) hemisphere: bool,
}

impl EffortArgs {
    /// The plan for an integrand; `whole_spectra` are wanted if they are shown.
    pub(super) fn plan<'a>(
        &self,
        integrand: &'a NamedIntegrand,
        global: &Global,
        whole_spectra: bool,
    ) -> Result<Plan<'a>, CliError> {
        let (method, epsilon) = self.transform.checked()?;
        Ok(Plan {
            integrand,
            domain: super::domain(self.hemisphere),
            seed: global.seed,
            trials: Trials {
                count: self.realizations,
                until: self
                    .until_rel
                    .map(|relative| Precision { relative, most: self.max_realizations }),
            },
            realizations: self.spectrum_realizations,
            lmax: self.lmax,
            method,
            epsilon,
            whole_spectra,
            quiet: global.quiet,
        })
    }
}

/// What is to be run for every pattern and number of points.
pub(super) struct Plan<'a> {
    pub(super) integrand: &'a NamedIntegrand,
    pub(super) domain: Domain,
    pub(super) seed: u64,
    pub(super) trials: Trials,
    /// The number of realizations of a spectrum, if the user has a wish.
    pub(super) realizations: Option<u64>,
    /// The largest degree of a spectrum, if the user has a wish.
    pub(super) lmax: Option<usize>,
    /// How spectra are computed, and how accurately.
    pub(super) method: Method,
    pub(super) epsilon: f64,
    /// Spectra go to 4 sqrt(N) even if the integrand needs less: they are to be shown.
    pub(super) whole_spectra: bool,
    pub(super) quiet: bool,
}

/// One pattern at one number of points.
pub(super) struct Case {
    pub(super) pattern: Pattern,
    /// The number of points that the user asked for.
    pub(super) asked: usize,
    sampler: Box<dyn Sampler>,
}

impl Case {
    /// The pattern with `asked` points, or with the nearest number that it has.
    pub(super) fn new(
        pattern: Pattern,
        asked: usize,
        domain: Domain,
        nearest: bool,
    ) -> Result<Self, CliError> {
        let sampler = patterns::build(&pattern, asked, domain, nearest)?;
        Ok(Self { pattern, asked, sampler })
    }

    pub(super) fn n_points(&self) -> usize {
        self.sampler.n_points()
    }
}

/// The results of one case.
pub(super) struct Row {
    pub(super) pattern: Pattern,
    pub(super) asked: usize,
    pub(super) comparison: Comparison,
}

/// Runs all cases, with one progress bar, and returns the rows in the order of the cases with the
/// integrand's energies.
pub(super) fn run(plan: &Plan<'_>, cases: &[Case]) -> Result<(Vec<Row>, Energy), CliError> {
    check(plan, cases)?;
    let on_energies = |lmax: usize| plan.integrand.announce_energies(plan.domain, lmax, plan.quiet);
    let mut predictor =
        plan.predictor_of(&*plan.integrand.function, plan.domain)?.on_energies(&on_energies);
    let mut work = 0.0;
    for case in cases {
        work += predictor.work(&*case.sampler)? + plan.trials.work(&*case.sampler);
    }
    let progress = Progress::new(work, plan.quiet);
    let rows = cases
        .iter()
        .map(|case| {
            progress.stage(&format!("{} N = {}", case.pattern, case.n_points()));
            let predicted = plan.predict(&mut predictor, case, &progress)?;
            let comparison =
                predictor.measure(predicted, &*case.sampler, plan.trials, &progress)?;
            Ok(Row { pattern: case.pattern.clone(), asked: case.asked, comparison })
        })
        .collect::<Result<Vec<Row>, CliError>>()?;
    if plan.whole_spectra {
        let most = cases.iter().map(Case::n_points).max().unwrap_or(0);
        predictor.energy_to(Resolution::natural_degree(most))?;
    }
    Ok((rows, predictor.energy().clone()))
}

/// Rejects what cannot be run.
pub(super) fn check(plan: &Plan<'_>, cases: &[Case]) -> Result<(), CliError> {
    check_domain(plan.integrand, plan.domain)?;
    if plan.trials.count < Precision::MIN_TRIALS {
        return Err(CliError::Usage(format!(
            "the error of a measured variance needs at least {} trials (-m), got {}",
            Precision::MIN_TRIALS,
            plan.trials.count
        )));
    }
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

/// Refuses numbers of trials whose estimates do not fit into memory.
fn check_trials(plan: &Plan<'_>) -> Result<(), CliError> {
    let trials = plan.trials;
    let (what, most) = match trials.until {
        Some(Precision { most, .. }) if most < trials.count => {
            return Err(CliError::Usage(format!(
                "--max-realizations must be at least the {} trials of -m, got {most}",
                trials.count
            )));
        }
        Some(Precision { most, .. }) => ("--max-realizations", most),
        None => ("-m", trials.count),
    };
    check_memory(&format!("{what} {most}"), 8.0 * most as f64)
}

/// Refuses a largest degree of the user's with which predictions would tell nothing of the patterns. White noise is the
/// one pattern whose power is 1 in every degree, as it is taken to be beyond the last one.
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
    /// What makes the predictions, for this integrand and others of the same run.
    pub(super) fn predictor_of<'a>(
        &self,
        integrand: &'a dyn Integrand,
        domain: Domain,
    ) -> Result<Predictor<'a>, CliError> {
        let predictor = Predictor::new(integrand, domain, self.seed, PredictionBudget::USUAL)?;
        let Self { lmax, realizations, method, epsilon, .. } = *self;
        Ok(predictor.with_options(SpectrumOptions { lmax, realizations, method, epsilon }))
    }

    /// From how many realizations at most the spectrum of a pattern is estimated.
    pub(super) fn spectrum_realizations(&self, sampler: &dyn Sampler, lmax: usize) -> u64 {
        let budget = PredictionBudget::USUAL;
        self.realizations.unwrap_or_else(|| budget.realizations(sampler, lmax))
    }

    /// The prediction for a case, with a spectrum as far as it is shown.
    fn predict(
        &self,
        predictor: &mut Predictor<'_>,
        case: &Case,
        progress: &Progress,
    ) -> Result<PredictedPoint, CliError> {
        let share = Share::new(progress, predictor.work(&*case.sampler)?);
        let mut point = predictor.predict(&*case.sampler, &share)?;
        share.finish().map_err(CliError::failed)?;
        let natural = Resolution::natural_degree(case.n_points());
        if self.whole_spectra && self.lmax.is_none() && point.spectrum.lmax() < natural {
            point.spectrum = predictor.spectrum_to(&*case.sampler, &point, natural)?;
        }
        Ok(point)
    }

    /// The degree that a spectrum needs at most.
    fn needed_degree(&self, case: &Case) -> usize {
        let needed = prediction_degree(&*case.sampler, &*self.integrand.function);
        let shown =
            if self.whole_spectra { Resolution::natural_degree(case.n_points()) } else { 0 };
        needed.max(shown)
    }
}

/// A row as scripts see it.
#[derive(Debug, Serialize)]
pub(super) struct RowRecord {
    sampler: String,
    integrand: String,
    domain: &'static str,
    asked: usize,
    n: usize,
    lmax: usize,
    realizations: u64,
    trials: usize,
    predicted: f64,
    predicted_stderr: f64,
    predicted_tail: f64,
    measured: f64,
    measured_stderr: f64,
    ratio: f64,
    ratio_stderr: f64,
    z: f64,
    mean: f64,
    mean_stderr: f64,
    exact: Option<f64>,
    predicted_tail_error: f64,
    /// 95 % intervals.
    predicted_low: f64,
    predicted_high: f64,
    measured_low: f64,
    measured_high: f64,
    /// Mean minus exact in standard errors, and its probability without a bias.
    bias_z: Option<f64>,
    bias_p: Option<f64>,
    /// Why numbers are missing.
    remark: Option<&'static str>,
}

/// The remark of a row whose measured variance has no error.
const TOO_FEW: &str = "too few trials see the integrand";

/// The confidence of the intervals in files.
const CONFIDENCE: f64 = 0.95;

impl RowRecord {
    pub(super) fn new(row: &Row, plan: &Plan<'_>) -> Self {
        let Comparison { predicted, measurement, .. } = &row.comparison;
        let PredictedPoint { spectrum, prediction } = predicted;
        let (ratio, ratio_stderr) = row.comparison.ratio();
        let (predicted_low, predicted_high) = prediction.interval(CONFIDENCE);
        let measured = row.comparison.measured_interval(CONFIDENCE);
        let (measured_low, measured_high) = measured.unwrap_or((f64::NAN, f64::NAN));
        let bias = row.comparison.bias();
        let remark = row.comparison.sees_too_little().then_some(TOO_FEW);
        // What the trials have not seen is no error of theirs.
        let known = |x: f64| if remark.is_some() { f64::NAN } else { x };
        Self {
            sampler: row.pattern.to_string(),
            integrand: plan.integrand.name.clone(),
            domain: plan.domain.name(),
            asked: row.asked,
            n: spectrum.n_points(),
            lmax: spectrum.lmax(),
            realizations: spectrum.realizations(),
            trials: measurement.estimates().len(),
            predicted: prediction.variance,
            predicted_stderr: prediction.stderr,
            predicted_tail: prediction.tail,
            measured: measurement.variance(),
            measured_stderr: known(measurement.variance() * row.comparison.error().relative()),
            ratio,
            ratio_stderr,
            z: row.comparison.z_score(),
            mean: measurement.mean(),
            mean_stderr: known(measurement.mean_stderr()),
            exact: row.comparison.exact,
            predicted_tail_error: prediction.tail_error,
            predicted_low,
            predicted_high,
            measured_low,
            measured_high,
            bias_z: bias.map(|b| b.z),
            bias_p: bias.map(|b| b.p_value),
            remark,
        }
    }

    /// Measured minus predicted variance in standard errors; NaN without a verdict.
    pub(super) fn z(&self) -> f64 {
        self.z
    }

    /// A line for every row whose measured variance has no error.
    pub(super) fn remarks(records: &[Self]) -> String {
        let line = |r: &Self| {
            Some(format!("{}, N = {}: {} (-m {}).\n", r.sampler, r.n, r.remark?, r.trials))
        };
        records.iter().filter_map(line).collect()
    }

    /// The heading of [`Self::cells`].
    pub(super) const HEADING: [&'static str; 10] =
        ["sampler", "N asked", "N", "predicted", "+-", "measured", "+-", "ratio", "z", "bias z"];

    /// The row of a table for people.
    pub(super) fn cells(&self) -> Vec<String> {
        // Where a variance is 0 there is no ratio.
        let ratio = if self.ratio.is_finite() && self.ratio_stderr.is_finite() {
            format!("{:.3} +- {:.3}", self.ratio, self.ratio_stderr)
        } else {
            "-".to_owned()
        };
        let score = |z: f64| match z.abs() {
            small if small < 1e4 => format!("{z:+.1}"),
            large if large.is_nan() => "-".to_owned(),
            _ => short(z),
        };
        let error = |x: f64| if x.is_finite() { format!("{x:.1e}") } else { "-".to_owned() };
        vec![
            self.sampler.to_owned(),
            self.asked.to_string(),
            self.n.to_string(),
            short(self.predicted),
            error(self.predicted_stderr.hypot(self.predicted_tail_error)),
            short(self.measured),
            error(self.measured_stderr),
            ratio,
            score(self.z),
            self.bias_z.map_or("-".to_owned(), score),
        ]
    }

    /// The heading of [`Self::record`].
    pub(super) const COLUMNS: &'static str = "sampler,integrand,domain,asked,n,lmax,realizations,\
         trials,predicted,predicted_stderr,predicted_tail,measured,measured_stderr,ratio,\
         ratio_stderr,z,mean,mean_stderr,exact,predicted_tail_error,predicted_low,predicted_high,\
         measured_low,measured_high,bias_z,bias_p";

    /// The row of a CSV file.
    pub(super) fn record(&self) -> Vec<String> {
        let mut cells = vec![
            self.sampler.to_owned(),
            self.integrand.clone(),
            self.domain.to_owned(),
            self.asked.to_string(),
            self.n.to_string(),
            self.lmax.to_string(),
            self.realizations.to_string(),
            self.trials.to_string(),
        ];
        let numbers = [
            self.predicted,
            self.predicted_stderr,
            self.predicted_tail,
            self.measured,
            self.measured_stderr,
            self.ratio,
            self.ratio_stderr,
            self.z,
            self.mean,
            self.mean_stderr,
            self.exact.unwrap_or(f64::NAN),
            self.predicted_tail_error,
            self.predicted_low,
            self.predicted_high,
            self.measured_low,
            self.measured_high,
            self.bias_z.unwrap_or(f64::NAN),
            self.bias_p.unwrap_or(f64::NAN),
        ];
        cells.extend(numbers.map(full));
        cells
    }
}
