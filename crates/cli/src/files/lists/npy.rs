//! Reads lists from NPY arrays.

use std::io::Read;

use super::{Columns, Fault, Number, fault_error};
use crate::files::file_error::{FileError, Place};
use crate::files::npy::NpyReader;

/// Returns the result of `accept` for every row of an array.
pub(super) fn read_npy<T: Number, R, const N: usize>(
    input: impl Read,
    path: &str,
    columns: &Columns<N>,
    mut accept: impl FnMut([T; N]) -> Result<R, Fault>,
) -> Result<Vec<R>, FileError> {
    let layout_error = |expected: &str, got: String| FileError::Layout {
        path: path.to_owned(),
        place: Place::Whole,
        expected: expected.to_owned(),
        got,
    };
    let array = NpyReader::new(input, path)?;
    let fits = match *array.shape() {
        [_] => N == 1,
        [_, columns] => columns == N,
        _ => false,
    };
    if !fits {
        let shape = if N == 1 { "(N,) or (N, 1)".to_owned() } else { format!("(N, {N})") };
        let names = columns.names.join(",");
        return Err(array.shape_error(&format!("an array of shape {shape} with {names}")));
    }
    let Some(item) = array.item_type().filter(|&item| T::takes(item)) else {
        return Err(layout_error(T::ITEM_TYPES, format!("the type {}", array.descr())));
    };
    let array = array.read_items(item)?;
    if array.bytes_follow {
        return Err(layout_error("a single array", "more bytes after it".to_owned()));
    }
    let result = |(row, bits): (usize, [u64; N])| {
        let numbers = bits.map(|bits| T::of_bits(item, bits));
        let result = match numbers.iter().position(|number| !number.is_expected()) {
            Some(column) => Err(Fault::Column(column, T::EXPECTED.to_owned())),
            None => accept(numbers),
        };
        result.map_err(|fault| {
            let got = numbers.map(|number| number.to_string());
            fault_error(fault, path, Place::Row(row), columns, &got)
        })
    };
    array.rows().enumerate().map(result).collect()
}
