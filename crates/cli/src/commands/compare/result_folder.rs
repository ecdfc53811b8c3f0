//! The folder of a comparison: one run at a time writes to it, and none overwrites another's results unasked.

use std::path::{Path, PathBuf};

use crate::error::CliError;
use crate::files::{FolderLock, as_group, read_regular};
use crate::report::Provenance;

/// The file that tells which run the others are of; it is written last.
pub(super) const RECORD: &str = "comparison.json";

/// All files, as they are listed in the help.
const FILES: [&str; 9] = [
    "comparison.csv",
    RECORD,
    "spectra.csv",
    "spectra.svg",
    "spectra.png",
    "variance.svg",
    "variance.png",
    "integrand.svg",
    "integrand.png",
];

/// A folder that this run may write its results to.
pub(super) struct ResultFolder {
    folder: PathBuf,
    _lock: FolderLock,
}

impl ResultFolder {
    /// Makes and locks the folder, before the work.
    ///
    /// # Errors
    /// When it cannot be written to, another run writes to it, or it has the results of another run and not
    /// `force`.
    pub(super) fn open(
        folder: &Path,
        provenance: &Provenance,
        force: bool,
    ) -> Result<Self, CliError> {
        let lock = FolderLock::take(folder, &provenance.command)?;
        if !force {
            check_unused(folder, provenance)?;
        }
        Ok(Self { folder: folder.to_owned(), _lock: lock })
    }

    /// Writes the results with `write`. An interrupt waits until all are written; after an error no record
    /// claims the files that are there.
    ///
    /// # Errors
    /// Those of `write`.
    pub(super) fn write(
        &self,
        write: impl FnOnce(&Path) -> Result<(), CliError>,
    ) -> Result<(), CliError> {
        as_group(|| {
            // Where there is none, there is nothing to remove; another failure shows when it is written.
            let _ = std::fs::remove_file(self.folder.join(RECORD));
            write(&self.folder)
        })
    }
}

/// Returns an error if there are results of another run: those of the same command are replaced by the same ones.
fn check_unused(folder: &Path, provenance: &Provenance) -> Result<(), CliError> {
    let is_there = |name: &&&str| folder.join(name).symlink_metadata().is_ok();
    let present: Vec<&str> = FILES.iter().filter(is_there).copied().collect();
    if present.is_empty() {
        return Ok(());
    }
    let whose =
        match Provenance::of_document(&read_regular(&folder.join(RECORD)).unwrap_or_default()) {
            Some(other) if other.is_same_run(provenance) => return Ok(()),
            Some(other) => format!("the results of another run: {}", other.line()),
            None => format!("{} of a run that is not known", present.join(", ")),
        };
    Err(CliError::Failed(format!(
        "{} has {whose}; choose another folder with -o, or overwrite them with --force",
        folder.display()
    )))
}
