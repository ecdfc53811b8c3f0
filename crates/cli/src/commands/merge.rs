//! `sphvar merge`: the results of a run that was computed in parts.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{Arg, Args, CommandFactory};

use super::plan::Manifest;
use crate::args::Cli;
use crate::error::CliError;
use crate::files::{AtomicFile, is_stdout, record_input};
use crate::global::Global;
use crate::shards::{ShardFile, Tasks};

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar spectrum poisson-disk -n 1024 -m 200 --shard 1/2 --save a.shard
  sphvar spectrum poisson-disk -n 1024 -m 200 --shard 2/2 --save b.shard
  sphvar merge a.shard b.shard -o spectrum.csv
  sphvar merge a.shard b.shard --json

A merge writes what the command itself would write, with the options of output in its parts or those given here: its \
results are bit-identical to those of one run, for any number of parts in any order. Options that only this command has \
follow --, as in `sphvar merge a.shard b.shard -- --per-order orders.csv`. Parts of different commands, versions or \
instruction-set classes are an error, and so are parts that read different files, a part that is given twice and, without \
--partial, missing parts.";

#[derive(Debug, Args)]
pub(crate) struct MergeArgs {
    /// The files of --save of all parts, or the folder of a plan
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Where the command writes its results, in any form that it has [default: that of the parts]
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Report the results of the given parts even if others are missing
    #[arg(long)]
    partial: bool,
    /// Save the results of all given parts in one file
    #[arg(long, value_name = "FILE")]
    save: Option<PathBuf>,
    /// Further options of output of the command
    #[arg(last = true, value_name = "OPTIONS")]
    outputs: Vec<OsString>,
}

pub(crate) fn run(args: &MergeArgs, global: &Global) -> Result<(), CliError> {
    let is_seed = |word: &String| word == "--seed" || word.starts_with("--seed=");
    let is_letter = |word: &String| word.starts_with("-s") && !word.starts_with("--");
    if global.session.words().iter().any(|word| is_seed(word) || is_letter(word)) {
        return Err(CliError::Usage("--seed: the parts have the seed of their command".to_owned()));
    }
    if let Some(path) = &args.save {
        if is_stdout(path) {
            return Err(CliError::Usage("--save must name a file".to_owned()));
        }
        AtomicFile::check(path)?;
    }
    let mut files = Vec::new();
    let mut memory = MAX_HELD;
    for path in paths(args)? {
        files.push((path.display().to_string(), ShardFile::read_within(&path, &mut memory)?));
        record_input(&path);
    }
    let merged = ShardFile::merged(files)?;
    let (have, of) = (&merged.request.parts, merged.request.of);
    let missing: Vec<u64> = missing(have, of).take(MAX_LISTED + 1).collect();
    if !missing.is_empty() && !args.partial {
        return Err(CliError::File(format!(
            "missing: {} of {of}; add {}, or use --partial for the results of the {} given",
            in_words(&missing),
            if missing.len() == 1 { "it" } else { "them" },
            have.len(),
        )));
    }
    // A run of which nothing is expensive has no results at all.
    if merged.is_empty() && !missing.is_empty() {
        return Err(CliError::File(
            "the given parts have no results: other parts have them".to_owned(),
        ));
    }
    let command = merged.request.command();
    global.session.say(&if missing.is_empty() {
        format!("{command}: all {of} parts")
    } else {
        format!(
            "{command}: {} of {of} parts; results that need the others are incomplete or left out",
            have.len()
        )
    });
    if let Some(path) = &args.save {
        merged.write(path)?;
    }
    let words = words(args, &merged.request.words, global)?;
    let Cli { command, global: mut replayed } = Cli::of_words(&words, true)
        .map_err(|error| CliError::Usage(format!("{command}: {error}")))?;
    let tasks = Tasks::of_results(merged, args.partial);
    // What is incomplete must not be taken for the result of the command.
    let shown = if missing.is_empty() { &words[..] } else { global.session.words() };
    replayed.session = global.session.with_tasks(shown, tasks);
    crate::execute(command, &replayed).map_err(|error| match error {
        CliError::File(text) if text.starts_with("cannot open ") => CliError::File(format!(
            "{text}; files of the command are named from the folder in which its parts were computed"
        )),
        other => other,
    })
}

