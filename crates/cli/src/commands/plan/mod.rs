//! `sphvar plan`: a command in parts, for programs that run jobs.
//!
//! ```text
//! words -> command -> checks of a part -> manifest.json, scripts -> engine -> parts/, logs/ -> merge
//! manifest.json, parts/, logs/ -> status
//! ```

mod folder;
mod manifest;
mod part_list;
mod scripts;
pub(crate) mod status;
mod words;

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use schemars::JsonSchema;
use serde::Serialize;

pub(crate) use self::manifest::Manifest;
use self::manifest::{Engine, Settings};
use self::scripts::{MERGE, RUN, SUBMIT};
use self::status::StatusArgs;
use self::words::PlannedWords;
use crate::args::{Cli, Command};
use crate::error::CliError;
use crate::global::Global;
use crate::report::{Document, Provenance, quoted};
use crate::shards::{Part, Tasks};

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar plan --shards 16 --for slurm -o job -- compare poisson-disk -n 1024 --integrand cosine
  sphvar plan spectrum poisson-disk -n 1024 -m 200 -o spectrum.csv --shards 16 --for shell -o parts
  sphvar plan status job
  sphvar plan status job --resubmit

Options of plan stand before the command or after it: everything from the name of the command on belongs to the \
command, up to the first of --shards and --for. A -- before the command is optional.

The folder gets manifest.json, the script `part` that computes one part, the script `merge`, and what the engine \
requires: `submit` starts the parts and then the merge (slurm, hyperqueue, shell), `run.py` does for Dask distributed \
and for the Python package of HyperQueue. `sphvar merge job` merges the parts of the plan in the folder job. Results of parts are kept in parts/, logs in logs/. The command runs in the \
folder in which plan was called, so relative paths are those of that folder, which all machines must see under the \
same path. A part that is done is not computed again, and a killed one continues.

A part uses one thread unless -j is given, to plan or to the command, so an engine runs a part per core.

status counts the parts that are done, running, failed and missing (not started, or waiting in the queue of the \
engine), and estimates the remaining time from the logs. A part has failed if it ended with an error or stopped \
reporting. --resubmit prints the line that runs failed and missing parts again, and then the merge, or the merge alone \
if it failed. The exit status is 0 if all parts are done and merged by the script of the plan, 2 if a part or the merge has \
failed, and 1 otherwise.";

/// The maximum number of parts.
pub(crate) const MAX_PARTS: u64 = 100_000;

/// The maximum number of tasks of an array of Slurm by default: `MaxArraySize` of slurm.conf is 1001,
/// and the largest index is less.
const SLURM_PARTS: u64 = 1000;

/// The options after a command that belong to the plan.
const AFTER: [&str; 2] = ["--shards", "--for"];

#[derive(Debug, Args)]
#[command(override_usage = "sphvar plan --shards K --for ENGINE -o DIR [OPTIONS] [--] COMMAND...
       sphvar plan COMMAND... --shards K --for ENGINE -o DIR [OPTIONS]
       sphvar plan status DIR [--resubmit]")]
pub(crate) struct PlanArgs {
    #[command(subcommand)]
    task: Option<PlanTask>,
    /// Number of parts
    #[arg(
        long,
        value_name = "K",
        value_parser = clap::value_parser!(u64).range(1..=MAX_PARTS)
    )]
    shards: Option<u64>,
    /// The program that runs the parts
    #[arg(long = "for", value_name = "ENGINE")]
    engine: Option<Engine>,
    /// Folder of the plan, which is created if it is missing
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Maximum number of parts at a time, for the shell [default: one per core, or what -j leaves]
    #[arg(long, value_name = "W", value_parser = clap::value_parser!(u64).range(1..))]
    workers: Option<u64>,
    /// Time limit of a part and of the merge, for Slurm, such as 2:00:00
    #[arg(long, value_name = "TIME", value_parser = parse_time)]
    time: Option<String>,
    /// Memory of a part and of the merge, for Slurm, such as 4G
    #[arg(long, value_name = "SIZE", value_parser = parse_mem)]
    mem: Option<String>,
    /// The command whose work is divided, without the name sphvar
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "COMMAND")]
    command: Vec<OsString>,
}

#[derive(Debug, Subcommand)]
enum PlanTask {
    /// Report which parts of a plan are done, running, failed and missing
    Status(StatusArgs),
}

