//! Reading spectra and energies per degree from text files.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::BufRead;
use std::path::Path;

use super::file_error::input_name;
use super::input::open_input;
use super::text_rows::{TextLine, TextRows, shortened};
use super::{FileError, Place};
use sphvar_integrands::EnergyQuantity;

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
/// the columns (with or without quotes, in any case and order, possibly among others); without one
/// they are l, power, stderr in this order. Lines that start with `#` and empty lines are skipped.
///
/// # Errors
///
/// If the file cannot be read, a line has another number of fields than the first, a field
/// is not a number, a degree is duplicate or missing, or there are no rows.
pub(crate) fn read_spectrum(path: &Path) -> Result<Vec<SpectrumRow>, FileError> {
    let spectrum = read_stream(open_input(path)?, &input_name(path), &POWER)?;
    Ok(spectrum.rows)
}

/// Returns the energies `E(l)` of a text file with the columns `l` and `energy` (or `e`, `cl`,
/// `c_l`), from degree 0, which is 0 if the file starts at degree 1; otherwise as
/// [`read_spectrum`].
///
/// Values are those of `quantity`; unless given, of the name of their column, and energies without
/// a header.
///
/// # Errors
///
/// Those of [`read_spectrum`].
pub(crate) fn read_energies(
    path: &Path,
    quantity: Option<EnergyQuantity>,
) -> Result<Vec<f64>, FileError> {
    energies(open_input(path)?, &input_name(path), quantity)
}

fn energies(
    input: impl BufRead,
    path: &str,
    quantity: Option<EnergyQuantity>,
) -> Result<Vec<f64>, FileError> {
    let content = match quantity {
        None => &ANY_ENERGY,
        Some(EnergyQuantity::Energy) => &ENERGY,
        Some(EnergyQuantity::AngularPower) => &ANGULAR_POWER,
    };
    let Spectrum { rows, name } = read_stream(input, path, content)?;
    let of_header = name.is_some_and(|name| ANGULAR_POWER.names.contains(&name));
    let orders = |l: usize| match quantity {
        Some(EnergyQuantity::Energy) => 1.0,
        None if !of_header => 1.0,
        _ => (2 * l + 1) as f64,
    };
    // Only degree 0 may be absent.
    let mut energies = vec![0.0; rows.last().map_or(0, |row| row.l) + 1];
    for row in rows {
        energies[row.l] = row.value * orders(row.l);
    }
    Ok(energies)
}

/// The values of a kind of file and their names, in lower case.
struct Content {
    names: &'static [&'static str],
    /// The names in words.
    words: &'static str,
}

const POWER: Content = Content { names: &["power", "mean"], words: "power (or mean)" };
const ENERGY: Content = Content { names: &["energy", "e"], words: "energy (or e)" };
const ANGULAR_POWER: Content = Content { names: &["cl", "c_l"], words: "cl (or c_l)" };
const ANY_ENERGY: Content =
    Content { names: &["energy", "e", "cl", "c_l"], words: "energy (or e), or cl (or c_l)" };

/// The rows of a file and the name of the column of their values, if it has a header.
struct Spectrum {
    rows: Vec<SpectrumRow>,
    name: Option<&'static str>,
}

fn read_stream(input: impl BufRead, path: &str, content: &Content) -> Result<Spectrum, FileError> {
    let value_name = content.names[0];
    let layout_error = |place, expected: String, got: String| FileError::Layout {
        path: path.to_owned(),
        place,
        expected,
        got,
    };
    let mut lines = TextRows::new(input, path, "text in UTF-8 with a row for each degree");
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
                layout = Some(Columns::of_header(line, content.names).ok_or_else(|| {
                    let expected = format!("columns l and {}, and stderr", content.words);
                    layout_error(place, expected, format!("the header {}", shortened(line.text)))
                })?);
                continue;
            }
            None => *layout.insert(Columns::without_header(fields.len()).ok_or_else(|| {
                let expected =
                    format!("fields l, {value_name} and stderr, or a header that names them");
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
        let value = number(value_name, columns.value)?;
        // The spectrum of one given set has no error, so its field is empty.
        let stderr = columns.stderr.filter(|&column| !fields[column].is_empty());
        let stderr = stderr.map_or(Ok(0.0), |column| number("stderr", column))?;
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

/// The positions of the numbers in a row.
#[derive(Clone, Copy)]
struct Columns {
    /// The number of fields.
    count: usize,
    l: usize,
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
            l: find(&["l"])?,
            value,
            name: Some(name),
            stderr: find(&["stderr"]),
            realizations: find(&["realizations"]),
        })
    }

    /// Returns the columns of lines with this number of fields; those after the third are ignored.
    fn without_header(count: usize) -> Option<Self> {
        let stderr = (count > 2).then_some(2);
        (count >= 2).then_some(Self {
            count,
            l: 0,
            value: 1,
            name: None,
            stderr,
            realizations: None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{EnergyQuantity, POWER, SpectrumRow, energies, read_stream};

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

    #[test]
    fn energies_are_read_in_both_normalizations() {
        let read = |text: &str, quantity| {
            energies(text.as_bytes(), "S", quantity).map_err(|error| error.to_string())
        };
        let (energy, cl) = (Some(EnergyQuantity::Energy), Some(EnergyQuantity::AngularPower));
        for (text, quantity) in [
            ("1,3\n2,10\n", None),
            ("2 10\n1 3\n", energy),
            ("1,1\n2,2\n", cl),
            ("l,Energy\n1,3\n2,10\n", None),
            ("l,E\n1,3\n2,10\n", energy),
            ("l,cl\n1,1\n2,2\n", None),
            ("C_l l\n1 1\n2 2\n", cl),
            ("l,cl,energy\n1,1,3\n2,2,10\n", None),
            ("l,cl,energy\n1,1,9\n2,2,9\n", cl),
        ] {
            assert_eq!(read(text, quantity), Ok(vec![0.0, 3.0, 10.0]), "{text:?} {quantity:?}");
        }
        assert_eq!(read("0,2\n", None), Ok(vec![2.0]));
        for (text, quantity, message) in [
            ("l,energy\n", None, "S: expected rows of l and energy, got none"),
            (
                "l,power\n1,2\n",
                None,
                "S:1: expected columns l and energy (or e), or cl (or c_l), and stderr, got the header \
                 l,power",
            ),
            (
                "l,energy\n1,2\n",
                cl,
                "S:1: expected columns l and cl (or c_l), and stderr, got the header l,energy",
            ),
            ("1,1\n2,-1\n", None, "S:2: energy: expected a finite number from 0, got \"-1\""),
            ("1,inf\n", cl, "S:1: cl: expected a finite number from 0, got \"inf\""),
            ("1,1\n1,1\n", None, "S:2: l: expected each degree once, got \"1\""),
            ("0,1\n2,1\n", None, "S: expected every degree from 1 to 2, got none of degree 1"),
        ] {
            assert_eq!(read(text, quantity), Err(message.to_owned()), "{text:?}");
        }
    }
}
