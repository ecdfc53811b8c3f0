//! `sphvar spectrum`: the angular power spectrum of a pattern or of points in files.

mod catalogue;
mod chart;
mod coefficient;
mod merging;
mod pairs;
pub(crate) mod report;
mod saved;
mod square;
mod square_chart;
pub(crate) mod square_report;
mod sums;

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use schemars::JsonSchema;
use serde::Serialize;
use serde::de::DeserializeOwned;
use sphvar_samplers::{
    Domain, Pattern, PointSet, Purpose, Realizations, Sampler, SetDistribution, Streams,
};
use sphvar_spectrum::{
    Accumulator, CoefficientSamples, Ensemble, ExactSpectrum, OrderAccumulator, OrderPower,
    Resolution, Spectrum, SpectrumAccumulator, accumulate,
};

use self::catalogue::Opened;
use self::coefficient::{Coefficient, parse_coefficient};
use self::pairs::{PairArgs, PairBody};
use self::report::emit;
pub(crate) use self::report::{Remarks, SpectrumBody};
pub(crate) use self::saved::SquareSums;
use self::saved::{SavedEnsemble, Shard};
pub(crate) use self::square::{SquareComputed, compute as compute_square};
pub(crate) use self::square_report::{SquareResult, SquareSpectrumBody};
pub(crate) use self::sums::{EstimatedSums, Origin};
use super::sets_args::SetsArgs;
use crate::counts::parse_realizations;
use crate::error::CliError;
use crate::files::AtomicFile;
use crate::flags::{
    KmaxArgs, LmaxArgs, OutArgs, SquareArgs, kmax_help, lmax_help, natural_degree_in_words,
};
use crate::global::Global;
use crate::instruction_set::instruction_set;
use crate::memory::{check_degree, check_memory, check_transform};
use crate::patterns;
use crate::point_sets::{FileSets, SetFacts, WeightSums};
use crate::progress::Progress;
use crate::report::{Provenance, check_result, csv_of, is_stdout, write_text};
use crate::shards::{Divided, Part, ShardArgs};
use crate::transforms::TransformArgs;

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar spectrum jittered -n 3888 -m 300 --lmax 190
  sphvar spectrum --points data/stars.csv --lmax 64
  sphvar spectrum --points cat.fits.gz --columns ra=RAJ2000,dec=DEJ2000,w=WEIGHT --lmax 64
  sphvar spectrum healpix -n 972 -o spectrum.png
  sphvar spectrum jittered -n 3888 --exact --lmax 190
  sphvar spectrum jittered -n 3888 -m 300 --shard 2/3 --save second.shard
  sphvar spectrum poisson-disk -n 200 -m 10 --pairs -o pairs.svg
  sphvar spectrum jittered-square --square -n 64 -m 20 --kmax 32 -o square.png

White noise has power 1 for l >= 1; P(0) = N. The error is the standard error of the mean over the \
realizations, each with an independent uniform random rotation. It is 0 for deterministic patterns, whose spectrum is \
exact, and absent (- or null) for a single set from a file. N of weighted points is (sum w)^2 / sum w^2. \
--exact evaluates the mean spectrum in closed form, which is available for white noise, for one point in each of N \
equal-area cells (jittered, equal-area; jittered-square), for dpp and latin-hypercube, and for deterministic patterns.

--pairs counts pairs of points by their angle: g is the density of pairs relative to that of independent points \
(1 - 1/N for these), K the area times the share of pairs within a radius, and L the radius of the cap of area K. \
g smooth is the same from the spectrum, averaged by a heat kernel.

With --square the power |S_k|^2/N is that of frequencies k = (k1, k2) of points u,v of the unit square under random \
toroidal shifts. Tables and the lower panel of plots show its mean over rings of |k| and its anisotropy, the relative \
variance of the power over a ring: a ratio, which is 1/M for M realizations of white noise, and absent where the ring has \
no power. A single set from a file gives a radial mean without an error; several sets of the same process, or -m for a \
sampler, give one. Powers of deterministic sets up to 1e-24 N, which are rounding errors, are 0.";