/// The options that change what is written but not what is computed, beside those of every command.
const OUTPUTS: [&str; 5] = ["-o", "--out", "--force", "--per-order", "--coefficient"];

/// The maximum number of bytes of results that are held; others are read when they are added.
const MAX_HELD: u64 = 1 << 28;

/// Returns the files of the parts: those given, or those of a plan in their place.
fn paths(args: &MergeArgs) -> Result<Vec<PathBuf>, CliError> {
    let mut paths = Vec::new();
    for path in &args.files {
        if !path.is_dir() {
            paths.push(path.clone());
            continue;
        }
        let manifest = Manifest::of_folder(path)?;
        let shown = path.display();
        let parts = manifest.existing_parts(path);
        if parts.is_empty() {
            return Err(CliError::File(format!(
                "no part of {shown} is done; see sphvar plan status {shown}"
            )));
        }
        // Its inputs and outputs are relative to that folder.
        let folder = manifest.working_folder();
        let is_here = std::env::current_dir()
            .and_then(|here| Ok(here.canonicalize()? == folder.canonicalize()?))
            .unwrap_or(false);
        if !is_here {
            return Err(CliError::File(format!(
                "the paths of the plan {shown} are relative to {}; run its script merge, or name its parts with \
                 {shown}/parts/*.shard to merge them here",
                folder.display()
            )));
        }
        paths.extend(parts);
    }
    Ok(paths)
}

/// Returns the words of the command with the options of output of this one.
fn words(args: &MergeArgs, request: &[String], global: &Global) -> Result<Vec<String>, CliError> {
    let mut words = request.to_vec();
    let utf8 = |word: &OsString| {
        let shown = || CliError::Usage(format!("{} is not valid UTF-8", word.display()));
        word.to_str().map(str::to_owned).ok_or_else(shown)
    };
    if let Some(path) = &args.out {
        words.extend(["-o".to_owned(), utf8(&path.clone().into_os_string())?]);
    }
    let outputs = args.outputs.iter().map(utf8).collect::<Result<Vec<_>, _>>()?;
    for word in outputs.iter().filter(|word| word.starts_with('-')) {
        let flag = word.split('=').next().unwrap_or_default();
        if !OUTPUTS.contains(&flag) {
            return Err(CliError::Usage(format!(
                "{flag} is no option of output, and the parts have computed their command as it is; those of output are {}",
                OUTPUTS.join(", ")
            )));
        }
    }
    for word in &outputs {
        words = without(words, word.split('=').next().unwrap_or_default());
    }
    words.extend(outputs);
    words.extend(global.json.then(|| "--json".to_owned()));
    words.extend(global.quiet.then(|| "--quiet".to_owned()));
    Ok(words)
}

/// Returns words without an option and its values: those of options with several values would be
/// added to later ones.
fn without(words: Vec<String>, flag: &str) -> Vec<String> {
    let command = Cli::command();
    let mut names = words.iter();
    let subcommand = names.find_map(|word| command.find_subcommand(word));
    let is_flag =
        |arg: &&Arg| flag.strip_prefix("--").is_some_and(|name| arg.get_long() == Some(name));
    let Some(arg) = subcommand.and_then(|command| command.get_arguments().find(is_flag)) else {
        return words;
    };
    let values = arg.get_num_args().map_or(1, |count| count.max_values());
    let mut kept = Vec::new();
    let mut words = words.into_iter().peekable();
    while let Some(word) = words.next() {
        let joined = word.strip_prefix(flag).is_some_and(|rest| rest.starts_with('='));
        if word == flag {
            for _ in 0..values {
                words.next_if(|word| !word.starts_with("--"));
            }
        } else if !joined {
            kept.push(word);
        }
    }
    kept
}

/// The maximum number of parts in a message.
const MAX_LISTED: usize = 12;

/// Returns the parts of `of` that are not in a list in order.
fn missing(have: &[u64], of: u64) -> impl Iterator<Item = u64> {
    let mut have = have.iter().copied().peekable();
    (1..=of).filter(move |&part| have.next_if_eq(&part).is_none())
}

fn in_words(parts: &[u64]) -> String {
    let named: Vec<String> = parts.iter().take(MAX_LISTED).map(u64::to_string).collect();
    let noun = if parts.len() == 1 { "part" } else { "parts" };
    let more = if parts.len() > MAX_LISTED { ", ..." } else { "" };
    format!("{noun} {}{more}", named.join(", "))
}
