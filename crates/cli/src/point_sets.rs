//! Point sets from the user's files.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sphvar_samplers::{
    Domain, Ensemble, Error, PointSet, PointSets, Progress, Purpose, Realizations, Sampler,
    SetDistribution, Space, Square, SquareDistribution, SquareSampler, Streams, rotate,
};
use sphvar_spectrum::{BlockTotal, ExactSum};

use crate::commands::PointFileArgs;
use crate::error::CliError;
use crate::files::FilePoint;
use crate::session::Session;

/// The point sets of files.
pub(crate) struct FileSets<S: Space = Domain> {
    name: String,
    sets: PointSets<S>,
    /// What was reported on the files.
    remarks: Vec<String>,
}

/// What is reported on the point sets of files beside results for their points.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct SetFacts {
    /// The names of the files.
    pub(crate) name: String,
    /// The mean number of points of a set, rounded.
    pub(crate) mean_size: usize,
    /// The number of sets.
    pub(crate) count: u64,
    pub(crate) weights: WeightTotals,
    /// What was reported when they were read.
    pub(crate) remarks: Vec<String>,
}

/// Given sets in their order, each with the rotation of a realization.
pub(crate) struct RotatedSets<'a> {
    pub(crate) sets: &'a [PointSet],
    pub(crate) rotations: Realizations<'a>,
}

impl Ensemble for RotatedSets<'_> {
    fn realize_into(
        &self,
        index: u64,
        set: &mut PointSet,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        self.sets.realize_into(index, set, progress)?;
        let domain = self.rotations.sampler().domain();
        rotate(self.rotations.rotation(index), domain, &mut set.points);
        Ok(())
    }
}

/// The sums of the weights of sets, each a mean over the sets.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub(crate) struct WeightSums {
    /// `(sum w)^2 / sum w^2`, the number of equal points with the same white noise.
    pub(crate) n_effective: f64,
    /// The sum of the weights; null if it overflows.
    #[schemars(with = "Option<f64>")]
    pub(crate) sum_w: f64,
    /// The sum of the squares of the weights; null if it overflows or underflows.
    #[schemars(with = "Option<f64>")]
    pub(crate) sum_w2: f64,
}

/// Exact totals over sets of the sums of their weights, for [`WeightSums`].
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct WeightTotals {
    n_effective: ExactSum,
    sum_w: ExactSum,
    sum_w2: ExactSum,
    sets: u64,
    has_weights: bool,
}

impl WeightTotals {
    /// Returns the totals over sets.
    pub(crate) fn of_sets<P>(sets: &[PointSet<P>]) -> Self {
        let mut totals = Self::default();
        for set in sets {
            let (sum, squares) = set.weight_sums();
            totals.n_effective.add(set.n_effective());
            totals.sum_w.add(sum);
            // Sets with weights have one that is not 0.
            totals.sum_w2.add(if squares.is_normal() { squares } else { f64::NAN });
            totals.sets += 1;
            totals.has_weights |= !set.weights.is_empty();
        }
        totals
    }

    /// Returns the totals over one set that was read in blocks.
    pub(crate) fn of_blocks(total: &BlockTotal) -> Self {
        let mut totals = Self { sets: 1, has_weights: total.has_weights, ..Self::default() };
        totals.n_effective.add(total.n_effective);
        totals.sum_w.add(total.sum_w);
        totals.sum_w2.add(if total.sum_w2.is_normal() { total.sum_w2 } else { f64::NAN });
        totals
    }

    /// Adds the totals over other sets.
    pub(crate) fn merge(&mut self, other: &Self) {
        self.n_effective.merge(&other.n_effective);
        self.sum_w.merge(&other.sum_w);
        self.sum_w2.merge(&other.sum_w2);
        self.sets = self.sets.saturating_add(other.sets);
        self.has_weights |= other.has_weights;
    }

    /// Returns the means over the sets, or `None` if no set has weights.
    pub(crate) fn means(&self) -> Option<WeightSums> {
        let mean = |sum: &ExactSum| sum.value() / self.sets as f64;
        self.has_weights.then(|| WeightSums {
            n_effective: mean(&self.n_effective),
            sum_w: mean(&self.sum_w),
            sum_w2: mean(&self.sum_w2),
        })
    }
}

impl WeightSums {
    /// Returns the means over sets, or `None` if no set has weights.
    pub(crate) fn of_sets<P>(sets: &[PointSet<P>]) -> Option<Self> {
        WeightTotals::of_sets(sets).means()
    }

    /// Returns the sums of a sampler whose sets are given or always the same, or `None` if they
    /// have no weights.
    pub(crate) fn of_sampler(sampler: &dyn Sampler) -> Result<Option<Self>, CliError> {
        match sampler.distribution() {
            SetDistribution::OneOf(sets) => Ok(Self::of_sets(sets)),
            SetDistribution::Fixed => {
                let mut rng = Streams::new(0, Purpose::Pattern, 0).realization(0);
                let set = sampler.sample(&mut rng).map_err(CliError::failed)?;
                Ok(Self::of_sets(&[set]))
            }
            _ => Ok(None),
        }
    }

    /// Returns the sums of a sampler of the square whose sets are given, or `None` if they have no
    /// weights; other patterns of the square have none.
    pub(crate) fn of_square_sampler(sampler: &dyn SquareSampler) -> Option<Self> {
        match sampler.distribution() {
            SquareDistribution::OneOf(sets) => Self::of_sets(sets),
            _ => None,
        }
    }
}

