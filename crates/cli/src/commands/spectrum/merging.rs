//! Merging of sums in memory.

use std::ops::Range;

use super::saved::{SavedEnsemble, Shard, ShardSums};
use crate::error::CliError;
use crate::shards::Part;

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
        return Err(CliError::Usage("no sums to merge".to_owned()));
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

/// Rejects a realization that is in two of them.
fn check_overlap<S: ShardSums>(shards: &[(String, Shard<S>)]) -> Result<(), CliError> {
    let mut parts: Vec<(Range<u64>, &String)> = shards
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
