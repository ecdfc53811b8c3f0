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
/// The files in the folder itself.
pub(super) const TABLES: [&str; 3] = ["claims.csv", "claims.md", "index.html"];
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
        // These two folders are the command's own; beside index.html there may be files of the user.
        remove_unfinished(&root.join(FIGURES), |_| true)?;
        remove_unfinished(&root.join(PIECES), |_| true)?;
        remove_unfinished(root, |name| {
            TABLES.iter().any(|table| name.starts_with(&format!(".{table}.")))
        })?;
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

/// Removes what a killed run left of files of the right names: see [`AtomicFile`](crate::files::AtomicFile).
fn remove_unfinished(folder: &Path, is_own: impl Fn(&str) -> bool) -> Result<(), CliError> {
    let write_error =
        |path: &Path, source| FileError::Write { path: path.display().to_string(), source };
    for entry in fs::read_dir(folder).map_err(|source| write_error(folder, source))? {
        let path = entry.map_err(|source| write_error(folder, source))?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if name.starts_with('.') && name.ends_with(".tmp") && is_own(&name) && path.is_file() {
            fs::remove_file(&path).map_err(|source| write_error(&path, source))?;
        }
    }
    Ok(())
}
