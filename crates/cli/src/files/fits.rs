//! Reading HEALPix maps from FITS files.

mod hdu;
mod header;
mod table;

use std::fs;
use std::io::Cursor;
use std::ops::Range;
use std::path::Path;

use fitsrs::card::Value;
use fitsrs::hdu::header::ValueMap;
use fitsrs::{Fits, HDU};

use super::file_error::{FileError, Place, input_name};

pub(crate) use hdu::{Hdu, HduChoice, HduReader, keyword_error};
pub(crate) use table::{Item, TableColumn};

/// A HEALPix map as it stands in a file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FitsMap {
    pub(crate) nside: u32,
    /// Whether the values are in nested order, as ORDERING says; else in ring order.
    pub(crate) nested: bool,
    /// In the order of the file.
    pub(crate) values: Vec<f64>,
    /// COORDSYS, the coordinate system: `G` galactic, `E` ecliptic, `C` equatorial.
    pub(crate) coordinates: Option<String>,
}

/// Reads field `field` (from 0) of the first binary table of a file, as healpy writes it.
///
/// The header comes from the crate `fitsrs`; of the data, columns of IEEE numbers of 4 or 8 bytes are
/// read here, any number of values in a row.
///
/// # Errors
/// When the file cannot be read or is cut short, and when the header does not say unmistakably that this is
/// a HEALPix map of the whole sphere, of what nside and in what order.
pub(crate) fn read_fits_map(path: &Path, field: usize) -> Result<FitsMap, FileError> {
    let bytes =
        fs::read(path).map_err(|source| FileError::Open { path: input_name(path), source })?;
    Reader { path, bytes: &bytes }.read(field)
}

/// A file in memory with its name for messages.
struct Reader<'a> {
    path: &'a Path,
    bytes: &'a [u8],
}

/// A column of numbers in a table.
struct Column {
    /// Its bytes within a row.
    bytes: Range<usize>,
    /// Bytes of a number, 4 or 8.
    width: usize,
    /// TSCAL and TZERO.
    scale: f64,
    zero: f64,
}

