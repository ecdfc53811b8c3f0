//! Reads harmonic coefficients: NPY arrays in the order of healpy, and FITS tables of healpy.

use std::io::BufRead;
use std::path::Path;

use sphvar_sh::{Alm, LmIndex};

use super::file_error::{FileError, Place, input_name};
use super::fits::{Hdu, HduChoice, HduReader, Item, TableColumn};
use super::input::{SkipBytes, open_input};
use super::memory_guard::check_announced;
use super::npy::{MAGIC, NpyReader, layout_error};

/// The maximum length of a row of a table, in bytes.
const MAX_ROW: usize = 1 << 20;
/// The columns of a table of coefficients.
const COLUMNS: [&str; 3] = ["index", "real", "imag"];

/// The largest degree of a table without a row for every degree.
const MAX_GAPS: usize = 1000;

/// Returns the coefficients `a_lm`, m >= 0, of a file, decompressed if it is a gzip file.
///
/// An NPY file has complex items in the order `m (2 lmax + 1 - m)/2 + l` of healpy, whose number
/// determines lmax. A table in a FITS file has the columns index = `l^2 + l + m + 1`, real and imag,
/// as `healpy.write_alm` writes it; coefficients without a row are 0. If `hdu` is the first of several
/// tables, as of T, E and B, a remark names it.
///
/// # Errors
///
/// If the file cannot be read, its layout is another one, a coefficient is not finite or occurs
/// twice, or the number of items is not that of an lmax.
pub(crate) fn read_alm(
    path: &Path,
    hdu: &HduChoice,
    remarks: &mut Vec<String>,
) -> Result<Alm, FileError> {
    let name = input_name(path);
    let mut input = open_input(path)?;
    let read_error = |source| FileError::Read { path: name.clone(), source };
    let start = input.fill_buf().map_err(read_error)?;
    if start.starts_with(MAGIC) {
        read_npy(input, &name)
    } else if start.starts_with(b"SIMPLE") {
        read_fits(input, &name, hdu, remarks)
    } else {
        Err(layout_error(&name, "an NPY array or a FITS table of coefficients", "another file"))
    }
}

fn read_npy(input: impl SkipBytes, path: &str) -> Result<Alm, FileError> {
    let layout = |expected: &str, got: &str| layout_error(path, expected, got);
    let array = NpyReader::new(input, path)?;
    let &[count] = array.shape() else {
        return Err(array.shape_error("an array of coefficients of shape (n,)"));
    };
    let Some(part) = array.complex_part() else {
        let got = format!("the type {}", array.descr());
        return Err(layout("complex items of type c8 or c16", &got));
    };
    let lmax = lmax_of(path, count)?;
    let mut alm = zeros(path, lmax)?;
    let values = alm.values_mut();
    let bytes_follow = array.for_each_row(2 * part.size(), 2 * part.size(), |at, bytes| {
        let (re, im) = bytes.split_at(part.size());
        [values[at].re, values[at].im] =
            finite(path, Place::Row(at), [part.number(re), part.number(im)])?;
        Ok(())
    })?;
    if bytes_follow {
        return Err(layout("a single array", "more bytes after it"));
    }
    Ok(alm)
}

/// Returns the coefficients of a real function from real and imaginary parts in the order of healpy.
///
/// # Errors
///
/// If their number is not that of a degree, one is not finite, or they do not fit in memory.
pub(crate) fn alm_of_array(name: &str, coefficients: &[[f64; 2]]) -> Result<Alm, FileError> {
    let mut alm = zeros(name, lmax_of(name, coefficients.len())?)?;
    for (at, (to, parts)) in alm.values_mut().iter_mut().zip(coefficients).enumerate() {
        [to.re, to.im] = finite(name, Place::Row(at), *parts)?;
    }
    Ok(alm)
}

/// Returns the degree of a number of coefficients.
///
/// # Errors
///
/// If it is that of no degree.
fn lmax_of(path: &str, count: usize) -> Result<usize, FileError> {
    let lmax = nearest_lmax(count);
    if LmIndex::new(lmax).is_ok_and(|index| index.len() != count) {
        let near = (lmax + 1) * (lmax + 2) / 2;
        let expected = format!(
            "(lmax + 1)(lmax + 2)/2 coefficients, {near} for lmax = {lmax}, the nearest (if mmax < lmax, save \
             healpy.resize_alm(alm, lmax, mmax, lmax, lmax))"
        );
        return Err(layout_error(path, &expected, &count.to_string()));
    }
    Ok(lmax)
}

/// Returns the lmax whose number of coefficients is nearest to `count`.
fn nearest_lmax(count: usize) -> usize {
    let number = |lmax: usize| (lmax + 1).saturating_mul(lmax + 2) / 2;
    // The largest degree with at most this number: (2 lmax + 3)^2 <= 8 count + 1.
    let below = (count.saturating_mul(8).saturating_add(1).isqrt().saturating_sub(3)) / 2;
    let is_nearer = number(below + 1).abs_diff(count) < number(below).abs_diff(count);
    if is_nearer { below + 1 } else { below }
}

