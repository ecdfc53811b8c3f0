//! `sphvar sample`: realizations of a pattern.

pub(crate) mod realized_sets;

use std::path::PathBuf;

use clap::Args;
use sphvar_samplers::{
    Domain, Ensemble, Pattern, Purpose, Realizations, SetDistribution, Square, SquareDistribution,
    SquarePattern, SquareRealizations, Streams,
};

use self::realized_sets::RealizedSets;
use crate::counts::parse_count;
use crate::error::CliError;
use crate::flags::{
    CountArgs, DomainArgs, NearestArgs, ONE_DOMAIN, SHIFTED, SamplerArgs, SquareArgs,
};
use crate::global::Global;
use crate::patterns;
use crate::plots::{OrthographicView, SquareView};
use crate::point_sets::{RotatedSets, ShiftedSets};
use crate::report::say;

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar sample jittered -n 972 -o points.csv
  sphvar sample fibonacci -n 1000 -o points.svg     (a picture)
  sphvar sample white-noise -n 4096 -m 100 --rotate -o sets.npy
  sphvar sample poisson-disk:mode=saturated -n 512 -m 3 -o disks-{i}.npy     (one file per set: disks-000000.npy, ...)
  sphvar sample poisson-disk:mode=saturated -n 4096 -o disks.ply
  sphvar sample step:alpha=1 -n 4096 -o step.npy    (no power up to degree 64)
  sphvar sample profile:b=2,alpha=1,to=2 -n 1000 -o quadratic.csv
  sphvar sample file:points.csv -o points.ply       (your own points in another format)
  sphvar sample sobol --square -n 1024 -o square.csv      (points u,v of the unit square)";

#[derive(Debug, Args)]
#[command(
    mut_arg("sampler", |sampler| sampler.required_unless_present("list"))
)]
pub(crate) struct SampleArgs {
    #[command(flatten)]
    pub(crate) sampler: SamplerArgs,
    /// The earlier spelling of `sphvar list`
    #[arg(long, hide = true)]
    pub(crate) list: bool,
    #[command(flatten)]
    pub(crate) count: CountArgs,
    #[command(flatten)]
    pub(crate) nearest: NearestArgs,
    /// Number of realizations [default: 1; of a file, each set once]
    #[arg(short = 'm', long, value_name = "M", value_parser = parse_count)]
    pub(crate) realizations: Option<usize>,
    #[command(flatten)]
    pub(crate) domain: DomainArgs,
    /// Apply an independent uniform random rotation to every realization
    #[arg(long)]
    pub(crate) rotate: bool,
    #[command(flatten)]
    pub(crate) square: SquareArgs,
    /// Apply an independent uniform toroidal shift to every realization of a pattern of the square
    #[arg(long, requires = "square")]
    pub(crate) shift: bool,
    /// Write the points to a file: .csv, .npy, .npz or .ply, or a picture as .svg or .png; - is CSV on standard output. {i} in the name is the number of the set, 000000, 000001, ..., one file per set
    #[arg(short, long, default_value = "-", value_name = "FILE")]
    pub(crate) out: PathBuf,
}

pub(crate) fn run(args: &SampleArgs, global: &Global) -> Result<(), CliError> {
    let (Some(sampler), false) = (&args.sampler.sampler, args.list) else {
        let advice = "--list has become a command: sphvar list samplers";
        return Err(CliError::Usage(advice.to_owned()));
    };
    if args.realizations == Some(0) {
        return Err(CliError::Usage("-m must be at least 1, got 0".to_owned()));
    }
    args.square.without(&[
        ("--hemisphere", args.domain.hemisphere, ONE_DOMAIN),
        ("--rotate", args.rotate, SHIFTED),
    ])?;
    if args.square.square {
        sample_square(sampler, args, global)
    } else {
        sample_directions(sampler, args, global)
    }
}

fn sample_directions(sampler: &str, args: &SampleArgs, global: &Global) -> Result<(), CliError> {
    let (n, nearest) = (args.count.count, args.nearest.nearest);
    let domain = args.domain.domain();
    let (pattern, sampler) =
        patterns::sampler_of::<Pattern, _>(sampler, n, domain, nearest, global.quiet)?;
    let last_empty_degree = sampler.last_empty_degree();
    let remark = last_empty_degree.map(|last| no_power(last, sampler.domain()));
    if let Some(empty) = &remark {
        say(global.quiet, &format!("{pattern}, N = {}: {empty}", sampler.n_points()));
    }
    let streams = Streams::new(global.seed, Purpose::Pattern, sampler.stream_group());
    let drawn = if args.rotate {
        Realizations::rotated(&*sampler, streams)
    } else {
        Realizations::unrotated(&*sampler, streams)
    };
    let given = match sampler.distribution() {
        SetDistribution::OneOf(sets) if args.realizations.is_none() => Some(sets),
        _ => None,
    };
    let given = given.map(|sets| RotatedSets { sets, rotations: drawn });
    let sets = RealizedSets {
        sampler: pattern.to_string(),
        label: pattern.label(),
        n_points: sampler.n_points(),
        given: given.as_ref().map(|given| given.sets.len()),
        ensemble: match &given {
            Some(given) => given as &dyn Ensemble,
            None => &drawn,
        },
        set_work: sampler.nominal_work(),
        last_empty_degree,
        remark,
        picture: |title, notes, points, path| {
            OrthographicView { title, notes, ..OrthographicView::default() }.render(points, path)
        },
    };
    sets.write(args, global)
}

fn sample_square(sampler: &str, args: &SampleArgs, global: &Global) -> Result<(), CliError> {
    let (n, nearest) = (args.count.count, args.nearest.nearest);
    let (pattern, sampler) =
        patterns::sampler_of::<SquarePattern, _>(sampler, n, Square, nearest, global.quiet)?;
    let streams = Streams::new(global.seed, Purpose::Pattern, sampler.stream_group());
    let drawn = if args.shift {
        SquareRealizations::shifted(&*sampler, streams)
    } else {
        SquareRealizations::unshifted(&*sampler, streams)
    };
    let given = match sampler.distribution() {
        SquareDistribution::OneOf(sets) if args.realizations.is_none() => Some(sets),
        _ => None,
    };
    let given = given.map(|sets| ShiftedSets { sets, shifts: drawn });
    let sets = RealizedSets {
        sampler: pattern.to_string(),
        label: pattern.label(),
        n_points: sampler.n_points(),
        given: given.as_ref().map(|given| given.sets.len()),
        ensemble: match &given {
            Some(given) => given as &dyn Ensemble<[f64; 2]>,
            None => &drawn,
        },
        set_work: sampler.nominal_work(),
        last_empty_degree: None,
        remark: None,
        picture: |title, notes, points, path| SquareView { title, notes }.render(points, path),
    };
    sets.write(args, global)
}

/// Returns the remark on sets without power at the degrees up to `last`.
fn no_power(last: usize, domain: Domain) -> String {
    match (last, domain) {
        (0, _) => "power at every degree".to_owned(),
        (_, Domain::Sphere) => format!("no power at degrees 1 to {last}"),
        (_, Domain::Hemisphere) => format!("no power at even degrees 2 to {last}"),
    }
}
