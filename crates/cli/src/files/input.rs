//! Opens files for reading.

use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::Path;

use super::file_error::{FileError, input_name, is_dash};

/// Bytes that are read from a file at a time.
const BUFFER: usize = 1 << 16;

/// Returns the content of a file; the path `-` is standard input.
///
/// # Errors
/// When there is no such file, it may not be read, or it is a folder.
pub(super) fn open_input(path: &Path) -> Result<Box<dyn BufRead>, FileError> {
    if is_dash(path) {
        return Ok(Box::new(io::stdin().lock()));
    }
    let open_error = |source| FileError::Open { path: input_name(path), source };
    let file = File::open(path).map_err(open_error)?;
    // A folder can be opened, and the message of the first read would not say what is wrong.
    if file.metadata().map_err(open_error)?.is_dir() {
        return Err(open_error(io::Error::from(io::ErrorKind::IsADirectory)));
    }
    Ok(Box::new(BufReader::with_capacity(BUFFER, file)))
}