/// The default number of realizations.
const REALIZATIONS: u64 = 100;

#[derive(Debug, Args)]
#[command(
    mut_arg("lmax", |lmax| lmax.help(lmax_help(&natural_degree_in_words()))),
    mut_arg("kmax", |kmax| kmax.help(kmax_help(&natural_degree_in_words())))
)]
pub(crate) struct SpectrumArgs {
    #[command(flatten)]
    pub(crate) sets: SetsArgs,
    /// Evaluate the mean spectrum in closed form: no realizations, no error
    #[arg(long, conflicts_with_all = [
        "points_from", "realizations", "per_order", "coefficient", "method", "epsilon",
    ])]
    pub(crate) exact: bool,
    #[arg(
        short = 'm',
        long,
        value_name = "M",
        value_parser = parse_realizations,
        conflicts_with = "points_from",
        help = format!("Number of realizations [default: {REALIZATIONS}; of a file, each set once]")
    )]
    pub(crate) realizations: Option<u64>,
    #[command(flatten)]
    pub(crate) lmax: LmaxArgs,
    #[command(flatten)]
    pub(crate) square: SquareArgs,
    #[command(flatten)]
    pub(crate) kmax: KmaxArgs,
    #[command(flatten)]
    pub(crate) transform: TransformArgs,
    #[command(flatten)]
    pub(crate) pairs: PairArgs,
    #[command(flatten)]
    pub(crate) out: OutArgs,
    #[command(flatten)]
    pub(crate) sharding: ShardArgs,
    /// Write the mean power of every degree and order, `(4 pi/N) |S_lm|^2`, to a CSV file
    #[arg(long, value_name = "FILE")]
    pub(crate) per_order: Option<PathBuf>,
    /// Write the samples of one coefficient `S_lm` over the realizations to a CSV file
    #[arg(long, num_args = 3, value_names = ["L", "M", "FILE"])]
    pub(crate) coefficient: Option<Vec<String>>,
}

/// The mean power of one degree and order, a row of `--per-order`.
#[derive(Debug, Serialize, JsonSchema)]
struct OrderRecord {
    l: usize,
    m: usize,
    power: f64,
    stderr: f64,
}

impl From<OrderPower> for OrderRecord {
    fn from(order: OrderPower) -> Self {
        let OrderPower { l, m, power, stderr, .. } = order;
        Self { l, m, power, stderr }
    }
}

/// The coefficient of one realization, a row of `--coefficient`.
#[derive(Debug, Serialize, JsonSchema)]
struct CoefficientRecord {
    re: f64,
    im: f64,
}

/// The source of the point sets.
enum Source {
    Sampler {
        pattern: Pattern,
        sampler: Box<dyn Sampler>,
    },
    /// The sets of files, `None` if their results are known.
    Files {
        facts: Box<SetFacts>,
        sets: Option<FileSets>,
    },
}

impl Source {
    /// Returns the sets of a pattern from a file, if each is to be taken once.
    fn given_sets(&self, args: &SpectrumArgs) -> Option<&[PointSet]> {
        let Self::Sampler { sampler, .. } = self else { return None };
        // Rotations change these quantities, but not the power of a degree.
        let has_orders = args.per_order.is_some() || args.coefficient.is_some();
        match sampler.distribution() {
            SetDistribution::OneOf(sets) if args.realizations.is_none() && !has_orders => {
                Some(sets)
            }
            _ => None,
        }
    }
}

/// A spectrum that was computed, with what is reported and saved beside it.
pub(crate) struct Computed {
    /// The sampler with its parameters, or the files.
    pub(crate) name: String,
    pub(crate) spectrum: Spectrum,
    pub(crate) remarks: Remarks,
    /// The sums of the realizations; `None` for a closed form.
    pub(crate) sums: Option<EstimatedSums>,
    /// The time that the spectrum took.
    pub(crate) seconds: f64,
    orders: Option<OrderAccumulator>,
    coefficient: Option<(Coefficient, CoefficientSamples)>,
}

