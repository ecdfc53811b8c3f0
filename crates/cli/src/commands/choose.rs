//! `sphvar choose`: which pattern has the error asked for with the fewest points, or the least error with
//! the points that there are.

mod candidate;
mod crossings;
mod presentation;
mod question;
mod reason;

use std::path::PathBuf;

use clap::Args;
use sphvar_samplers::Pattern;
use sphvar_variance::{PredictionBudget, Predictor};

use self::candidate::Candidate;
use self::presentation::{Answer, LeftOut};
use self::question::Question;
use crate::counts::parse_count;
use crate::error::CliError;
use crate::global::Global;
use crate::integrands::{FORMS, check_domain, parse_integrand};
use crate::memory::check_memory;
use crate::patterns::parse_patterns;
use crate::progress::Progress;
use crate::report::check_result;
use crate::spec::argument;

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar choose --integrand env:data/city.exr --error 1%
  sphvar choose --integrand cap:degrees=60 -n 1000 -o errors.png
  sphvar choose --integrand ylm:l=4 --absolute --error 0.01 --samplers jittered,fibonacci

The error is one standard error of the integral, the root of the predicted variance, over uniform
rotations of the pattern. Predictions come from spectra, estimated until the variance is known to 3 %;
patterns of which that costs too much at the N wanted are extrapolated by their rate and say so.
A set's seconds are measured on one core, the median of up to five.";

#[derive(Debug, Args)]
pub(crate) struct ChooseArgs {
    #[arg(long, value_parser = argument(), help = format!("Integrand: {FORMS}"))]
    pub(crate) integrand: String,
    /// The standard error wanted, relative to the integral: 1% or 0.01; above 50 % with a % sign
    #[arg(long, value_name = "E", required_unless_present = "points", conflicts_with = "points")]
    pub(crate) error: Option<String>,
    /// The number of points at hand; samplers take the largest that they have up to it
    #[arg(short = 'n', long, value_name = "N", value_parser = parse_count)]
    pub(crate) points: Option<usize>,
    /// --error is in units of the integral itself
    #[arg(long, requires = "error")]
    pub(crate) absolute: bool,
    /// Samplers, separated by commas, or all [default: all that cost little enough]
    #[arg(long, value_name = "LIST")]
    pub(crate) samplers: Option<String>,
    /// Integrate over the hemisphere z >= 0
    #[arg(long)]
    pub(crate) hemisphere: bool,
    /// The most points that --error may take
    #[arg(long, default_value_t = 100_000, value_name = "N", value_parser = parse_count,
        conflicts_with = "points")]
    pub(crate) max_points: usize,
    /// Seconds that a value of the integrand costs: rank by the time for the set and all values
    #[arg(long, value_name = "SECONDS", requires = "error")]
    pub(crate) cost_per_sample: Option<f64>,
    /// Write the answer to a file: .csv, .json, or a plot of errors against N as .svg or .png
    #[arg(short, long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
}

/// A default sampler is left out where a prediction alone would take longer, in seconds.
const TOO_LONG: f64 = 10.0;
/// Bytes of a point of a set that is transformed, at least.
const BYTES_PER_POINT: f64 = 24.0;
/// Sets that a prediction takes at least.
const LEAST_SETS: f64 = 8.0;

pub(crate) fn run(args: &ChooseArgs, global: &Global) -> Result<(), CliError> {
    if let Some(path) = &args.out {
        check_result(path, true)?;
    }
    let integrand = parse_integrand(&args.integrand, global.quiet)?;
    let domain = super::domain(args.hemisphere);
    check_domain(&integrand, domain)?;
    if let Some(cost) = args.cost_per_sample
        && !(cost >= 0.0 && cost.is_finite())
    {
        let message = format!("--cost-per-sample must be finite and at least 0, got {cost}");
        return Err(CliError::Usage(message));
    }
    let patterns = match &args.samplers {
        Some(list) => parse_patterns(list)?,
        None => Pattern::ALL.to_vec(),
    };
    let function = &*integrand.function;
    let mut predictor = Predictor::new(function, domain, global.seed, PredictionBudget::USUAL)
        .map_err(CliError::usage)?;
    let question = Question::new(args, &integrand, predictor.energy())?;
    if let Some(n) = args.points {
        check_memory(&format!("-n {n}"), BYTES_PER_POINT * n as f64)?;
    }

    let weight = |pattern: &Pattern| 0.3 + pattern.seconds(1024).min(1.0) * LEAST_SETS;
    let progress = Progress::new(patterns.iter().map(weight).sum(), global.quiet);
    let (mut candidates, mut left_out) = (Vec::<Candidate>::new(), Vec::new());
    for pattern in patterns {
        if candidates.iter().any(|c| *c.curve.pattern() == pattern) {
            continue;
        }
        progress.stage(&pattern.to_string());
        let share = weight(&pattern);
        let seconds = args.points.map_or(0.0, |n| LEAST_SETS * pattern.seconds(n));
        if args.samplers.is_none() && seconds > TOO_LONG {
            left_out.push(LeftOut {
                sampler: pattern.to_string(),
                reason: format!("a prediction would take some {seconds:.0} s; --samplers takes it"),
            });
        } else {
            match Candidate::new(pattern.clone(), &question, &mut predictor, global.seed) {
                Ok(candidate) => candidates.push(candidate),
                Err(error) => left_out
                    .push(LeftOut { sampler: pattern.to_string(), reason: error.to_string() }),
            }
        }
        progress.advance(share);
    }
    drop(progress);
    if candidates.is_empty() {
        let reasons: Vec<String> =
            left_out.iter().map(|l| format!("{}: {}", l.sampler, l.reason)).collect();
        return Err(CliError::Failed(reasons.join("; ")));
    }
    candidate::rank(&mut candidates, &question);
    Answer::new(&question, &predictor, &candidates, left_out, global.seed).emit(args, global)
}
