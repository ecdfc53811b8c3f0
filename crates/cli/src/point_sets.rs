//! Point sets that users bring in files.

use glam::DVec3;
use serde::Serialize;
use sphvar_samplers::Domain;
use sphvar_spectrum::PointSets;

use crate::commands::PointFileArgs;
use crate::error::CliError;
use crate::files::{PointSet, read_points};
use crate::report::say;

/// The point sets of files, as an ensemble.
pub(crate) struct FileSets {
    name: String,
    sets: Vec<PointSet>,
}

/// The sums of the weights of sets, each a mean over the sets.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct WeightSums {
    /// `(sum w)^2 / sum w^2`, the number of equal points with the same white noise.
    pub(crate) n_effective: f64,
    pub(crate) sum_w: f64,
    pub(crate) sum_w2: f64,
}

impl FileSets {
    /// The sets of all these files in their order, turned up to `domain`; says what is remarkable
    /// about them unless `quiet`.
    pub(crate) fn read(
        args: &PointFileArgs,
        domain: Domain,
        quiet: bool,
    ) -> Result<Self, CliError> {
        let options = args.options();
        let mut sets = Vec::new();
        for path in &args.files {
            let file = read_points(path, &options)?;
            for warning in &file.warnings {
                say(quiet, &format!("warning: {warning}"));
            }
            for remark in &file.remarks {
                say(quiet, remark);
            }
            if args.join {
                join(&mut sets, file.sets, &path.display().to_string())?;
            } else {
                sets.extend(file.sets);
            }
        }
        for (i, set) in sets.iter().enumerate() {
            if set.weights.as_ref().is_some_and(|w| w.iter().all(|&w| w == 0.0)) {
                return Err(CliError::Failed(format!("set {i} has no weight: every weight is 0")));
            }
        }
        for set in &mut sets {
            for p in &mut set.directions {
                *p = domain.representative(*p);
            }
        }
        let names: Vec<String> = args.files.iter().map(|p| p.display().to_string()).collect();
        let read = Self { name: names.join(" "), sets };
        if read.sets.len() > 1 {
            say(quiet, &read.summary(args.files.len() > 1));
        }
        Ok(read)
    }

    /// Returns how many sets there are and of what size, for people.
    fn summary(&self, several_files: bool) -> String {
        let sizes = || self.sets.iter().map(|s| s.directions.len());
        let (least, most) = (sizes().min().unwrap_or(0), sizes().max().unwrap_or(0));
        let points = if least == most {
            format!("{least} points each")
        } else {
            format!("{least} to {most} points, each normalised by its own number")
        };
        let join = if several_files { "; --join makes the files one set" } else { "" };
        format!("{} realizations read, {points}{join}", self.sets.len())
    }

    /// Returns the sums of the weights; `None` if no set has any.
    pub(crate) fn weight_sums(&self) -> Option<WeightSums> {
        if self.sets.iter().all(|set| set.weights.is_none()) {
            return None;
        }
        let mut mean = WeightSums { n_effective: 0.0, sum_w: 0.0, sum_w2: 0.0 };
        let share = 1.0 / self.sets.len() as f64;
        for set in &self.sets {
            let n = set.directions.len() as f64;
            let (sum, squares, scale) = set.weights.as_ref().map_or((n, n, 1.0), |weights| {
                // The squares of the largest and the smallest weights leave the range of f64.
                let scale = weights.iter().fold(0.0_f64, |scale, w| scale.max(w.abs()));
                let scaled = || weights.iter().map(|w| w / scale);
                (compensated(scaled()), compensated(scaled().map(|w| w * w)), scale)
            });
            mean.n_effective += share * (sum * sum / squares);
            mean.sum_w += share * (scale * sum);
            mean.sum_w2 += share * (scale * (scale * squares));
        }
        Some(mean)
    }

    /// The names of the files.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// How many sets there are.
    pub(crate) fn count(&self) -> u64 {
        self.sets.len() as u64
    }

    /// The mean number of points of a set, rounded.
    pub(crate) fn mean_size(&self) -> usize {
        let total: usize = self.sets.iter().map(|s| s.directions.len()).sum();
        (total + self.sets.len() / 2) / self.sets.len().max(1)
    }
}

impl PointSets for FileSets {
    fn realize_into(
        &self,
        index: u64,
        points: &mut Vec<DVec3>,
        weights: &mut Vec<f64>,
    ) -> Result<(), sphvar_spectrum::Error> {
        let set = usize::try_from(index).ok().and_then(|i| self.sets.get(i));
        points.clear();
        weights.clear();
        if let Some(set) = set {
            points.extend_from_slice(&set.directions);
            weights.extend(set.weights.iter().flatten());
        }
        Ok(())
    }
}

/// Adds the sets of one more file to the one set of all.
fn join(joined: &mut Vec<PointSet>, sets: Vec<PointSet>, path: &str) -> Result<(), CliError> {
    for set in sets {
        let Some(one) = joined.first_mut() else {
            joined.push(set);
            continue;
        };
        match (&mut one.weights, set.weights) {
            (Some(weights), Some(more)) => weights.extend(more),
            (None, None) => {}
            (Some(_), None) => {
                return Err(CliError::Failed(format!(
                    "--join: {path} has no weights, the points before it have"
                )));
            }
            (None, Some(_)) => {
                return Err(CliError::Failed(format!(
                    "--join: {path} has weights, the points before it have none"
                )));
            }
        }
        one.directions.extend(set.directions);
    }
    Ok(())
}

/// Returns a sum with the error of a single rounding or so (Neumaier).
fn compensated(terms: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut rest) = (0.0_f64, 0.0);
    for term in terms {
        let next = sum + term;
        rest += if sum.abs() >= term.abs() { (sum - next) + term } else { (term - next) + sum };
        sum = next;
    }
    sum + rest
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::{FileSets, WeightSums};
    use crate::files::PointSet;

    fn of_weights(weights: &[f64]) -> Option<WeightSums> {
        let directions = vec![DVec3::Z; weights.len()];
        let set = PointSet { directions, weights: Some(weights.to_vec()) };
        FileSets { name: String::new(), sets: vec![set] }.weight_sums()
    }

    #[test]
    fn effective_numbers_do_not_depend_on_the_scale() {
        for scale in [1.0, 1e-160, 1e154] {
            let sums = of_weights(&[scale, 2.0 * scale, -0.5 * scale]).unwrap();
            // (1 + 2 - 1/2)^2 / (1 + 4 + 1/4).
            assert!((sums.n_effective - 6.25 / 5.25).abs() < 1e-15, "{sums:?}");
            assert!((sums.sum_w / (2.5 * scale) - 1.0).abs() < 1e-15, "{sums:?}");
        }
        // A tenth cannot be represented; a plain sum of a million of them is off by 1e-6.
        let sums = of_weights(&vec![0.1; 1_000_000]).unwrap();
        assert!((sums.sum_w - 1e5).abs() < 1e-10, "{sums:?}");
        let none = PointSet { directions: vec![DVec3::Z], weights: None };
        assert_eq!(FileSets { name: String::new(), sets: vec![none] }.weight_sums(), None);
    }
}
