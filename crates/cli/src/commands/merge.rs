//! `sphvar merge`: merges spectrum shards.

use std::ops::Range;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use sphvar_spectrum::SpectrumAccumulator;

use super::spectrum::{Remarks, SquareResult, check_save, emit, emit_square};
use crate::error::CliError;
use crate::files::{Part, SavedEnsemble, Shard, ShardSums, SquareSums};
use crate::flags::OutArgs;
use crate::global::Global;
use crate::report::{Provenance, check_result};

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar spectrum poisson-disk -n 1024 -m 200 --shard 1/2 --save a.shard
  sphvar spectrum poisson-disk -n 1024 -m 200 --shard 2/2 --save b.shard
  sphvar merge a.shard b.shard -o spectrum.csv

Sums are exact, so the spectrum is bit-identical to that of a single run for any parts in any order. Shards of different samplers, numbers of points or realizations, degrees, accuracies, seeds, versions \
or instruction-set classes are an error, and so are duplicate realizations and, without --partial, missing \
parts.";

#[derive(Debug, Args)]
pub(crate) struct MergeArgs {
    /// Shards, the files of `sphvar spectrum --save`
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    #[command(flatten)]
    out: OutArgs,
    /// Merge the given shards even if others are missing
    #[arg(long)]
    partial: bool,
    /// Save the exact sums of all shards as one
    #[arg(long, value_name = "FILE")]
    save: Option<PathBuf>,
}

pub(crate) fn run(args: &MergeArgs, global: &Global) -> Result<(), CliError> {
    if let Some(path) = &args.out.out {
        check_result(path, true)?;
    }
    if let Some(path) = &args.save {
        check_save(path)?;
    }
    let started = Instant::now();
    let out = args.out.out.as_deref();
    let seconds = || started.elapsed().as_secs_f64();
    if args.files.iter().all(|path| Shard::<SquareSums>::begins(path)) {
        let Shard { ensemble, sums, .. } = merged::<SquareSums>(args, global)?;
        let result = SquareResult::of_sums(&sums, !ensemble.is_random)?;
        let provenance = Provenance::new(&global.session, ensemble.seed);
        let (name, remarks) = (&ensemble.sampler, Remarks::default());
        return emit_square(out, global, name, &result, &remarks, seconds(), &provenance);
    }
    let Shard { ensemble, sums, .. } = merged::<SpectrumAccumulator>(args, global)?;
    let spectrum = sums.finish()?;
    let spectrum = if ensemble.is_random { spectrum } else { spectrum.into_exact() };
    let provenance = Provenance::new(&global.session, ensemble.seed);
    let (name, remarks) = (&ensemble.sampler, Remarks::default());
    emit(out, global, name, &spectrum, remarks, seconds(), &provenance)
}

/// Returns the shards of `args` as one, after it is saved if requested.
fn merged<S: ShardSums>(args: &MergeArgs, global: &Global) -> Result<Shard<S>, CliError> {
    let mut shards: Vec<(String, Shard<S>)> = Vec::new();
    for path in &args.files {
        shards.push((path.display().to_string(), Shard::read(path)?));
    }
    let whole = merge_shards(shards)?;
    let total = whole.ensemble.realizations;
    let missing = whole.missing();
    if !missing.is_empty() && !args.partial {
        return Err(CliError::File(format!(
            "missing: {}; add {}, or use --partial to merge the {} available of {total} realizations",
            missing_in_words(&whole),
            if missing.len() == 1 { "it" } else { "them" },
            total - count(&missing),
        )));
    }
    let merged = if missing.is_empty() {
        format!("all {total} realizations")
    } else {
        let ranges = in_words(&joined(whole.ranges()), range_in_words);
        format!("{} of {total} realizations: {ranges}", total - count(&missing))
    };
    global.session.say(&format!("{}, {merged}", whole.ensemble.sampler));
    if let Some(path) = &args.save {
        whole.write(path)?;
    }
    Ok(whole)
}

/// Returns shards of one ensemble, each with its name in messages, as one.
///
/// # Errors
///
/// If there are none, if they are of different ensembles, or if a realization is in two of them.
pub(crate) fn merge_shards<S: ShardSums>(
    shards: Vec<(String, Shard<S>)>,
) -> Result<Shard<S>, CliError> {
    check_equal(&shards, |ensemble| {
        let SavedEnsemble { sampler, seed, realizations, .. } = ensemble;
        let of_sampler = [
            ("samplers", sampler.clone()),
            ("seeds", seed.to_string()),
            ("numbers of realizations", realizations.to_string()),
        ];
        of_sampler.into_iter().chain(computation(ensemble)).collect()
    })?;
    check_overlap(&shards)?;
    let mut whole = sum(shards)?;
    let total = whole.ensemble.realizations;
    whole.parts.sort_by_key(|part| part.range(total).start);
    Ok(whole)
}

