//! A folder that only one run writes to.

use std::fs::{File, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::path::Path;

use super::atomic::sweep_temporaries;
use super::file_error::FileError;
use super::live_files::{
    LiveFile, adopt_empty_folder, create_folders, is_at, remove_empty_folders,
};

/// The locked file. It exists while the run lasts and names the holder of the lock.
const NAME: &str = ".sphvar.lock";

/// The maximum length of a holder's description that is read.
const MAX_HOLDER: u64 = 300;

/// The prefix of the description while results are written, by which a later run recognizes that a
/// killed run left them incomplete.
const WRITING: &str = "writing, ";

/// A folder that only this run writes to.
///
/// The lock is held by the operating system and so ends with the process. A later run takes over
/// the folder of a killed one.
#[derive(Debug)]
pub(crate) struct FolderLock {
    /// Present until the lock is dropped.
    file: Option<LiveFile>,
    path: String,
    about: String,
    is_unfinished: bool,
}

impl FolderLock {
    /// Creates the folder if it is missing and locks it; `command` describes this run to others.
    ///
    /// # Errors
    ///
    /// If the folder cannot be created or written to, or another run holds its lock.
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
            // On a file system without locks the folder is unprotected, but the run continues.
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

    /// Returns whether a run was killed while it wrote its results into this folder and they have
    /// not been removed.
    pub(crate) fn is_unfinished(&self) -> bool {
        self.is_unfinished
    }

    /// Marks the folder as one with incomplete results, until they are complete or removed.
    ///
    /// # Errors
    ///
    /// When the file of the lock cannot be written.
    pub(crate) fn set_unfinished(&mut self, is_unfinished: bool) -> Result<(), FileError> {
        self.is_unfinished = is_unfinished;
        let Some(file) = &self.file else { return Ok(()) };
        describe(file.file(), is_unfinished, &self.about)
            .map_err(|source| FileError::WriteInto { path: self.path.clone(), source })
    }

    /// Creates a folder inside the locked one; it is removed at the end if it is empty.
    ///
    /// # Errors
    ///
    /// If it cannot be created.
    #[expect(clippy::unused_self, reason = "only the holder of the lock creates folders")]
    pub(crate) fn create_folder(&self, folder: &Path) -> Result<(), FileError> {
        create(folder)?;
        adopt_empty_folder(folder);
        Ok(())
    }
}

/// Writes the description of the holder. An existing mark is preserved throughout.
fn describe(mut file: &File, is_unfinished: bool, about: &str) -> io::Result<()> {
    let text = format!("{}{about}", if is_unfinished { WRITING } else { "" });
    file.rewind()?;
    file.write_all(text.as_bytes())?;
    file.set_len(text.len() as u64)
}

/// Creates a folder with its parents; folders that stay empty are removed at the end.
fn create(folder: &Path) -> Result<(), FileError> {
    let path = folder.display().to_string();
    if folder.exists() && !folder.is_dir() {
        return Err(FileError::NotAFolder { path });
    }
    create_folders(folder).map_err(|source| FileError::WriteInto { path, source })
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // The file is removed first, because the folder is not empty before.
        drop(self.file.take());
        remove_empty_folders();
    }
}
