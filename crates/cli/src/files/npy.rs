//! NPY, the array format of `NumPy`: reads rows of plain numbers and writes arrays.
//!
//! This reader is our own. Hostile headers (dimensions whose product overflows, deeply
//! nested dictionaries) would have to be rejected before a parser of the whole format sees them,
//! and that takes the same parsing.

mod description;
mod item_type;

#[cfg(test)]
mod tests;

use std::io::{self, Read, Write};
use std::ops::Range;

use npyz::WriterBuilder;

use super::file_error::{FileError, Place};
use super::input::SkipBytes;
use super::memory_guard::MemoryGuard;

use description::Description;

pub(super) use description::Field;
pub(super) use item_type::ItemType;

/// The first bytes of every NPY file. No UTF-8 text starts with the first of them.
pub(super) const MAGIC: &[u8; 6] = b"\x93NUMPY";
/// The header of a plain array takes 128 bytes, that of records about 20 bytes a field; a much
/// longer one describes something else.
const MAX_HEADER: usize = 1 << 16;
/// The number of bytes that are read at a time, a multiple of all item sizes.
const CHUNK: usize = 1 << 16;

/// An array whose header has been read and whose items have not.
pub(super) struct NpyReader<'a, R> {
    input: R,
    path: &'a str,
    description: Description,
    /// The number of bytes before the items.
    header_bytes: usize,
}

impl<'a, R: Read> NpyReader<'a, R> {
    /// Returns a reader positioned after the header of a file of version 1, 2 or 3.
    ///
    /// # Errors
    ///
    /// When the file cannot be read, is not an NPY file, ends within the header, or
    /// contains objects other than records and plain items.
    pub(super) fn new(mut input: R, path: &'a str) -> Result<Self, FileError> {
        let mut header = HeaderBytes { input: &mut input, path, taken: 0 };
        let magic = header.take_some(MAGIC.len())?;
        if !MAGIC.starts_with(&magic) {
            return Err(layout_error(path, "the magic bytes of an NPY file", "other bytes"));
        }
        header.check_end(MAGIC.len(), magic.len())?;
        // The length has 2 bytes in version 1 and 4 bytes in versions 2 and 3.
        let width = match header.take(2)?[0] {
            1 => 2,
            2 | 3 => 4,
            other => {
                let got = format!("version {other}");
                return Err(layout_error(path, "an NPY file of version 1, 2 or 3", &got));
            }
        };
        let length =
            header.take(width)?.iter().rev().fold(0, |sum, &byte| (sum << 8) | usize::from(byte));
        if length > MAX_HEADER {
            let expected = format!("a header of at most {MAX_HEADER} bytes");
            return Err(layout_error(path, &expected, &length.to_string()));
        }
        let text = String::from_utf8_lossy(&header.take(length)?).into_owned();
        let header_bytes = header.taken;
        let description = Description::parse(&text).ok_or_else(|| {
            let expected = "an NPY header of an array of plain numbers with a plain decimal shape";
            layout_error(path, expected, text.trim())
        })?;
        Ok(Self { input, path, description, header_bytes })
    }

    /// Returns the dimensions.
    pub(super) fn shape(&self) -> &[usize] {
        &self.description.shape
    }

    /// Returns the fields of a record, or `None` for an array of plain items.
    pub(super) fn fields(&self) -> Option<&[Field]> {
        self.description.fields.as_deref()
    }

    /// Returns the item type as the header names it, such as `<f8`.
    pub(super) fn descr(&self) -> &str {
        &self.description.descr
    }

    /// Returns the item type, or `None` if it is neither a float nor an integer type.
    pub(super) fn item_type(&self) -> Option<ItemType> {
        ItemType::of_descr(&self.description.descr)
    }

    /// Returns the type of the real and of the imaginary part of complex items, or `None` if the
    /// items are not complex.
    pub(super) fn complex_part(&self) -> Option<ItemType> {
        let descr = match self.descr() {
            "<c8" => "<f4",
            ">c8" => ">f4",
            "<c16" => "<f8",
            ">c16" => ">f8",
            _ => return None,
        };
        ItemType::of_descr(descr)
    }

    /// Returns the error of an array with another shape.
    pub(super) fn shape_error(&self, expected: &str) -> FileError {
        let got = format!("the shape {}", python_tuple(self.shape()));
        layout_error(self.path, expected, &got)
    }

