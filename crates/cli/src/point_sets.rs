//! Point sets that users bring in files.

use std::path::PathBuf;

use glam::DVec3;
use sphvar_samplers::Domain;
use sphvar_spectrum::PointSets;

use crate::error::CliError;
use crate::files::{PointSet, ReadOptions, read_points};
use crate::report::say;

/// The point sets of files, as an ensemble.
pub(crate) struct FileSets {
    name: String,
    sets: Vec<PointSet>,
}

impl FileSets {
    /// The sets of all these files in their order, turned up to `domain`; says what is remarkable
    /// about them unless `quiet`.
    pub(crate) fn read(
        files: &[PathBuf],
        columns: Option<&[String]>,
        domain: Domain,
        quiet: bool,
    ) -> Result<Self, CliError> {
        let columns = columns.map(<[String]>::to_vec);
        let options = ReadOptions { columns, ..ReadOptions::default() };
        let mut sets = Vec::new();
        for path in files {
            let file = read_points(path, &options)?;
            for warning in &file.warnings {
                say(quiet, &format!("warning: {warning}"));
            }
            sets.extend(file.sets);
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
        let sizes: Vec<usize> = sets.iter().map(|s| s.directions.len()).collect();
        if let (Some(least), Some(most)) = (sizes.iter().min(), sizes.iter().max())
            && least != most
        {
            say(quiet, &format!("sets of {least} to {most} points, each normalised by its own"));
        }
        let names: Vec<String> = files.iter().map(|p| p.display().to_string()).collect();
        Ok(Self { name: names.join(" "), sets })
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
