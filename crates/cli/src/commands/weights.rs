//! `sphvar weights`: quadrature weights for points in a file.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::Resettable;
use schemars::JsonSchema;
use serde::Serialize;
use sphvar_samplers::PointSet;
use sphvar_spectrum::{Method, QuadratureError, QuadratureProblem, QuadratureWeights, WeightSigns};

use super::sets_args::PointFileArgs;
use crate::counts::parse_one_count;
use crate::error::CliError;
use crate::files::{AtomicFile, is_stream, write_points};
use crate::flags::DomainArgs;
use crate::global::Global;
use crate::memory::check_degree;
use crate::point_sets::FileSets;
use crate::progress::Progress;
use crate::report::{Document, Provenance, is_stdout, number};
use crate::session::Session;

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar weights data/stars.csv --degree 10
  sphvar weights points.npy --degree 2 --nonnegative -o rule.csv
  sphvar weights points.npy -o rule.npz     (the largest degree that converges)

Sums of the weights times a spherical harmonic are the integrals of all harmonics up to the degree, with the sum 4 pi \
(2 pi on the hemisphere, where only even degrees count). Of all such weights those with the least sum of squares are \
computed, by conjugate gradients; with --nonnegative, those of them that are at least 0, by a Newton method. The residual is \
the largest sum that should be 0, relative to that of degree 0. The condition number is that of the matrix of the harmonics \
at the points. Degree t needs at least (t+1)^2 points; points that leave large gaps permit only lower degrees.";

#[derive(Debug, Args)]
#[command(
    mut_arg("points_from", |arg| {
        arg.long(Resettable::Reset).required(true).help(POINTS_HELP)
    }),
    mut_arg("columns", |arg| arg.conflicts_with(Resettable::Reset)),
    mut_arg("hdu", |arg| arg.conflicts_with(Resettable::Reset)),
    mut_arg("join", |arg| arg.conflicts_with(Resettable::Reset)),
    mut_arg("skip_invalid", |arg| arg.conflicts_with(Resettable::Reset)),
    mut_arg("normalize", |arg| arg.conflicts_with(Resettable::Reset))
)]
pub(crate) struct WeightsArgs {
    #[command(flatten)]
    pub(crate) files: PointFileArgs,
    /// Degree to which the weights are exact [default: the largest that converges]
    #[arg(long, value_name = "L", value_parser = parse_one_count)]
    pub(crate) degree: Option<usize>,
    /// Compute weights of at least 0
    #[arg(long)]
    pub(crate) nonnegative: bool,
    #[command(flatten)]
    pub(crate) domain: DomainArgs,
    /// Write the points to a file: with weights, .csv, .npz or .ply; - is CSV on standard output
    #[arg(short, long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}

const POINTS_HELP: &str = "File of one set of points: CSV or other text, .npy, .npz, .ply, a FITS table, each possibly gzipped; - is standard input. \
Several files are joined with --join. Weights in the file are ignored";

/// Quadrature weights of given points: `weights --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct WeightsBody {
    /// The names of the files.
    points: String,
    /// The number of points.
    n: usize,
    /// The number of distinct points; on the hemisphere antipodes are the same point.
    n_distinct: usize,
    /// The degree to which the weights are exact.
    degree: usize,
    /// Whether the weights are restricted to nonnegative ones.
    nonnegative: bool,
    /// The largest `|sum w Y_lm|` of a degree from 1 to `degree`, relative to `|sum w Y_00|`.
    residual: f64,
    /// The smallest weight; the sum of all is 4 pi, or 2 pi on the hemisphere.
    min_weight: f64,
    /// The largest weight.
    max_weight: f64,
    /// The estimated condition number of the matrix of all harmonics up to `degree` at the points.
    condition: f64,
    /// `(sum w)^2 / sum w^2`, the number of equally weighted points with the same noise.
    n_effective: f64,
    /// The largest degree up to which the residual is at most 1e-11.
    exact_degree: usize,
    /// The number of iterations of conjugate gradients.
    iterations: usize,
    /// The weights in the order of the points, unless they are written to a file.
    #[serde(skip_serializing_if = "Option::is_none")]
    weights: Option<Vec<f64>>,
}

pub(crate) fn run(args: &WeightsArgs, global: &Global) -> Result<(), CliError> {
    if let Some(path) = &args.out {
        check_weighted_points(path)?;
    }
    let (mut body, weighted) = compute(args, global)?;
    let provenance = Provenance::new(&global.session, global.seed);
    let to_stdout = args.out.as_deref().is_some_and(is_stdout);
    if let Some(path) = args.out.as_deref().filter(|_| !(to_stdout && global.json)) {
        let sets = std::slice::from_ref(&weighted);
        write_points(path, None, sets, Some(&provenance.line()))?;
    }
    let is_written = args.out.as_deref().is_some_and(|path: &Path| !is_stdout(path));
    body.weights = (!is_written).then_some(weighted.weights);
    if global.json {
        Document::new(&body, &provenance).print(&global.session)
    } else if to_stdout {
        Ok(())
    } else {
        let mut text = body.text();
        if args.out.is_none() {
            text += "\n-o FILE writes the points with their weights.\n";
        }
        global.session.print(&text)
    }
}

