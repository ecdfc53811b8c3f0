//! Sets of rotations in files.

use std::path::Path;

use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use schemars::JsonSchema;
use serde::Serialize;
use sphvar_samplers::RotationSet;

use super::{Case, RotationsArgs};
use crate::error::CliError;
use crate::files::{
    AtomicFile, RotationFile, RotationFormat, is_stdout, is_stream, write_rotations,
};
use crate::global::Global;
use crate::progress::Progress;
use crate::report::{Document, Provenance, lower_extension, write_text};

/// Sets of rotations: `rotations -o FILE.json`, and `rotations --json -o FILE` without the rotations.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct RotationSetsBody {
    /// The pattern with its parameters.
    sampler: String,
    /// The number of rotations of a set.
    n: usize,
    /// The number of sets.
    realizations: usize,
    /// How rotations are written: `quaternions`, `matrices`, `euler` or `euler-degrees`.
    #[schemars(with = "String")]
    format: RotationFormat,
    /// The names of the numbers of a rotation.
    columns: Vec<&'static str>,
    /// The numbers of each rotation of each set, unless they are in another file.
    #[serde(skip_serializing_if = "Option::is_none")]
    rotations: Option<Vec<Vec<Vec<f64>>>>,
    /// The weights of the rotations of each set, if they have weights; only ratios matter.
    #[serde(skip_serializing_if = "Option::is_none")]
    weights: Option<Vec<Vec<f64>>>,
}

/// Sets that are written to a file.
pub(super) struct WrittenSets {
    sampler: String,
    format: RotationFormat,
    sets: Vec<RotationSet>,
}

impl WrittenSets {
    /// Generates the sets of a pattern.
    pub(super) fn realize(
        case: &Case,
        args: &RotationsArgs,
        global: &Global,
    ) -> Result<Self, CliError> {
        if let Some(path) = &args.out {
            check(path)?;
        }
        let work = args.realizations as f64 * case.sampler.n_points() as f64;
        let progress = Progress::new(work, &global.session);
        progress.stage(&case.pattern.to_string());
        let ensemble = case.ensemble(args, global);
        let realize = |index| {
            let mut set = RotationSet::default();
            ensemble.realize_into(index, &mut set, &progress).map_err(CliError::failed)?;
            Ok(set)
        };
        let sets = (0..args.realizations)
            .into_par_iter()
            .map(realize)
            .collect::<Result<Vec<_>, CliError>>()?;
        Ok(Self { sampler: case.pattern.to_string(), format: args.format, sets })
    }

    /// Writes the sets in the format of the extension and, with `--json`, prints a document.
    pub(super) fn write(
        self,
        path: &Path,
        provenance: &Provenance,
        global: &Global,
    ) -> Result<(), CliError> {
        let to_stdout = is_stdout(path);
        if lower_extension(path).as_deref() == Some("json") {
            let body = self.body(true);
            let text = serde_json::to_string(&Document::new(&body, provenance));
            write_text(path, &(text.map_err(CliError::failed)? + "\n"))?;
        } else if !(to_stdout && global.json) {
            let file = match lower_extension(path).as_deref() {
                Some("npy") => RotationFile::Npy,
                Some("npz") => RotationFile::Npz,
                _ => RotationFile::Csv,
            };
            if file == RotationFile::Npy && self.has_weights() {
                let path = path.display();
                return Err(CliError::Usage(format!(
                    "{path}: an .npy array of rotations has no weights; write .npz, .csv or .json"
                )));
            }
            write_rotations(path, file, self.format, &self.sets)?;
        }
        if global.json {
            return Document::new(&self.body(to_stdout), provenance).print(&global.session);
        }
        Ok(())
    }

    /// Returns whether the rotations have weights.
    fn has_weights(&self) -> bool {
        self.sets.iter().any(|set| !set.weights.is_empty())
    }

    /// Returns the document, with the rotations or without.
    fn body(&self, is_whole: bool) -> RotationSetsBody {
        let numbers =
            |set: &RotationSet| set.points.iter().map(|q| self.format.numbers(*q)).collect();
        RotationSetsBody {
            sampler: self.sampler.clone(),
            n: self.sets.first().map_or(0, RotationSet::len),
            realizations: self.sets.len(),
            format: self.format,
            columns: self.format.columns().to_vec(),
            rotations: is_whole.then(|| self.sets.iter().map(numbers).collect()),
            weights: (is_whole && self.has_weights())
                .then(|| self.sets.iter().map(|set| set.weights.clone()).collect()),
        }
    }
}

/// Returns an error for a file that could not be written, before the work starts.
fn check(path: &Path) -> Result<(), CliError> {
    let extension = lower_extension(path);
    let is_known = matches!(extension.as_deref(), Some("csv" | "npy" | "npz" | "json"))
        || extension.is_none() && is_stream(path);
    if !is_known {
        let path = path.display();
        return Err(CliError::Usage(format!(
            "{path}: rotations are written as .csv, .npy, .npz or .json"
        )));
    }
    Ok(AtomicFile::check(path)?)
}
