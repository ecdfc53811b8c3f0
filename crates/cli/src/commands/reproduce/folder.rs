//! The folder of a reproduction: its structure and its lock.

use std::fs;
use std::path::{Path, PathBuf};

use sphvar_thesis::Figure;

use super::{data, drawing};
use crate::error::CliError;
use crate::files::{FileError, FolderLock, PieceStore};
use crate::report::{Provenance, write_text};
use crate::session::Session;

/// A folder that only this run writes to.
pub(super) struct OutFolder {
    root: PathBuf,
    _lock: FolderLock,
}

/// Panels and their data.
const FIGURES: &str = "figures";
/// Finished pieces of work.
const PIECES: &str = "pieces";
/// The files in the folder itself.
pub(super) const TABLES: [&str; 3] = ["claims.csv", "claims.md", "index.html"];

impl OutFolder {
    /// Creates the folder if it is missing, and locks it.
    pub(super) fn open(root: &Path, session: &Session) -> Result<Self, CliError> {
        let command = Provenance::new(session, 0).command;
        let lock = FolderLock::take(root, &command)?;
        lock.create_folder(&root.join(FIGURES))?;
        lock.create_folder(&root.join(PIECES))?;
        Ok(Self { root: root.to_owned(), _lock: lock })
    }

    /// Returns the store of finished pieces.
    pub(super) fn pieces(&self) -> Result<PieceStore, CliError> {
        Ok(PieceStore::open(&self.root.join(PIECES))?)
    }

    /// Draws every panel and writes its data beside it; returns the names of both files, relative
    /// to the folder.
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

    /// Writes a text file, complete or not at all.
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