/// A plan that was written: `sphvar plan --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct PlanBody {
    /// The folder of the plan.
    folder: String,
    /// The number of parts.
    parts: u64,
    /// The program that runs the parts: `slurm`, `hyperqueue`, `dask` or `shell`.
    #[schemars(with = "String")]
    engine: Engine,
    /// The line of a shell that runs the parts and then the merge.
    run: String,
    /// The line of a shell that reports what is done.
    status: String,
}

pub(crate) fn run(args: &PlanArgs, global: &Global) -> Result<(), CliError> {
    if let Some(PlanTask::Status(status)) = &args.task {
        if args.shards.is_some() || args.engine.is_some() || args.out.is_some() {
            return Err(CliError::Usage("status takes the folder of a plan only".to_owned()));
        }
        return status::run(status, global);
    }
    let is_own = |word: &OsString| {
        let word = word.to_string_lossy();
        AFTER.contains(&word.split('=').next().unwrap_or_default())
    };
    match args.command.iter().position(is_own) {
        None => write(args, global),
        Some(at) => {
            let words = options_first(global.session.words(), args.command.len(), at);
            let Cli { command, global: mut again } = Cli::of_words(&words, false)?;
            again.session = global.session.clone();
            match command {
                Command::Plan(args) => write(&args, &again),
                _ => Err(CliError::Usage("expected sphvar plan".to_owned())),
            }
        }
    }
}

/// Returns the words of this command with the options that follow the planned command, the last
/// `length` words, moved before it; they start at `at`.
fn options_first(words: &[String], length: usize, at: usize) -> Vec<String> {
    let (before, planned) = words.split_at(words.len() - length.min(words.len()));
    let (planned, after) = planned.split_at(at);
    let before = before.strip_suffix(&["--".to_owned()]).unwrap_or(before);
    [before, after, &["--".to_owned()], planned].concat()
}

fn write(args: &PlanArgs, global: &Global) -> Result<(), CliError> {
    let missing = |what: &str| CliError::Usage(format!("missing required option {what}"));
    let parts = args.shards.ok_or_else(|| missing("--shards K"))?;
    let engine = args.engine.ok_or_else(|| missing("--for slurm, hyperqueue, dask or shell"))?;
    let out = args.out.as_ref().ok_or_else(|| missing("-o DIR, the folder of the plan"))?;
    if args.command.is_empty() {
        return Err(CliError::Usage("missing the command whose work is divided".to_owned()));
    }
    check_engine(args, engine)?;
    for (option, is_given) in [("--seed", global.seed != 0), ("--memory", global.memory.is_some())]
    {
        if is_given {
            return Err(CliError::Usage(format!(
                "{option} is an option of the command that is divided; write it after the name of that command"
            )));
        }
    }
    let words = args.command.iter().map(|word| utf8(word)).collect::<Result<_, _>>()?;
    let words = PlannedWords::new(words)?;
    let threads = words.threads.unwrap_or(global.threads.max(1));
    let (workers, time, mem) = (args.workers, args.time.clone(), args.mem.clone());
    let settings = Settings { parts, engine, threads, workers, time, mem };
    let here = std::env::current_dir()
        .map_err(|error| CliError::Failed(format!("the current folder is unknown: {error}")))?;
    let mut manifest =
        Manifest::new(words.words(), settings, path_text(&here)?, path_text(&program())?);
    let folder = here.join(out);
    let scripts = scripts::scripts(&manifest, &words, &path_text(&folder)?);
    manifest.files = scripts.iter().map(|(name, _)| (*name).to_owned()).collect();
    check(&words, &manifest, &folder, global)?;
    let provenance = Provenance::new(&global.session, global.seed);
    folder::write(out, &manifest, &scripts, &provenance.command)?;
    if engine == Engine::Slurm && parts > SLURM_PARTS {
        global.session.say(&format!(
            "warning: sites limit the size of an array of Slurm, by default to {SLURM_PARTS} tasks, and sbatch \
             rejects {parts}; see MaxArraySize in the output of scontrol show config, or use fewer parts"
        ));
    }
    let run = run_line(&manifest, out, None)?;
    let status = format!("sphvar plan status {}", quoted(&path_text(out)?));
    if global.json {
        let body = PlanBody { folder: path_text(out)?, parts, engine, run, status };
        return Document::new(&body, &provenance).print(&global.session);
    }
    global.session.print(&format!(
        "run the parts and the merge:  {run}\nsee what is done:             {status}\n"
    ))
}

