//! Writes lists as CSV or NPY.

use std::io::{self, Write};
use std::path::Path;

use super::Written;
use crate::files::atomic::AtomicFile;
use crate::files::file_error::{FileError, output_name};
use crate::files::npy::write_npy;
use crate::files::points::PointFormat;
use crate::files::target::is_stream;

/// The approximate number of bytes of text that are written at a time.
const CHUNK: usize = 1 << 16;

/// A list file to be written.
///
/// It is opened before the work starts, so that an invalid name is an error at once.
#[derive(Debug)]
pub(crate) struct ListWriter {
    file: AtomicFile,
    npy: bool,
}

impl ListWriter {
    /// Returns a writer in the format of the extension; `-` is standard output, as CSV.
    ///
    /// # Errors
    ///
    /// If the extension is not that of a list format, or the file cannot be created.
    pub(crate) fn create(path: &Path) -> Result<Self, FileError> {
        let npy = match PointFormat::of_path(path) {
            Some(PointFormat::Npy) => true,
            Some(PointFormat::Csv) => false,
            None if is_stream(path) => false,
            _ => {
                return Err(FileError::UnknownExtension {
                    path: output_name(path),
                    known: ".csv, .npy",
                });
            }
        };
        Ok(Self { file: AtomicFile::create(path)?, npy })
    }

    /// Writes all rows; the file appears when it is complete.
    ///
    /// CSV has the `names` as header and the shortest digits that are read back as the same number,
    /// at most 17. NPY has the shape `(rows, N)`, or `(rows,)` for a single column, of 8-byte items
    /// in little-endian byte and C order.
    ///
    /// # Errors
    ///
    /// When the file cannot be written.
    pub(crate) fn write<T: Written, const N: usize>(
        mut self,
        names: &[&str; N],
        rows: &[[T; N]],
    ) -> Result<(), FileError> {
        let written = if self.npy {
            let n = rows.len() as u64;
            let shape = if N == 1 { vec![n] } else { vec![n, N as u64] };
            write_npy(&mut self.file, T::DESCR, &shape, rows.as_flattened().iter().copied())
        } else {
            write_csv(&mut self.file, names, rows)
        };
        written.map_err(|source| self.file.error(source))?;
        self.file.commit()
    }
}

fn write_csv<T: Written, const N: usize>(
    out: &mut impl Write,
    names: &[&str; N],
    rows: &[[T; N]],
) -> io::Result<()> {
    let mut text = names.join(",");
    text.push('\n');
    for row in rows {
        for (i, &number) in row.iter().enumerate() {
            if i > 0 {
                text.push(',');
            }
            number.append_to(&mut text);
        }
        text.push('\n');
        if text.len() >= CHUNK {
            out.write_all(text.as_bytes())?;
            text.clear();
        }
    }
    out.write_all(text.as_bytes())
}
