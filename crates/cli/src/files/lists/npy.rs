//! Reads lists from NPY arrays.

use std::io::Read;

use super::number::ItemType;
use super::{Columns, Fault, Number, fault_error};
use crate::files::file_error::{FileError, Place};

/// The first bytes of every NPY file.
pub(super) const MAGIC: &[u8; 6] = b"\x93NUMPY";
/// The header of a plain array takes 128 bytes; what is much longer describes something else.
const LONGEST_HEADER: usize = 2048;
/// Bytes that are read at a time: a multiple of all item sizes.
const CHUNK: usize = 1 << 16;

/// Returns `accept` of every row of an array.
pub(super) fn read_npy<T: Number, R, const N: usize>(
    mut input: impl Read,
    path: &str,
    columns: &Columns<N>,
    mut accept: impl FnMut([T; N]) -> Result<R, Fault>,
) -> Result<Vec<R>, FileError> {
    let header = Header::read(&mut input, path)?;
    let form_error = |expected: String, got: String| FileError::Layout {
        path: path.to_owned(),
        place: Place::Whole,
        expected,
        got,
    };
    let wanted_columns = N as u64;
    let rows = match header.shape[..] {
        [rows] if N == 1 => rows,
        [rows, columns] if columns == wanted_columns => rows,
        _ => {
            let shape = if N == 1 { "(N,) or (N, 1)".to_owned() } else { format!("(N, {N})") };
            return Err(form_error(
                format!("an array of shape {shape} with {}", columns.names.join(",")),
                format!("the shape {}", python_tuple(&header.shape)),
            ));
        }
    };
    let Some(item) = ItemType::of_descr(&header.descr).filter(|&item| T::takes(item)) else {
        return Err(form_error(T::ITEM_TYPES.to_owned(), format!("the type {}", header.descr)));
    };
    // All sizes fit where this one fits.
    let data_bytes = rows
        .checked_mul(wanted_columns * u64::from(item.size))
        .filter(|&bytes| usize::try_from(bytes).is_ok() && bytes < u64::MAX / 2)
        .ok_or_else(|| {
            form_error("an array that fits in memory".to_owned(), python_tuple(&header.shape))
        })?;

    let bits = read_items(&mut input, item, data_bytes).map_err(|failure| match failure {
        Failure::Read(source) => FileError::Read { path: path.to_owned(), source },
        Failure::EndedAfter(bytes) => FileError::Truncated {
            path: path.to_owned(),
            what: format!("an array of shape {}", python_tuple(&header.shape)),
            expected: header.bytes + data_bytes,
            got: header.bytes + bytes,
        },
    })?;
    let follows =
        input.read(&mut [0]).map_err(|source| FileError::Read { path: path.to_owned(), source })?;
    if follows > 0 {
        return Err(form_error("a single array".to_owned(), "more bytes after it".to_owned()));
    }

    let n_rows = bits.len() / N;
    let (by_row, by_column) = if header.fortran_order { (1, n_rows) } else { (N, 1) };
    let mut results = Vec::with_capacity(n_rows);
    for row in 0..n_rows {
        let items: [u64; N] = std::array::from_fn(|i| bits[row * by_row + i * by_column]);
        let numbers = items.map(|bits| T::of_bits(item, bits));
        let result = match numbers.iter().position(|number| !number.is_expected()) {
            Some(column) => Err(Fault::Column(column, T::EXPECTED.to_owned())),
            None => accept(numbers),
        };
        results.push(result.map_err(|fault| {
            let got = numbers.map(|number| number.to_string());
            fault_error(fault, path, Place::Row(row), columns, &got)
        })?);
    }
    Ok(results)
}

enum Failure {
    Read(std::io::Error),
    EndedAfter(u64),
}

/// Returns the bits of `data_bytes` bytes of items. Memory grows with what is there and not with what
/// the header promises.
fn read_items(input: &mut impl Read, item: ItemType, data_bytes: u64) -> Result<Vec<u64>, Failure> {
    let size = usize::from(item.size);
    let mut bits = Vec::new();
    let mut chunk = Vec::with_capacity(CHUNK);
    let mut done = 0;
    while done < data_bytes {
        chunk.clear();
        let wanted = (data_bytes - done).min(CHUNK as u64);
        let read = input.take(wanted).read_to_end(&mut chunk).map_err(Failure::Read)? as u64;
        done += read;
        if read < wanted {
            return Err(Failure::EndedAfter(done));
        }
        bits.extend(chunk.chunks_exact(size).map(|bytes| item.bits(bytes)));
    }
    Ok(bits)
}

