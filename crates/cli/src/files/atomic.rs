//! Output files that appear complete or not at all.

use std::ffi::OsStr;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use super::file_error::{FileError, output_name};
use super::live_files::{LiveFile, sweep};
use super::target::Target;
use super::used_files::{conflict, record_output};

/// A file under construction: written beside its target under a temporary name and renamed by
/// [`commit`](Self::commit).
///
/// A drop without a commit, or an interrupt, removes the temporary file and leaves the target
/// unchanged. A process that is killed outright leaves at most `.NAME.sphvar-PID-COUNT.tmp`, never
/// a part of a file under the final name; the next run that writes in that folder removes it.
/// Symbolic links are followed, and an existing file keeps its permission bits. Standard output,
/// devices and pipes are written to directly.
#[derive(Debug)]
pub(crate) struct AtomicFile {
    name: String,
    sink: Sink,
}

#[derive(Debug)]
enum Sink {
    Stdout(BufWriter<io::Stdout>),
    Stream(BufWriter<File>),
    Beside { temporary: BufWriter<LiveFile>, target: PathBuf },
}

impl AtomicFile {
    /// Returns a writer for `path`; `-` means standard output.
    ///
    /// # Errors
    ///
    /// If the folder is missing or not writable, the target is a folder or read-only, or this run
    /// has read or written it.
    pub(crate) fn create(path: &Path) -> Result<Self, FileError> {
        let name = output_name(path);
        let write_error = |source| FileError::Write { path: name.clone(), source };
        let sink = match Target::of(path)? {
            Target::Stdout => Sink::Stdout(BufWriter::new(io::stdout())),
            Target::Stream(path) => {
                // A descriptor may refer to a file that already has content.
                let stream = File::options().append(true).open(path).map_err(write_error)?;
                Sink::Stream(BufWriter::new(stream))
            }
            Target::File { path: target, existing } => {
                if let Some(reason) = conflict(&target) {
                    return Err(FileError::InvalidTarget { path: name, reason });
                }
                let temporary = temporary_beside(&target).map_err(write_error)?;
                if let Some(metadata) = existing {
                    let permissions = metadata.permissions();
                    temporary.file().set_permissions(permissions).map_err(write_error)?;
                }
                Sink::Beside { temporary: BufWriter::new(temporary), target }
            }
        };
        Ok(Self { name, sink })
    }

    /// Returns the error for a target that [`create`](Self::create) would reject, without side
    /// effects.
    ///
    /// # Errors
    ///
    /// Those of [`create`](Self::create).
    pub(crate) fn check(path: &Path) -> Result<(), FileError> {
        match Target::of(path)? {
            // Opening and closing a pipe would signal the end of the data to its reader.
            Target::Stdout | Target::Stream(_) => Ok(()),
            Target::File { .. } => Self::create(path).map(drop),
        }
    }

    /// Writes a file, complete or not at all; `-` is standard output.
    ///
    /// # Errors
    ///
    /// Those of [`create`](Self::create) and [`commit`](Self::commit), or if the bytes cannot be
    /// written.
    pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
        let mut file = Self::create(path)?;
        file.write_all(bytes).map_err(|source| file.error(source))?;
        file.commit()
    }

    /// Flushes all data, makes the file durable and gives it its final name.
    ///
    /// # Errors
    ///
    /// If the last bytes cannot be written or the rename fails; the temporary file is then removed
    /// and the target is unchanged.
    pub(crate) fn commit(self) -> Result<(), FileError> {
        let Self { name, sink } = self;
        // An input may have been opened since.
        if let Sink::Beside { target, .. } = &sink
            && let Some(reason) = conflict(target)
        {
            return Err(FileError::InvalidTarget { path: name, reason });
        }
        finish(sink).map_err(|source| FileError::Write { path: name, source })
    }

    /// Returns a write error that names this file.
    pub(crate) fn error(&self, source: io::Error) -> FileError {
        FileError::Write { path: self.name.clone(), source }
    }

    fn writer(&mut self) -> &mut dyn Write {
        match &mut self.sink {
            Sink::Stdout(writer) => writer,
            Sink::Stream(writer) => writer,
            Sink::Beside { temporary, .. } => temporary,
        }
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.writer().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer().flush()
    }
}

fn finish(sink: Sink) -> io::Result<()> {
    match sink {
        Sink::Stdout(mut writer) => writer.flush(),
        Sink::Stream(mut writer) => writer.flush(),
        Sink::Beside { temporary, target } => {
            let temporary = temporary.into_inner().map_err(io::IntoInnerError::into_error)?;
            temporary.file().sync_all()?;
            temporary.rename(&target)?;
            record_output(&target);
            Ok(())
        }
    }
}