    /// Reads all items of this type, which [`item_type`](Self::item_type) has given.
    ///
    /// # Errors
    ///
    /// When the bytes of the array cannot be counted, the file ends before it, or reading
    /// fails.
    ///
    /// # Performance
    ///
    /// Stores 8 bytes per item of any type. Only items in the file count, so a header
    /// that announces more takes no memory.
    pub(super) fn read_items(mut self, item: ItemType) -> Result<Array, FileError> {
        let bytes = self.bytes_of(item.size()).ok_or_else(|| self.size_error())?;
        let read_error = |source| FileError::Read { path: self.path.to_owned(), source };
        let mut guard = MemoryGuard::default();
        let mut bits = Vec::new();
        let mut chunk = Vec::new();
        let mut done = 0;
        while done < bytes {
            let wanted = (bytes - done).min(CHUNK);
            self.read_bytes(&mut chunk, wanted, done, bytes)?;
            done += wanted;
            bits.extend(chunk.chunks_exact(item.size()).map(|bytes| item.bits(bytes)));
            guard.check(self.path, "an array", 8 * bits.len() as u64)?;
        }
        let bytes_follow = self.input.read(&mut [0]).map_err(read_error)? > 0;
        let Description { shape, fortran_order, .. } = self.description;
        Ok(Array { bits, shape, fortran_order, bytes_follow })
    }

    /// Returns the number of rows of `row` bytes each, of items or records of `item` bytes; 0 if
    /// they cannot be counted.
    pub(super) fn rows(&self, item: usize, row: usize) -> usize {
        self.bytes_of(item).and_then(|bytes| bytes.checked_div(row)).unwrap_or(0)
    }

    /// Returns whether a file of this number of bytes has the whole array.
    pub(super) fn fits(&self, item: usize, file_bytes: u64) -> bool {
        let bytes = self.bytes_of(item).and_then(|bytes| bytes.checked_add(self.header_bytes));
        bytes.is_some_and(|bytes| bytes as u64 <= file_bytes)
    }

    /// Calls `take` with the index and the bytes of each row of an array, `row` bytes each, the last
    /// index fastest in either order of the file. Returns whether the file continues after the array.
    ///
    /// `item` is the number of bytes of a plain item or of a record, and `row` a multiple of them
    /// by a number that divides the last dimension.
    ///
    /// # Errors
    ///
    /// As [`read_items`](Self::read_items), and those of `take`.
    ///
    /// # Performance
    ///
    /// Stores a part of a file in C order, and all of one in Fortran order.
    pub(super) fn for_each_row(
        self,
        item: usize,
        row: usize,
        take: impl FnMut(usize, &[u8]) -> Result<(), FileError>,
    ) -> Result<bool, FileError>
    where
        R: SkipBytes,
    {
        let rows = 0..self.rows(item, row);
        self.for_some_rows(item, row, rows, take)
    }

    /// Does the same for a range of rows. Returns false unless these are the last ones.
    ///
    /// # Errors
    ///
    /// As [`for_each_row`](Self::for_each_row).
    ///
    /// # Performance
    ///
    /// Stores a part of a file, but all of one in Fortran order that is compressed or has more than
    /// two dimensions. Rows of other regular files that are not in the range are not read.
    pub(super) fn for_some_rows(
        mut self,
        item: usize,
        row: usize,
        range: Range<usize>,
        mut take: impl FnMut(usize, &[u8]) -> Result<(), FileError>,
    ) -> Result<bool, FileError>
    where
        R: SkipBytes,
    {
        let bytes = self.bytes_of(item).ok_or_else(|| self.size_error())?;
        let rows = bytes.checked_div(row).unwrap_or(0);
        let range = range.start..range.end.min(rows);
        let path = self.path;
        let read_error = |source| FileError::Read { path: path.to_owned(), source };
        // The order of a single dimension is irrelevant.
        let is_fortran = self.description.fortran_order && self.shape().len() > 1;
        let is_matrix = self.shape().len() == 2 && self.shape()[1].checked_mul(item) == Some(row);
        if is_fortran && is_matrix && self.columns_can_be_read().map_err(read_error)? {
            self.for_each_row_of_columns(item, row, rows, range.clone(), &mut take)?;
        } else if is_fortran && rows > 0 {
            let all = self.read_all(bytes)?;
            let items = row / item;
            let mut gathered = vec![0; row];
            for index in range.clone() {
                for (column, place) in gathered.chunks_exact_mut(item).enumerate() {
                    let start = item * fortran_place(self.shape(), index * items + column);
                    place.copy_from_slice(&all[start..start + item]);
                }
                take(index, &gathered)?;
            }
        } else {
            let mut chunk = Vec::new();
            let together = (CHUNK / row.max(1)).max(1);
            let mut index = range.start;
            self.input.skip_bytes((index * row) as u64).map_err(read_error)?;
            while index < range.end {
                let count = together.min(range.end - index);
                self.read_bytes(&mut chunk, count * row, index * row, bytes)?;
                for bytes in chunk.chunks_exact(row) {
                    take(index, bytes)?;
                    index += 1;
                }
            }
        }
        Ok(range.end == rows && self.input.read(&mut [0]).map_err(read_error)? > 0)
    }

