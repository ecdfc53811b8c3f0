//! Reading spectra from text files.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::BufRead;
use std::path::Path;

use super::file_error::input_name;
use super::input::open_input;
use super::text_rows::{TextLine, TextRows, shortened};
use super::{FileError, Place};

/// One degree of a spectrum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpectrumRow {
    pub(crate) l: usize,
    pub(crate) power: f64,
    /// 0 if the file does not state one: the value counts as exact.
    pub(crate) stderr: f64,
    /// 0 if the file does not state it.
    pub(crate) realizations: u64,
}

/// Returns the degrees of a text file with the columns `l` and `power` (or `mean`), and `stderr`
/// and `realizations` if there are any; the path `-` is standard input.
///
/// Fields are separated by commas or spaces. A first line without any number is a header and names
/// the columns (with or without quotes, in any case and order, possibly among others); without one
/// they are l, power, stderr in this order. Lines that start with `#` and empty lines are skipped.
///
/// # Errors
///
/// If the file cannot be read, a line has another number of fields than the first, a field
/// is not a number, a degree is duplicate or missing, or there are no rows.
pub(crate) fn read_spectrum(path: &Path) -> Result<Vec<SpectrumRow>, FileError> {
    read_stream(open_input(path)?, &input_name(path))
}

fn read_stream(input: impl BufRead, path: &str) -> Result<Vec<SpectrumRow>, FileError> {
    let layout_error = |place, expected: String, got: String| FileError::Layout {
        path: path.to_owned(),
        place,
        expected,
        got,
    };
    let mut lines = TextRows::new(input, path, "text in UTF-8 with rows of l and power");
    let mut layout: Option<Columns> = None;
    let mut rows: BTreeMap<usize, SpectrumRow> = BTreeMap::new();
    while let Some(line) = lines.next_line()? {
        if line.is_comment() {
            continue;
        }
        let place = Place::Line(line.number);
        let fields: Vec<Cow<'_, str>> = line.fields().collect();
        let columns = match layout {
            Some(columns) => columns,
            None if line.is_header() => {
                layout = Some(Columns::of_header(line).ok_or_else(|| {
                    let expected = "columns l and power (or mean), and stderr".to_owned();
                    layout_error(place, expected, format!("the header {}", shortened(line.text)))
                })?);
                continue;
            }
            None => *layout.insert(Columns::without_header(fields.len()).ok_or_else(|| {
                let expected = "fields l, power and stderr, or a header that names them".to_owned();
                layout_error(place, expected, format!("{} without a header", fields.len()))
            })?),
        };
        if fields.len() != columns.count {
            let expected = format!("{} fields", columns.count);
            return Err(layout_error(place, expected, fields.len().to_string()));
        }
        let wrong = |field: &str, expected: &str, got: &str| FileError::Value {
            path: path.to_owned(),
            place,
            field: field.to_owned(),
            expected: expected.to_owned(),
            got: format!("{:?}", shortened(got)),
        };
        let degree = &fields[columns.l];
        let l = degree.parse().map_err(|_| wrong("l", "a degree", degree))?;
        if rows.contains_key(&l) {
            return Err(wrong("l", "each degree once", degree));
        }
        let number = |field: &str, column: usize| {
            let text = &fields[column];
            let value = text.parse().ok().filter(|x: &f64| x.is_finite() && *x >= 0.0);
            value.ok_or_else(|| wrong(field, "a finite number from 0", text))
        };
        let power = number("power", columns.power)?;
        // The spectrum of one given set has no error, so its field is empty.
        let stderr = columns.stderr.filter(|&column| !fields[column].is_empty());
        let stderr = stderr.map_or(Ok(0.0), |column| number("stderr", column))?;
        let count = |column: usize| {
            let text = &fields[column];
            text.parse().map_err(|_| wrong("realizations", "a whole number", text))
        };
        let realizations = columns.realizations.map_or(Ok(0), count)?;
        rows.insert(l, SpectrumRow { l, power, stderr, realizations });
    }
    let Some(&lmax) = rows.keys().next_back() else {
        return Err(layout_error(
            Place::Whole,
            "rows of l and power".to_owned(),
            "none".to_owned(),
        ));
    };
    if let Some(missing) = (1..=lmax).find(|l| !rows.contains_key(l)) {
        return Err(layout_error(
            Place::Whole,
            format!("every degree from 1 to {lmax}"),
            format!("none of degree {missing}"),
        ));
    }
    Ok(rows.into_values().collect())
}

