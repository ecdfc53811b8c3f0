//! Reading pair correlations from text files.

use std::path::Path;

use sphvar_samplers::ProfileTable;

use super::file_error::input_name;
use super::input::read_whole;
use super::spectra::read_powers;
use super::text_rows::{TextRows, shortened};
use super::{FileError, Place};

/// Returns the content of a file with the columns `gamma`, in radians, and `g`, possibly among
/// others, as `spectrum --pairs` writes them, or with powers as those of
/// [`read_spectrum`](super::read_spectrum).
///
/// # Errors
///
/// Those of [`read_spectrum`](super::read_spectrum).
pub(crate) fn read_profile(path: &Path) -> Result<ProfileTable, FileError> {
    read_bytes(&read_whole(path)?, &input_name(path))
}

fn read_bytes(bytes: &[u8], path: &str) -> Result<ProfileTable, FileError> {
    match read_pairs(bytes, path)? {
        Some(pairs) => Ok(ProfileTable::PairCorrelation(pairs)),
        None => read_powers(bytes, path).map(ProfileTable::Powers),
    }
}

/// Returns the rows of a pair correlation, `None` if the header does not name its columns.
fn read_pairs(bytes: &[u8], path: &str) -> Result<Option<Vec<[f64; 2]>>, FileError> {
    let mut lines = TextRows::new(bytes, path, "text in UTF-8 with a row for each degree or angle");
    let mut columns = None;
    let mut pairs = Vec::new();
    while let Some(line) = lines.next_line()? {
        if line.is_comment() {
            continue;
        }
        let Some((count, columns)) = columns else {
            let find =
                |name: &str| line.fields().position(|field| field.eq_ignore_ascii_case(name));
            let (Some(gamma), Some(g)) = (find("gamma"), find("g")) else { return Ok(None) };
            columns = Some((line.fields().count(), [("gamma", gamma), ("g", g)]));
            continue;
        };
        let fields: Vec<_> = line.fields().collect();
        let place = Place::Line(line.number);
        if fields.len() != count {
            return Err(FileError::Layout {
                path: path.to_owned(),
                place,
                expected: format!("{count} fields"),
                got: fields.len().to_string(),
            });
        }
        let mut row = [0.0; 2];
        for (value, (field, column)) in row.iter_mut().zip(columns) {
            let number = fields[column].parse().ok().filter(|x: &f64| x.is_finite());
            *value = number.ok_or_else(|| FileError::Value {
                path: path.to_owned(),
                place,
                field: field.to_owned(),
                expected: "a finite number".to_owned(),
                got: format!("{:?}", shortened(&fields[column])),
            })?;
        }
        pairs.push(row);
    }
    Ok(columns.map(|_| pairs))
}

#[cfg(test)]
mod tests {
    use super::{ProfileTable, read_bytes};

    fn read(text: &str) -> Result<ProfileTable, String> {
        read_bytes(text.as_bytes(), "F").map_err(|error| error.to_string())
    }

    #[test]
    fn headers_decide_between_pairs_and_powers() {
        let pairs = ProfileTable::PairCorrelation(vec![[0.1, 0.5], [0.2, 1.0]]);
        for text in [
            "gamma,g\n0.1,0.5\n0.2,1\n",
            "# measured\n\"G\" \"Gamma\" stderr\n0.5 0.1 0\n1 0.2 0\n",
        ] {
            assert_eq!(read(text).as_ref(), Ok(&pairs), "{text:?}");
        }
        let powers = ProfileTable::Powers(vec![0.0, 0.5, 1.0]);
        for text in ["1,0.5\n2,1\n", "l,power\n1,0.5\n2,1\n"] {
            assert_eq!(read(text).as_ref(), Ok(&powers), "{text:?}");
        }
        assert_eq!(read("gamma,g\n"), Ok(ProfileTable::PairCorrelation(vec![])));
    }

    #[test]
    fn errors_name_the_place() {
        for (text, message) in [
            ("gamma,g\n0.1,x\n", "F:2: g"),
            ("gamma,g\n0.1\n", "2 fields"),
            ("gamma,g\n0.1,nan\n", "a finite number"),
            ("gamma,power\n0.1,1\n", "columns l and power"),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.contains(message), "{text:?}: {error}");
        }
    }
}
