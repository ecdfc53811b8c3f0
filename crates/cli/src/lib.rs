//! The command `sphvar`: which pattern of N directions on the sphere or hemisphere has the smallest
//! error for an integrand, and why.
//!
//! This crate contains flags, files, tables, plots and progress; the numerical methods are in the
//! libraries.

mod args;
mod commands;
mod counts;
mod draws;
#[doc(hidden)]
pub mod embedding;
mod error;
mod files;
mod flags;
#[doc(hidden)]
pub mod fuzzing;
mod given;
mod global;
mod instruction_set;
mod integrands;
mod interrupts;
mod memory;
mod message;
mod patterns;
mod plots;
mod point_sets;
mod profiles;
mod progress;
mod report;
mod run_log;
#[cfg(test)]
mod schema;
mod session;
mod shards;
mod share;
mod spec;
mod transforms;
mod values;

use std::ffi::OsString;
use std::io::Write;
use std::process::ExitCode;
use std::sync::Arc;

use clap::{CommandFactory, Parser};

use crate::args::{Cli, Command};
use crate::error::CliError;
use crate::global::Global;
use crate::run_log::RunLog;
use crate::session::Session;

/// Runs the command with the arguments of the process and returns its exit status: 0 for success, 1
/// for failure, 2 for a usage error.
#[must_use]
pub fn run() -> ExitCode {
    ExitCode::from(run_words(std::env::args_os().skip(1).collect()))
}

/// Runs the command with the words after its name and returns its exit status.
fn run_words(words: Vec<OsString>) -> u8 {
    let all = std::iter::once(OsString::from("sphvar")).chain(words.iter().cloned());
    let mut cli = match Cli::try_parse_from(all) {
        Ok(cli) => cli,
        Err(error) => return usage(error, &words),
    };
    files::record_used_files();
    let log = match open_log(&cli, &words) {
        Ok(log) => log,
        Err(error) => return failure(&error),
    };
    cli.global.session = Session::of_process(&words, cli.global.quiet, log.clone());
    let for_signals = log.clone();
    let report = move |signal, status| {
        if let Some(log) = &for_signals {
            log.interrupted(signal, status);
        }
    };
    let watched = interrupts::watch(report)
        .map_err(|error| CliError::Failed(format!("cannot watch for signals: {error}")));
    let result = watched.and_then(|()| dispatch(cli));
    if let Some(log) = log {
        log.end(&result);
    }
    match result {
        Ok(()) => 0,
        // A reader that closes its pipe has received what it needs.
        Err(CliError::ClosedPipe) => 0,
        Err(error) => failure(&error),
    }
}

/// Opens the log of the run, if it has one.
fn open_log(cli: &Cli, words: &[OsString]) -> Result<Option<Arc<RunLog>>, CliError> {
    let Some(path) = &cli.global.log else { return Ok(None) };
    let words: Vec<String> = words.iter().map(|word| word.to_string_lossy().into_owned()).collect();
    let part = cli.command.sharding().and_then(|sharding| sharding.shard);
    RunLog::open(path, &words, part).map(Some)
}

/// Reports an error and returns the exit status.
fn failure(error: &CliError) -> u8 {
    if !matches!(error, CliError::NotDone | CliError::PlanFailed) {
        message::write(&format!("error: {error}"));
    }
    error.status()
}

/// Prints the output of clap, which is help or a usage error, and returns the exit status: 0 or 2.
fn usage(mut error: clap::Error, words: &[OsString]) -> u8 {
    let words: Vec<String> = words.iter().map(|word| word.to_string_lossy().into_owned()).collect();
    flags::retired::explain(&mut error, &Cli::command(), &words);
    let text = error.to_string();
    let lines: Vec<String> = arguments_escaped(&text, &words).lines().map(message::clean).collect();
    let printed = if error.use_stderr() && lines.join("\n") != text.trim_end() {
        writeln!(std::io::stderr(), "{}", lines.join("\n"))
    } else {
        error.print()
    };
    // If standard error is closed, the failure cannot be reported.
    let _ = printed;
    if error.use_stderr() { 2 } else { 0 }
}

/// Returns a text that quotes arguments with their control characters escaped: a line break in an
/// argument must not look like the end of a line.
fn arguments_escaped(text: &str, words: &[String]) -> String {
    let mut text = text.to_owned();
    for argument in words {
        // Of `--key=value`, either part may be quoted.
        for part in
            argument.split_once('=').map_or(vec![&**argument], |(key, value)| vec![key, value])
        {
            if part.contains('\n') {
                text = text.replace(part, &message::escape(part));
            }
        }
    }
    text
}

fn dispatch(cli: Cli) -> Result<(), CliError> {
    rayon::ThreadPoolBuilder::new().num_threads(cli.global.threads).build_global().map_err(
        |e| CliError::Failed(format!("cannot start {} threads: {e}", cli.global.threads)),
    )?;
    memory::set_memory_limit(cli.global.memory);
    let Cli { command, mut global } = cli;
    let Some(sharding) = command.sharding().filter(|args| args.save.is_some()).cloned() else {
        return execute(command, &global);
    };
    let tasks = sharding.tasks(global.session.words())?;
    global.session = global.session.with_tasks(global.session.words(), tasks.clone());
    execute(command, &global)?;
    tasks.finish()?;
    sharding.report(&global)
}

/// Runs a subcommand on the current pool of threads.
fn execute(command: Command, global: &Global) -> Result<(), CliError> {
    match command {
        Command::Compare(args) => commands::compare::run(&args, global),
        Command::Choose(args) => commands::choose::run(&args, global),
        Command::Sample(args) => commands::sample::run(&args, global),
        Command::Rotations(args) => commands::rotations::run(&args, global),
        Command::Spectrum(args) => commands::spectrum::run(&args, global),
        Command::Merge(args) => commands::merge::run(&args, global),
        Command::Plan(args) => commands::plan::run(&args, global),
        Command::Variance(args) => commands::variance::run(&args, global),
        Command::Progressive(args) => commands::progressive::run(&args, global),
        Command::Integrate(args) => commands::integrate::run(&args, global),
        Command::Weights(args) => commands::weights::run(&args, global),
        Command::Fit(args) => commands::fit::run(&args, global),
        Command::Bounds(args) => commands::bounds::run(&args, global),
        Command::Audit(args) => commands::audit::run(&args, global),
        Command::Quality(args) => commands::quality::run(&args, global),
        Command::Render(args) => commands::render::run(&args, global),
        Command::Lights(args) => commands::lights::run(&args, global),
        Command::Reproduce(args) => commands::reproduce::run(&args, global),
        Command::Healpix(args) => commands::healpix::run(&args, global),
        Command::Accuracy(args) => commands::accuracy::run(&args, global),
        Command::List(args) => commands::list::run(&args, global),
        Command::Completions(args) => commands::completions::run(&args, global),
        Command::Eval(args) => commands::eval::run(&args, global),
    }
}