/// The positions of the numbers in a row.
#[derive(Clone, Copy)]
struct Columns {
    /// The number of fields.
    count: usize,
    l: usize,
    power: usize,
    stderr: Option<usize>,
    realizations: Option<usize>,
}

impl Columns {
    fn of_header(line: TextLine<'_>) -> Option<Self> {
        let find = |wanted: &[&str]| {
            line.fields().position(|name| wanted.iter().any(|w| name.eq_ignore_ascii_case(w)))
        };
        Some(Self {
            count: line.fields().count(),
            l: find(&["l"])?,
            power: find(&["power", "mean"])?,
            stderr: find(&["stderr"]),
            realizations: find(&["realizations"]),
        })
    }

    /// Returns the columns of lines with this number of fields; those after the third are ignored.
    fn without_header(count: usize) -> Option<Self> {
        let stderr = (count > 2).then_some(2);
        (count >= 2).then_some(Self { count, l: 0, power: 1, stderr, realizations: None })
    }
}

#[cfg(test)]
mod tests {
    use super::{SpectrumRow, read_stream};

    fn read(text: &str) -> Result<Vec<SpectrumRow>, String> {
        read_stream(text.as_bytes(), "S").map_err(|error| error.to_string())
    }

    #[test]
    fn every_dialect_gives_the_same_rows() {
        let row = |l, power, stderr| SpectrumRow { l, power, stderr, realizations: 0 };
        let with_errors = vec![row(1, 0.5, 0.25), row(2, 1e-3, 0.0)];
        for text in [
            "1,0.5,0.25\n2,1e-3,0\n",
            "2 1e-3 0\n1 0.5 0.25",
            "1 0.5 0.25 9\n2 1e-3 0 9",
            "l,power,stderr\n1,0.5,0.25\n2,1e-3,0\n",
            "\u{feff}# by hand\r\n\r\n\"L\", \"Power\" ,\"stderr\"\r\n1,0.5,0.25\r\n2,1e-3,0\r\n",
            "l,omega,mean,stderr,name\n1,0,0.5,0.25,\"a, b\"\n # between\n2,0,1e-3,0,\n",
        ] {
            assert_eq!(read(text).as_ref(), Ok(&with_errors), "{text:?}");
        }
        let exact = vec![row(0, 64.0, 0.0), row(1, 0.5, 0.0)];
        for text in ["0,64\n1,0.5\n", "power l\n64 0\n0.5 1\n"] {
            assert_eq!(read(text).as_ref(), Ok(&exact), "{text:?}");
        }
    }

    #[test]
    fn the_number_of_realizations_is_read() {
        let rows = read("l,power,stderr,realizations\n1,0.5,0.1,40\n").unwrap();
        assert_eq!(rows[0].realizations, 40);
    }

    #[test]
    fn wrong_lines_are_named() {
        for (text, message) in [
            ("", "S: expected rows of l and power, got none"),
            ("l,power\n", "S: expected rows of l and power, got none"),
            (
                "# l\n\nl,p\n",
                "S:3: expected columns l and power (or mean), and stderr, got the header l,p",
            ),
            (
                "1\n",
                "S:1: expected fields l, power and stderr, or a header that names them, got 1 without a header",
            ),
            ("l,power\n\n1,0.5\n2,x\n", "S:4: power: expected a finite number from 0, got \"x\""),
            ("1 0.5\n2 nan", "S:2: power: expected a finite number from 0, got \"nan\""),
            (
                "l,power,realizations\n1,0.5,x\n",
                "S:2: realizations: expected a whole number, got \"x\"",
            ),
            ("nan 0.5", "S:1: l: expected a degree, got \"nan\""),
            ("1 0.5 -1", "S:1: stderr: expected a finite number from 0, got \"-1\""),
            ("l,power,stderr\n1,0.5\n", "S:2: expected 3 fields, got 2"),
            ("1,0.5\n2,0.5\n\n1,0.5\n", "S:4: l: expected each degree once, got \"1\""),
            ("1,0.5\n3,0.5\n", "S: expected every degree from 1 to 3, got none of degree 2"),
        ] {
            assert_eq!(read(text), Err(message.to_owned()), "{text:?}");
        }
    }
}
