//! Reads point sets from NPY arrays.

use std::io::BufRead;

use super::PointFile;
use super::collector::PointCollector;
use crate::files::file_error::{FileError, Place};
use crate::files::npy::NpyReader;

/// Returns the sets of an NPY file: one for `(N, 3)`, M for `(M, N, 3)`.
///
/// Takes 4 and 8 byte floats of either byte order, in C or Fortran order.
pub(super) fn read_npy(mut input: impl BufRead, path: &str) -> Result<PointFile, FileError> {
    let start =
        input.fill_buf().map_err(|source| FileError::Read { path: path.to_owned(), source })?;
    if start.is_empty() {
        return Err(FileError::Empty { path: path.to_owned() });
    }
    let array = NpyReader::new(input, path)?;
    let (points, several) = match *array.shape() {
        [points, 3] => (points, false),
        [_, points, 3] => (points, true),
        _ => return Err(array.shape_error("an array of shape (N, 3) or (M, N, 3)")),
    };
    let Some(item) = array.item_type().filter(|item| item.is_float()) else {
        return Err(FileError::Layout {
            path: path.to_owned(),
            place: Place::Whole,
            expected: "numbers of type float64 or float32".to_owned(),
            got: format!("the type '{}'", array.descr()),
        });
    };
    let array = array.read_items(item)?;
    let mut collector = PointCollector::new(path);
    for (index, row) in array.rows::<3>().enumerate() {
        let (set, row_of_set) = (index / points, index % points);
        if row_of_set == 0 {
            collector.next_set();
        }
        let place = if several { Place::RowOfSet(set, row_of_set) } else { Place::Row(row_of_set) };
        collector.push_vector(row.map(|bits| item.float(bits)), place)?;
    }
    if array.bytes_follow {
        collector.warn("bytes follow the array and were not read");
    }
    collector.finish()
}
