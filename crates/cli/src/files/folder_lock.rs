//! A folder that one run alone writes to.

use std::fs::{File, TryLockError};
use std::io::{Read, Seek, Write};
use std::path::Path;

use super::atomic::sweep_temporaries;
use super::file_error::FileError;
use super::live_files::{LiveFile, create_folders, is_at, remove_empty_folders};

/// The file that is locked. It is there as long as the run lasts and says who holds the lock.
const NAME: &str = ".sphvar.lock";

/// Longest description of a holder that is read.
const MAX_HOLDER: u64 = 300;

/// A folder that this run alone writes to.
///
/// The lock is one of the system: it ends with the process, however that ends. What is left of a killed run is
/// taken over.
#[derive(Debug)]
pub(crate) struct FolderLock {
    /// There until the lock is dropped.
    file: Option<LiveFile>,
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
        loop {
            let mut options = File::options();
            let open = options.read(true).write(true).create(true).truncate(false).open(&path);
            let mut file = open.map_err(into)?;
            if let Err(TryLockError::WouldBlock) = file.try_lock() {
                let mut holder = String::new();
                let _ = file.take(MAX_HOLDER).read_to_string(&mut holder);
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
            let about = format!("process {}: {command}\n", std::process::id());
            file.set_len(0).and_then(|()| file.rewind()).map_err(into)?;
            file.write_all(about.as_bytes()).map_err(into)?;
            return Ok(Self { file: Some(LiveFile::adopt(file, path)) });
        }
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
