//! Files that are read and written by this program only.

use std::fs;
use std::io;
use std::path::Path;

use super::AtomicFile;
use super::file_error::{FileError, output_name};
use super::target::is_stream;

/// Returns the bytes of a regular file.
///
/// # Errors
///
/// If it cannot be read or is not a regular file; reading a pipe would block.
pub(crate) fn read_regular(path: &Path) -> io::Result<Vec<u8>> {
    if !fs::metadata(path)?.is_file() {
        return Err(io::Error::other("it is not a plain file"));
    }
    fs::read(path)
}

/// Writes a regular file, complete or not at all.
///
/// # Errors
///
/// Those of [`AtomicFile::write_whole`], or if the path is another kind of file, such as a pipe, on
/// which writing would block.
pub(crate) fn write_regular(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    if is_stream(path) {
        let reason = "it is not a plain file; remove it";
        return Err(FileError::InvalidTarget { path: output_name(path), reason });
    }
    AtomicFile::write_whole(path, bytes)
}
