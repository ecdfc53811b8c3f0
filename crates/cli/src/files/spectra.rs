//! Reading numbers per degree, such as spectra, from text files.

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
    /// The power or energy.
    pub(crate) value: f64,
    /// 0 if the file does not state one: the value counts as exact.
    pub(crate) stderr: f64,
    /// 0 if the file does not state it.
    pub(crate) realizations: u64,
}

/// Returns the degrees of a text file with the columns `l` and `power` (or `mean`), and `stderr`
/// and `realizations` if there are any; the path `-` is standard input.
///
/// Fields are separated by commas or spaces. A first line without any number is a header and names
/// the columns (with or without quotes, in any case and order, possibly among others), otherwise a
/// comment that names as many columns as there are fields; without one they are l, power, stderr in
/// this order. Other lines that start with `#` and empty lines are skipped.
///
/// # Errors
///
/// If the file cannot be read, a line has another number of fields than the first, a field
/// is not a number, a degree is duplicate or missing, or there are no rows.
pub(crate) fn read_spectrum(path: &Path) -> Result<Vec<SpectrumRow>, FileError> {
    let spectrum = read_stream(open_input(path)?, &input_name(path), &POWER)?;
    Ok(spectrum.rows)
}

/// Returns the powers by degree from 0 of a text file, 0 where it starts at degree 1; degree 0 is
/// not used.
pub(super) fn read_powers(input: impl BufRead, path: &str) -> Result<Vec<f64>, FileError> {
    let Spectrum { rows, .. } = read_stream(input, path, &POWER)?;
    let first = rows.first().map_or(0, |row| row.l);
    Ok((0..first).map(|_| 0.0).chain(rows.iter().map(|row| row.value)).collect())
}

/// The values of a kind of file.
pub(super) struct Content {
    /// The names of the column, in lower case.
    pub(super) names: &'static [&'static str],
    /// The names in words.
    pub(super) words: &'static str,
    /// The layout without a header, for messages.
    pub(super) layout: &'static str,
    /// Whether a file without a header may have the values alone, from degree 0.
    pub(super) alone: bool,
    /// The number of standard errors by which a value may be less than 0.
    pub(super) max_below: f64,
}

const POWER: Content = Content {
    names: &["power", "mean"],
    words: "power (or mean)",
    layout: "fields l, power and stderr, or a header that names them",
    alone: false,
    max_below: 0.0,
};

/// The rows of a file and the name of the column of their values, if it has a header.
pub(super) struct Spectrum {
    pub(super) rows: Vec<SpectrumRow>,
    pub(super) name: Option<&'static str>,
}

