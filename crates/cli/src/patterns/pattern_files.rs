//! The files that patterns name.

use std::path::Path;

use glam::DVec3;
use sphvar_grammar::ResolveError;
use sphvar_samplers::{
    Error, FileResolver, PointFile, PointFileParameters, ProfileTable, Space,
    SquarePointFileParameters,
};

use crate::error::CliError;
use crate::files::{FilePoint, OptionSpelling, ReadOptions};
use crate::session::Session;

/// Reads the files that patterns name: `profile:FILE` as the command reads spectra, `file:FILE` as
/// it reads `--points`. Arrays that an embedding program gives have precedence.
pub(crate) struct PatternFiles<'a> {
    pub(super) session: &'a Session,
}

impl FileResolver for PatternFiles<'_> {
    fn profile(&self, file: &Path) -> Result<ProfileTable, ResolveError> {
        self.session.read_profile(file).map_err(ResolveError::new)
    }

    fn points(&self, source: &PointFileParameters) -> Result<Vec<PointFile>, ResolveError> {
        self.read(source, PointFile::<DVec3>::check).map_err(ResolveError::new)
    }

    fn square_points(
        &self,
        source: &SquarePointFileParameters,
    ) -> Result<Vec<PointFile<[f64; 2]>>, ResolveError> {
        self.read(source, PointFile::<[f64; 2]>::check).map_err(ResolveError::new)
    }
}

impl PatternFiles<'_> {
    fn read<S: Space<Point: FilePoint>>(
        &self,
        source: &PointFileParameters<S>,
        check: fn(&PointFile<S::Point>) -> Result<(), Error>,
    ) -> Result<Vec<PointFile<S::Point>>, CliError> {
        let wrong = |key: &str, reason: String| {
            CliError::Usage(format!("file:{}: {key}: {reason}", source.file().display()))
        };
        let columns = source.columns.as_deref().map(str::parse).transpose();
        let hdu = source.hdu.as_deref().map(str::parse).transpose();
        let options = ReadOptions {
            columns: columns.map_err(|reason| wrong("columns", reason))?,
            hdu: hdu.map_err(|reason| wrong("hdu", reason))?.unwrap_or_default(),
            skip_invalid: source.skip_invalid,
            normalize: source.normalize,
            spelling: OptionSpelling::Keys,
            ..ReadOptions::default()
        };
        let (mut read, mut errors) = (Vec::new(), Vec::new());
        for (stated_count, path) in self.session.point_files(source.file())? {
            let file = self.read_one(&path, stated_count, &options);
            if stated_count.is_none() {
                return Ok(vec![file?]);
            }
            // The files of a template are used without each other.
            let checked = file.and_then(|file| match check(&file) {
                Ok(()) => Ok(file),
                Err(error) => Err(CliError::File(error.to_string())),
            });
            match checked {
                Ok(file) => read.push(file),
                Err(error) => errors.push(error),
            }
        }
        if read.is_empty() && !errors.is_empty() {
            return Err(errors.swap_remove(0));
        }
        for error in errors {
            self.session.say(&format!("warning: {error}; the file is not used"));
        }
        Ok(read)
    }

    fn read_one<P: FilePoint>(
        &self,
        path: &Path,
        stated_count: Option<usize>,
        options: &ReadOptions,
    ) -> Result<PointFile<P>, CliError> {
        let file = self.session.read_points(path, options)?;
        let warnings = file.warnings.iter().map(|warning| format!("warning: {warning}"));
        warnings.chain(file.remarks).for_each(|remark| self.session.say(&remark));
        let name = path.display().to_string();
        if file.sets.len() > 1 {
            let count = file.sets.len();
            self.session.say(&format!(
                "{name}: an ensemble of {count} sets; predictions are exact for these, not for \
                     the ensemble that they come from"
            ));
        }
        let is_weighted = file.sets.iter().any(|set| !set.weights.is_empty());
        // Only weights are checked set by set.
        let starts = if is_weighted { &file.starts[..] } else { &[] };
        Ok(PointFile {
            starts: starts.iter().map(|place| format!("{name}{place}")).collect(),
            name,
            stated_count,
            sets: file.sets,
            first_below: file.first_below,
        })
    }
}
