//! `sphvar quality`: measures of point sets, beside those of reference patterns.

mod chart;
mod rank;
pub(crate) mod record;
mod source;
mod square;
pub(crate) mod square_record;
mod text;

use clap::Args;
use sphvar_spectrum::quality::Quality;

pub(crate) use self::record::QualityBody;
use self::record::{MeasureRow, QualityRecord};
use self::source::Source;
use crate::counts::{Counts, parse_realizations};
use crate::error::CliError;
use crate::flags::{CountArgs, DomainArgs, NearestArgs, OutArgs, SamplersArgs, SquareArgs};
use crate::global::Global;
use crate::memory::check_degree;
use crate::progress::Progress;
use crate::report::{Forms, Provenance, check_result, csv_of, emit};

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar quality fibonacci -n 200
  sphvar quality jittered,healpix,fibonacci -n 192 -o quality.svg
  sphvar quality jittered -n 48 --rank
  sphvar quality sobol,r2,white-square --square -n 64

Distances are chords; the mesh ratio is twice the covering radius over the separation. The square of \
the L2 cap discrepancy is the integral, over the heights -1 to 1 of caps, of the mean square of the difference \
between the share of points in a cap and its share of the area (Stolarsky); worst-case errors are those of the mean \
of functions of norm 1 in the Sobolev space H^s; energies are sums over unordered pairs, of weighted points with the \
factor N_eff^2 w_j w_k for weights of sum 1. Scaled values are multiplied by the power of N \
in the next column (energies: the constant of the second term), which makes them comparable between \
numbers of points; those of good sets are close to the value of the hexagonal lattice, the best \
known for large N. On the hemisphere all measures are those of lines, through the points and their \
antipodes; the energy of two lines is k(|x - y|) + k(|x + y|).

p-values test independent uniform points, whose probability is that of a smaller discrepancy (lower: small \
for points that are more regular) or of a larger one (upper: small for points that cluster). They are asymptotic: \
a p-value of 1 % is right to a third of itself from 20 points on, smaller ones less. A file is measured as it is, each of its sets a realization.

With --square the measures are the toroidal separation, also relative to that of a hexagonal lattice of N points per unit \
area, the star discrepancy (the largest difference between the share of points in a box [0,u) x [0,v) and its area), its root mean \
square over boxes with one corner at the origin and the other anywhere (L2 star discrepancy, Warnock), the same over boxes \
that wrap around (Hickernell), and the least t for which 2^m points are a (t,m,2)-net in base 2. They are written as .csv or .json, not as a plot.";

#[derive(Debug, Args)]
#[command(
    mut_group("SamplersArgs", |samplers| samplers.required(true)),
    mut_arg("positional_samplers", |samplers| {
        samplers.help(format!("{}; or files of points", SamplersArgs::HELP))
    })
)]
pub(crate) struct QualityArgs {
    #[command(flatten)]
    pub(crate) samplers: SamplersArgs,
    #[command(flatten)]
    pub(crate) count: CountArgs,
    #[command(flatten)]
    pub(crate) nearest: NearestArgs,
    /// Number of realizations, of each sampler; files have their own
    #[arg(short = 'm', long, value_name = "M", default_value = "1", value_parser = parse_realizations)]
    pub(crate) realizations: u64,
    #[command(flatten)]
    pub(crate) domain: DomainArgs,
    #[command(flatten)]
    pub(crate) square: SquareArgs,
    /// Maximum degree, inclusive, of fits of harmonics whose condition numbers are computed; a list such as 4,8 [default: a fourth and half of sqrt(N)]
    #[arg(long, value_name = "L")]
    pub(crate) lmax: Option<Counts>,
    /// Rank the set among all patterns that are not expensive at its number of points; only of directions
    #[arg(long)]
    pub(crate) rank: bool,
    #[command(flatten)]
    pub(crate) out: OutArgs,
}

/// A sampler or file with its measures.
struct Measured {
    source: Source,
    quality: Quality,
}

pub(crate) fn run(args: &QualityArgs, global: &Global) -> Result<(), CliError> {
    if args.square.square {
        return square::run(args, global);
    }
    if let Some(path) = &args.out.out {
        check_result(path, true)?;
    }
    let domain = args.domain.domain();
    if args.realizations == 0 {
        return Err(CliError::Usage("-m must be at least 1, got 0".to_owned()));
    }
    let degrees = args.lmax.as_ref().map(Counts::all);
    for &degree in degrees.unwrap_or_default() {
        check_degree("--lmax", degree)?;
    }
    let sources = Source::all(&args.samplers.required()?, args, global)?;

    let work = sources.iter().map(|s| s.count as f64 * s.sampler.nominal_work()).sum();
    let progress = Progress::new(work, &global.session);
    let mut measured = Vec::new();
    for source in sources {
        progress.stage(&source.name);
        let quality = source.measure(domain, degrees, &progress)?;
        measured.push(Measured { source, quality });
    }
    let ranks = if args.rank {
        measured
            .iter()
            .map(|m| rank::rank(m, domain, global, &progress).map(Some))
            .collect::<Result<Vec<_>, _>>()?
    } else {
        measured.iter().map(|_| None).collect()
    };
    let references = match &args.out.out {
        Some(path) if crate::plots::ImageFormat::of_path(path).is_some() => {
            Some(chart::References::new(&measured, domain, global, &progress)?)
        }
        _ => None,
    };
    drop(progress);

    let rows: Vec<QualityRecord> =
        measured.iter().zip(ranks).map(|(m, rank)| QualityRecord::new(m, rank)).collect();
    let measures: Vec<MeasureRow> = measured.iter().flat_map(MeasureRow::all).collect();
    let provenance = Provenance::new(&global.session, global.seed);
    let body = QualityBody::new(rows);
    let chart = || {
        let references = references.as_ref().ok_or_else(|| {
            CliError::Failed("reference patterns are measured for plots only".to_owned())
        })?;
        Ok(chart::chart(&measured, references))
    };
    let forms = Forms {
        csv: &|| csv_of(&provenance, &measures),
        chart: Some(&chart),
        text: &|| text::text(&measured, body.records()),
    };
    emit(args.out.out.as_deref(), global, &provenance, &body, &forms)
}