pub(crate) fn run(args: &SpectrumArgs, global: &Global) -> Result<(), CliError> {
    if args.square.square {
        return square::run(args, global);
    }
    check_outputs(args, global)?;
    let Some(computed) = compute(args, global, None)? else {
        return global.session.tasks().without_results();
    };
    let provenance = Provenance::new(&global.session, global.seed);
    if let (Some(path), Some(orders)) = (&args.per_order, computed.orders) {
        let domain = computed.spectrum.domain();
        let orders = orders.finish().into_iter().filter(|o| domain.has_degree(o.l));
        let rows: Vec<OrderRecord> = orders.map(OrderRecord::from).collect();
        write_text(path, &csv_of(&provenance, &rows)?)?;
    }
    if let Some((coefficient, samples)) = computed.coefficient {
        let samples = samples.finish();
        let rows = samples.iter().map(|a| CoefficientRecord { re: a.re, im: a.im });
        write_text(&coefficient.path, &csv_of(&provenance, &rows.collect::<Vec<_>>())?)?;
    }
    let Computed { name, spectrum, remarks, seconds, .. } = computed;
    emit(args.out.out.as_deref(), global, &name, &spectrum, remarks, seconds, &provenance)
}

/// Computes the spectrum of directions that the arguments describe, of the realizations of one part
/// if it is given; `None` if this run keeps only a part of the work.
pub(crate) fn compute(
    args: &SpectrumArgs,
    global: &Global,
    only: Option<Part>,
) -> Result<Option<Computed>, CliError> {
    let domain = args.sets.domain.domain();
    let source = if args.sets.sampler.sampler.is_some() {
        source(args, domain, global)?
    } else {
        match catalogue::open(args, domain, global)? {
            Opened::Catalogue(catalogue) => return catalogue.compute(args, domain, global, only),
            Opened::Sets(facts, sets) => Source::Files { facts, sets },
        }
    };
    if let Source::Sampler { pattern, sampler } = &source
        && args.exact
    {
        return compute_exact(args, global, pattern, &**sampler);
    }
    let given = source.given_sets(args);
    let (name, n_points, count) = match &source {
        Source::Sampler { pattern, sampler } => {
            let default = given.map_or(REALIZATIONS, |sets| sets.len() as u64);
            (pattern.to_string(), sampler.n_points(), args.realizations.unwrap_or(default))
        }
        Source::Files { facts, .. } => (facts.name.clone(), facts.mean_size, facts.count),
    };
    if count == 0 {
        return Err(CliError::Usage("-m must be at least 1, got 0".to_owned()));
    }
    let lmax = args.lmax.lmax.unwrap_or_else(|| Resolution::natural_degree(n_points));
    check_degree("--lmax", lmax)?;
    let coefficient =
        args.coefficient.as_deref().map(|c| parse_coefficient(c, lmax, domain)).transpose()?;
    let (method, epsilon) = args.transform.checked()?;
    let resolution = Resolution { lmax, n_points, method, epsilon };
    check_transform(resolution, count)?;
    if args.per_order.is_some() {
        // Every order has two exact sums of about 150 bytes in every thread.
        let orders = 0.5 * ((lmax + 1) as f64).powi(2);
        let threads = rayon::current_num_threads() as f64;
        check_memory("--per-order", 300.0 * orders * threads)?;
    }
    let started = Instant::now();
    let orders = args.per_order.is_some().then(|| OrderAccumulator::new(lmax)).transpose()?;
    let pairs = args.pairs.settings(domain, n_points, lmax, &global.session)?;
    let (sets, count): (&dyn Ensemble, u64) = match (&source, &given) {
        (Source::Files { sets: Some(sets), .. }, _) => (sets.sets(), count),
        (Source::Files { sets: None, .. }, _) => (&NO_SETS, count),
        (_, Some(sets)) => (sets, count),
        (Source::Sampler { sampler, .. }, _) => {
            let streams = Streams::new(global.seed, Purpose::Pattern, sampler.stream_group());
            // One set of a deterministic pattern determines its spectrum, but not the distribution
            // of quantities that rotations change.
            let distributions = args.per_order.is_some() || args.coefficient.is_some();
            let count = if sampler.is_random() || distributions { count } else { 1 };
            (&Realizations::rotated(&**sampler, streams), count)
        }
    };
    let set_work = match &source {
        Source::Sampler { sampler, .. } if given.is_none() => sampler.nominal_work(),
        _ => 0.0,
    };
    let pair_work = pairs.as_ref().map_or(0.0, |pairs| pairs.work(n_points));
    let work = set_work + method.nominal_work(n_points, lmax) + pair_work;
    let progress = Progress::new(count as f64 * work, &global.session);
    progress.stage(&name);
    let empty = (
        SpectrumAccumulator::new(domain, n_points, lmax),
        (orders, coefficient.as_ref().map(|c| CoefficientSamples::new(c.l, c.m))),
    );
    let of_pairs = pairs.as_ref().map(|pairs| pairs.accumulators(&progress)).transpose()?;
    let ((sums, (orders, samples)), of_pairs) = if of_pairs.is_some() {
        let empty = (empty, of_pairs);
        accumulate(sets, resolution, 0..count, &empty, &progress)?
    } else {
        let orders = if args.per_order.is_some() { ", every order" } else { "" };
        let samples = coefficient.as_ref().map(|c| format!(", coefficient {} {}", c.l, c.m));
        let task = format!("{name}{orders}{}", samples.unwrap_or_default());
        let task = Divided { name: &task, count, work };
        let sums = of_realizations(only, task, global, &progress, Accumulator::merge, |range| {
            Ok(accumulate(sets, resolution, range, &empty, &progress)?)
        })?;
        let Some(sums) = sums else { return Ok(None) };
        (sums, None)
    };
    let (exact, origin) = match &source {
        Source::Sampler { pattern, sampler } => {
            let weights = WeightSums::of_sampler(&**sampler)?;
            let is_file = matches!(pattern, Pattern::PointFile(_));
            (!sampler.is_random(), Origin::of_sampler(is_file, weights))
        }
        Source::Files { facts, .. } => (count == 1, Origin::Given(Box::new(facts.weights.clone()))),
    };
    let spectrum = sums.finish()?;
    let spectrum = if exact { spectrum.into_exact() } else { spectrum };
    let ensemble = SavedEnsemble {
        sampler: name.clone(),
        is_random: !exact,
        domain,
        lmax,
        transform: format!("{method:?} {epsilon:e}"),
        seed: global.seed,
        realizations: count,
        version: Provenance::new(&global.session, global.seed).version.to_string(),
        instruction_set: instruction_set(),
    };
    let shard = Shard { ensemble, parts: vec![only.unwrap_or(Part::WHOLE)], sums };
    let sums = EstimatedSums { shard, origin };
    let mut remarks = sums.remarks();
    let pairs = of_pairs.map(|sums| PairBody::new(&sums, exact, remarks.has_no_error));
    remarks.pairs = pairs.transpose()?;
    drop(progress);
    let seconds = started.elapsed().as_secs_f64();
    let coefficient = coefficient.zip(samples);
    Ok(Some(Computed { name, spectrum, remarks, sums: Some(sums), seconds, orders, coefficient }))
}

