//! Lists of plain rows, such as pixels or angles, as CSV or NPY: one row in, one row out.
//!
//! Point sets have a separate reader, which converts every row to a direction. Here numbers are
//! preserved exactly, and integers are never converted to floats.

mod npy;
mod number;
mod text;
mod write;

#[cfg(test)]
mod tests;

use std::io::BufRead;
use std::path::Path;

use super::file_error::{FileError, Place, input_name};
use super::input::open_input;
use super::npy::MAGIC;
use super::points::PointFormat;

pub(crate) use number::{Number, Written};
pub(crate) use write::ListWriter;

/// The columns of a list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Columns<const N: usize> {
    /// The names in the header; without a header, the columns are in this order.
    pub(crate) names: [&'static str; N],
    /// The unit or another remark for messages about missing columns.
    pub(crate) remark: &'static str,
}

/// The reason why a row with well-formed numbers cannot be used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Fault {
    /// The number of one column, an index in [`Columns::names`], is invalid; the text states the
    /// expected value.
    Column(usize, String),
    /// The row as a whole is invalid.
    Row(String),
}

/// Returns the result of `accept` for every row of a file, in order; the path `-` is standard
/// input.
///
/// A file is NPY if its name or its first byte indicates it, and text otherwise.
///
/// Text has fields separated by commas or spaces. A first line without any number is a header and
/// selects the columns by their names (with or without quotes, in any case and order, possibly
/// among other columns); without one, the fields are exactly the columns. Lines that start with `#`
/// and empty lines are skipped.
///
/// NPY has the shape `(rows, N)`, or `(rows,)` for a single column, in C or Fortran order and
/// either byte order; floats of 4 or 8 bytes for `f64`, integers of 1 to 8 bytes for `i128`.
///
/// # Errors
///
/// When the file cannot be read, is neither, or has a row that is malformed or has a
/// [`Fault`]; the message names the file, the line (or row), the field, and the expected value. A
/// file with neither header nor row is an error; a header or an array without rows is an empty
/// list.
///
/// # Performance
///
/// Stores the results and, for an NPY file, 8 bytes per number.
pub(crate) fn read_list<T: Number, R, const N: usize>(
    path: &Path,
    columns: &Columns<N>,
    accept: impl FnMut([T; N]) -> Result<R, Fault>,
) -> Result<Vec<R>, FileError> {
    let input = open_input(path)?;
    let npy = PointFormat::of_input_path(path) == Some(PointFormat::Npy);
    read_stream(input, &input_name(path), npy, columns, accept)
}

fn read_stream<T: Number, R, const N: usize>(
    mut input: impl BufRead,
    path: &str,
    npy: bool,
    columns: &Columns<N>,
    accept: impl FnMut([T; N]) -> Result<R, Fault>,
) -> Result<Vec<R>, FileError> {
    let start =
        input.fill_buf().map_err(|source| FileError::Read { path: path.to_owned(), source })?;
    // One byte suffices: no text starts with it, and for a damaged file the error of the array
    // reader is more specific.
    if npy || start.first() == Some(&MAGIC[0]) {
        npy::read_npy(input, path, columns, accept)
    } else {
        text::read_text(input, path, columns, accept)
    }
}

/// Returns the error of a row that was not accepted; `got` contains its numbers as they are
/// written.
fn fault_error<const N: usize>(
    fault: Fault,
    path: &str,
    place: Place,
    columns: &Columns<N>,
    got: &[impl AsRef<str>; N],
) -> FileError {
    let (field, expected, got) = match fault {
        Fault::Column(column, expected) => {
            (columns.names[column].to_owned(), expected, got[column].as_ref().to_owned())
        }
        Fault::Row(expected) => {
            let numbers: Vec<&str> = got.iter().map(AsRef::as_ref).collect();
            (columns.names.join(","), expected, format!("({})", numbers.join(", ")))
        }
    };
    FileError::Value { path: path.to_owned(), place, field, expected, got }
}
