//! A folder that one run alone writes to.

use std::fs::{File, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::path::Path;

use super::atomic::sweep_temporaries;
use super::file_error::FileError;
use super::live_files::{LiveFile, create_folders, is_at, remove_empty_folders};

/// The file that is locked. It is there as long as the run lasts and says who holds the lock.
const NAME: &str = ".sphvar.lock";

/// Longest description of a holder that is read.
const MAX_HOLDER: u64 = 300;

/// How the description begins while results are written, so that a later run can tell what a killed one left.
const WRITING: &str = "writing, ";

/// A folder that this run alone writes to.
///
/// The lock is one of the system: it ends with the process, however that ends. What is left of a killed run is
/// taken over.
#[derive(Debug)]
pub(crate) struct FolderLock {
    /// There until the lock is dropped.
    file: Option<LiveFile>,
    path: String,
    about: String,
    is_unfinished: bool,
}

impl FolderLock {
    /// Makes the folder if it is missing and locks it; `command` is what other runs are told.
    ///
    /// # Errors
    /// When the folder cannot be made or written to, or another run holds it.
    pub(crate) fn take(folder: &Path, command: &str) -> Result<Self, FileError> {
        let shown = folder.display().to_string();
        let into = |source| FileError::WriteInto { path: shown.clone(), source };
        create(folder)?;
        sweep_temporaries(folder);
        let path = folder.join(NAME);
        let about = format!("process {}: {command}\n", std::process::id());
        loop {
            let mut options = File::options();
            let open = options.read(true).write(true).create(true).truncate(false).open(&path);
            let mut file = open.map_err(into)?;
            let is_held = matches!(file.try_lock(), Err(TryLockError::WouldBlock));
            let mut holder = Vec::new();
            let _ = Read::by_ref(&mut file).take(MAX_HOLDER).read_to_end(&mut holder);
            let holder = String::from_utf8_lossy(&holder);
            if is_held {
                let holder = holder.trim();
                let holder = if holder.is_empty() { "it has just begun" } else { holder };
                let holder = holder.to_owned();
                return Err(FileError::Busy { path: shown, holder });
            }
            // A file system that has no locks protects nothing, but that is no reason to do nothing there.
            if !is_at(&file, &path) {
                // The run that held it has just ended and removed it.
                continue;
            }
            let is_unfinished = holder.starts_with(WRITING);
            describe(&file, is_unfinished, &about).map_err(into)?;
            let file = Some(LiveFile::adopt(file, path));
            return Ok(Self { file, path: shown, about, is_unfinished });
        }
    }

    /// Returns whether a run was killed while it wrote its results into this folder, and these were not removed yet.
    pub(crate) fn is_unfinished(&self) -> bool {
        self.is_unfinished
    }

    /// Marks the folder as one whose results are not complete, until they are or were removed.
    ///
    /// # Errors
    /// When the file of the lock cannot be written.
    pub(crate) fn set_unfinished(&mut self, is_unfinished: bool) -> Result<(), FileError> {
        self.is_unfinished = is_unfinished;
        let Some(file) = &self.file else { return Ok(()) };
        describe(file.file(), is_unfinished, &self.about)
            .map_err(|source| FileError::WriteInto { path: self.path.clone(), source })
    }

    /// Makes a folder in the one that is locked.
    ///
    /// # Errors
    /// When it cannot be made.
    #[expect(clippy::unused_self, reason = "only who holds the lock makes folders")]
    pub(crate) fn create_folder(&self, folder: &Path) -> Result<(), FileError> {
        create(folder)
    }
}

/// Writes the description of the holder. A mark that was there before is not lost meanwhile.
fn describe(mut file: &File, is_unfinished: bool, about: &str) -> io::Result<()> {
    let text = format!("{}{about}", if is_unfinished { WRITING } else { "" });
    file.rewind()?;
    file.write_all(text.as_bytes())?;
    file.set_len(text.len() as u64)
}

/// Makes a folder with its parents; what stays empty is removed in the end.
fn create(folder: &Path) -> Result<(), FileError> {
    let path = folder.display().to_string();
    if folder.exists() && !folder.is_dir() {
        return Err(FileError::NotAFolder { path });
    }
    create_folders(folder).map_err(|source| FileError::WriteInto { path, source })
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // First the file, or no folder would be empty.
        drop(self.file.take());
        remove_empty_folders();
    }
}
