//! `sphvar merge`: one spectrum from saved parts.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;

use super::spectrum::{Remarks, check_save, emit};
use crate::error::CliError;
use crate::files::Shard;
use crate::global::Global;
use crate::report::{Provenance, check_result, say};

pub(crate) const EXAMPLES: &str = "Examples:
  sphvar spectrum poisson-disk -n 1024 -m 200 --shard 1/2 --save a.shard
  sphvar spectrum poisson-disk -n 1024 -m 200 --shard 2/2 --save b.shard
  sphvar merge a.shard b.shard -o spectrum.csv

Sums are kept exactly: the spectrum has the bits of one run, whatever the parts and their order. Parts
of other samplers, numbers of points, degrees, accuracies, seeds or versions are refused, and so is a
realization that is in two of them.";

#[derive(Debug, Args)]
pub(crate) struct MergeArgs {
    /// Files of `spectrum --save`
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Write the spectrum to a file: .csv, .json, or a plot as .svg or .png
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Save the sums of all parts as one
    #[arg(long, value_name = "FILE")]
    save: Option<PathBuf>,
}

pub(crate) fn run(args: &MergeArgs, global: &Global) -> Result<(), CliError> {
    if let Some(path) = &args.out {
        check_result(path, true)?;
    }
    if let Some(path) = &args.save {
        check_save(path)?;
    }
    let started = Instant::now();
    let mut shards = Vec::new();
    for path in &args.files {
        shards.push((path.display().to_string(), Shard::read(path)?));
    }
    check_overlap(&shards)?;
    let mut shards = shards.into_iter();
    let Some((first, mut whole)) = shards.next() else {
        return Err(CliError::Usage("no files to merge".to_owned()));
    };
    for (name, shard) in shards {
        let differ = |what: &str, a: &dyn std::fmt::Display, b: &dyn std::fmt::Display| {
            CliError::Failed(format!("{first} and {name} are of different {what}: {a} and {b}"))
        };
        let (a, b) = (&whole.ensemble, &shard.ensemble);
        if a.sampler != b.sampler {
            return Err(differ("samplers", &a.sampler, &b.sampler));
        }
        if a.seed != b.seed {
            return Err(differ("seeds", &a.seed, &b.seed));
        }
        if a.transform != b.transform {
            return Err(differ("transforms", &a.transform, &b.transform));
        }
        if a.version != b.version {
            return Err(differ("versions of sphvar", &a.version, &b.version));
        }
        whole
            .sums
            .try_merge(&shard.sums)
            .map_err(|error| CliError::Failed(format!("{first} and {name}: {error}")))?;
        whole.parts.extend(shard.parts);
    }
    whole.parts.sort_by_key(|part| part.start);
    whole.parts.dedup_by(|next, part| {
        let touch = part.end == next.start;
        if touch {
            part.end = next.end;
        }
        touch
    });
    let parts: Vec<String> =
        whole.parts.iter().map(|part| format!("{} to {}", part.start, part.end - 1)).collect();
    say(global.quiet, &format!("{}, realizations {}", whole.ensemble.sampler, parts.join(", ")));
    if let Some(path) = &args.save {
        whole.write(path)?;
    }
    let spectrum = whole.sums.finish()?;
    let spectrum = if whole.ensemble.is_random { spectrum } else { spectrum.into_exact() };
    let seconds = started.elapsed().as_secs_f64();
    let provenance = Provenance::new(whole.ensemble.seed);
    emit(
        args.out.as_deref(),
        global,
        &whole.ensemble.sampler,
        &spectrum,
        Remarks::default(),
        seconds,
        &provenance,
    )
}

/// Refuses a realization that is in two files.
fn check_overlap(shards: &[(String, Shard)]) -> Result<(), CliError> {
    let mut parts: Vec<_> =
        shards.iter().flat_map(|(name, s)| s.parts.iter().map(move |part| (part, name))).collect();
    parts.sort_by_key(|(part, _)| part.start);
    for pair in parts.windows(2) {
        let [(a, first), (b, second)] = pair else { continue };
        if a.end > b.start {
            return Err(CliError::Failed(format!(
                "realization {} is in {first} and in {second}",
                b.start
            )));
        }
    }
    Ok(())
}
