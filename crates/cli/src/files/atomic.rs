//! Output that appears whole or not at all.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile};

use super::file_error::{FileError, is_dash, output_name};

/// A file under construction: written beside its target under a temporary name and renamed by
/// [`commit`](Self::commit).
///
/// Dropping it without a commit removes the temporary file and leaves the target as it was. Three
/// kinds of target are not replaced by a rename: `-` is standard output; a device or pipe such as
/// `/dev/null` is written to directly, since a rename would put a plain file in its place; and a
/// symbolic link is followed, so that the link stays and the file that it names is replaced.
/// An existing file keeps its permission bits. A process killed by a signal cannot clean up: it
/// leaves at most `.NAME.xxxxxx.tmp`, never the final name.
#[derive(Debug)]
pub(crate) struct AtomicFile {
    name: String,
    sink: Sink,
}

#[derive(Debug)]
enum Sink {
    Stdout(BufWriter<io::Stdout>),
    Device(BufWriter<File>),
    Beside { temporary: BufWriter<NamedTempFile>, target: PathBuf },
}

impl AtomicFile {
    /// Returns a writer for `path`; `-` means standard output.
    ///
    /// # Errors
    /// When the folder is missing or not writable, or the target is a folder or read-only.
    pub(crate) fn create(path: &Path) -> Result<Self, FileError> {
        let name = output_name(path);
        if is_dash(path) {
            return Ok(Self { name, sink: Sink::Stdout(BufWriter::new(io::stdout())) });
        }
        let write_error = |source| FileError::Write { path: name.clone(), source };
        let refused = |reason| FileError::Refused { path: name.clone(), reason };

        let existing = fs::metadata(path).ok();
        if let Some(metadata) = &existing {
            if metadata.is_dir() {
                return Err(refused("it is a folder; give the name of a file"));
            }
            if metadata.permissions().readonly() {
                return Err(refused("it is read-only; remove it or choose another name"));
            }
            if !metadata.is_file() {
                let device = File::options().write(true).open(path).map_err(write_error)?;
                return Ok(Self { name, sink: Sink::Device(BufWriter::new(device)) });
            }
        }
        let target = match &existing {
            Some(_) => fs::canonicalize(path).map_err(write_error)?,
            None => path.to_path_buf(),
        };
        let Some(file_name) = target.file_name() else {
            return Err(refused("it names no file"));
        };
        let folder = match target.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        if folder.is_file() {
            return Err(refused("what stands before its last / is a file and not a folder"));
        }
        if !folder.is_dir() {
            let folder = folder.display().to_string();
            return Err(FileError::MissingFolder { path: name, folder });
        }
        let prefix = format!(".{}.", file_name.to_string_lossy());
        let temporary = temporary_beside(folder, &prefix).map_err(write_error)?;
        if let Some(metadata) = &existing {
            fs::set_permissions(temporary.path(), metadata.permissions()).map_err(write_error)?;
        }
        let temporary = BufWriter::new(temporary);
        Ok(Self { name, sink: Sink::Beside { temporary, target } })
    }

    /// Refuses a target that [`create`](Self::create) would refuse, and leaves no trace.
    ///
    /// # Errors
    /// Those of [`create`](Self::create).
    pub(crate) fn check(path: &Path) -> Result<(), FileError> {
        // A pipe that is opened and closed shows its reader the end.
        let is_device = fs::metadata(path).is_ok_and(|m| !m.is_file() && !m.is_dir());
        if is_device { Ok(()) } else { Self::create(path).map(drop) }
    }

    /// Writes a file whole, or not at all; `-` is standard output.
    ///
    /// # Errors
    /// Those of [`create`](Self::create) and [`commit`](Self::commit), or when the bytes cannot be written.
    pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
        let mut file = Self::create(path)?;
        file.write_all(bytes).map_err(|source| file.error(source))?;
        file.commit()
    }

    /// Flushes everything, makes it durable and gives the file its final name.
    ///
    /// # Errors
    /// When the last bytes cannot be written or the rename fails; the temporary file is then
    /// removed and the target is as it was.
    pub(crate) fn commit(self) -> Result<(), FileError> {
        let Self { name, sink } = self;
        finish(sink).map_err(|source| FileError::Write { path: name, source })
    }

    /// Returns an error of writing that names this file.
    pub(crate) fn error(&self, source: io::Error) -> FileError {
        FileError::Write { path: self.name.clone(), source }
    }

    fn writer(&mut self) -> &mut dyn Write {
        match &mut self.sink {
            Sink::Stdout(writer) => writer,
            Sink::Device(writer) => writer,
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
        Sink::Device(mut writer) => writer.flush(),
        Sink::Beside { temporary, target } => {
            let temporary = temporary.into_inner().map_err(io::IntoInnerError::into_error)?;
            temporary.as_file().sync_all()?;
            temporary.persist(&target).map_err(|failed| failed.error)?;
            Ok(())
        }
    }
}

/// Creates a temporary file in `folder` with the permissions that a new file would get: the
/// library's default is readable by the owner alone, and the rename would keep that.
fn temporary_beside(folder: &Path, prefix: &str) -> io::Result<NamedTempFile> {
    let mut builder = Builder::new();
    builder.prefix(prefix).suffix(".tmp");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // Read and write for all, less the process's umask.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

#[cfg(test)]
mod tests {
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
        assert_eq!(names_in(folder.path()).len(), 1, "the temporary stands beside the target");
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
    fn folder_and_read_only_target_are_refused() {
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
        // The superuser may write anywhere: there the file is created and no error is due.
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
