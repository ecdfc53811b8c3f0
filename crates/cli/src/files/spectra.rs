//! Reading spectra from text files.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use super::file_error::input_name;
use super::{FileError, Place};

/// One degree of a spectrum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpectrumRow {
    pub(crate) l: usize,
    pub(crate) power: f64,
    /// 0 where the file gives none: the value is taken as exact.
    pub(crate) stderr: f64,
}

/// Reads the degrees of a CSV file with the columns `l` and `power` (or `mean`), and `stderr` if there
/// is one; without a header the columns are l, power, stderr in this order. `#` starts a comment.
///
/// # Errors
/// When the file cannot be read, a field is missing or no number, a degree is given twice or left
/// out, or there is no row.
pub(crate) fn read_spectrum(path: &Path) -> Result<Vec<SpectrumRow>, FileError> {
    let name = input_name(path);
    let text = fs::read_to_string(path)
        .map_err(|source| FileError::Open { path: name.clone(), source })?;
    let mut columns = Columns { l: 0, power: 1, stderr: Some(2) };
    let mut rows: BTreeMap<usize, SpectrumRow> = BTreeMap::new();
    let lines = text.lines().enumerate().map(|(i, line)| (i + 1, line));
    let mut lines = lines.filter(|(_, l)| !l.trim().is_empty() && !l.starts_with('#')).peekable();
    if let Some(&(line, header)) = lines.peek()
        && header.contains(|c: char| c.is_alphabetic() && c != 'e' && c != 'E')
    {
        columns = Columns::of_header(&fields(header)).ok_or_else(|| FileError::Layout {
            path: name.clone(),
            place: Place::Line(line),
            expected: "columns l and power (or mean), and stderr".to_owned(),
            got: header.to_owned(),
        })?;
        lines.next();
    }
    for (line, content) in lines {
        let fields = fields(content);
        let wrong = |field: &str, expected: &str, got: &str| FileError::Value {
            path: name.clone(),
            place: Place::Line(line),
            field: field.to_owned(),
            expected: expected.to_owned(),
            got: format!("\"{got}\""),
        };
        let text = |i: usize| fields.get(i).copied().unwrap_or("");
        let l = text(columns.l);
        let l = l.parse().map_err(|_| wrong("l", "a degree", l))?;
        if rows.contains_key(&l) {
            return Err(wrong("l", "each degree once", text(columns.l)));
        }
        let number = |field: &str, i: usize| {
            let value: Option<f64> =
                text(i).parse().ok().filter(|x: &f64| x.is_finite() && *x >= 0.0);
            value.ok_or_else(|| wrong(field, "a finite number from 0", text(i)))
        };
        let stderr = match columns.stderr {
            Some(i) if i < fields.len() => number("stderr", i)?,
            _ => 0.0,
        };
        rows.insert(l, SpectrumRow { l, power: number("power", columns.power)?, stderr });
    }
    let lmax = *rows.keys().next_back().ok_or(FileError::Layout {
        path: name.clone(),
        place: Place::Whole,
        expected: "rows of l and power".to_owned(),
        got: "none".to_owned(),
    })?;
    if let Some(missing) = (1..=lmax).find(|l| !rows.contains_key(l)) {
        return Err(FileError::Layout {
            path: name,
            place: Place::Whole,
            expected: format!("every degree from 1 to {lmax}"),
            got: format!("none of degree {missing}"),
        });
    }
    Ok(rows.into_values().collect())
}

/// Where a row has its numbers.
struct Columns {
    l: usize,
    power: usize,
    stderr: Option<usize>,
}

impl Columns {
    fn of_header(names: &[&str]) -> Option<Self> {
        let find = |wanted: &[&str]| names.iter().position(|n| wanted.contains(n));
        Some(Self { l: find(&["l"])?, power: find(&["power", "mean"])?, stderr: find(&["stderr"]) })
    }
}

fn fields(line: &str) -> Vec<&str> {
    if line.contains(',') {
        line.split(',').map(str::trim).collect()
    } else {
        line.split_whitespace().collect()
    }
}
