//! Resolves the path of an output: a file, standard output, or a stream such as a pipe.

use std::fs::{self, Metadata};
use std::io;
use std::path::{Path, PathBuf};

use super::file_error::{FileError, is_dash, output_name};

/// The maximum number of links before they count as a loop, as in Linux.
const MAX_LINKS: usize = 40;

/// The target of an output path.
#[derive(Debug)]
pub(super) enum Target {
    /// `-`, or a name of descriptor 1 such as `/dev/stdout`.
    Stdout,
    /// A device, a FIFO, or another descriptor. It is written to directly, because a rename would
    /// replace it by a regular file.
    Stream(PathBuf),
    /// The file at the end of all links; it need not exist.
    File {
        /// Its resolved path.
        path: PathBuf,
        /// The metadata of the file if it exists.
        existing: Option<Metadata>,
    },
}

impl Target {
    /// Returns the target of `path`; links are resolved completely, even to a file that does not
    /// exist.
    ///
    /// # Errors
    ///
    /// If it is a folder, a read-only file, a loop of links, or in a folder that does not
    /// exist.
    pub(super) fn of(path: &Path) -> Result<Self, FileError> {
        if is_dash(path) {
            return Ok(Self::Stdout);
        }
        let name = output_name(path);
        let write_error = |source| FileError::Write { path: name.clone(), source };
        let invalid = |reason| FileError::InvalidTarget { path: name.clone(), reason };
        let mut at = path.to_path_buf();
        for _ in 0..=MAX_LINKS {
            match descriptor(&at) {
                Some(1) => return Ok(Self::Stdout),
                Some(_) => return Ok(Self::Stream(at)),
                None => (),
            }
            let metadata = match fs::symlink_metadata(&at) {
                Ok(metadata) => metadata,
                Err(error) if is_absent(&error) => {
                    check_folder(&name, &at)?;
                    return Ok(Self::File { path: at, existing: None });
                }
                Err(error) => return Err(write_error(error)),
            };
            if metadata.is_symlink() {
                let to = fs::read_link(&at).map_err(write_error)?;
                at.pop();
                at.push(to);
                continue;
            }
            if metadata.is_dir() {
                return Err(invalid("it is a folder; give the name of a file"));
            }
            if metadata.permissions().readonly() {
                return Err(invalid("it is read-only; remove it or choose another name"));
            }
            return Ok(if metadata.is_file() {
                Self::File { path: at, existing: Some(metadata) }
            } else {
                Self::Stream(at)
            });
        }
        Err(invalid("its symbolic links form a loop"))
    }
}

/// Returns whether an output path denotes standard output.
pub(crate) fn is_stdout(path: &Path) -> bool {
    matches!(Target::of(path), Ok(Target::Stdout))
}

/// Returns whether an output path denotes standard output, a device, a FIFO or an open descriptor.
/// Without an extension, these receive the format of standard output.
pub(crate) fn is_stream(path: &Path) -> bool {
    matches!(Target::of(path), Ok(Target::Stdout | Target::Stream(_)))
}

fn is_absent(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory)
}

/// Returns an error if the folder of `path` does not permit a new file.
fn check_folder(name: &str, path: &Path) -> Result<(), FileError> {
    let path_of = || name.to_owned();
    let ends_in_separator = path.as_os_str().as_encoded_bytes().last() == Some(&b'/');
    if path.file_name().is_none() || ends_in_separator {
        return Err(FileError::InvalidTarget { path: path_of(), reason: "it names no file" });
    }
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    if folder.is_file() {
        let reason = "its parent is a file and not a folder";
        return Err(FileError::InvalidTarget { path: path_of(), reason });
    }
    if !folder.is_dir() {
        let folder = folder.display().to_string();
        return Err(FileError::MissingFolder { path: path_of(), folder });
    }
    Ok(())
}

/// Returns the number of the open descriptor that a path such as `/dev/fd/3` names.
fn descriptor(path: &Path) -> Option<u32> {
    let number = path.file_name()?.to_str()?.parse().ok()?;
    let folder = fs::canonicalize(path.parent()?).ok()?;
    let is_own = |name: &str| fs::canonicalize(name).is_ok_and(|own| own == folder);
    (is_own("/dev/fd") || is_own("/proc/self/fd")).then_some(number)
}
