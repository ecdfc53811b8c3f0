//! `sphvar sample`: realizations of a pattern.

use std::path::{Path, PathBuf};

use clap::Args;
use glam::DVec3;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use serde::Serialize;
use sphvar_samplers::{Domain, Pattern, PatternFacts, Purpose, Realizations, Streams};

use crate::error::CliError;
use crate::files::{AtomicFile, NumberedPath, write_points};
use crate::global::Global;
use crate::memory::check_memory;
use crate::patterns;
use crate::plots::{ImageFormat, OrthographicView};
use crate::progress::Progress;
use crate::report::{Provenance, is_stdout, print, print_json, say};

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar sample jittered -n 972 -o points.csv
  sphvar sample fibonacci -n 1000 -o points.svg     (a picture)
  sphvar sample white-noise -n 4096 -m 100 --rotate -o sets.npy
  sphvar sample poisson-disk:mode=saturated -n 4096 -o disks.ply
  sphvar sample poisson-disk:mode=saturated -n 4096 -m 3 -o disks-{i}.npy    (one file a set)
  sphvar sample step:alpha=1 -n 4096 -o step.npy    (no power up to degree 63)
  sphvar sample profile:b=2,alpha=1,to=2 -n 1000 -o quadratic.csv
  sphvar sample --list";

#[derive(Debug, Args)]
pub(crate) struct SampleArgs {
    /// The sampler, with parameters as name:key=value,key=value
    #[arg(required_unless_present = "list")]
    pub(crate) sampler: Option<String>,
    /// List the samplers with their parameters, the numbers of points that they have, what a set costs,
    /// their power at low degrees, their rates and who described them
    #[arg(long)]
    pub(crate) list: bool,
    /// Number of points
    #[arg(short = 'n', long = "points", value_name = "N", required_unless_present = "list")]
    pub(crate) points: Option<usize>,
    /// Number of realizations
    #[arg(short = 'm', long, default_value_t = 1, value_name = "M")]
    pub(crate) realizations: usize,
    /// Points on the hemisphere z >= 0
    #[arg(long)]
    pub(crate) hemisphere: bool,
    /// Turn every realization by a uniform random rotation of its own
    #[arg(long)]
    pub(crate) rotate: bool,
    /// Take the nearest number of points that the pattern has
    #[arg(long)]
    pub(crate) nearest: bool,
    /// File for the points (.csv, .npy, .ply) or a picture of them (.svg, .png); - is CSV on
    /// standard output. With {i} in the name every set gets a file of its own: {i} becomes 000000, 000001, ...
    #[arg(short, long, default_value = "-", value_name = "FILE")]
    pub(crate) out: PathBuf,
}

/// The document of `--json`.
#[derive(Debug, Serialize)]
struct Document {
    sampler: String,
    n: usize,
    realizations: usize,
    /// The number of points of each set, where the pattern does not fix it.
    #[serde(skip_serializing_if = "Option::is_none")]
    counts: Option<Vec<usize>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    points: Option<Vec<Vec<[f64; 3]>>>,
    provenance: Provenance,
}