struct Header {
    descr: String,
    fortran_order: bool,
    shape: Vec<u64>,
    /// The length of everything before the data.
    bytes: u64,
}

impl Header {
    fn read(input: &mut impl Read, path: &str) -> Result<Self, FileError> {
        let mut bytes = Vec::new();
        let mut take = |count: usize| -> Result<Vec<u8>, FileError> {
            let mut part = Vec::new();
            input
                .take(count as u64)
                .read_to_end(&mut part)
                .map_err(|source| FileError::Read { path: path.to_owned(), source })?;
            bytes.extend_from_slice(&part);
            if part.len() == count {
                return Ok(part);
            }
            Err(FileError::Truncated {
                path: path.to_owned(),
                what: "the NPY header".to_owned(),
                expected: (bytes.len() - part.len() + count) as u64,
                got: bytes.len() as u64,
            })
        };
        let form_error = |expected: &str, got: &str| FileError::Layout {
            path: path.to_owned(),
            place: Place::Whole,
            expected: expected.to_owned(),
            got: got.to_owned(),
        };
        if take(MAGIC.len())? != MAGIC {
            return Err(form_error("the magic bytes of an NPY file", "other bytes"));
        }
        // The length has 2 bytes in version 1 and 4 bytes in versions 2 and 3.
        let width = match take(2)?[0] {
            1 => 2,
            2 | 3 => 4,
            other => {
                let got = format!("version {other}");
                return Err(form_error("an NPY file of version 1, 2 or 3", &got));
            }
        };
        let length = take(width)?.iter().rev().fold(0, |sum, &byte| (sum << 8) | usize::from(byte));
        if length > LONGEST_HEADER {
            let expected = format!("a header of at most {LONGEST_HEADER} bytes");
            return Err(form_error(&expected, &length.to_string()));
        }
        let text = String::from_utf8_lossy(&take(length)?).into_owned();
        let (descr, fortran_order, shape) = parse_header(&text).ok_or_else(|| {
            form_error("the NPY header of an array of plain numbers", text.trim())
        })?;
        Ok(Self { descr, fortran_order, shape, bytes: bytes.len() as u64 })
    }
}

/// Returns item type, order and shape of a header such as
/// `{'descr': '<i8', 'fortran_order': False, 'shape': (5, 2), }`.
fn parse_header(text: &str) -> Option<(String, bool, Vec<u64>)> {
    let descr = value_of(text, "descr")?;
    let quote = descr.chars().next().filter(|c| matches!(c, '\'' | '"'))?;
    let (descr, _) = descr[1..].split_once(quote)?;
    let order = value_of(text, "fortran_order")?;
    let fortran_order = order.starts_with("True");
    if !fortran_order && !order.starts_with("False") {
        return None;
    }
    let (inside, _) = value_of(text, "shape")?.strip_prefix('(')?.split_once(')')?;
    // A comma at the end is how Python tells (5,) from a number.
    let inside = inside.trim();
    let inside = inside.strip_suffix(',').unwrap_or(inside);
    let shape = match inside {
        "" => Vec::new(),
        _ => inside.split(',').map(|n| n.trim().parse().ok()).collect::<Option<_>>()?,
    };
    Some((descr.to_owned(), fortran_order, shape))
}

/// Returns what follows the colon of a quoted key.
fn value_of<'t>(text: &'t str, key: &str) -> Option<&'t str> {
    let after = ['\'', '"'].iter().find_map(|quote| {
        let quoted = format!("{quote}{key}{quote}");
        text.find(&quoted).map(|at| &text[at + quoted.len()..])
    })?;
    Some(after.trim_start().strip_prefix(':')?.trim_start())
}

fn python_tuple(shape: &[u64]) -> String {
    match shape {
        [single] => format!("({single},)"),
        _ => format!("({})", shape.iter().map(u64::to_string).collect::<Vec<_>>().join(", ")),
    }
}
