//! Files that must not outlive this process: temporary ones and locks.
//!
//! The list of them is the one piece of state that the whole process shares. A signal arrives in a thread of its
//! own, which can only know from such a list what the other threads are writing.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// What is to be removed if the process ends before its time, and which folders were searched for
/// what earlier processes left.
#[derive(Debug)]
struct Live {
    files: BTreeSet<PathBuf>,
    /// Folders made by this process, outer ones first; they are removed if they are empty.
    folders: Vec<PathBuf>,
    swept: BTreeSet<PathBuf>,
}

static LIVE: Mutex<Live> =
    Mutex::new(Live { files: BTreeSet::new(), folders: Vec::new(), swept: BTreeSet::new() });

/// Held while several files that belong together are given their names.
static GROUP: Mutex<()> = Mutex::new(());

/// Nothing under these locks can leave a value half changed, so a panic elsewhere does not matter.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Runs `write` so that an interrupt waits for its end: files that belong together appear together.
pub(crate) fn as_group<T>(write: impl FnOnce() -> T) -> T {
    let _group = lock(&GROUP);
    write()
}

/// Removes every live file and ends the process. No file can be begun or given its name meanwhile.
pub(crate) fn remove_all_and_exit(status: i32) -> ! {
    let _group = lock(&GROUP);
    let live = lock(&LIVE);
    for path in &live.files {
        // Nobody is left who could be told of a failure.
        let _ = fs::remove_file(path);
    }
    for folder in live.folders.iter().rev() {
        let _ = fs::remove_dir(folder);
    }
    std::process::exit(status)
}

/// Makes a folder with its parents. Until [`keep_folders`], an interrupt removes those that were not there before
/// and are empty.
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

/// Removes the folders of [`create_folders`] that are empty.
pub(super) fn remove_empty_folders() {
    for folder in lock(&LIVE).folders.drain(..).rev() {
        let _ = fs::remove_dir(folder);
    }
}

/// A new file that is removed when it is dropped or the process is interrupted, unless it is given another
/// name before.
///
/// Its lock is held as long as it is open, so that another process can tell it from one that a killed process
/// left.
#[derive(Debug)]
pub(super) struct LiveFile {
    file: File,
    path: PathBuf,
}

impl LiveFile {
    /// Creates a file that is not there, with the permissions that new files get.
    ///
    /// # Errors
    /// When it cannot be created; [`io::ErrorKind::AlreadyExists`] if it is there.
    pub(super) fn create(path: PathBuf) -> io::Result<Self> {
        let mut live = lock(&LIVE);
        let file = File::options().read(true).write(true).create_new(true).open(&path)?;
        live.files.insert(path.clone());
        drop(live);
        let created = Self { file, path };
        // On a file system that has no locks nobody can take the file for an abandoned one either.
        let _ = created.file.lock();
        if is_at(&created.file, &created.path) {
            Ok(created)
        } else {
            // Another process took it for abandoned before it was locked.
            Err(io::ErrorKind::AlreadyExists.into())
        }
    }

    /// Takes a file that is open and locked, and is to be removed in the end.
    pub(super) fn adopt(file: File, path: PathBuf) -> Self {
        lock(&LIVE).files.insert(path.clone());
        Self { file, path }
    }

    /// Returns the file.
    pub(super) fn file(&self) -> &File {
        &self.file
    }

    /// Gives the file its final name, in place of a file that has it.
    ///
    /// # Errors
    /// When it cannot be renamed; it is then removed.
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
        // After a rename the name may be another file's.
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

/// Whether `path` names this open file.
pub(super) fn is_at(file: &File, path: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let same = |a: &fs::Metadata, b: &fs::Metadata| (a.dev(), a.ino()) == (b.dev(), b.ino());
        matches!((file.metadata(), fs::metadata(path)), (Ok(a), Ok(b)) if same(&a, &b))
    }
    #[cfg(not(unix))]
    {
        // An open file cannot be removed there.
        let _ = file;
        path.exists()
    }
}

/// Removes the files in `folder` that `is_own` knows by their names and that no process holds, once for each folder.
pub(super) fn sweep(folder: &Path, is_own: impl Fn(&str) -> bool) {
    if !lock(&LIVE).swept.insert(folder.to_path_buf()) {
        return;
    }
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if is_file && entry.file_name().to_str().is_some_and(&is_own) {
            // What cannot be opened or locked stays.
            let Ok(file) = File::options().read(true).write(true).open(entry.path()) else {
                continue;
            };
            if file.try_lock().is_ok() {
                let _ = fs::remove_file(entry.path());
            }
        }
    }
}