/// Returns the rows of a text file; see [`read_spectrum`].
pub(super) fn read_stream(
    input: impl BufRead,
    path: &str,
    content: &Content,
) -> Result<Spectrum, FileError> {
    let value_name = content.names[0];
    let layout_error = |place, expected: String, got: String| FileError::Layout {
        path: path.to_owned(),
        place,
        expected,
        got,
    };
    let mut lines = TextRows::new(input, path, "text in UTF-8 with a row for each degree");
    let mut layout: Option<Columns> = None;
    let mut in_comment: Option<Columns> = None;
    let mut rows: BTreeMap<usize, SpectrumRow> = BTreeMap::new();
    while let Some(line) = lines.next_line()? {
        if line.is_comment() {
            let names = line.with_text(line.text.trim_start_matches('#'));
            in_comment = Columns::of_header(names, content.names).or(in_comment);
            continue;
        }
        let place = Place::Line(line.number);
        let fields: Vec<Cow<'_, str>> = line.fields().collect();
        let columns = match layout {
            Some(columns) => columns,
            None if line.is_header() => {
                layout = Some(Columns::of_header(line, content.names).ok_or_else(|| {
                    let expected = format!("columns l and {}, and stderr", content.words);
                    layout_error(place, expected, format!("the header {}", shortened(line.text)))
                })?);
                continue;
            }
            None => {
                let commented = in_comment.filter(|columns| columns.count == fields.len());
                let columns =
                    commented.or_else(|| Columns::without_header(fields.len(), content.alone));
                *layout.insert(columns.ok_or_else(|| {
                    let got = format!("{} without a header", fields.len());
                    layout_error(place, content.layout.to_owned(), got)
                })?)
            }
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
        let l = match columns.l {
            Some(column) => {
                degree(&fields[column]).ok_or_else(|| wrong("l", "a degree", &fields[column]))?
            }
            None => rows.len(),
        };
        if rows.contains_key(&l) {
            return Err(wrong("l", "each degree once", &l.to_string()));
        }
        let number = |field: &str, column: usize, min: f64| {
            let text = &fields[column];
            let value = text.parse().ok().filter(|x: &f64| x.is_finite() && *x >= min);
            let expected = if min < 0.0 {
                Cow::from(format!(
                    "a finite number from 0, or less by at most {} times stderr",
                    content.max_below
                ))
            } else {
                Cow::from("a finite number from 0")
            };
            value.ok_or_else(|| wrong(field, &expected, text))
        };
        // The spectrum of one given set has no error, so its field is empty.
        let stderr = columns.stderr.filter(|&column| !fields[column].is_empty());
        let stderr = stderr.map_or(Ok(0.0), |column| number("stderr", column, 0.0))?;
        let value = number(value_name, columns.value, -content.max_below * stderr)?;
        let count = |column: usize| {
            let text = &fields[column];
            text.parse().map_err(|_| wrong("realizations", "a whole number", text))
        };
        let realizations = columns.realizations.map_or(Ok(0), count)?;
        rows.insert(l, SpectrumRow { l, value, stderr, realizations });
    }
    let Some(&lmax) = rows.keys().next_back() else {
        return Err(layout_error(
            Place::Whole,
            format!("rows of l and {value_name}"),
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
    let name = layout.and_then(|columns| columns.name);
    Ok(Spectrum { rows: rows.into_values().collect(), name })
}

/// Returns the degree of a field, which `numpy.savetxt` writes as 2.000000000000000000e+00.
fn degree(text: &str) -> Option<usize> {
    /// Larger numbers are no degrees, and up to this one all whole numbers are exact.
    const MAX: f64 = 1e15;
    let l: f64 = text.parse().ok()?;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a whole number from 0 to 1e15"
    )]
    (l.fract() == 0.0 && (0.0..=MAX).contains(&l)).then_some(l as usize)
}

/// The positions of the numbers in a row.
#[derive(Clone, Copy)]
struct Columns {
    /// The number of fields.
    count: usize,
    /// Rows without degrees are those of degrees 0, 1, ...
    l: Option<usize>,
    value: usize,
    /// The name of the value in the header.
    name: Option<&'static str>,
    stderr: Option<usize>,
    realizations: Option<usize>,
}

impl Columns {
    fn of_header(line: TextLine<'_>, names: &[&'static str]) -> Option<Self> {
        let find = |wanted: &[&str]| {
            line.fields().position(|name| wanted.iter().any(|w| name.eq_ignore_ascii_case(w)))
        };
        let (value, name) = names.iter().find_map(|name| Some((find(&[name])?, *name)))?;
        Some(Self {
            count: line.fields().count(),
            l: Some(find(&["l"])?),
            value,
            name: Some(name),
            stderr: find(&["stderr"]),
            realizations: find(&["realizations"]),
        })
    }

    /// Returns the columns of lines with this number of fields; those after the third are ignored.
    fn without_header(count: usize, values_alone: bool) -> Option<Self> {
        let (l, value) = match count {
            1 if values_alone => (None, 0),
            0 | 1 => return None,
            _ => (Some(0), 1),
        };
        let stderr = (count > 2).then_some(2);
        Some(Self { count, l, value, name: None, stderr, realizations: None })
    }
}

#[cfg(test)]
mod tests {
    use super::{POWER, SpectrumRow, read_stream};

    fn read(text: &str) -> Result<Vec<SpectrumRow>, String> {
        let spectrum = read_stream(text.as_bytes(), "S", &POWER);
        spectrum.map(|spectrum| spectrum.rows).map_err(|error| error.to_string())
    }

    #[test]
    fn every_dialect_gives_the_same_rows() {
        let row = |l, value, stderr| SpectrumRow { l, value, stderr, realizations: 0 };
        let with_errors = vec![row(1, 0.5, 0.25), row(2, 1e-3, 0.0)];
        for text in [
            "1,0.5,0.25\n2,1e-3,0\n",
            "2 1e-3 0\n1 0.5 0.25",
            "1 0.5 0.25 9\n2 1e-3 0 9",
            "1.000e+00 5.0e-01 2.5e-01\n2.000e+00 1.0e-03 0.0e+00\n",
            "# power and l of a fit\n# l stderr power\n1 0.25 0.5\n2.0 0 1e-3\n",
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
            ("1.5 0.5", "S:1: l: expected a degree, got \"1.5\""),
            ("-1 0.5", "S:1: l: expected a degree, got \"-1\""),
            ("1e300 0.5", "S:1: l: expected a degree, got \"1e300\""),
            ("1 -0.5 9", "S:1: power: expected a finite number from 0, got \"-0.5\""),
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
