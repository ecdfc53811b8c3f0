//! `sphvar sample`: realizations of a pattern.

pub(crate) mod realized_sets;

use std::path::{Path, PathBuf};

use clap::Args;
use glam::DVec3;
use sphvar_samplers::{
    Domain, Ensemble, Pattern, Purpose, Realizations, SetDistribution, Square, SquareDistribution,
    SquarePattern, SquareRealizations, Streams,
};
use sphvar_variance::{WarpedPattern, WarpedRealizations};

use self::realized_sets::RealizedSets;
use crate::counts::parse_count;
use crate::error::CliError;
use crate::flags::{
    CountArgs, DomainArgs, NearestArgs, ONE_DOMAIN, SHIFTED, SamplerArgs, SquareArgs, missing_count,
};
use crate::global::Global;
use crate::integrands::strategies_of;
use crate::patterns::{self, DirectionSampler};
use crate::plots::{OrthographicView, PlotError, SquareView};
use crate::point_sets::{RotatedSets, ShiftedSets};

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar sample jittered -n 972 -o points.csv
  sphvar sample fibonacci -n 1000 -o points.svg     (a picture)
  sphvar sample white-noise -n 4096 -m 100 --rotate -o sets.npy
  sphvar sample poisson-disk:mode=saturated -n 512 -m 3 -o disks-{i}.npy     (one file per set: disks-000000.npy, ...)
  sphvar sample poisson-disk:mode=saturated -n 4096 -o disks.ply
  sphvar sample step:alpha=1 -n 4096 -o step.npy    (no power up to degree 64)
  sphvar sample profile:b=2,alpha=1,to=2 -n 1000 -o quadratic.csv
  sphvar sample file:points.csv -o points.ply       (your own points in another format)
  sphvar sample sobol --square -n 1024 -o square.csv      (points u,v of the unit square)
  sphvar sample sobol:warp=cosine -n 256 --hemisphere -o cosine.npz     (points with weights 1/(N p) for a density p)
  sphvar sample r2:warp=vmf:kappa=50 -n 256 -m 8 -o lobes.npz";

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
    /// Apply an independent uniform random rotation to every realization (not of warped patterns, which are shifted before they are mapped)
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
        return sample_square(sampler, args, global);
    }
    match patterns::parse_sampler(sampler, &global.session)? {
        DirectionSampler::Uniform(pattern) => sample_uniform(&pattern, args, global),
        DirectionSampler::Warped(pattern) => sample_warped(&pattern, args, global),
        DirectionSampler::Adapted(pattern) => Err(CliError::Usage(format!(
            "{pattern}: sample has patterns with warp=; lights writes the sites of {pattern} for a map"
        ))),
    }
}

fn sample_uniform(pattern: &Pattern, args: &SampleArgs, global: &Global) -> Result<(), CliError> {
    let (n, nearest) = (args.count.count, args.nearest.nearest);
    let domain = args.domain.domain();
    let sampler = patterns::nearest_sampler(pattern, n, domain, nearest, &global.session)?;
    let last_empty_degree = sampler.last_empty_degree();
    let remark = last_empty_degree.map(|last| no_power(last, sampler.domain()));
    let streams = streams(sampler.sequence_group(), sampler.stream_group(), global);
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
        remark: remark.clone(),
        picture: sphere_picture,
    };
    sets.write(args, global)?;
    // The statement is about sets that exist: the work may fail or be interrupted.
    if let Some(empty) = &remark {
        global.session.say(&format!("{pattern}, N = {}: {empty}", sampler.n_points()));
    }
    Ok(())
}

/// Draws directions on the visible hemisphere.
fn sphere_picture(
    title: String,
    notes: Vec<String>,
    points: &[DVec3],
    path: &Path,
) -> Result<(), PlotError> {
    OrthographicView { title, notes, ..OrthographicView::default() }.render(points, path)
}

fn sample_warped(
    pattern: &WarpedPattern,
    args: &SampleArgs,
    global: &Global,
) -> Result<(), CliError> {
    if args.rotate {
        let advice =
            "warped patterns are shifted on the square before they are mapped, not rotated";
        return Err(CliError::Usage(format!("--rotate does not apply to {pattern}: {advice}")));
    }
    let requested = args.count.count.or(pattern.own_count()).ok_or_else(missing_count)?;
    let (n_points, samplers) = patterns::build_warped(pattern, requested, args.nearest.nearest)?;
    if n_points != requested {
        let label = pattern.label();
        let remark = format!(
            "{label}: {n_points} points, the valid count nearest to the requested {requested}"
        );
        global.session.say(&remark);
    }
    let all = strategies_of(&[&pattern.warp], args.domain.domain(), &global.session)?;
    let drawn = WarpedRealizations::new(
        &all[0],
        pattern.heuristic,
        &samplers,
        global.seed,
        Purpose::Pattern,
    )
    .of_prefixes();
    let sets = RealizedSets {
        sampler: pattern.to_string(),
        label: pattern.label(),
        n_points,
        given: None,
        ensemble: &drawn,
        set_work: pattern.trial_work(n_points),
        last_empty_degree: None,
        remark: Some("weights 1/(N p)".to_owned()),
        picture: sphere_picture,
    };
    sets.write(args, global)
}

fn sample_square(sampler: &str, args: &SampleArgs, global: &Global) -> Result<(), CliError> {
    let (n, nearest) = (args.count.count, args.nearest.nearest);
    let (pattern, sampler) =
        patterns::sampler_of::<SquarePattern, _>(sampler, n, Square, nearest, &global.session)?;
    let streams = streams(sampler.sequence_group(), sampler.stream_group(), global);
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

/// Returns the streams of the sequence that all numbers of points share, or of the sets of one number
/// of points where the pattern is no sequence.
fn streams(sequence_group: Option<usize>, set_group: usize, global: &Global) -> Streams {
    Streams::new(global.seed, Purpose::Pattern, sequence_group.unwrap_or(set_group))
}

/// Returns the remark on sets without power at the degrees up to `last`.
fn no_power(last: usize, domain: Domain) -> String {
    match (last, domain) {
        (0, _) => "power at every degree".to_owned(),
        (_, Domain::Sphere) => format!("no power at degrees 1 to {last}"),
        (_, Domain::Hemisphere) => format!("no power at even degrees 2 to {last}"),
    }
}