/// Computes the weights that the arguments describe. Returns the document without them, and the
/// points with them.
pub(crate) fn compute(
    args: &WeightsArgs,
    global: &Global,
) -> Result<(WeightsBody, PointSet), CliError> {
    if let Some(degree) = args.degree {
        check_degree("--degree", degree)?;
    }
    let domain = args.domain.domain();
    let files = FileSets::read(&args.files, domain, &global.session)?;
    let [set] = files.sets().sets() else {
        return Err(CliError::File(format!(
            "{}: weights are computed for one set of points, got {} sets",
            files.name(),
            files.count()
        )));
    };
    if !set.weights.is_empty() {
        global.session.say("the weights in the file are ignored");
    }
    let signs = if args.nonnegative { WeightSigns::Nonnegative } else { WeightSigns::Any };
    let problem = QuadratureProblem::new(&set.points, domain, signs).map_err(CliError::failed)?;
    let (n, n_distinct) = (set.len(), problem.n_distinct());
    if n_distinct < n {
        let repeated = n - n_distinct;
        global
            .session
            .say(&format!("{repeated} of {n} points are repeated and share their weight"));
    }
    let rule = solve(&problem, args.degree, n, &global.session)?;
    let weighted = PointSet { points: set.points.clone(), weights: rule.weights };
    let body = WeightsBody {
        points: files.name().to_owned(),
        n,
        n_distinct,
        degree: rule.degree,
        nonnegative: args.nonnegative,
        residual: rule.residual,
        min_weight: weighted.weights.iter().copied().fold(f64::INFINITY, f64::min),
        max_weight: weighted.weights.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        condition: rule.condition,
        n_effective: weighted.n_effective(),
        exact_degree: rule.exact_degree,
        iterations: rule.iterations,
        weights: None,
    };
    Ok((body, weighted))
}

/// Returns an error for a file that could not be written, before the work starts.
pub(super) fn check_weighted_points(path: &Path) -> Result<(), CliError> {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    if !matches!(extension.as_deref(), Some("csv" | "npz" | "ply")) && !is_stream(path) {
        return Err(CliError::Usage(format!(
            "{}: points with weights are written as .csv, .npz or .ply",
            path.display()
        )));
    }
    Ok(AtomicFile::check(path)?)
}

/// Returns weights of the requested degree or, without one, of the largest that converges.
fn solve(
    problem: &QuadratureProblem<'_>,
    degree: Option<usize>,
    n: usize,
    session: &Session,
) -> Result<QuadratureWeights, CliError> {
    /// The number of iterations of a typical solution, for the progress bar.
    const TYPICAL_ITERATIONS: f64 = 100.0;
    let largest = degree.unwrap_or(problem.largest_possible_degree());
    let work = 2.0 * Method::Auto.nominal_work(n, largest);
    let progress = Progress::new(TYPICAL_ITERATIONS * work, session);
    progress.stage("weights");
    let mut watch = || match progress.advance(work) {
        Ok(()) => ControlFlow::Continue(()),
        Err(_) => ControlFlow::Break(()),
    };
    let Some(degree) = degree else {
        return problem.solve_largest(largest, &mut watch).map_err(CliError::failed);
    };
    match problem.solve(degree, &mut watch) {
        Ok(rule) => Ok(rule),
        Err(error @ QuadratureError::TooFewPoints { .. }) => Err(CliError::usage(error)),
        Err(
            error @ (QuadratureError::NotConverged { .. } | QuadratureError::NoNonnegative { .. }),
        ) => {
            progress.stage("the largest degree");
            let works = problem.solve_largest(degree, &mut watch).map_err(CliError::failed)?;
            Err(CliError::Failed(format!(
                "{error}; the largest degree that works is {}",
                works.degree
            )))
        }
        Err(error) => Err(CliError::failed(error)),
    }
}

impl WeightsBody {
    fn text(&self) -> String {
        let kind = if self.nonnegative { "nonnegative weights" } else { "weights" };
        format!(
            "{} points, {kind} of least norm exact to degree {}\n\
             residual          {}\n\
             condition number  {}\n\
             weights           {} to {}\n\
             effective N       {}\n",
            self.n,
            self.exact_degree,
            number::value(self.residual),
            number::ratio(self.condition),
            number::value(self.min_weight),
            number::value(self.max_weight),
            number::count(self.n_effective),
        )
    }
}
