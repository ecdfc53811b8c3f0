//! Rows of predicted and measured variance on the unit square, for `variance` and `compare`.

use sphvar_samplers::{Square, SquarePattern};
use sphvar_sh::Frequencies;
use sphvar_spectrum::SquareResolution;
use sphvar_variance::{
    Comparison, Experiment, Measurement, PredictionBudget, SquarePredictor, Trials,
};

use super::cases::Case;
use super::effort::EffortArgs;
use super::rows::{Effort, Known, Predicted, Row, ShownEnergy, finished, known_of};
use crate::error::CliError;
use crate::flags::{NO_HARMONICS, ONE_DOMAIN, ProjectArgs, USE_KMAX};
use crate::global::Global;
use crate::integrands::NamedSquareIntegrand;
use crate::memory::check_memory;
use crate::progress::Progress;

/// The largest frequency of spectra that are shown.
const MAX_SHOWN: usize = 256;

/// Rejects options that do not apply to the square, and returns the settings of a run; set
/// `whole_spectra` if the spectra are shown.
pub(super) fn settings<'a>(
    args: &EffortArgs,
    project: ProjectArgs,
    other: &[(&str, bool, &str)],
    global: &'a Global,
    whole_spectra: bool,
) -> Result<Effort<'a>, CliError> {
    args.square.without(&[
        ("--hemisphere", args.domain.hemisphere, ONE_DOMAIN),
        ("--lmax", args.lmax.lmax.is_some(), USE_KMAX),
        ("--project", project.project.is_some(), NO_HARMONICS),
        ("--method", args.transform.is_method_chosen(), "its transform is fast (--epsilon)"),
    ])?;
    args.square.without(other)?;
    if let Some(kmax) = args.kmax.kmax {
        check_frequencies(kmax)?;
    }
    args.settings(args.kmax.kmax, global, whole_spectra)
}

/// Rejects a largest frequency whose spectra exist for no pattern or do not fit in memory.
fn check_frequencies(kmax: usize) -> Result<(), CliError> {
    let max = Frequencies::MAX_KMAX;
    if kmax > max {
        return Err(CliError::Usage(format!("--kmax: the largest frequency is {max}, got {kmax}")));
    }
    // Bytes of the grid of the transform and of the tables of pairs of frequencies, per kmax^2.
    const BYTES: f64 = 300.0;
    check_memory(&format!("a spectrum to frequency {kmax} (--kmax)"), BYTES * (kmax as f64).powi(2))
}

/// Runs all cases, with one progress bar, and returns the rows in the order of the cases, with the
/// energies of the integrand; `None` if this run keeps only a part of the work.
pub(super) fn run(
    integrand: &NamedSquareIntegrand,
    effort: &Effort<'_>,
    cases: &[Case<SquarePattern>],
) -> Result<Option<(Vec<Row>, ShownEnergy)>, CliError> {
    let wrong = |e| CliError::Usage(format!("{}: {e}", integrand.name));
    let budget = PredictionBudget::DEFAULT;
    let predictor =
        SquarePredictor::new(&*integrand.function, effort.seed, budget).map_err(wrong)?;
    let mut predictor = predictor.with_options(effort.spectra);
    effort.check(1)?;
    let mut work = 0.0;
    for case in cases {
        let trials = effort.trials_of::<Square>(case.sampler());
        work += trials.work_of::<Square>(case.sampler());
        if effort.does_all() && effort.is_predicted() {
            work += predictor.work(case.sampler())?;
        }
    }
    let progress = Progress::new(work, effort.session);
    let known = effort.known(|| {
        let cases: Vec<_> = cases.iter().collect();
        known_of(&mut predictor, effort, &cases)
    })?;
    let mut rows = Vec::new();
    for (i, case) in cases.iter().enumerate() {
        progress.stage(&format!("{} N = {}", case.pattern.label(), case.n_points()));
        let experiment = known.as_ref().and_then(|known| known.experiments.get(i));
        let predicted = if effort.is_predicted() {
            effort.predicted(&case.name(), || predict(&mut predictor, effort, case, &progress))?
        } else {
            Some(Predicted::default())
        };
        let measured = measure(&predictor, effort, case, (experiment, &predicted), &progress)?;
        if let (Some(predicted), Some(comparison)) = (predicted, measured) {
            rows.push(case.row(integrand.name.clone(), &predictor, predicted, comparison));
        }
    }
    finished(rows, known.map(Known::shown::<Frequencies>), effort)
}

/// Returns the comparison for a case; `None` if this run does not have all results.
fn measure(
    predictor: &SquarePredictor<'_>,
    effort: &Effort<'_>,
    case: &Case<SquarePattern>,
    (experiment, predicted): (Option<&Experiment>, &Option<Predicted>),
    progress: &Progress,
) -> Result<Option<Comparison>, CliError> {
    let trials = effort.trials_of::<Square>(case.sampler());
    let mut source = |range| predictor.estimates(case.sampler(), range, progress);
    let known = experiment.zip(predicted.as_ref());
    if trials.until.is_some() {
        let Some((experiment, predicted)) = known else { return Ok(None) };
        let prediction = predicted.prediction();
        return Ok(Some(experiment.measure(&mut source, prediction, trials, progress)?));
    }
    let size = (trials.count, Trials::new(1).work_of::<Square>(case.sampler()));
    let compute = |range| Ok(source(range)?);
    let estimates = effort.estimates(&case.name(), size, progress, Vec::extend, compute)?;
    Ok(estimates.zip(known).map(|(estimates, (experiment, predicted))| {
        experiment.comparison(predicted.prediction(), Measurement::new(estimates))
    }))
}

/// Returns what the row of a case contains of its prediction, with the spectrum if it is shown.
fn predict(
    predictor: &mut SquarePredictor<'_>,
    effort: &Effort<'_>,
    case: &Case<SquarePattern>,
    progress: &Progress,
) -> Result<Predicted, CliError> {
    let share = effort.share(progress, predictor.work(case.sampler())?);
    let mut point = predictor.predict(case.sampler(), &share)?;
    share.finish().map_err(CliError::failed)?;
    if effort.whole_spectra && effort.spectra.lmax.is_none() {
        let natural = SquareResolution::natural_frequency(case.n_points()).min(MAX_SHOWN);
        if point.spectrum.bands().kmax() < natural {
            let shown = Frequencies::new(natural).map_err(CliError::failed)?;
            point.spectrum = predictor.spectrum_to(case.sampler(), &point, &shown)?;
        }
    }
    Ok(case.predicted(&point, effort.whole_spectra))
}
