//! The command line: the list of subcommands.

use clap::error::ErrorKind;
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use crate::commands::{
    accuracy, audit, bounds, choose, compare, completions, eval, fit, healpix, integrate, lights,
    list, merge, plan, progressive, quality, render, reproduce, rotations, sample, spectrum,
    variance, weights,
};
use crate::error::CliError;
use crate::flags;
use crate::global::Global;
use crate::shards::ShardArgs;

/// Which pattern of N directions on the sphere or hemisphere gives the least integration error, and why
#[derive(Debug, Parser)]
#[command(
    name = "sphvar",
    version,
    propagate_version = true,
    max_term_width = 100,
    after_help = QUESTIONS
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
    #[command(flatten)]
    pub(crate) global: Global,
}

const QUESTIONS: &str = "Three questions:
  Which pattern of 500 directions has the least error for my integrand?
    sphvar choose --integrand vmf:kappa=50 -n 500
  How many directions does an error of 1 % need?
    sphvar choose --integrand cap:degrees=60 --error 1%
  Do predicted and measured variance agree, and how fast do they fall?
    sphvar compare --integrand cap:degrees=60 -n 48,192,768 -o results";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Compare patterns on an integrand: predicted and measured variance, rates, crossovers
    #[command(after_help = compare::EXAMPLES)]
    Compare(compare::CompareArgs),
    /// Rank patterns for an integrand by the points required for an error, or by the error with N points
    #[command(after_help = choose::EXAMPLES)]
    Choose(choose::ChooseArgs),
    /// Generate realizations of a pattern: points as CSV, NPY or PLY, or a picture as SVG or PNG
    #[command(after_help = sample::EXAMPLES)]
    Sample(sample::SampleArgs),
    /// Generate rotations, as quaternions, matrices or Euler angles, or measure sets of them
    #[command(after_help = rotations::EXAMPLES)]
    Rotations(rotations::RotationsArgs),
    /// Compute the angular power spectrum of a pattern, or of points in files
    #[command(after_help = spectrum::EXAMPLES)]
    Spectrum(spectrum::SpectrumArgs),
    /// Write the results of a command from its parts, bit-identical to those of a single run
    #[command(after_help = merge::EXAMPLES)]
    Merge(merge::MergeArgs),
    /// Divide a command into parts: job files for Slurm, HyperQueue, Dask or a shell, and their state
    #[command(after_help = plan::EXAMPLES)]
    Plan(plan::PlanArgs),
    /// Predict and measure the variance of patterns on one integrand
    #[command(after_help = variance::EXAMPLES)]
    Variance(variance::VarianceArgs),
    /// Predict and measure the error of every prefix of sequences, for progressive sampling
    #[command(after_help = progressive::EXAMPLES)]
    Progressive(progressive::ProgressiveArgs),
    /// Integrate a function to a tolerance, with nodes and an error
    #[command(after_help = integrate::EXAMPLES)]
    Integrate(integrate::IntegrateArgs),
    /// Compute quadrature weights for points in a file, exact to a degree
    #[command(after_help = weights::EXAMPLES)]
    Weights(weights::WeightsArgs),
    /// Fit spherical harmonics to values at the points of a file: coefficients, energies, noise
    #[command(after_help = fit::EXAMPLES)]
    Fit(fit::FitArgs),
    /// Bound the variance and its convergence rate by spectral profiles
    #[command(after_help = bounds::EXAMPLES)]
    Bounds(bounds::BoundsArgs),
    /// Test a sampler or point files for rotation invariance, which the variance formula assumes
    #[command(after_help = audit::EXAMPLES)]
    Audit(audit::AuditArgs),
    /// Measure point sets: distances, discrepancies, worst-case errors, energies, uniformity
    #[command(after_help = quality::EXAMPLES)]
    Quality(quality::QualityArgs),
    /// Render a scene with a pattern's directions: ambient occlusion or light, and its error
    #[command(after_help = render::EXAMPLES)]
    Render(Box<render::RenderArgs>),
    /// Convert an environment map to N directional lights, with the error of the irradiance
    #[command(after_help = lights::EXAMPLES)]
    Lights(lights::LightsArgs),
    /// Recompute the figures of Singh's thesis and check its numbers
    #[command(after_help = reproduce::EXAMPLES)]
    Reproduce(reproduce::ReproduceArgs),
    /// Convert lists of directions and angles to HEALPix pixels and back
    #[command(after_help = healpix::EXAMPLES)]
    Healpix(healpix::HealpixArgs),
    /// Evaluate a Legendre function, a harmonic, the spectrum of a cap, or a profile
    #[command(after_help = eval::EXAMPLES)]
    Eval(eval::EvalArgs),
    /// Measure accuracy and speed against high-precision references, including extreme inputs
    #[command(after_help = accuracy::EXAMPLES)]
    Accuracy(accuracy::AccuracyArgs),
    /// List samplers, integrands and file formats, with parameters, valid counts, costs and rates
    #[command(after_help = list::EXAMPLES)]
    List(list::ListArgs),
    /// Print completions for a shell, or write manual pages
    #[command(after_help = completions::EXAMPLES)]
    Completions(completions::CompletionsArgs),
}

impl Cli {
    /// Returns the command with these words after the name of the program; if `is_overriding`, later
    /// options take the place of earlier ones.
    ///
    /// # Errors
    ///
    /// If the words are no command.
    pub(crate) fn of_words(words: &[String], is_overriding: bool) -> Result<Self, CliError> {
        let all = std::iter::once("sphvar").chain(words.iter().map(String::as_str));
        let matches = Self::command().args_override_self(is_overriding).try_get_matches_from(all);
        let cli = matches.and_then(|matches| Self::from_arg_matches(&matches));
        cli.map_err(|error| CliError::Usage(usage_message(error, words)))
    }
}

/// Returns the message of an error about words that are no valid command line, without the usage and
/// the advice for a terminal.
pub(crate) fn usage_message(mut error: clap::Error, words: &[String]) -> String {
    if matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) {
        return "--help and --version are no commands".to_owned();
    }
    flags::retired::explain(&mut error, &Cli::command(), words);
    let text = error.to_string();
    let text = text.strip_prefix("error: ").unwrap_or(&text);
    let end = ["\n\nUsage:", "\n\nFor more information"].iter().filter_map(|end| text.find(end));
    let text = &text[..end.min().unwrap_or(text.len())];
    let lines: Vec<&str> = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    lines.join(" ")
}

impl Command {
    /// Returns the flags of a command whose work can be divided.
    pub(crate) fn sharding(&self) -> Option<&ShardArgs> {
        match self {
            Self::Compare(args) => Some(&args.effort.sharding),
            Self::Render(args) => Some(&args.sharding),
            Self::Reproduce(args) => Some(&args.sharding),
            Self::Sample(args) => Some(&args.sharding),
            Self::Spectrum(args) => Some(&args.sharding),
            Self::Variance(args) => Some(&args.effort.sharding),
            Self::Progressive(args) => Some(&args.sharding),
            Self::Audit(args) => Some(&args.sharding),
            _ => None,
        }
    }
}
