//! Values at scattered points in files.

use std::path::PathBuf;

use glam::DVec3;
use sphvar_samplers::{Domain, PointSet};
use sphvar_spectrum::{FitError, LeastSquares};

use crate::error::CliError;
use crate::files::ReadOptions;
use crate::session::Session;

/// Values at scattered points.
pub(crate) struct Values {
    /// The names of the files.
    name: String,
    /// The directions, with the weights of the values.
    set: PointSet,
    values: Vec<f64>,
    /// Warnings and remarks on the files.
    pub(crate) remarks: Vec<String>,
}

impl Values {
    /// Reads the values of all these files, each of which has one set of points. On the hemisphere,
    /// points below the equator are replaced by their antipodes.
    pub(crate) fn read(
        files: &[PathBuf],
        options: &ReadOptions,
        domain: Domain,
        session: &Session,
    ) -> Result<Self, CliError> {
        let options = ReadOptions { values: true, ..options.clone() };
        let names: Vec<String> = files.iter().map(|path| path.display().to_string()).collect();
        let mut weighted_by = None;
        let mut read = Self {
            name: names.join(" "),
            set: PointSet::default(),
            values: Vec::new(),
            remarks: Vec::new(),
        };
        for (path, name) in files.iter().zip(&names) {
            let file = session.read_points::<DVec3>(path, &options)?;
            read.remarks.extend(file.warnings.into_iter().map(|w| format!("warning: {w}")));
            read.remarks.extend(file.remarks);
            let count = file.sets.len();
            let Some(set) = file.sets.into_iter().next().filter(|_| count == 1) else {
                return Err(CliError::File(format!(
                    "{name}: values are fitted for one set of points, got {count} sets"
                )));
            };
            let role = file.weight_role;
            let first = *weighted_by.get_or_insert(role);
            if role != first {
                let words = |role: Option<&str>| role.unwrap_or("neither").to_owned();
                return Err(CliError::File(format!(
                    "{name}: expected weights w in all joined files, or standard errors sigma in all, or neither, got {} \
                     after {}",
                    words(role),
                    words(first)
                )));
            }
            read.set.points.extend(set.points);
            read.set.weights.extend(set.weights);
            read.values.extend(file.values);
        }
        if domain == Domain::Hemisphere {
            let below = read.set.points.iter().filter(|p| p.z < 0.0).count();
            if below > 0 {
                let words = "points with z < 0 are replaced by their antipodes";
                read.remarks.push(format!("{below} {words}"));
            }
            read.set.points.iter_mut().for_each(|p| *p = domain.representative(*p));
        }
        Ok(read)
    }

    /// Returns the names of the files.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// Returns the number of points.
    pub(crate) fn len(&self) -> usize {
        self.values.len()
    }

    /// Returns the least-squares problem of these values.
    pub(crate) fn problem(&self, domain: Domain, ridge: f64) -> Result<LeastSquares<'_>, FitError> {
        let problem = LeastSquares::new(&self.set.points, &self.values, domain)?;
        let problem = match &self.set.weights[..] {
            [] => problem,
            weights => problem.with_weights(weights)?,
        };
        problem.with_ridge(ridge)
    }
}
