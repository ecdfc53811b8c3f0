//! `sphvar sample`: realizations of a pattern.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;
use sphvar_samplers::{Domain, Pattern, Purpose, Realizations, Streams};

use crate::error::CliError;
use crate::files::{AtomicFile, write_points};
use crate::global::Global;
use crate::memory::check_memory;
use crate::patterns;
use crate::plots::{ImageFormat, OrthographicView};
use crate::report::{Provenance, print, print_json, say, table};

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar sample jittered -n 972 -o points.csv
  sphvar sample fibonacci -n 1000 -o points.svg     (a picture)
  sphvar sample white-noise -n 4096 -m 100 --rotate -o sets.npy";

#[derive(Debug, Args)]
pub(crate) struct SampleArgs {
    /// The sampler
    #[arg(required_unless_present = "list")]
    pub(crate) sampler: Option<String>,
    /// List the samplers with the numbers of points that they have
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
    /// standard output
    #[arg(short, long, default_value = "-", value_name = "FILE")]
    pub(crate) out: PathBuf,
}

/// The document of `--json`.
#[derive(Debug, Serialize)]
struct Document {
    sampler: String,
    n: usize,
    realizations: usize,
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
    if args.out.as_os_str() != "-" {
        AtomicFile::check(&args.out)?;
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
    let sets = (0..args.realizations as u64)
        .map(|i| ensemble.realize(i).map_err(CliError::usage))
        .collect::<Result<Vec<_>, _>>()?;
    let provenance = Provenance::new(global.seed);
    let to_stdout = args.out.as_os_str() == "-";
    if ImageFormat::of_path(&args.out).is_some() {
        if args.realizations > 1 {
            say(global.quiet, "the picture shows the first realization");
        }
        let view = OrthographicView {
            title: format!("{pattern}, N = {n_points}"),
            notes: vec![provenance.line()],
            ..OrthographicView::default()
        };
        view.render(&sets[0], &args.out)?;
    } else if !(to_stdout && global.json) {
        write_points(&args.out, None, &sets, Some(&provenance.line()))?;
    }
    if global.json {
        let points = to_stdout
            .then(|| sets.iter().map(|s| s.iter().map(glam::DVec3::to_array).collect()).collect());
        let realizations = args.realizations;
        return print_json(&Document {
            sampler: pattern.to_string(),
            n: n_points,
            realizations,
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
    sphere: &'static str,
    hemisphere: &'static str,
}

fn list(global: &Global) -> Result<(), CliError> {
    let entry = |p: &Pattern| Entry {
        sampler: p.name(),
        sphere: p.legal_counts(Domain::Sphere),
        hemisphere: p.legal_counts(Domain::Hemisphere),
    };
    let entries: Vec<Entry> = Pattern::ALL.iter().map(entry).collect();
    if global.json {
        return print_json(&entries);
    }
    let cells = |e: &Entry| [e.sampler, e.sphere, e.hemisphere].map(str::to_owned).to_vec();
    let rows = entries.iter().map(cells).collect();
    print(&table(&["sampler", "N on the sphere", "N on the hemisphere"], rows, 3))
}
