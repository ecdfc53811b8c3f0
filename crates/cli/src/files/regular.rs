//! Files that only this program reads and writes.

use std::fs;
use std::io;
use std::path::Path;

use super::AtomicFile;
use super::file_error::{FileError, output_name};
use super::target::is_stream;

/// Returns the bytes of a plain file.
///
/// # Errors
/// When it cannot be read, or is something else: the program writes no pipe, and would wait for one.
pub(crate) fn read_regular(path: &Path) -> io::Result<Vec<u8>> {
    if !fs::metadata(path)?.is_file() {
        return Err(io::Error::other("it is not a plain file"));
    }
    fs::read(path)
}

/// Writes a plain file whole, or not at all.
///
/// # Errors
/// Those of [`AtomicFile::write_whole`], or when something else has its name, such as a pipe, which would wait for a
/// reader.
pub(crate) fn write_regular(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    if is_stream(path) {
        let reason = "it is not a plain file; remove it";
        return Err(FileError::Refused { path: output_name(path), reason });
    }
    AtomicFile::write_whole(path, bytes)
}
