//! Reading files that this program has written.

use std::fs;
use std::io;
use std::path::Path;

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
