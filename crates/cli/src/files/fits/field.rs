//! Selects the field of a table or an image that is a HEALPix map.

use super::header::Header;
use super::table::TableColumn;
use crate::files::file_error::{FileError, Place};
use crate::files::text_rows::shortened;

/// The required kind of a field.
pub(super) const REAL_FIELD: &str = "a field of real numbers, such as TFORM = 'D'";

/// The column of a table, or one of several consecutive maps in an image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum FitsField {
    /// Its index from 0, not counting the column of pixel numbers, as in healpy.
    Number(usize),
    /// A text: the column with this TTYPE, or else with this number, or else with this TTYPE in any
    /// case.
    Name(String),
}

/// Returns the column of a field.
pub(super) fn chosen_column(
    path: &str,
    mut columns: Vec<TableColumn>,
    field: &FitsField,
) -> Result<TableColumn, FileError> {
    let number = |number: usize| Some(number).filter(|number| *number < columns.len());
    let at = match field {
        FitsField::Number(at) => number(*at),
        FitsField::Name(name) => columns
            .iter()
            .position(|c| c.name == *name)
            .or_else(|| name.parse().ok().and_then(number))
            .or_else(|| columns.iter().position(|c| c.name.eq_ignore_ascii_case(name))),
    };
    let Some(at) = at else {
        let names: Vec<&str> = columns.iter().take(12).map(|column| column.name.as_str()).collect();
        let more = if columns.len() > names.len() { ", ..." } else { "" };
        let known = format!("{} fields: {}{more}", columns.len(), names.join(", "));
        return Err(unknown_field(path, columns.len(), field, &known));
    };
    let column = columns.swap_remove(at);
    if column.items == 0 {
        return Err(layout(
            path,
            REAL_FIELD,
            "a column of complex numbers or of arrays of variable length",
        ));
    }
    Ok(column)
}

/// Returns the number of consecutive maps of this number of pixels in an image.
pub(super) fn maps_in_image(path: &str, header: &Header, pixels: u64) -> Result<u64, FileError> {
    let axes = header.integer("NAXIS").unwrap_or(0);
    let lengths: Vec<u64> = (1..=axes)
        .filter_map(|axis| header.integer(&format!("NAXIS{axis}")))
        .filter_map(|length| u64::try_from(length).ok())
        .collect();
    let mut product = 1_u64;
    for (axis, length) in lengths.iter().enumerate() {
        product = product.saturating_mul(*length);
        if product == pixels {
            return Ok(lengths[axis + 1..].iter().fold(1, |n: u64, &m| n.saturating_mul(m)));
        }
    }
    let lengths: Vec<String> = lengths.iter().take(8).map(u64::to_string).collect();
    let got = if lengths.is_empty() { "none".to_owned() } else { lengths.join(" x ") };
    Err(layout(path, &format!("an image of {pixels} pixels along its first axes, by NSIDE"), &got))
}

/// Returns the index of a field among the maps of an image, which have no names.
pub(super) fn image_field(path: &str, maps: u64, field: &FitsField) -> Result<u64, FileError> {
    let number = match field {
        FitsField::Number(number) => Some(*number),
        FitsField::Name(name) => name.parse().ok(),
    };
    let count = usize::try_from(maps).unwrap_or(usize::MAX);
    number
        .filter(|number| *number < count)
        .map(|number| number as u64)
        .ok_or_else(|| unknown_field(path, count, field, &format!("an image of {maps} maps")))
}

/// Returns the error of a field that is not among the `count` fields.
fn unknown_field(path: &str, count: usize, field: &FitsField, known: &str) -> FileError {
    let number = match field {
        FitsField::Number(number) => Ok(*number),
        FitsField::Name(name) => name.parse::<usize>().map_err(|_| name),
    };
    match number {
        Ok(number) => layout(
            path,
            &format!("a field below {count}, the number of columns of values"),
            &format!("field {number} ({known})"),
        ),
        Err(name) => layout(path, &format!("a field {}", shortened(name)), known),
    }
}

/// Returns the error of an invalid file structure.
pub(super) fn layout(path: &str, expected: &str, got: &str) -> FileError {
    FileError::Layout {
        path: path.to_owned(),
        place: Place::Whole,
        expected: expected.to_owned(),
        got: got.to_owned(),
    }
}