impl FileSets {
    /// Reads the sets of all these files in order; on the hemisphere, points below the equator are
    /// replaced by their antipodes. Reports remarks.
    pub(crate) fn read(
        args: &PointFileArgs,
        domain: Domain,
        session: &Session,
    ) -> Result<Self, CliError> {
        Self::read_with(args, domain, session, |sets| {
            let below = match domain {
                Domain::Sphere => 0,
                Domain::Hemisphere => {
                    sets.iter().flat_map(|s| &s.points).filter(|p| p.z < 0.0).count()
                }
            };
            below_remark(below)
        })
    }
}

impl FileSets<Square> {
    /// Reads the sets of all these files in order. Reports remarks.
    pub(crate) fn read_square(args: &PointFileArgs, session: &Session) -> Result<Self, CliError> {
        Self::read_with(args, Square, session, |_| None)
    }
}

impl<S: Space<Point: FilePoint>> FileSets<S> {
    /// Reads the sets with a remark on them.
    fn read_with(
        args: &PointFileArgs,
        space: S,
        session: &Session,
        remark: impl Fn(&[PointSet<S::Point>]) -> Option<String>,
    ) -> Result<Self, CliError> {
        let options = args.options();
        let mut sets = Vec::new();
        let mut remarks = Vec::new();
        let mut say = |text: String| {
            session.say(&text);
            remarks.push(text);
        };
        for path in &args.files {
            let file = session.read_points(path, &options)?;
            for warning in &file.warnings {
                say(format!("warning: {warning}"));
            }
            file.remarks.into_iter().for_each(&mut say);
            if !args.join
                && let Some(i) = file.sets.iter().position(has_zero_weights)
            {
                return Err(CliError::File(format!(
                    "{}: all weights of set {i} (0-based) are 0",
                    path.display()
                )));
            }
            if args.join {
                join(&mut sets, file.sets, &path.display().to_string())?;
            } else {
                sets.extend(file.sets);
            }
        }
        if let Some(remark) = remark(&sets) {
            say(remark);
        }
        let name = args.name();
        let sets =
            PointSets::new(sets, space).map_err(|e| CliError::File(format!("{name}: {e}")))?;
        let mut read = Self { name, sets, remarks: Vec::new() };
        if read.count() > 1 {
            say(read.summary(args.files.len() > 1));
        }
        read.remarks = remarks;
        Ok(read)
    }

    /// Returns the number and the sizes of the sets, in words.
    fn summary(&self, several_files: bool) -> String {
        let sizes = || self.sets.sets().iter().map(PointSet::len);
        let (min, max) = (sizes().min().unwrap_or(0), sizes().max().unwrap_or(0));
        let points = if min == max {
            format!("{min} points each")
        } else {
            format!("{min} to {max} points, each normalised by its own number")
        };
        let join = if several_files { "; --join makes the files one set" } else { "" };
        format!("{} realizations read, {points}{join}", self.count())
    }

    /// Returns what is reported on the sets beside results for their points.
    pub(crate) fn facts(&self) -> SetFacts {
        SetFacts {
            name: self.name.clone(),
            mean_size: self.mean_size(),
            count: self.count(),
            weights: WeightTotals::of_sets(self.sets.sets()),
            remarks: self.remarks.clone(),
        }
    }

    /// Returns the names of the files.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// Returns the sets, which are both an ensemble and a sampler.
    pub(crate) fn sets(&self) -> &PointSets<S> {
        &self.sets
    }

    /// Returns the number of sets.
    pub(crate) fn count(&self) -> u64 {
        self.sets.sets().len() as u64
    }

    /// Returns the mean number of points of a set, rounded.
    pub(crate) fn mean_size(&self) -> usize {
        let total: usize = self.sets.sets().iter().map(PointSet::len).sum();
        let count = self.sets.sets().len();
        (total + count / 2) / count
    }
}

/// Returns whether a set has weights, all of them 0.
fn has_zero_weights<P>(set: &PointSet<P>) -> bool {
    !set.weights.is_empty() && set.weights.iter().all(|&w| w == 0.0)
}

/// Appends the sets of another file to the single joined set.
fn join<P>(
    joined: &mut Vec<PointSet<P>>,
    sets: Vec<PointSet<P>>,
    path: &str,
) -> Result<(), CliError> {
    for set in sets {
        let Some(one) = joined.first_mut() else {
            joined.push(set);
            continue;
        };
        check_joined_weights(!one.weights.is_empty(), !set.weights.is_empty(), path)?;
        one.weights.extend(set.weights);
        one.points.extend(set.points);
    }
    Ok(())
}

/// Rejects a file with weights after others without them, and the reverse.
pub(crate) fn check_joined_weights(
    have_others: bool,
    has_this: bool,
    path: &str,
) -> Result<(), CliError> {
    match (have_others, has_this) {
        (true, false) => Err(CliError::File(format!(
            "--join: {path} has no weights, but the files before it have"
        ))),
        (false, true) => Err(CliError::File(format!(
            "--join: {path} has weights, but the files before it have none"
        ))),
        _ => Ok(()),
    }
}

/// Returns the remark on points below the equator of the hemisphere, if there are any.
pub(crate) fn below_remark(below: usize) -> Option<String> {
    let remark = || format!("{below} points with z < 0 are replaced by their antipodes");
    (below > 0).then(remark)
}
