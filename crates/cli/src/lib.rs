//! The command `sphvar`: which pattern of N directions on the sphere or hemisphere gives the least
//! error for an integrand, and why.
//!
//! This crate is flags, files, tables, plots and progress; the science is in the libraries.

mod args;
mod commands;
mod counts;
mod error;
mod files;
mod global;
mod integrands;
mod memory;
mod patterns;
mod plots;
mod point_sets;
mod profiles;
mod progress;
mod report;
mod share;
mod spec;
mod transforms;

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;

use crate::args::{Cli, Command};
use crate::error::CliError;

/// Runs the command with the arguments of the process and returns its exit status: 0 done, 1 failed,
/// 2 usage.
#[must_use]
pub fn run() -> ExitCode {
    // Wrong usage exits with 2 and --help with 0, both by clap's own hand.
    let cli = Cli::parse();
    match dispatch(cli) {
        Ok(()) => ExitCode::SUCCESS,
        // The reader of a pipe has what it wanted.
        Err(CliError::ClosedPipe) => ExitCode::SUCCESS,
        Err(error) => {
            // Nothing is left to be done if standard error is gone too.
            let _ = writeln!(std::io::stderr(), "sphvar: {error}");
            ExitCode::from(error.status())
        }
    }
}

fn dispatch(cli: Cli) -> Result<(), CliError> {
    rayon::ThreadPoolBuilder::new().num_threads(cli.global.threads).build_global().map_err(
        |e| CliError::Failed(format!("cannot start {} threads: {e}", cli.global.threads)),
    )?;
    match cli.command {
        Command::Compare(args) => commands::compare::run(&args, &cli.global),
        Command::Choose(args) => commands::choose::run(&args, &cli.global),
        Command::Sample(args) => commands::sample::run(&args, &cli.global),
        Command::Spectrum(args) => commands::spectrum::run(&args, &cli.global),
        Command::Merge(args) => commands::merge::run(&args, &cli.global),
        Command::Variance(args) => commands::variance::run(&args, &cli.global),
        Command::Bounds(args) => commands::bounds::run(&args, &cli.global),
        Command::Audit(args) => commands::audit::run(&args, &cli.global),
        Command::Render(args) => commands::render::run(&args, &cli.global),
        Command::Reproduce(args) => commands::reproduce::run(&args, &cli.global),
        Command::Healpix(args) => commands::healpix::run(&args, &cli.global),
        Command::Accuracy(args) => commands::accuracy::run(&args, &cli.global),
        Command::Eval(args) => commands::eval::run(&args, &cli.global),
    }
}
