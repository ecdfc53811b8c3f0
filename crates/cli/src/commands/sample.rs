//! `sphvar sample`: realizations of a pattern.

mod kept_set;
pub(crate) mod realized_sets;

use std::path::{Path, PathBuf};

use clap::Args;
use glam::DVec3;

use self::realized_sets::RealizedSets;
use crate::counts::parse_count;
use crate::draws::{DrawRequest, Draws};
use crate::error::CliError;
use crate::flags::{
    CountArgs, DomainArgs, NearestArgs, ONE_DOMAIN, SHIFTED, SamplerArgs, SquareArgs,
};
use crate::global::Global;
use crate::plots::{OrthographicView, PlotError, SquareView};
use crate::shards::ShardArgs;

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
  sphvar sample r2:warp=vmf:kappa=50 -n 256 -m 8 -o lobes.npz
  sphvar sample ccvt -n 1024 -m 100 -o sets.npy --shard 2/4 --save second.shard";

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
    #[command(flatten)]
    pub(crate) sharding: ShardArgs,
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
    let request = DrawRequest {
        sampler: sampler.clone(),
        n: args.count.count,
        nearest: args.nearest.nearest,
        hemisphere: args.domain.hemisphere,
        is_randomized: args.rotate || args.shift,
        seed: global.seed,
    };
    if args.square.square {
        let draws = Draws::square(&request, &global.session)?;
        let picture = |title, notes, points: &[_], path: &Path| {
            SquareView { title, notes }.render(points, path)
        };
        RealizedSets { draws: &draws, picture }.write(args, global)?;
        return Ok(());
    }
    let draws = Draws::new(&request, &global.session)?;
    let is_written = RealizedSets { draws: &draws, picture: sphere_picture }.write(args, global)?;
    // The statement is about sets that exist: the work may fail or be interrupted.
    if let (true, Some(_), Some(empty)) = (is_written, draws.last_empty_degree, &draws.remark) {
        let sampler = &draws.sampler;
        global.session.say(&format!("{sampler}, N = {}: {empty}", draws.n_points()));
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