/// The maximum number of characters of a name that a temporary name repeats: at most 100 bytes, to
/// which 42 are added. Some file systems allow no more than 143.
const MAX_STEM: usize = 25;

/// The start and the end of the suffix that a temporary name appends to `.NAME`, around the numbers
/// of a process and a file.
const MARK: &str = ".sphvar-";
const SUFFIX: &str = ".tmp";

/// Returns the temporary name number `count` of this process for a file.
fn temporary_name(file_name: &OsStr, count: u64) -> String {
    let stem: String = file_name.to_string_lossy().chars().take(MAX_STEM).collect();
    format!(".{stem}{MARK}{}-{count}{SUFFIX}", std::process::id())
}

/// Returns whether a name has the form of [`temporary_name`].
fn is_temporary_name(name: &str) -> bool {
    let numbers = name
        .strip_prefix('.')
        .and_then(|rest| rest.strip_suffix(SUFFIX))
        .and_then(|rest| rest.rsplit_once(MARK))
        .and_then(|(_, numbers)| numbers.split_once('-'));
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    numbers.is_some_and(|(process, count)| is_number(process) && is_number(count))
}

/// Removes temporary files in `folder` that killed processes left.
pub(super) fn sweep_temporaries(folder: &Path) {
    sweep(folder, is_temporary_name);
}

/// Creates a temporary file beside `target`, with the permissions of a new file.
fn temporary_beside(target: &Path) -> io::Result<LiveFile> {
    let folder = match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    sweep_temporaries(folder);
    let file_name = target.file_name().unwrap_or_default();
    let mut count = 0;
    loop {
        match LiveFile::create(folder.join(temporary_name(file_name, count))) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => count += 1,
            created => return created,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn names_in(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<String> =
            entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    #[test]
    fn commit_replaces_and_leaves_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        fs::write(&path, "old").unwrap();
        let mut file = AtomicFile::create(&path).unwrap();
        file.write_all(b"new").unwrap();
        file.flush().unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "old", "visible before the commit");
        file.commit().unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "new");
        assert_eq!(names_in(folder.path()), ["a.csv"]);
    }

    #[test]
    fn drop_leaves_no_trace() {
        let folder = tempfile::tempdir().unwrap();
        let mut file = AtomicFile::create(&folder.path().join("a.csv")).unwrap();
        file.write_all(b"half").unwrap();
        assert_eq!(
            names_in(folder.path()).len(),
            1,
            "the temporary file is in the folder of the target"
        );
        drop(file);
        assert!(names_in(folder.path()).is_empty(), "{:?}", names_in(folder.path()));
    }

    #[test]
    fn missing_folder_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("no/such/a.csv");
        let message = AtomicFile::create(&path).unwrap_err().to_string();
        assert!(message.contains(&path.display().to_string()), "{message}");
        assert!(message.contains("does not exist; create it first"), "{message}");
    }

    #[test]
    fn folder_and_read_only_target_are_rejected() {
        let folder = tempfile::tempdir().unwrap();
        let message = AtomicFile::create(folder.path()).unwrap_err().to_string();
        assert!(message.contains("it is a folder"), "{message}");

        let path = folder.path().join("kept.csv");
        fs::write(&path, "kept").unwrap();
        let mut permissions = fs::metadata(&path).unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&path, permissions).unwrap();
        let message = AtomicFile::create(&path).unwrap_err().to_string();
        assert!(message.contains("it is read-only"), "{message}");
        assert_eq!(fs::read_to_string(&path).unwrap(), "kept");
    }

    #[cfg(unix)]
    #[test]
    fn read_only_folder_is_named() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o555)).unwrap();
        let path = folder.path().join("a.csv");
        // The superuser may write anywhere: the file is created there, and no error is expected.
        if let Err(error) = AtomicFile::create(&path) {
            let message = error.to_string();
            assert!(message.contains(&path.display().to_string()), "{message}");
        }
        fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o755)).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn devices_links_and_permissions_survive() {
        use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};
        let mut file = AtomicFile::create(Path::new("/dev/null")).unwrap();
        file.write_all(b"gone").unwrap();
        file.commit().unwrap();
        assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());

        let folder = tempfile::tempdir().unwrap();
        let real = folder.path().join("real.csv");
        let link = folder.path().join("link.csv");
        fs::write(&real, "old").unwrap();
        fs::set_permissions(&real, fs::Permissions::from_mode(0o640)).unwrap();
        symlink(&real, &link).unwrap();
        let mut file = AtomicFile::create(&link).unwrap();
        file.write_all(b"new").unwrap();
        file.commit().unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().file_type().is_symlink());
        assert_eq!(fs::read_to_string(&real).unwrap(), "new");
        assert_eq!(fs::metadata(&real).unwrap().permissions().mode() & 0o777, 0o640);
    }
}