/// Computes the spectrum in closed form; `None` if another part has it.
fn compute_exact(
    args: &SpectrumArgs,
    global: &Global,
    pattern: &Pattern,
    sampler: &dyn Sampler,
) -> Result<Option<Computed>, CliError> {
    let lmax = args.lmax.lmax.unwrap_or_else(|| Resolution::natural_degree(sampler.n_points()));
    check_degree("--lmax", lmax)?;
    let exact = ExactSpectrum::of(sampler).ok_or_else(|| sampled_only(pattern))?;
    let bytes = exact.bytes(lmax, rayon::current_num_threads());
    check_memory(&format!("a spectrum to degree {lmax} (--lmax)"), bytes)?;
    let started = Instant::now();
    let name = pattern.to_string();
    let progress = Progress::new(exact.work(lmax), &global.session);
    progress.stage(&name);
    let spectrum = global.session.tasks().once(&name, || Ok(exact.to(lmax, &progress)?))?;
    let Some(spectrum) = spectrum else { return Ok(None) };
    drop(progress);
    let seconds = started.elapsed().as_secs_f64();
    let weights = WeightSums::of_sampler(sampler)?;
    let remarks = Remarks { has_no_error: false, weights, pairs: None };
    let (sums, orders, coefficient) = (None, None, None);
    Ok(Some(Computed { name, spectrum, remarks, sums, seconds, orders, coefficient }))
}