    /// Returns whether the input has positions, so that columns in Fortran order can be read in turn.
    fn columns_can_be_read(&mut self) -> io::Result<bool>
    where
        R: SkipBytes,
    {
        self.input.jump_to(self.header_bytes as u64)
    }

    /// Calls `take` for a range of the rows of an array of columns.
    fn for_each_row_of_columns(
        &mut self,
        item: usize,
        row: usize,
        rows: usize,
        range: Range<usize>,
        take: &mut impl FnMut(usize, &[u8]) -> Result<(), FileError>,
    ) -> Result<(), FileError>
    where
        R: SkipBytes,
    {
        let together = CHUNK / item;
        let (mut chunk, mut gathered) = (Vec::new(), Vec::new());
        let mut index = range.start;
        while index < range.end {
            let count = together.min(range.end - index);
            gathered.clear();
            gathered.resize(count * row, 0);
            for column in 0..row / item {
                let done = (column * rows + index) * item;
                let jumped = self.input.jump_to((self.header_bytes + done) as u64);
                jumped.map_err(|source| FileError::Read { path: self.path.to_owned(), source })?;
                self.read_bytes(&mut chunk, count * item, done, rows * row)?;
                let places = gathered.chunks_exact_mut(row).zip(chunk.chunks_exact(item));
                for (row, bytes) in places {
                    row[column * item..][..item].copy_from_slice(bytes);
                }
            }
            for bytes in gathered.chunks_exact(row) {
                take(index, bytes)?;
                index += 1;
            }
        }
        Ok(())
    }

    /// Returns all `bytes` of the array, limited by the available memory.
    fn read_all(&mut self, bytes: usize) -> Result<Vec<u8>, FileError> {
        let (mut all, mut chunk) = (Vec::new(), Vec::new());
        let mut guard = MemoryGuard::default();
        while all.len() < bytes {
            let wanted = (bytes - all.len()).min(CHUNK);
            self.read_bytes(&mut chunk, wanted, all.len(), bytes)?;
            all.extend_from_slice(&chunk);
            guard.check(self.path, "an array in Fortran order", all.len() as u64)?;
        }
        Ok(all)
    }

    /// Replaces `chunk` by the next `wanted` bytes of `bytes`, of which `done` have been read.
    fn read_bytes(
        &mut self,
        chunk: &mut Vec<u8>,
        wanted: usize,
        done: usize,
        bytes: usize,
    ) -> Result<(), FileError> {
        chunk.clear();
        let part = self.input.by_ref().take(wanted as u64);
        let read = { part }.read_to_end(chunk);
        read.map_err(|source| FileError::Read { path: self.path.to_owned(), source })?;
        if chunk.len() < wanted {
            return Err(FileError::Truncated {
                path: self.path.to_owned(),
                what: format!("an array of shape {}", python_tuple(self.shape())),
                expected: (self.header_bytes + bytes) as u64,
                got: (self.header_bytes + done + chunk.len()) as u64,
            });
        }
        Ok(())
    }

    fn size_error(&self) -> FileError {
        let expected = "an array of a plain decimal shape that fits in memory";
        layout_error(self.path, expected, &format!("the shape {}", python_tuple(self.shape())))
    }