fn read_fits(
    input: impl BufRead,
    path: &str,
    choice: &HduChoice,
    remarks: &mut Vec<String>,
) -> Result<Alm, FileError> {
    let mut file = HduReader::new(input, path);
    let expected =
        "an NPY array or a FITS table of coefficients with the columns index, real, imag";
    let hdu = file.select(choice, Hdu::is_table, expected)?;
    let (row, rows) = hdu.table_size(path, MAX_ROW)?;
    let fields = TableColumn::of_table(&hdu, path)?;
    let column = |name: &str| fields.iter().find(|field| field.name.eq_ignore_ascii_case(name));
    let [Some(index), Some(re), Some(im)] = COLUMNS.map(column) else {
        let names: Vec<&str> = fields.iter().map(|field| field.name.as_str()).collect();
        let got = format!("the columns {}", names.join(", "));
        return Err(layout_error(path, "the columns index, real, imag", &got));
    };
    if [index, re, im].iter().any(|column| column.items != 1) {
        return Err(layout_error(path, "one number in a column and row", "arrays or other types"));
    }
    let what = format!("{rows} rows of {row} bytes");
    let (mut bytes, mut found) = (vec![0; row], Vec::new());
    for number in 1..=rows {
        file.read_data(&mut bytes, &what)?;
        let place = Place::TableRow(number);
        let item = |column: &TableColumn| match column.item(&bytes, 0) {
            Item::Number(number) => number,
            Item::Text(_) | Item::Missing => f64::NAN,
        };
        let lm = degree_and_order(path, place, item(index))?;
        found.push((lm, finite(path, place, [item(re), item(im)])?, place));
    }
    // What follows the table is not needed, and may be damaged.
    let next = (*choice == HduChoice::First).then(|| file.next_hdu().ok().flatten()).flatten();
    if let Some(next) = next.filter(Hdu::is_table) {
        let (first, other) = (hdu.number, next.number);
        remarks.push(format!(
            "{path}: the first table with coefficients is used, HDU {first} (T of T, E and B); hdu={other} selects the \
             next"
        ));
    }
    let lmax = found
        .iter()
        .map(|((l, _), ..)| *l)
        .max()
        .ok_or_else(|| layout_error(path, "rows of coefficients", "an empty table"))?;
    // Even a table of m = 0 alone has a row for each degree; a wrong index may be any number.
    if lmax > MAX_GAPS && found.len() <= lmax {
        let expected = format!("at least {} rows for degree {lmax} of the largest index", lmax + 1);
        return Err(layout_error(path, &expected, &found.len().to_string()));
    }
    let mut alm = zeros(path, lmax)?;
    let mut is_known = vec![false; alm.values().len()];
    for ((l, m), value, place) in found {
        let at = alm.index().at(l, m);
        if std::mem::replace(&mut is_known[at], true) {
            let got = format!("l = {l}, m = {m} again");
            return Err(value_error(path, place, "index", "each coefficient once", got));
        }
        let a = &mut alm.values_mut()[at];
        [a.re, a.im] = value;
    }
    Ok(alm)
}

/// Returns l and m of the index `l^2 + l + m + 1`.
fn degree_and_order(path: &str, place: Place, index: f64) -> Result<(usize, usize), FileError> {
    let wrong = |expected: &str| value_error(path, place, "index", expected, index.to_string());
    // Whole numbers up to this one are exact, and degrees far beyond the largest.
    if !(index.fract() == 0.0 && (1.0..=1e15).contains(&index)) {
        return Err(wrong("a whole number from 1, l^2 + l + m + 1"));
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a whole number from 1 to 1e15"
    )]
    let from_0 = index as u64 - 1;
    let l = from_0.isqrt();
    let m = (from_0 - l * l).checked_sub(l);
    let m =
        m.ok_or_else(|| wrong("an index l^2 + l + m + 1 with m >= 0, as for real functions"))?;
    match (usize::try_from(l), usize::try_from(m)) {
        (Ok(l), Ok(m)) => Ok((l, m)),
        _ => Err(wrong("a degree that fits in memory")),
    }
}

/// Returns coefficients of 0.
fn zeros(path: &str, lmax: usize) -> Result<Alm, FileError> {
    let degrees = lmax as f64 + 1.0;
    check_announced(path, &format!("coefficients to degree {lmax}"), 8.0 * degrees * degrees)?;
    Alm::zeros(lmax).map_err(|e| layout_error(path, "a supported degree", &e.to_string()))
}

/// Returns the real and the imaginary part.
fn finite(path: &str, place: Place, [re, im]: [f64; 2]) -> Result<[f64; 2], FileError> {
    if re.is_finite() && im.is_finite() {
        return Ok([re, im]);
    }
    Err(value_error(path, place, "coefficient", "finite numbers", format!("{re} + {im} i")))
}

fn value_error(path: &str, place: Place, field: &str, expected: &str, got: String) -> FileError {
    let (path, field, expected) = (path.to_owned(), field.to_owned(), expected.to_owned());
    FileError::Value { path, place, field, expected, got }
}

#[cfg(test)]
mod tests {
    use super::{degree_and_order, nearest_lmax};
    use crate::files::file_error::Place;

    #[test]
    fn the_nearest_degree_is_found() {
        for (count, lmax) in
            [(0, 0), (1, 0), (2, 0), (3, 1), (4, 1), (5, 2), (6, 2), (23, 5), (25, 6)]
        {
            assert_eq!(nearest_lmax(count), lmax, "{count}");
        }
        for lmax in [7, 40, 20_000] {
            let count = (lmax + 1) * (lmax + 2) / 2;
            for near in [count - 1, count, count + 1] {
                assert_eq!(nearest_lmax(near), lmax, "{near}");
            }
        }
        assert!(nearest_lmax(usize::MAX) > 20_000);
    }

    #[test]
    fn indices_are_those_of_healpy() {
        let place = Place::TableRow(1);
        for (l, m) in [(0, 0), (1, 0), (1, 1), (40, 17), (20_000, 20_000)] {
            let index = (l * l + l + m + 1) as f64;
            assert_eq!(degree_and_order("F", place, index).ok(), Some((l, m)));
        }
        // 2 is l = 1, m = -1.
        for bad in [0.0, -1.0, 2.0, 1.5, f64::NAN, 1e16] {
            assert!(degree_and_order("F", place, bad).is_err(), "{bad}");
        }
    }
}