impl Reader<'_> {
    fn read(&self, field: usize) -> Result<FitsMap, FileError> {
        // What does not start so is no FITS file, and the reader of headers need not see it.
        if !self.bytes.starts_with(b"SIMPLE  =") {
            return Err(self.layout("a FITS file", "a file that does not start with SIMPLE"));
        }
        self.check_counts()?;
        for hdu in Fits::from_reader(Cursor::new(self.bytes)) {
            let hdu = hdu.map_err(|error| self.layout("a FITS file", &error.to_string()))?;
            if let HDU::XBinaryTable(table) = hdu {
                let start = usize::try_from(table.get_data_unit_byte_offset());
                return self.table(table.get_header(), start.unwrap_or(usize::MAX), field);
            }
        }
        Err(self.layout("a binary table extension with a map", "none"))
    }

    /// Refuses numbers of axes and of fields beyond the 999 of the standard, over which the reader of headers would
    /// count for ever.
    fn check_counts(&self) -> Result<(), FileError> {
        for name in ["TFIELDS", "NAXIS"] {
            let start = format!("{name:<8}=");
            for card in self.bytes.chunks(80).filter(|card| card.starts_with(start.as_bytes())) {
                let value = String::from_utf8_lossy(&card[start.len()..]);
                let value = value.split('/').next().unwrap_or_default().trim();
                if value.parse::<u64>().is_ok_and(|count| count > 999) {
                    return Err(self.keyword(name, "at most 999", value));
                }
            }
        }
        Ok(())
    }

    fn table(&self, header: &ValueMap, start: usize, field: usize) -> Result<FitsMap, FileError> {
        if let Some(kind) = text(header, "PIXTYPE")
            && kind != "HEALPIX"
        {
            return Err(self.keyword("PIXTYPE", "'HEALPIX'", &format!("'{kind}'")));
        }
        let nested = match text(header, "ORDERING").map(|o| o.to_ascii_uppercase()).as_deref() {
            Some("RING") => false,
            Some("NESTED" | "NEST") => true,
            Some(other) => {
                return Err(self.keyword("ORDERING", "'RING' or 'NESTED'", &format!("'{other}'")));
            }
            None => return Err(self.keyword("ORDERING", "'RING' or 'NESTED'", "no such keyword")),
        };
        if let Some(scheme) = text(header, "INDXSCHM")
            && scheme != "IMPLICIT"
        {
            let expected = "'IMPLICIT', a map of all pixels in order";
            return Err(self.keyword("INDXSCHM", expected, &format!("'{scheme}'")));
        }
        let nside = self.count(header, "NSIDE")?;
        let expected = "an integer from 1 to 8192";
        let nside = u32::try_from(nside)
            .ok()
            .filter(|n| (1..=8192).contains(n))
            .ok_or_else(|| self.keyword("NSIDE", expected, &nside.to_string()))?;
        let n_pixels = 12 * u64::from(nside) * u64::from(nside);
        for (name, expected) in [("FIRSTPIX", 0), ("LASTPIX", n_pixels - 1)] {
            if header.get(name).is_some() {
                let got = self.count(header, name)?;
                if got != expected {
                    let whole = format!("{expected}, as of a map of the whole sphere");
                    return Err(self.keyword(name, &whole, &got.to_string()));
                }
            }
        }
        let (row, rows) = (self.count(header, "NAXIS1")?, self.count(header, "NAXIS2")?);
        let column = self.column(header, field)?;
        let numbers = (column.bytes.len() / column.width) as u64;
        if numbers.checked_mul(rows) != Some(n_pixels) || column.bytes.end as u64 > row {
            return Err(self.layout(
                &format!("{n_pixels} values for NSIDE = {nside}"),
                &format!("{rows} rows of {row} bytes with {numbers} values each"),
            ));
        }
        let data = self.bytes.get(start..).unwrap_or_default();
        let expected = row.saturating_mul(rows);
        if (data.len() as u64) < expected {
            return Err(FileError::Truncated {
                path: input_name(self.path),
                what: format!("{rows} rows of {row} bytes"),
                expected: expected.saturating_add(start as u64),
                got: self.bytes.len() as u64,
            });
        }
        // Both are at most the length of the data.
        let in_memory = |n: u64| usize::try_from(n).unwrap_or(usize::MAX);
        let values = data.chunks_exact(in_memory(row).max(1)).take(in_memory(rows));
        Ok(FitsMap {
            nside,
            nested,
            values: values.flat_map(|row| column.numbers(row)).collect(),
            coordinates: text(header, "COORDSYS").filter(|c| !c.is_empty()),
        })
    }

    /// The place and type of a column.
    fn column(&self, header: &ValueMap, field: usize) -> Result<Column, FileError> {
        let fields = self.count(header, "TFIELDS")?;
        if field as u64 >= fields {
            let got = format!("field {field}");
            return Err(self.layout(&format!("a field below TFIELDS = {fields}"), &got));
        }
        let mut start = 0usize;
        for i in 1.. {
            let name = format!("TFORM{i}");
            let form = text(header, &name)
                .ok_or_else(|| self.keyword(&name, "the type of the column", "no such keyword"))?;
            let digits = form.find(|c: char| !c.is_ascii_digit()).unwrap_or(form.len());
            let (repeat, kind) = form.split_at(digits);
            let repeat: usize =
                if repeat.is_empty() { 1 } else { repeat.parse().unwrap_or(usize::MAX) };
            let width = match kind.chars().next() {
                Some('L' | 'B' | 'A') => 1,
                Some('I') => 2,
                Some('J' | 'E') => 4,
                Some('K' | 'D' | 'C' | 'P') => 8,
                Some('M' | 'Q') => 16,
                _ => return Err(self.keyword(&name, "a type of numbers", &format!("'{form}'"))),
            };
            let end = repeat.checked_mul(width).and_then(|len| start.checked_add(len));
            let end = end.ok_or_else(|| self.keyword(&name, "a number of values", &form))?;
            if i == field + 1 {
                if !matches!(kind.trim(), "E" | "D") || repeat == 0 {
                    let expected = "E or D, numbers of 4 or 8 bytes, such as '1024E'";
                    return Err(self.keyword(&name, expected, &format!("'{form}'")));
                }
                return Ok(Column {
                    bytes: start..end,
                    width,
                    scale: number(header, &format!("TSCAL{i}")).unwrap_or(1.0),
                    zero: number(header, &format!("TZERO{i}")).unwrap_or(0.0),
                });
            }
            start = end;
        }
        // The loop ends at the field, which is below TFIELDS.
        Err(self.layout("a field", "none"))
    }

    fn count(&self, header: &ValueMap, name: &str) -> Result<u64, FileError> {
        let expected = "an integer of at least 0";
        match header.get(name) {
            Some(Value::Integer { value, .. }) => {
                u64::try_from(*value).map_err(|_| self.keyword(name, expected, &value.to_string()))
            }
            Some(_) => Err(self.keyword(name, expected, "another type")),
            None => Err(self.keyword(name, expected, "no such keyword")),
        }
    }

    fn keyword(&self, name: &str, expected: &str, got: &str) -> FileError {
        FileError::Value {
            path: input_name(self.path),
            place: Place::Whole,
            field: format!("keyword {name}"),
            expected: expected.to_owned(),
            got: got.to_owned(),
        }
    }

    fn layout(&self, expected: &str, got: &str) -> FileError {
        FileError::Layout {
            path: input_name(self.path),
            place: Place::Whole,
            expected: expected.to_owned(),
            got: got.to_owned(),
        }
    }
}

impl Column {
    /// The numbers of a row; FITS is big-endian.
    fn numbers(&self, row: &[u8]) -> impl Iterator<Item = f64> {
        row[self.bytes.clone()].chunks_exact(self.width).map(|bytes| {
            let value = match (<[u8; 4]>::try_from(bytes), <[u8; 8]>::try_from(bytes)) {
                (Ok(four), _) => f64::from(f32::from_be_bytes(four)),
                (_, Ok(eight)) => f64::from_be_bytes(eight),
                _ => f64::NAN,
            };
            self.scale * value + self.zero
        })
    }
}

/// The text of a keyword without the blanks that fill it up.
fn text(header: &ValueMap, name: &str) -> Option<String> {
    match header.get(name) {
        Some(Value::String { value, .. }) => Some(value.trim().to_owned()),
        _ => None,
    }
}

fn number(header: &ValueMap, name: &str) -> Option<f64> {
    match header.get(name) {
        Some(Value::Integer { value, .. }) => Some(*value as f64),
        Some(Value::Float { value, .. }) => Some(*value),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