    /// Returns the number of bytes of all items, if they and the header fit in memory.
    fn bytes_of(&self, item: usize) -> Option<usize> {
        if self.shape().contains(&0) {
            return Some(0);
        }
        let mut dimensions = self.shape().iter();
        let bytes = dimensions.try_fold(item, |bytes, &n| bytes.checked_mul(n))?;
        (bytes < usize::MAX / 2).then_some(bytes)
    }
}

/// The items of an array.
pub(super) struct Array {
    /// The bits of every item, in the order of the file.
    bits: Vec<u64>,
    shape: Vec<usize>,
    fortran_order: bool,
    /// Whether the file continues after the array.
    pub(super) bytes_follow: bool,
}

impl Array {
    /// Returns the bits of the items in rows, the last index fastest in either order of the file.
    ///
    /// `N` is the last dimension, or 1. The number of items determines the number of rows: a shape
    /// such as `(10^18, 0, 3)` has none.
    pub(super) fn rows<const N: usize>(&self) -> impl Iterator<Item = [u64; N]> + '_ {
        debug_assert!(N == 1 || self.shape.last() == Some(&N), "{:?} in rows of {N}", self.shape);
        let rows = self.bits.len() / N;
        let step = if self.fortran_order { rows } else { 1 };
        (0..rows).map(move |row| {
            let start =
                if self.fortran_order { fortran_place(&self.shape, row * N) } else { row * N };
            std::array::from_fn(|column| self.bits[start + column * step])
        })
    }
}

/// Returns the index, in an array in Fortran order, of the item with the given index when the last
/// dimension varies fastest.
fn fortran_place(shape: &[usize], place: usize) -> usize {
    let mut rest = place;
    shape.iter().rev().fold(0, |sum, &dimension| {
        let index = rest % dimension;
        rest /= dimension;
        sum * dimension + index
    })
}

/// Writes an array in C order.
///
/// `descr` is explicit rather than native, so that files do not depend on the machine.
///
/// # Errors
///
/// When writing fails, or `descr` is not the item type of a `T`, or the number of items
/// disagrees with the shape.
pub(super) fn write_npy<T: npyz::Serialize>(
    out: &mut impl Write,
    descr: &str,
    shape: &[u64],
    items: impl IntoIterator<Item = T>,
) -> io::Result<()> {
    let invalid = |error| io::Error::new(io::ErrorKind::InvalidData, error);
    let item = npyz::DType::new_scalar(descr.parse().map_err(invalid)?);
    let mut writer =
        npyz::WriteOptions::<T>::new().dtype(item).shape(shape).writer(out).begin_nd()?;
    writer.extend(items)?;
    writer.finish()
}

/// The bytes of a header, counted as they are taken.
struct HeaderBytes<'a, R> {
    input: R,
    path: &'a str,
    taken: usize,
}

impl<R: Read> HeaderBytes<'_, R> {
    /// Returns the next bytes, fewer than `count` only where the file ends.
    fn take_some(&mut self, count: usize) -> Result<Vec<u8>, FileError> {
        let mut bytes = Vec::new();
        let part = self.input.by_ref().take(count as u64);
        let read = { part }.read_to_end(&mut bytes);
        read.map_err(|source| FileError::Read { path: self.path.to_owned(), source })?;
        self.taken += bytes.len();
        Ok(bytes)
    }

    /// Returns the next `count` bytes.
    fn take(&mut self, count: usize) -> Result<Vec<u8>, FileError> {
        let bytes = self.take_some(count)?;
        self.check_end(count, bytes.len())?;
        Ok(bytes)
    }

    /// Returns an error if only `got` of the last `count` bytes were available.
    fn check_end(&self, count: usize, got: usize) -> Result<(), FileError> {
        if got == count {
            return Ok(());
        }
        Err(FileError::Truncated {
            path: self.path.to_owned(),
            what: "the NPY header".to_owned(),
            expected: (self.taken - got + count) as u64,
            got: self.taken as u64,
        })
    }
}

fn python_tuple(shape: &[usize]) -> String {
    match shape {
        [single] => format!("({single},)"),
        _ => format!("({})", shape.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")),
    }
}

/// Returns the error of a file with another layout.
pub(super) fn layout_error(path: &str, expected: &str, got: &str) -> FileError {
    FileError::Layout {
        path: path.to_owned(),
        place: Place::Whole,
        expected: expected.to_owned(),
        got: got.to_owned(),
    }
}
