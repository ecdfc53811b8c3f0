//! `sphvar spectrum --square`: the power of frequencies of the unit square.

use std::time::Instant;

use sphvar_samplers::{
    Ensemble, PointSet, Purpose, Square, SquareDistribution, SquarePattern, SquareRealizations,
    SquareSampler, Streams,
};
use sphvar_sh::Frequencies;
use sphvar_spectrum::{
    Accumulator, ExactSquareSpectrum, Method, RadialAccumulator, SpectrumAccumulator,
    SquareResolution, accumulate_square,
};

use super::catalogue::{check_input, open_sets};
use super::square_report::{SquareResult, emit_square};
use super::{
    EstimatedSums, Origin, REALIZATIONS, Remarks, SavedEnsemble, Shard, SpectrumArgs, SquareSums,
    check_outputs, of_realizations,
};
use crate::error::CliError;
use crate::flags::{ONE_DOMAIN, USE_KMAX};
use crate::global::Global;
use crate::instruction_set::instruction_set;
use crate::memory::check_memory;
use crate::patterns;
use crate::point_sets::{FileSets, SetFacts, WeightSums};
use crate::progress::Progress;
use crate::report::Provenance;
use crate::shards::{Divided, Part};

/// What takes the place of options for harmonics and for angles on the sphere.
const OF_SPHERE: &str = "it is for directions";

/// The memory of the sums of a band on every thread, in bytes.
const BAND_BYTES: f64 = 320.0;

/// The source of the point sets.
enum Source {
    Sampler {
        pattern: SquarePattern,
        sampler: Box<dyn SquareSampler>,
    },
    /// The sets of files, `None` if their results are known.
    Files {
        facts: Box<SetFacts>,
        sets: Option<FileSets<Square>>,
    },
}

/// The sets of files whose results are known.
const NO_SETS: &[PointSet<[f64; 2]>] = &[];

impl Source {
    fn new(args: &SpectrumArgs, global: &Global) -> Result<Self, CliError> {
        let Some(name) = &args.sets.sampler.sampler else {
            check_input(args)?;
            let read = || FileSets::read_square(&args.sets.files, &global.session);
            let (facts, sets) = open_sets(global, read)?;
            return Ok(Self::Files { facts: Box::new(facts), sets });
        };
        let (n, nearest) = (args.sets.count.count, args.sets.nearest.nearest);
        let (pattern, sampler) = patterns::sampler_of(name, n, Square, nearest, &global.session)?;
        Ok(Self::Sampler { pattern, sampler })
    }

    /// Returns the name and the number of points.
    fn facts(&self) -> (String, usize) {
        match self {
            Self::Sampler { pattern, sampler } => (pattern.to_string(), sampler.n_points()),
            Self::Files { facts, .. } => (facts.name.clone(), facts.mean_size),
        }
    }
}

/// A spectrum on the square that was computed, with what is reported and saved beside it.
pub(crate) struct SquareComputed {
    /// The sampler with its parameters, or the files.
    pub(crate) name: String,
    pub(crate) result: SquareResult,
    pub(crate) remarks: Remarks,
    /// The sums of the realizations; `None` for a closed form.
    pub(crate) sums: Option<EstimatedSums<SquareSums>>,
    /// The time that the spectrum took.
    pub(crate) seconds: f64,
}

pub(super) fn run(args: &SpectrumArgs, global: &Global) -> Result<(), CliError> {
    check_outputs(args, global)?;
    let Some(computed) = compute(args, global, None)? else {
        return global.session.tasks().without_results();
    };
    let SquareComputed { name, result, remarks, seconds, .. } = computed;
    let provenance = Provenance::new(&global.session, global.seed);
    let out = args.out.out.as_deref();
    emit_square(out, global, &name, &result, &remarks, seconds, &provenance)
}

/// Computes the spectrum of points of the square that the arguments describe, of the realizations of
/// one part if it is given; `None` if this run keeps only a part of the work.
pub(crate) fn compute(
    args: &SpectrumArgs,
    global: &Global,
    only: Option<Part>,
) -> Result<Option<SquareComputed>, CliError> {
    args.square.without(&[
        ("--hemisphere", args.sets.domain.hemisphere, ONE_DOMAIN),
        ("--lmax", args.lmax.lmax.is_some(), USE_KMAX),
        ("--pairs", args.pairs.pairs, OF_SPHERE),
        ("--per-order", args.per_order.is_some(), OF_SPHERE),
        ("--coefficient", args.coefficient.is_some(), OF_SPHERE),
        ("--method", args.transform.checked()?.0 != Method::Auto, OF_SPHERE),
    ])?;
    let source = Source::new(args, global)?;
    let (name, n_points) = source.facts();
    let kmax = args.kmax.kmax.unwrap_or_else(|| SquareResolution::natural_frequency(n_points));
    let max = SquareResolution::MAX_KMAX_WITH_ERRORS;
    if kmax > max {
        return Err(CliError::Usage(format!(
            "--kmax must be at most {max} for spectra, which have every frequency up to it, got {kmax}"
        )));
    }
    let frequencies = Frequencies::new(kmax).map_err(CliError::failed)?;
    let started = Instant::now();
    if let Source::Sampler { pattern, sampler } = &source
        && args.exact
    {
        let result = exact(pattern, &**sampler, &frequencies, global)?;
        let Some(result) = result else { return Ok(None) };
        let weights = WeightSums::of_square_sampler(&**sampler);
        let remarks = Remarks { weights, ..Remarks::default() };
        let seconds = started.elapsed().as_secs_f64();
        return Ok(Some(SquareComputed { name, result, remarks, sums: None, seconds }));
    }
    let sampled = sampled(args, global, &source, frequencies, only)?;
    let Some((result, sums)) = sampled else { return Ok(None) };
    let seconds = started.elapsed().as_secs_f64();
    let remarks = sums.remarks();
    Ok(Some(SquareComputed { name, result, remarks, sums: Some(sums), seconds }))
}

