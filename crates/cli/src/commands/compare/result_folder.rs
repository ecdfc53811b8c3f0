//! The folder of a comparison. One run at a time writes to it, and results of another run are
//! overwritten only on request.

use std::path::{Path, PathBuf};

use crate::error::CliError;
use crate::files::{FolderLock, as_group, read_regular};
use crate::report::Provenance;

/// The record that identifies the run of the other files; it is written last.
pub(super) const RECORD: &str = "comparison.json";

/// All files, in the order of the help.
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
    /// Creates and locks the folder before the work starts, and removes the files of a run that was
    /// killed while it wrote them.
    ///
    /// # Errors
    ///
    /// If the folder is not writable, another run writes to it, or it has the results of another
    /// run and `force` is false.
    pub(super) fn open(
        folder: &Path,
        provenance: &Provenance,
        force: bool,
    ) -> Result<Self, CliError> {
        let mut lock = FolderLock::take(folder, &provenance.command)?;
        // Results are complete if there is a record of them.
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

    /// Writes the results with `write`. An interrupt is delayed until all are written. After an
    /// error the record is removed, and so are the files that did not exist before.
    ///
    /// # Errors
    ///
    /// Those of `write`.
    pub(super) fn write(
        mut self,
        write: impl FnOnce(&Path) -> Result<(), CliError>,
    ) -> Result<(), CliError> {
        as_group(|| {
            let before = present(&self.folder);
            self.lock.set_unfinished(true)?;
            // A missing record need not be removed; any other failure is reported when the record
            // is written.
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

/// Returns the names of the result files that exist.
fn present(folder: &Path) -> Vec<&'static str> {
    FILES.into_iter().filter(|name| is_there(folder, name)).collect()
}

/// Removes regular files, the only kind that is written here.
pub(super) fn remove(folder: &Path, names: &[&str]) {
    for name in names {
        let path = folder.join(name);
        if path.symlink_metadata().is_ok_and(|metadata| metadata.is_file()) {
            // A file that cannot be removed is reported when it is written.
            let _ = std::fs::remove_file(path);
        }
    }
}

/// Returns an error if the folder has results of another run. Results of the same command are
/// replaced by identical ones.
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
