//! The folder of a reproduction: what lies where, and who may write.

use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};

use sphvar_thesis::Figure;

use super::{data, drawing};
use crate::error::CliError;
use crate::files::{FileError, PieceStore};
use crate::report::{Provenance, write_text};

/// A folder that this run alone writes to.
pub(super) struct OutFolder {
    root: PathBuf,
    /// Held as long as the run lasts; the system frees it however the run ends.
    _lock: File,
}

/// Panels and their data.
const FIGURES: &str = "figures";
/// Finished pieces of work.
const PIECES: &str = "pieces";
/// What a run locks against others.
const LOCK: &str = ".lock";

impl OutFolder {
    /// Makes the folder if it is missing, and removes what a killed run left unfinished.
    pub(super) fn open(root: &Path) -> Result<Self, CliError> {
        let write_error = |source| FileError::Write { path: root.display().to_string(), source };
        for folder in [root.to_owned(), root.join(FIGURES), root.join(PIECES)] {
            fs::create_dir_all(folder).map_err(write_error)?;
        }
        let lock = File::create(root.join(LOCK)).map_err(write_error)?;
        match lock.try_lock() {
            Ok(()) => (),
            Err(TryLockError::WouldBlock) => {
                return Err(CliError::Failed(format!(
                    "{}: another run writes to this folder; wait for it or choose another",
                    root.display()
                )));
            }
            Err(TryLockError::Error(source)) => return Err(write_error(source).into()),
        }
        for folder in [root.to_owned(), root.join(FIGURES), root.join(PIECES)] {
            for entry in fs::read_dir(&folder).map_err(write_error)? {
                let entry = entry.map_err(write_error)?;
                if is_unfinished(&entry.file_name().to_string_lossy()) {
                    fs::remove_file(entry.path()).map_err(write_error)?;
                }
            }
        }
        Ok(Self { root: root.to_owned(), _lock: lock })
    }

    /// Where finished pieces are kept.
    pub(super) fn pieces(&self) -> Result<PieceStore, CliError> {
        Ok(PieceStore::open(&self.root.join(PIECES))?)
    }

    /// Draws every panel and writes its numbers beside it; the names of both files, relative to the folder.
    pub(super) fn write_panels(
        &self,
        figure: &Figure,
        provenance: &Provenance,
    ) -> Result<Vec<[String; 2]>, CliError> {
        let mut files = Vec::new();
        for panel in &figure.panels {
            let stem = format!("{FIGURES}/{}-{}", figure.id, panel.name);
            let picture = format!("{stem}.{}", drawing::extension(&panel.content));
            let numbers = format!("{stem}.csv");
            drawing::draw(figure, panel, provenance, &self.root.join(&picture))?;
            self.write(&numbers, &data::csv_of(&panel.content, provenance))?;
            files.push([picture, numbers]);
        }
        Ok(files)
    }

    /// Writes a text file, whole or not at all.
    pub(super) fn write(&self, name: &str, text: &str) -> Result<(), CliError> {
        write_text(&self.root.join(name), text)
    }

    /// Reads a file that was written.
    pub(super) fn read(&self, name: &str) -> Result<Vec<u8>, CliError> {
        let path = self.root.join(name);
        let name = path.display().to_string();
        Ok(fs::read(path).map_err(|source| FileError::Read { path: name, source })?)
    }
}

/// Whether a name is one of those that files have while they are written.
fn is_unfinished(name: &str) -> bool {
    name.starts_with('.') && name.ends_with(".tmp")
}
