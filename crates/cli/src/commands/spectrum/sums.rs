//! The sums of spectra, which are merged from files or in memory.

use serde::{Deserialize, Serialize};
use sphvar_spectrum::SpectrumAccumulator;

use super::merging::{merge_given, merge_shards};
use super::report::Remarks;
use super::saved::{Shard, ShardSums};
use crate::error::CliError;
use crate::point_sets::{WeightSums, WeightTotals};

/// The sums of the realizations of a spectrum, with what is reported beside them.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(bound = "S: ShardSums")]
pub(crate) struct EstimatedSums<S: ShardSums = SpectrumAccumulator> {
    pub(crate) shard: Shard<S>,
    pub(crate) origin: Origin,
}

/// The origin of the realizations of a spectrum.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) enum Origin {
    /// The numbered realizations of a built-in sampler.
    Sampler(Option<WeightSums>),
    /// The numbered realizations of a sampler that reads files. Their content is not recorded, so it
    /// is unknown whether others are of the same sampler.
    FileSampler(Option<WeightSums>),
    /// The sets that the user gave, each once: they have no numbers.
    Given(Box<WeightTotals>),
}

impl Origin {
    /// Returns the origin of realizations of a sampler, which reads files if `is_file`.
    pub(super) fn of_sampler(is_file: bool, weights: Option<WeightSums>) -> Self {
        if is_file { Self::FileSampler(weights) } else { Self::Sampler(weights) }
    }
}

impl<S: ShardSums> EstimatedSums<S> {
    /// Returns what is reported beside the spectrum of these sums.
    pub(crate) fn remarks(&self) -> Remarks {
        // A single given set is of interest itself, not as a realization of an ensemble, so its
        // spectrum has no error.
        let (has_no_error, weights) = match &self.origin {
            Origin::Sampler(weights) | Origin::FileSampler(weights) => (false, *weights),
            Origin::Given(totals) => (self.shard.ensemble.realizations == 1, totals.means()),
        };
        Remarks { has_no_error, weights, pairs: None }
    }

    /// Returns the sums of the realizations of both; `names` are theirs in messages. Given sets are
    /// added; realizations of a sampler must differ, as those of files of sums.
    pub(crate) fn merged(self, other: Self, names: [&str; 2]) -> Result<Self, CliError> {
        let [name, other_name] = names.map(str::to_owned);
        let origin = match (self.origin, other.origin) {
            (Origin::Sampler(weights), Origin::Sampler(_)) => Origin::Sampler(weights),
            (Origin::Given(mut totals), Origin::Given(others)) => {
                totals.merge(&others);
                Origin::Given(totals)
            }
            (Origin::FileSampler(_), _) | (_, Origin::FileSampler(_)) => {
                return Err(CliError::Usage(
                    "spectra of samplers that read files cannot be merged: the content of the files is not recorded with \
                     the sums; give the sets as points"
                        .to_owned(),
                ));
            }
            _ => {
                return Err(CliError::Usage(format!(
                    "cannot merge the spectra of a sampler and of given sets: {} and {}",
                    self.shard.ensemble.sampler, other.shard.ensemble.sampler
                )));
            }
        };
        let shards = vec![(name, self.shard), (other_name, other.shard)];
        let shard = match origin {
            Origin::Given(_) => merge_given(shards),
            _ => merge_shards(shards),
        };
        // What is wrong are the sums given here, not files.
        let shard = shard.map_err(CliError::usage)?;
        Ok(Self { shard, origin })
    }
}
