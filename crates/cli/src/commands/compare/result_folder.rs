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
    lock: FolderLock,
}

impl ResultFolder {
    /// Makes and locks the folder, before the work, and removes what a run left that was killed while it wrote.
    ///
    /// # Errors
    /// When it cannot be written to, another run writes to it, or it has the results of another run and not
    /// `force`.
    pub(super) fn open(
        folder: &Path,
        provenance: &Provenance,
        force: bool,
    ) -> Result<Self, CliError> {
        let mut lock = FolderLock::take(folder, &provenance.command)?;
        // Results are complete when there is a record of them.
        if lock.is_unfinished() {
            if !is_there(folder, RECORD) {
                remove(folder, &present(folder));
            }
            lock.set_unfinished(false)?;
        }
        if !force {
            check_unused(folder, provenance)?;
        }
        Ok(Self { folder: folder.to_owned(), lock })
    }

    /// Writes the results with `write`. An interrupt waits until all are written; after an error no record
    /// claims the files that are there, and those are removed that were not there before.
    ///
    /// # Errors
    /// Those of `write`.
    pub(super) fn write(
        mut self,
        write: impl FnOnce(&Path) -> Result<(), CliError>,
    ) -> Result<(), CliError> {
        as_group(|| {
            let before = present(&self.folder);
            self.lock.set_unfinished(true)?;
            // Where there is none, there is nothing to remove; another failure shows when it is written.
            let _ = std::fs::remove_file(self.folder.join(RECORD));
            let written = write(&self.folder);
            if written.is_err() {
                let mut new = present(&self.folder);
                new.retain(|name| !before.contains(name));
                remove(&self.folder, &new);
            }
            let cleared = self.lock.set_unfinished(false);
            written.and(cleared.map_err(CliError::from))
        })
    }
}

fn is_there(folder: &Path, name: &str) -> bool {
    folder.join(name).symlink_metadata().is_ok()
}

/// Returns the names of the files of results that are there.
fn present(folder: &Path) -> Vec<&'static str> {
    FILES.into_iter().filter(|name| is_there(folder, name)).collect()
}

/// Removes plain files, as they are written here.
fn remove(folder: &Path, names: &[&str]) {
    for name in names {
        let path = folder.join(name);
        if path.symlink_metadata().is_ok_and(|metadata| metadata.is_file()) {
            // What cannot be removed is found again, and told, when it is to be written.
            let _ = std::fs::remove_file(path);
        }
    }
}

/// Returns an error if there are results of another run: those of the same command are replaced by the same ones.
fn check_unused(folder: &Path, provenance: &Provenance) -> Result<(), CliError> {
    let present = present(folder);
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
