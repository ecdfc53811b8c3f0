//! `sphvar sample`: realizations of a pattern.

use std::path::{Path, PathBuf};

use clap::Args;
use glam::DVec3;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use schemars::JsonSchema;
use serde::Serialize;
use sphvar_samplers::{
    Domain, Ensemble, Pattern, PointSet, Purpose, Realizations, SetDistribution, Streams,
};

use crate::counts::parse_count;
use crate::error::CliError;
use crate::files::{AtomicFile, NumberedPath, write_points};
use crate::flags::{CountArgs, DomainArgs, NearestArgs, SamplerArgs};
use crate::global::Global;
use crate::memory::check_memory;
use crate::patterns;
use crate::plots::{ImageFormat, OrthographicView};
use crate::point_sets::RotatedSets;
use crate::progress::Progress;
use crate::report::{Document, Provenance, is_stdout, say};

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar sample jittered -n 972 -o points.csv
  sphvar sample fibonacci -n 1000 -o points.svg     (a picture)
  sphvar sample white-noise -n 4096 -m 100 --rotate -o sets.npy
  sphvar sample poisson-disk:mode=saturated -n 512 -m 3 -o disks-{i}.npy     (one file per set: disks-000000.npy, ...)
  sphvar sample poisson-disk:mode=saturated -n 4096 -o disks.ply
  sphvar sample step:alpha=1 -n 4096 -o step.npy    (no power up to degree 64)
  sphvar sample profile:b=2,alpha=1,to=2 -n 1000 -o quadratic.csv
  sphvar sample file:points.csv -o points.ply       (your own points in another format)";

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
    /// Write the points to a file: .csv, .npy, .npz or .ply, or a picture as .svg or .png; - is CSV on standard output. {i} in the name is the number of the set, 000000, 000001, ..., one file per set
    #[arg(short, long, default_value = "-", value_name = "FILE")]
    pub(crate) out: PathBuf,
}

/// Realizations of a pattern: `sample --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct SampleBody {
    /// The sampler with its parameters.
    sampler: String,
    /// The number of points; the mean where it is random.
    n: usize,
    /// The number of sets.
    realizations: usize,
    /// No set has power at any degree from 1 to this, for patterns that are made so.
    #[serde(skip_serializing_if = "Option::is_none")]
    last_empty_degree: Option<usize>,
    /// The number of points of each set, where the pattern does not fix it.
    #[serde(skip_serializing_if = "Option::is_none")]
    counts: Option<Vec<usize>>,
    /// The unit vectors x, y, z of each set, unless they are written to a file.
    #[serde(skip_serializing_if = "Option::is_none")]
    points: Option<Vec<Vec<[f64; 3]>>>,
    /// The weights of the points of each set, if they have weights.
    #[serde(skip_serializing_if = "Option::is_none")]
    weights: Option<Vec<Vec<f64>>>,
}

