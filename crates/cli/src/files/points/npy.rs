//! Reads point sets from NPY arrays.

use std::io::{self, Read};

use npyz::{DType, Deserialize, NpyFile, NpyHeader};

use super::PointFile;
use super::collector::PointCollector;
use crate::files::file_error::{FileError, Place};

const MAGIC: &[u8; 6] = b"\x93NUMPY";
/// A header of a numeric array takes 128 bytes; ten times that is not one of ours. The bound keeps
/// a hostile header from nesting so deep that the parser runs out of stack.
const LONGEST_HEADER: usize = 2048;

/// Returns the sets of an NPY file: one for `(N, 3)`, M for `(M, N, 3)`.
///
/// Takes 4 and 8 byte floats of either byte order, in C or Fortran order.
pub(super) fn read_npy(mut input: impl Read, path: &str) -> Result<PointFile, FileError> {
    let header_bytes = read_header_bytes(&mut input, path)?;
    let header = NpyHeader::from_reader(header_bytes.as_slice())
        .map_err(|error| layout(path, "an NPY header", &error.to_string()))?;
    let points = match *header.shape() {
        [points, 3] | [_, points, 3] => points,
        ref other => {
            return Err(layout(
                path,
                "an array of shape (N, 3) or (M, N, 3)",
                &format!("the shape {}", python_tuple(other)),
            ));
        }
    };
    let shape = header.shape().to_vec();
    let strides = header.strides().to_vec();
    let item = match header.dtype() {
        DType::Plain(kind) => kind.to_string().get(1..).unwrap_or_default().to_owned(),
        _ => String::new(),
    };
    let data = match item.as_str() {
        "f8" => read_numbers::<f64>(header, input, path, &header_bytes)?,
        "f4" => read_numbers::<f32>(header, input, path, &header_bytes)?,
        _ => {
            return Err(layout(
                path,
                "numbers of type float64 or float32",
                &format!("the type {}", header.dtype().descr()),
            ));
        }
    };

    let too_large = || layout(path, "an array that fits in memory", &python_tuple(&shape));
    let points = usize::try_from(points).map_err(|_| too_large())?;
    let at = |offset: u64| {
        let offset = usize::try_from(offset).ok();
        offset.and_then(|offset| data.numbers.get(offset).copied()).ok_or_else(too_large)
    };
    let mut collector = PointCollector::new(path);
    // Counted by the numbers that are there: a shape such as (10^18, 0, 3) is no loop of 10^18.
    for index in 0..data.numbers.len() / 3 {
        let (set, row) = (index / points, index % points);
        let (place, start) = match strides[..] {
            [by_set, by_row, _] => {
                if row == 0 {
                    collector.next_set();
                }
                (Place::RowOfSet(set, row), set as u64 * by_set + row as u64 * by_row)
            }
            _ => (Place::Row(row), row as u64 * strides[0]),
        };
        let step = strides[strides.len() - 1];
        let vector = [at(start)?, at(start + step)?, at(start + 2 * step)?];
        collector.push_vector(vector, place)?;
    }
    if data.bytes_follow {
        collector.warn("bytes follow the array and were not read");
    }
    collector.finish()
}

/// The numbers of an array in the order of the file.
struct Numbers {
    numbers: Vec<f64>,
    bytes_follow: bool,
}

fn read_numbers<T: Deserialize + Into<f64>>(
    header: NpyHeader,
    input: impl Read,
    path: &str,
    header_bytes: &[u8],
) -> Result<Numbers, FileError> {
    let shape = python_tuple(header.shape());
    let descr = header.dtype().descr();
    // Both factors were checked in `numbers_of_header`.
    let data_bytes = header.shape().iter().product::<u64>() * size_of::<T>() as u64;
    let mut counted = Counted { input, bytes: 0 };
    let mut numbers = Vec::new();
    let items = NpyFile::with_header(header, &mut counted)
        .data::<T>()
        .map_err(|_| layout(path, "numbers of type float64 or float32", &descr))?;
    let mut failure = None;
    for item in items {
        match item {
            Ok(number) => numbers.push(number.into()),
            Err(error) => {
                failure = Some(error);
                break;
            }
        }
    }
    match failure {
        None => {}
        Some(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
            let header_length = header_bytes.len() as u64;
            return Err(FileError::Truncated {
                path: path.to_owned(),
                what: format!("an array of shape {shape}"),
                expected: header_length + data_bytes,
                got: header_length + counted.bytes,
            });
        }
        Some(source) => {
            return Err(FileError::Read { path: path.to_owned(), source });
        }
    }
    let bytes_follow = counted
        .read(&mut [0])
        .map_err(|source| FileError::Read { path: path.to_owned(), source })?
        > 0;
    Ok(Numbers { numbers, bytes_follow })
}

