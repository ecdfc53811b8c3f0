//! Files that must not outlive this process: temporary files and locks.
//!
//! Their list is the only global state of the process. Signals are handled in a separate thread,
//! which needs the list to know the files that the other threads are writing.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The files to be removed if the process ends early, and the folders that were searched for files
/// of earlier processes.
#[derive(Debug)]
struct Live {
    files: BTreeSet<PathBuf>,
    /// Folders created by this process, outer ones first; they are removed if they are empty.
    folders: Vec<PathBuf>,
    swept: BTreeSet<PathBuf>,
}

static LIVE: Mutex<Live> =
    Mutex::new(Live { files: BTreeSet::new(), folders: Vec::new(), swept: BTreeSet::new() });

/// Held while several related files are given their names.
static GROUP: Mutex<()> = Mutex::new(());

/// No panic under these locks can leave an inconsistent value, so poisoning is ignored.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Runs `write` and delays interrupts until it ends, so that related files appear together.
pub(crate) fn as_group<T>(write: impl FnOnce() -> T) -> T {
    let _group = lock(&GROUP);
    write()
}

/// Removes every live file and ends the process. Meanwhile, no file can be created or given its
/// name.
pub(crate) fn remove_all_and_exit(status: i32) -> ! {
    let _group = lock(&GROUP);
    let live = lock(&LIVE);
    for path in &live.files {
        // Errors cannot be reported at this point.
        let _ = fs::remove_file(path);
    }
    for folder in live.folders.iter().rev() {
        let _ = fs::remove_dir(folder);
    }
    std::process::exit(status)
}

/// Creates a folder with its parents. Until [`remove_empty_folders`], an interrupt removes those
/// that did not exist before and are empty.
pub(super) fn create_folders(folder: &Path) -> io::Result<()> {
    let mut live = lock(&LIVE);
    let missing = |path: &&Path| !path.as_os_str().is_empty() && !path.exists();
    let mut made: Vec<PathBuf> =
        folder.ancestors().take_while(missing).map(Path::to_path_buf).collect();
    made.reverse();
    fs::create_dir_all(folder)?;
    live.folders.append(&mut made);
    Ok(())
}

/// Counts an empty folder among those of [`create_folders`]: a process that was killed has left it.
pub(super) fn adopt_empty_folder(folder: &Path) {
    let is_empty = fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_none());
    let mut live = lock(&LIVE);
    if is_empty && !live.folders.iter().any(|other| other == folder) {
        live.folders.push(folder.to_path_buf());
    }
}

/// Removes the folders of [`create_folders`] that are empty.
pub(super) fn remove_empty_folders() {
    for folder in lock(&LIVE).folders.drain(..).rev() {
        let _ = fs::remove_dir(folder);
    }
}

/// A new file that is removed if it is dropped or the process is interrupted before it is given
/// another name.
///
/// Its lock is held while it is open, so that other processes can distinguish it from a file that a
/// killed process left.
#[derive(Debug)]
pub(super) struct LiveFile {
    file: File,
    path: PathBuf,
}

impl LiveFile {
    /// Creates a file that does not exist, with the permissions of new files.
    ///
    /// # Errors
    ///
    /// If it cannot be created; [`io::ErrorKind::AlreadyExists`] if it exists.
    pub(super) fn create(path: PathBuf) -> io::Result<Self> {
        let mut live = lock(&LIVE);
        let file = File::options().read(true).write(true).create_new(true).open(&path)?;
        live.files.insert(path.clone());
        drop(live);
        let created = Self { file, path };
        // On a file system without locks, other processes cannot take the file for abandoned
        // either.
        let _ = created.file.lock();
        if is_at(&created.file, &created.path) {
            Ok(created)
        } else {
            // Another process took it for abandoned before it was locked.
            Err(io::ErrorKind::AlreadyExists.into())
        }
    }

    /// Takes ownership of an open and locked file that is to be removed at the end.
    pub(super) fn adopt(file: File, path: PathBuf) -> Self {
        lock(&LIVE).files.insert(path.clone());
        Self { file, path }
    }

    /// Returns the file.
    pub(super) fn file(&self) -> &File {
        &self.file
    }

    /// Gives the file its final name, replacing an existing file.
    ///
    /// # Errors
    ///
    /// If it cannot be renamed; it is then removed.
    pub(super) fn rename(self, target: &Path) -> io::Result<()> {
        let mut live = lock(&LIVE);
        let renamed = fs::rename(&self.path, target);
        if renamed.is_ok() {
            live.files.remove(&self.path);
        }
        drop(live);
        renamed
    }
}

impl Drop for LiveFile {
    fn drop(&mut self) {
        let mut live = lock(&LIVE);
        // After a rename, the name may belong to another file.
        if live.files.remove(&self.path) {
            let _ = fs::remove_file(&self.path);
        }
    }
}

impl Write for LiveFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// Returns whether `path` names this open file.
pub(crate) fn is_at(file: &File, path: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let same = |a: &fs::Metadata, b: &fs::Metadata| (a.dev(), a.ino()) == (b.dev(), b.ino());
        matches!((file.metadata(), fs::metadata(path)), (Ok(a), Ok(b)) if same(&a, &b))
    }
    #[cfg(not(unix))]
    {
        // On that system an open file cannot be removed.
        let _ = file;
        path.exists()
    }
}

/// Removes the files in `folder` whose names satisfy `is_own` and that no process holds, once for
/// each folder.
pub(super) fn sweep(folder: &Path, is_own: impl Fn(&str) -> bool) {
    if !lock(&LIVE).swept.insert(folder.to_path_buf()) {
        return;
    }
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if is_file && entry.file_name().to_str().is_some_and(&is_own) {
            // Files that cannot be opened or locked are kept.
            let Ok(file) = File::options().read(true).write(true).open(entry.path()) else {
                continue;
            };
            if file.try_lock().is_ok() {
                let _ = fs::remove_file(entry.path());
            }
        }
    }
}