pub(crate) fn run(args: &SampleArgs, global: &Global) -> Result<(), CliError> {
    let (Some(sampler), Some(n), false) = (&args.sampler, args.points, args.list) else {
        return list(global);
    };
    let pattern = patterns::parse_pattern(sampler)?;
    if args.realizations == 0 {
        return Err(CliError::Usage("-m must be at least 1, got 0".to_owned()));
    }
    let numbered = NumberedPath::of(&args.out);
    for path in numbered.map_or(vec![args.out.clone()], |numbered| {
        vec![numbered.path(0), numbered.path(args.realizations - 1)]
    }) {
        AtomicFile::check(&path)?;
    }
    let sampler = patterns::build(&pattern, n, super::domain(args.hemisphere), args.nearest)?;
    let n_points = sampler.n_points();
    let total = 24.0 * n_points as f64 * args.realizations as f64;
    check_memory(&format!("{} sets of {n_points} points", args.realizations), total)?;
    if n_points != n {
        say(
            global.quiet,
            &format!("{pattern}: {n_points} points, the nearest to the {n} asked for"),
        );
    }

    let streams = Streams::new(global.seed, Purpose::Pattern, pattern.stream_group(n_points));
    let ensemble = if args.rotate {
        Realizations::rotated(&*sampler, streams)
    } else {
        Realizations::unrotated(&*sampler, streams)
    };
    let progress = Progress::new(args.realizations as f64, global.quiet);
    progress.stage(&pattern.to_string());
    let realize = |i| {
        let set = ensemble.realize(i).map_err(CliError::failed)?;
        progress.advance(1.0);
        Ok(set)
    };
    let sets = (0..args.realizations as u64)
        .into_par_iter()
        .map(realize)
        .collect::<Result<Vec<_>, CliError>>()?;
    drop(progress);
    let provenance = Provenance::new(global.seed);
    let to_stdout = is_stdout(&args.out);
    let write = |path: &Path, sets: &[Vec<DVec3>]| -> Result<(), CliError> {
        if ImageFormat::of_path(path).is_none() {
            return Ok(write_points(path, None, sets, Some(&provenance.line()))?);
        }
        if sets.len() > 1 {
            say(global.quiet, "the picture shows the first realization");
        }
        let view = OrthographicView {
            title: format!("{pattern}, N = {}", sets[0].len()),
            notes: vec![provenance.line()],
            ..OrthographicView::default()
        };
        Ok(view.render(&sets[0], path)?)
    };
    if let Some(numbered) = numbered {
        for (i, set) in sets.iter().enumerate() {
            write(&numbered.path(i), std::slice::from_ref(set))?;
        }
    } else if !(to_stdout && global.json) {
        write(&args.out, &sets)?;
    }
    if global.json {
        let points = to_stdout
            .then(|| sets.iter().map(|s| s.iter().map(DVec3::to_array).collect()).collect());
        let realizations = args.realizations;
        let counts: Vec<usize> = sets.iter().map(Vec::len).collect();
        let counts = Some(counts).filter(|counts| counts.iter().any(|&count| count != n_points));
        return print_json(&Document {
            sampler: pattern.to_string(),
            n: n_points,
            realizations,
            counts,
            points,
            provenance,
        });
    }
    Ok(())
}

/// A pattern as `--list` shows it.
#[derive(Debug, Serialize)]
struct Entry {
    sampler: &'static str,
    parameters: String,
    sphere: &'static str,
    hemisphere: &'static str,
    cost: &'static str,
    law: &'static str,
    best_rate: &'static str,
    worst_rate: &'static str,
    source: &'static str,
}

impl Entry {
    fn new(pattern: &Pattern) -> Self {
        let PatternFacts { cost, law, best_rate, worst_rate, source, .. } = pattern.facts();
        Self {
            sampler: pattern.name(),
            parameters: pattern.all_parameters().join(","),
            sphere: pattern.legal_counts(Domain::Sphere),
            hemisphere: pattern.legal_counts(Domain::Hemisphere),
            cost,
            law,
            best_rate,
            worst_rate,
            source,
        }
    }
}

fn list(global: &Global) -> Result<(), CliError> {
    let entries: Vec<Entry> = Pattern::ALL.iter().map(Entry::new).collect();
    if global.json {
        return print_json(&entries);
    }
    let mut text = String::new();
    for e in &entries {
        let name = if e.parameters.is_empty() {
            e.sampler.to_owned()
        } else {
            format!("{}:{}", e.sampler, e.parameters)
        };
        // A pattern takes a paragraph: in one table the columns would not fit a terminal.
        let counts = if e.sphere == e.hemisphere {
            e.sphere.to_owned()
        } else {
            format!("{}; on the hemisphere {}", e.sphere, e.hemisphere)
        };
        let rates = format!("N^{} smooth, N^{} with jumps", e.best_rate, e.worst_rate);
        text += &name;
        text.push('\n');
        for (what, value) in [
            ("N", counts.as_str()),
            ("cost", e.cost),
            ("P(l) as l -> 0", e.law),
            ("variance", rates.as_str()),
            ("source", e.source),
        ] {
            text += &format!("    {what:<15} {value}\n");
        }
    }
    print(&text)
}