/// Computes the spectrum in closed form; `None` if another part has it.
fn exact(
    pattern: &SquarePattern,
    sampler: &dyn SquareSampler,
    frequencies: &Frequencies,
    global: &Global,
) -> Result<Option<SquareResult>, CliError> {
    let exact = ExactSquareSpectrum::of(sampler).ok_or_else(|| sampled_only(pattern))?;
    let kmax = frequencies.kmax();
    let bytes = exact.bytes(frequencies, rayon::current_num_threads());
    check_memory(&format!("a spectrum to frequency {kmax} (--kmax)"), bytes)?;
    let progress = Progress::new(exact.work(frequencies), &global.session);
    let name = pattern.to_string();
    progress.stage(&name);
    let compute = || Ok(exact.to(frequencies, &progress)?);
    let Some(spectrum) = global.session.tasks().once(&name, compute)? else { return Ok(None) };
    let is_transformed =
        matches!(sampler.distribution(), SquareDistribution::Fixed | SquareDistribution::OneOf(_));
    let spectrum = if is_transformed { spectrum.without_rounding() } else { spectrum };
    Ok(Some(SquareResult::exact(spectrum)))
}

/// Estimates the spectrum from sets.
fn sampled(
    args: &SpectrumArgs,
    global: &Global,
    source: &Source,
    frequencies: Frequencies,
    only: Option<Part>,
) -> Result<Option<(SquareResult, EstimatedSums<SquareSums>)>, CliError> {
    let (name, n_points) = source.facts();
    let kmax = frequencies.kmax();
    let (_, epsilon) = args.transform.checked()?;
    let (given_sets, shifted);
    // The power does not depend on shifts, which given sets do without.
    let (sets, count, set_work): (&dyn Ensemble<[f64; 2]>, u64, f64) = match source {
        Source::Files { facts, sets: Some(sets) } => (sets.sets(), facts.count, 0.0),
        Source::Files { facts, sets: None } => (&NO_SETS, facts.count, 0.0),
        Source::Sampler { sampler, .. } => {
            let given = match sampler.distribution() {
                SquareDistribution::OneOf(sets) if args.realizations.is_none() => Some(sets),
                _ => None,
            };
            if let Some(sets) = given {
                given_sets = sets;
                (&given_sets, sets.len() as u64, 0.0)
            } else {
                let streams = Streams::new(global.seed, Purpose::Pattern, sampler.stream_group());
                shifted = SquareRealizations::shifted(&**sampler, streams);
                let count = args.realizations.unwrap_or(REALIZATIONS);
                (&shifted, count, sampler.nominal_work())
            }
        }
    };
    if count == 0 {
        return Err(CliError::Usage("-m must be at least 1, got 0".to_owned()));
    }
    let is_random = match source {
        Source::Sampler { sampler, .. } => sampler.is_random(),
        Source::Files { .. } => count > 1,
    };
    // One set of a deterministic pattern determines its spectrum.
    let count = if is_random { count } else { 1 };
    let resolution = SquareResolution { frequencies: frequencies.clone(), epsilon };
    let threads = rayon::current_num_threads();
    let bytes = resolution.bytes(n_points, count, threads)
        + BAND_BYTES * frequencies.len() as f64 * threads as f64;
    check_memory(&format!("a spectrum of {n_points} points to frequency {kmax} (--kmax)"), bytes)?;
    let work = set_work + resolution.nominal_work(n_points);
    let progress = Progress::new(count as f64 * work, &global.session);
    progress.stage(&name);
    let empty = (
        SpectrumAccumulator::of_square(frequencies.clone(), n_points)?,
        RadialAccumulator::new(frequencies),
    );
    let task = Divided { name: &name, count, work };
    let sums = of_realizations(only, task, global, &progress, Accumulator::merge, |range| {
        Ok(accumulate_square(sets, &resolution, range, &empty, &progress)?)
    })?;
    let Some((spectrum, radial)) = sums else { return Ok(None) };
    drop(progress);
    let sums = SquareSums { spectrum, radial };
    let result = SquareResult::of_sums(&sums, !is_random)?;
    let ensemble = SavedEnsemble {
        sampler: name,
        is_random,
        domain: (),
        lmax: kmax,
        transform: format!("{epsilon:e}"),
        seed: global.seed,
        realizations: count,
        version: Provenance::new(&global.session, global.seed).version.to_string(),
        instruction_set: instruction_set(),
    };
    let shard = Shard { ensemble, parts: vec![only.unwrap_or(Part::WHOLE)], sums };
    let origin = match source {
        Source::Sampler { pattern, sampler } => {
            let is_file = matches!(pattern, SquarePattern::PointFile(_));
            Origin::of_sampler(is_file, WeightSums::of_square_sampler(&**sampler))
        }
        Source::Files { facts, .. } => Origin::Given(Box::new(facts.weights.clone())),
    };
    Ok(Some((result, EstimatedSums { shard, origin })))
}

/// Returns the error of `--exact` for a pattern without a closed-form spectrum.
fn sampled_only(pattern: &SquarePattern) -> CliError {
    let is_exact = |pattern: &&SquarePattern| {
        let sampler = pattern.build(pattern.nearest_count(12));
        sampler.is_ok_and(|sampler| ExactSquareSpectrum::of(&*sampler).is_some())
    };
    let exact: Vec<&str> =
        SquarePattern::ALL.iter().filter(is_exact).map(SquarePattern::name).collect();
    CliError::Usage(format!(
        "the spectrum of {pattern} has no closed form; those with one are {}",
        exact.join(", ")
    ))
}