/// Returns magic, version, length and text of the header, checked as far as the parser needs it.
fn read_header_bytes(mut input: impl Read, path: &str) -> Result<Vec<u8>, FileError> {
    let mut bytes = Vec::new();
    take(&mut input, &mut bytes, 8, path)?;
    if bytes.is_empty() {
        return Err(FileError::Empty { path: path.to_owned() });
    }
    if !bytes.starts_with(MAGIC) {
        return Err(layout(path, "the magic bytes of an NPY file", "other bytes"));
    }
    // The length has 2 bytes in version 1 and 4 bytes in versions 2 and 3.
    let width = match bytes.get(6) {
        Some(1) => 2,
        Some(2 | 3) => 4,
        Some(other) => {
            return Err(layout(
                path,
                "an NPY file of version 1, 2 or 3",
                &format!("version {other}"),
            ));
        }
        None => 2,
    };
    take(&mut input, &mut bytes, width, path)?;
    let mut length = 0;
    if bytes.len() == 8 + width {
        length = bytes[8..].iter().rev().fold(0, |length, &byte| (length << 8) | usize::from(byte));
        if length > LONGEST_HEADER {
            return Err(layout(
                path,
                &format!("a header of at most {LONGEST_HEADER} bytes"),
                &length.to_string(),
            ));
        }
        take(&mut input, &mut bytes, length, path)?;
    }
    let expected = 8 + width + length;
    if bytes.len() < expected || length == 0 {
        return Err(FileError::Truncated {
            path: path.to_owned(),
            what: "the NPY header".to_owned(),
            expected: expected as u64,
            got: bytes.len() as u64,
        });
    }
    let text = String::from_utf8_lossy(&bytes[8 + width..]).into_owned();
    if !numbers_of_header_are_sane(&text) {
        return Err(layout(path, "a plain decimal shape whose bytes can be counted", text.trim()));
    }
    Ok(bytes)
}

/// Appends up to `count` bytes.
fn take(
    input: &mut impl Read,
    bytes: &mut Vec<u8>,
    count: usize,
    path: &str,
) -> Result<(), FileError> {
    input
        .take(count as u64)
        .read_to_end(bytes)
        .map(|_| ())
        .map_err(|source| FileError::Read { path: path.to_owned(), source })
}

/// Returns whether the product of all numbers in the header, the item's size among them, fits.
///
/// The parser multiplies the dimensions unchecked, which would panic or wrap. A number that runs
/// into a letter or underscore is Python's hexadecimal, exponent or grouping and is refused.
fn numbers_of_header_are_sane(text: &str) -> bool {
    let mut product = 1_u64;
    let mut rest = text;
    while let Some(start) = rest.find(|c: char| c.is_ascii_digit()) {
        let digits = &rest[start..];
        let end = digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len());
        let (number, after) = digits.split_at(end);
        if after.starts_with(|c: char| c.is_alphabetic() || c == '_') {
            return false;
        }
        let Some(next) =
            number.parse::<u64>().ok().and_then(|number| product.checked_mul(number.max(1)))
        else {
            return false;
        };
        product = next;
        rest = after;
    }
    // The longest header has to be added without overflow.
    product < u64::MAX / 2
}

fn python_tuple(shape: &[u64]) -> String {
    match shape {
        [single] => format!("({single},)"),
        _ => format!("({})", shape.iter().map(u64::to_string).collect::<Vec<_>>().join(", ")),
    }
}

fn layout(path: &str, expected: &str, got: &str) -> FileError {
    FileError::Layout {
        path: path.to_owned(),
        place: Place::Whole,
        expected: expected.to_owned(),
        got: got.to_owned(),
    }
}

/// Counts the bytes that pass.
struct Counted<R> {
    input: R,
    bytes: u64,
}

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.input.read(buffer)?;
        self.bytes += read as u64;
        Ok(read)
    }
}