/// Returns the sums of given sets, each with its name in messages, as one. Given sets have no
/// numbers, so all are added.
///
/// # Errors
///
/// If there are none, or if they were computed differently.
pub(crate) fn merge_given<S: ShardSums>(
    shards: Vec<(String, Shard<S>)>,
) -> Result<Shard<S>, CliError> {
    check_equal(&shards, |ensemble| computation(ensemble).collect())?;
    let count = |(_, shard): &(String, Shard<S>)| shard.ensemble.realizations;
    let total = shards.iter().map(count).fold(0, u64::saturating_add);
    let mut whole = sum(shards)?;
    whole.ensemble.realizations = total;
    whole.ensemble.is_random = total > 1;
    whole.parts = vec![Part::WHOLE];
    Ok(whole)
}

/// Adds the sums of shards.
fn sum<S: ShardSums>(shards: Vec<(String, Shard<S>)>) -> Result<Shard<S>, CliError> {
    let mut shards = shards.into_iter();
    let Some((first, mut whole)) = shards.next() else {
        return Err(CliError::Usage("no files to merge".to_owned()));
    };
    for (name, shard) in shards {
        whole
            .sums
            .try_merge(&shard.sums)
            .map_err(|error| CliError::File(format!("{first} and {name}: {error}")))?;
        whole.parts.extend(shard.parts);
    }
    Ok(whole)
}

/// Returns what the bits of sums depend on besides the sets.
fn computation<D>(ensemble: &SavedEnsemble<D>) -> impl Iterator<Item = (&'static str, String)> {
    let SavedEnsemble { transform, version, instruction_set, .. } = ensemble;
    let facts = [
        ("transforms", transform.clone()),
        ("versions of sphvar", version.clone()),
        ("instruction sets", instruction_set.clone()),
    ];
    facts.into_iter()
}

/// Returns an error if two shards differ in one of the facts on their ensembles.
fn check_equal<S: ShardSums>(
    shards: &[(String, Shard<S>)],
    facts: impl Fn(&SavedEnsemble<S::Domain>) -> Vec<(&'static str, String)>,
) -> Result<(), CliError> {
    let Some(((first, a), others)) = shards.split_first() else { return Ok(()) };
    let expected = facts(&a.ensemble);
    for (name, b) in others {
        let pairs = expected.iter().zip(facts(&b.ensemble));
        if let Some(((what, a), (_, b))) = pairs.into_iter().find(|((_, a), (_, b))| a != b) {
            return Err(CliError::File(format!(
                "{first} and {name} are of different {what}: {a} and {b}"
            )));
        }
    }
    Ok(())
}

/// The maximum number of list entries in a message; further entries are counted.
const MAX_LISTED: usize = 12;

fn in_words<T>(list: &[T], word: impl Fn(&T) -> String) -> String {
    let named: Vec<String> = list.iter().take(MAX_LISTED).map(word).collect();
    let more = list.len() - named.len();
    named.join(", ") + &if more > 0 { format!(" and {more} more") } else { String::new() }
}

fn range_in_words(range: &Range<u64>) -> String {
    match range.end - range.start {
        1 => range.start.to_string(),
        _ => format!("{} to {}", range.start, range.end - 1),
    }
}

/// Returns the missing parts if all files have the same number of parts, and their realizations.
fn missing_in_words<S: ShardSums>(whole: &Shard<S>) -> String {
    let missing = whole.missing();
    let realizations = format!("realizations {}", in_words(&missing, range_in_words));
    let total = whole.ensemble.realizations;
    let parts = whole.parts[0].parts;
    if whole.parts.iter().any(|part| part.parts != parts) {
        return realizations;
    }
    let mut absent = Vec::new();
    for gap in &missing {
        let mut next = gap.start;
        // One more than are named shows that there are more.
        while next < gap.end && absent.len() <= MAX_LISTED {
            let part = Part::of_realization(next, total, parts);
            next = part.range(total).end;
            absent.push(part);
        }
    }
    let more = if absent.len() > MAX_LISTED { ", ..." } else { "" };
    absent.truncate(MAX_LISTED);
    format!("parts {}{more} ({realizations})", in_words(&absent, Part::to_string))
}

/// Returns the ranges in order, with adjacent ranges joined.
fn joined(mut ranges: Vec<Range<u64>>) -> Vec<Range<u64>> {
    ranges.dedup_by(|next, range| {
        let touch = range.end == next.start;
        if touch {
            range.end = next.end;
        }
        touch
    });
    ranges
}

fn count(ranges: &[Range<u64>]) -> u64 {
    ranges.iter().map(|range| range.end - range.start).sum()
}

/// Rejects a realization that is in two files.
fn check_overlap<S: ShardSums>(shards: &[(String, Shard<S>)]) -> Result<(), CliError> {
    let mut parts: Vec<_> = shards
        .iter()
        .flat_map(|(name, s)| s.ranges().into_iter().map(move |range| (range, name)))
        .collect();
    parts.sort_by_key(|(part, _)| part.start);
    for pair in parts.windows(2) {
        let [(a, first), (b, second)] = pair else { continue };
        if a.end > b.start {
            return Err(CliError::File(format!(
                "realization {} is in {first} and in {second}",
                b.start
            )));
        }
    }
    Ok(())
}