/// Returns an error for options of other engines.
fn check_engine(args: &PlanArgs, engine: Engine) -> Result<(), CliError> {
    for (option, is_given, of, name) in [
        ("--time", args.time.is_some(), Engine::Slurm, "slurm"),
        ("--mem", args.mem.is_some(), Engine::Slurm, "slurm"),
        ("--workers", args.workers.is_some(), Engine::Shell, "shell"),
    ] {
        if is_given && engine != of {
            return Err(CliError::Usage(format!("{option} requires --for {name}")));
        }
    }
    Ok(())
}

/// Runs the command as a part does, up to its tasks, which are not computed: what every part would
/// reject is rejected here.
fn check(
    words: &PlannedWords,
    manifest: &Manifest,
    folder: &Path,
    global: &Global,
) -> Result<(), CliError> {
    let parts = manifest.parts;
    let save = path_text(&manifest.part_path(folder, 1))?;
    let (part_words, Cli { command, global: mut planned }) = words.of_part(parts, &save)?;
    // A single part would report its results.
    let tasks = Tasks::planned(Part { part: 1, parts: parts.max(2) });
    planned.session = global.session.with_tasks(&part_words, tasks.clone());
    crate::execute(command, &planned)?;
    let units = tasks.planned_units();
    if units < parts {
        let some = if units == 0 { "none" } else { "only some" };
        global.session.say(&format!(
            "warning: the work consists of {units} indivisible pieces, so {some} of the {parts} parts have \
             anything to compute"
        ));
    }
    Ok(())
}

/// Returns the line of a shell that runs the merge of a plan in a folder.
fn merge_line(folder: &Path) -> Result<String, CliError> {
    Ok(format!("sh {}", quoted(&path_text(&folder.join(MERGE))?)))
}

/// Returns the line of a shell that runs parts of a plan in a folder, all of them by default, and then
/// the merge.
fn run_line(manifest: &Manifest, folder: &Path, parts: Option<&str>) -> Result<String, CliError> {
    let path = |name: &str| Ok::<_, CliError>(quoted(&path_text(&folder.join(name))?));
    Ok(match (manifest.engine, parts) {
        (Engine::Dask, None) => format!("python3 {}", path(RUN)?),
        (Engine::Dask, Some(parts)) => format!("python3 {} --parts {parts}", path(RUN)?),
        (_, None) => format!("sh {}", path(SUBMIT)?),
        (_, Some(parts)) => format!("sh {} {parts}", path(SUBMIT)?),
    })
}

/// Returns the path of this program.
fn program() -> PathBuf {
    // A package for Python starts the command by a script, which is the first argument after the
    // interpreter; the interpreter alone would not run it.
    let current = std::env::current_exe().unwrap_or_else(|_| PathBuf::from("sphvar"));
    let is_python = current
        .file_stem()
        .is_some_and(|name| name.to_string_lossy().to_lowercase().starts_with("python"));
    let script = std::env::args_os().nth(1).map(PathBuf::from).filter(|_| is_python);
    let script = script.and_then(|script| std::path::absolute(script).ok());
    match script.filter(|script| script.is_file()) {
        Some(script) => script,
        None if is_python => PathBuf::from("sphvar"),
        None => current,
    }
}

fn utf8(word: &OsStr) -> Result<String, CliError> {
    let invalid = || CliError::Usage(format!("{} is not valid UTF-8", word.display()));
    word.to_str().map(str::to_owned).ok_or_else(invalid)
}

/// Returns a path as text, which manifests and scripts consist of.
fn path_text(path: &Path) -> Result<String, CliError> {
    utf8(path.as_os_str())
}

/// Parses a time limit of Slurm.
fn parse_time(text: &str) -> Result<String, String> {
    let is_time = text.starts_with(|c: char| c.is_ascii_digit())
        && text.chars().all(|c| c.is_ascii_digit() || ":-".contains(c));
    is_time
        .then(|| text.to_owned())
        .ok_or_else(|| format!("expected minutes, H:MM:SS or D-HH:MM:SS, got \"{text}\""))
}

/// Parses an amount of memory of Slurm.
fn parse_mem(text: &str) -> Result<String, String> {
    let digits = text.trim_end_matches(['K', 'M', 'G', 'T']);
    let is_size = text.len() - digits.len() <= 1
        && !digits.is_empty()
        && digits.chars().all(|c| c.is_ascii_digit());
    is_size
        .then(|| text.to_owned())
        .ok_or_else(|| format!("expected a number with K, M, G or T such as 4G, got \"{text}\""))
}