pub(crate) fn run(args: &SampleArgs, global: &Global) -> Result<(), CliError> {
    let (Some(sampler), false) = (&args.sampler.sampler, args.list) else {
        let advice = "--list has become a command: sphvar list samplers";
        return Err(CliError::Usage(advice.to_owned()));
    };
    if args.realizations == Some(0) {
        return Err(CliError::Usage("-m must be at least 1, got 0".to_owned()));
    }
    let (n, nearest) = (args.count.count, args.nearest.nearest);
    let domain = args.domain.domain();
    let (pattern, sampler) = patterns::sampler_of(sampler, n, domain, nearest, global.quiet)?;
    let given = match sampler.distribution() {
        SetDistribution::OneOf(sets) if args.realizations.is_none() => Some(sets),
        _ => None,
    };
    let realizations = args.realizations.unwrap_or(given.map_or(1, <[PointSet]>::len));
    let numbered = NumberedPath::of(&args.out);
    let first_and_last = numbered.map_or(vec![args.out.clone()], |numbered| {
        vec![numbered.path(0), numbered.path(realizations - 1)]
    });
    for path in first_and_last {
        AtomicFile::check(&path)?;
    }
    let n_points = sampler.n_points();
    let total = 24.0 * n_points as f64 * realizations as f64;
    check_memory(&format!("{realizations} sets of {n_points} points"), total)?;

    let last_empty_degree = sampler.last_empty_degree();
    let empty = last_empty_degree.map(|last| no_power(last, sampler.domain()));
    if let Some(empty) = &empty {
        say(global.quiet, &format!("{pattern}, N = {n_points}: {empty}"));
    }
    let streams = Streams::new(global.seed, Purpose::Pattern, sampler.stream_group());
    let drawn = if args.rotate {
        Realizations::rotated(&*sampler, streams)
    } else {
        Realizations::unrotated(&*sampler, streams)
    };
    let given = given.map(|sets| RotatedSets { sets, rotations: drawn });
    let ensemble: &dyn Ensemble = match &given {
        Some(given) => given,
        None => &drawn,
    };
    let set_work = if given.is_some() { 0.0 } else { sampler.nominal_work() };
    let work = realizations as f64 * set_work;
    let progress = Progress::new(work, global.quiet);
    progress.stage(&pattern.label());
    let realize = |i| {
        let mut set = PointSet::default();
        ensemble.realize_into(i, &mut set, &progress).map_err(CliError::failed)?;
        Ok(set)
    };
    let sets = (0..realizations as u64)
        .into_par_iter()
        .map(realize)
        .collect::<Result<Vec<_>, CliError>>()?;
    drop(progress);
    let provenance = Provenance::new(global.seed);
    let line = provenance.line();
    let note = empty.map_or(line.clone(), |empty| format!("{line}; {empty}"));
    let to_stdout = is_stdout(&args.out);
    if let Some(numbered) = numbered {
        for (i, set) in sets.iter().enumerate() {
            write_sets(&numbered.path(i), std::slice::from_ref(set), &pattern, &note)?;
        }
    } else if !(to_stdout && global.json) {
        if ImageFormat::of_path(&args.out).is_some() && realizations > 1 {
            say(global.quiet, "the picture shows the first realization");
        }
        write_sets(&args.out, &sets, &pattern, &note)?;
    }
    if global.json {
        let coordinates = |set: &PointSet| set.points.iter().map(DVec3::to_array).collect();
        let points = to_stdout.then(|| sets.iter().map(coordinates).collect());
        let is_weighted = sets.iter().any(|set| !set.weights.is_empty());
        let weights = (to_stdout && is_weighted)
            .then(|| sets.iter().map(|set| set.weights.clone()).collect());
        let counts: Vec<usize> = sets.iter().map(PointSet::len).collect();
        let counts = Some(counts).filter(|counts| counts.iter().any(|&count| count != n_points));
        let body = SampleBody {
            sampler: pattern.to_string(),
            n: n_points,
            realizations,
            last_empty_degree,
            counts,
            points,
            weights,
        };
        return Document::new(&body, &provenance).print();
    }
    Ok(())
}

/// Writes all sets, or a picture of the first one.
fn write_sets(
    path: &Path,
    sets: &[PointSet],
    pattern: &Pattern,
    note: &str,
) -> Result<(), CliError> {
    if ImageFormat::of_path(path).is_none() {
        return Ok(write_points(path, None, sets, Some(note))?);
    }
    let view = OrthographicView {
        title: format!("{}, N = {}", pattern.label(), sets[0].len()),
        notes: vec![note.to_owned()],
        ..OrthographicView::default()
    };
    Ok(view.render(&sets[0].points, path)?)
}

/// Returns the remark on sets without power at the degrees up to `last`.
fn no_power(last: usize, domain: Domain) -> String {
    match (last, domain) {
        (0, _) => "power at every degree".to_owned(),
        (_, Domain::Sphere) => format!("no power at degrees 1 to {last}"),
        (_, Domain::Hemisphere) => format!("no power at even degrees 2 to {last}"),
    }
}