/// Rejects outputs that cannot be written, before the work starts.
fn check_outputs(args: &SpectrumArgs, global: &Global) -> Result<(), CliError> {
    if let Some(path) = &args.out.out {
        check_result(path, true)?;
    }
    let coefficient = args.coefficient.as_ref().and_then(|c| c.last()).map(Path::new);
    let tables = [("--per-order", args.per_order.as_deref()), ("--coefficient", coefficient)];
    for (flag, path) in tables {
        let Some(path) = path else { continue };
        if global.json && is_stdout(path) {
            return Err(CliError::Usage(format!(
                "{flag} must name a file: with --json, standard output contains the document"
            )));
        }
        AtomicFile::check(path)?;
    }
    Ok(())
}

/// Returns the sums over the realizations of a task: of one part if it is given, otherwise of all;
/// `None` if this run keeps only a part of the work.
fn of_realizations<T: Serialize + DeserializeOwned>(
    only: Option<Part>,
    task: Divided<'_>,
    global: &Global,
    progress: &Progress,
    merge: impl Fn(&mut T, &T),
    compute: impl Fn(Range<u64>) -> Result<T, CliError>,
) -> Result<Option<T>, CliError> {
    let Some(part) = only else {
        let append = |sums: &mut T, others: T| {
            merge(sums, &others);
            Ok(())
        };
        return global.session.tasks().divided(task, progress, append, compute);
    };
    check_part(part, task.count)?;
    compute(part.range(task.count)).map(Some)
}

/// Rejects a part without realizations.
fn check_part(part: Part, count: u64) -> Result<(), CliError> {
    if part.range(count).is_empty() {
        let why = match count {
            1 => "a deterministic pattern has one set, which is in part 1",
            _ => "use at most as many parts as realizations",
        };
        return Err(CliError::Usage(format!(
            "part {part} contains none of the {count} realizations; {why}"
        )));
    }
    Ok(())
}

/// The sets of files whose results are known.
const NO_SETS: &[PointSet] = &[];

fn source(args: &SpectrumArgs, domain: Domain, global: &Global) -> Result<Source, CliError> {
    let name = args.sets.sampler.sampler.as_deref().unwrap_or_default();
    let (n, nearest) = (args.sets.count.count, args.sets.nearest.nearest);
    let (pattern, sampler) = patterns::sampler_of(name, n, domain, nearest, &global.session)?;
    if args.exact && ExactSpectrum::of(&*sampler).is_none() {
        return Err(sampled_only(&pattern));
    }
    Ok(Source::Sampler { pattern, sampler })
}

/// Returns the error of `--exact` for a pattern without a closed-form spectrum.
fn sampled_only(pattern: &Pattern) -> CliError {
    let is_exact = |pattern: &&Pattern| {
        let n = pattern.nearest_count(12, Domain::Sphere);
        let sampler = pattern.build(n, Domain::Sphere);
        sampler.is_ok_and(|sampler| ExactSpectrum::of(&*sampler).is_some())
    };
    let exact: Vec<&str> = Pattern::ALL.iter().filter(is_exact).map(Pattern::name).collect();
    CliError::Usage(format!(
        "the spectrum of {pattern} has no closed form; those with one are {}",
        exact.join(", ")
    ))
}
