//! Reading energies per degree from text files.

use std::io::BufRead;
use std::path::Path;

use sphvar_integrands::{EnergyEstimates, EnergyQuantity};

use super::file_error::input_name;
use super::input::open_input;
use super::spectra::{Content, Spectrum, SpectrumRow, read_stream};
use super::{FileError, Place};

/// Estimates of energies that are 0 are less than 0 by more than this number of standard errors
/// with a probability of 3e-7.
const MAX_BELOW: f64 = 5.0;
const ENERGY: Content = Content {
    names: &["energy", "e"],
    words: "energy (or e)",
    layout: "fields l, energy and stderr, or a header that names them",
    alone: true,
    max_below: MAX_BELOW,
};
const ANGULAR_POWER: Content = Content {
    names: &["cl", "c_l"],
    words: "cl (or c_l)",
    layout: "fields l, cl and stderr, or a header that names them",
    alone: true,
    max_below: MAX_BELOW,
};
/// A column of numbers alone could be either.
const ANY_ENERGY: Content = Content {
    names: &["energy", "e", "cl", "c_l"],
    words: "energy (or e), or cl (or c_l)",
    layout: "fields l, energy and stderr, or a header that names them (a column of energies or C_l alone needs \
             quantity=energy or cl)",
    alone: false,
    max_below: MAX_BELOW,
};

/// The energies of a file.
#[derive(Debug, PartialEq)]
pub(crate) struct EnergyFile {
    /// The energies, 0 instead of negative estimates, and their standard errors.
    pub(crate) energies: EnergyEstimates,
    /// The degrees whose estimates are negative.
    pub(crate) negative: Vec<usize>,
}

/// Returns the energies `E(l)` of a text file with the columns `l` and `energy` (or `e`, `cl`,
/// `c_l`), from degree 0, which is 0 if the file starts at degree 1; otherwise as
/// [`read_spectrum`](super::read_spectrum).
///
/// Values are those of `quantity`; unless given, of the name of their column, and energies without
/// a header. If `quantity` is given, a file without a header may have the values alone, from degree
/// 0, as numpy writes the arrays of healpy. Values with a standard error may be negative by up to
/// five of them, as estimates without noise are.
///
/// # Errors
///
/// Those of [`read_spectrum`](super::read_spectrum); FITS files.
pub(crate) fn read_energies(
    path: &Path,
    quantity: Option<EnergyQuantity>,
) -> Result<EnergyFile, FileError> {
    energies(open_input(path)?, &input_name(path), quantity)
}

fn energies(
    mut input: impl BufRead,
    path: &str,
    quantity: Option<EnergyQuantity>,
) -> Result<EnergyFile, FileError> {
    let start = input.fill_buf();
    let start = start.map_err(|source| FileError::Read { path: path.to_owned(), source })?;
    if start.starts_with(b"SIMPLE") {
        return Err(FileError::Layout {
            path: path.to_owned(),
            place: Place::Whole,
            expected: "text with columns l and energy or cl, or with quantity=cl the one that \
                       numpy.savetxt(\"cl.txt\", healpy.read_cl(FILE)) writes"
                .to_owned(),
            got: "a FITS file".to_owned(),
        });
    }
    let content = match quantity {
        None => &ANY_ENERGY,
        Some(EnergyQuantity::Energy) => &ENERGY,
        Some(EnergyQuantity::AngularPower) => &ANGULAR_POWER,
    };
    let Spectrum { rows, name } = read_stream(input, path, content)?;
    let of_header = name.is_some_and(|name| ANGULAR_POWER.names.contains(&name));
    let is_angular_power = match quantity {
        Some(quantity) => quantity == EnergyQuantity::AngularPower,
        None => of_header,
    };
    Ok(of_rows(rows, is_angular_power))
}

/// Returns energies, or `C_l` as `quantity` states, that a program gives by degree from 0 with
/// their standard errors, if they are known; `name` is for messages.
///
/// # Errors
///
/// If there are none, or one is invalid.
pub(crate) fn energies_of_array(
    name: &str,
    values: &[f64],
    errors: Option<&[f64]>,
    quantity: Option<EnergyQuantity>,
) -> Result<EnergyFile, FileError> {
    let is_angular_power = quantity == Some(EnergyQuantity::AngularPower);
    if values.is_empty() {
        return Err(FileError::Layout {
            path: name.to_owned(),
            place: Place::Whole,
            expected: "energies by degree from 0".to_owned(),
            got: "none".to_owned(),
        });
    }
    let row = |(l, &value): (usize, &f64)| {
        let stderr = errors.map_or(0.0, |errors| errors[l]);
        let wrong = |field: &str, expected: &str, got: f64| FileError::Value {
            path: name.to_owned(),
            place: Place::Row(l),
            field: field.to_owned(),
            expected: expected.to_owned(),
            got: got.to_string(),
        };
        if !(stderr.is_finite() && stderr >= 0.0) {
            return Err(wrong("stderr", "a finite number from 0", stderr));
        }
        if !(value.is_finite() && value >= -MAX_BELOW * stderr) {
            let field = if is_angular_power { "cl" } else { "energy" };
            let expected = match stderr {
                0.0 => "a finite number from 0".to_owned(),
                _ => format!("a finite number from 0, or less by at most {MAX_BELOW} times stderr"),
            };
            return Err(wrong(field, &expected, value));
        }
        Ok(SpectrumRow { l, value, stderr, realizations: 0 })
    };
    let rows: Result<Vec<SpectrumRow>, FileError> = values.iter().enumerate().map(row).collect();
    Ok(of_rows(rows?, is_angular_power))
}

/// Returns the energies of rows in the order of their degrees.
fn of_rows(rows: Vec<SpectrumRow>, is_angular_power: bool) -> EnergyFile {
    let orders = |l: usize| if is_angular_power { (2 * l + 1) as f64 } else { 1.0 };
    // Only degree 0 may be absent.
    let count = rows.last().map_or(0, |row| row.l) + 1;
    let (mut per_degree, mut stderr) = (vec![0.0; count], vec![0.0; count]);
    let mut negative = vec![];
    for row in rows {
        if row.value < 0.0 {
            negative.push(row.l);
        }
        per_degree[row.l] = row.value.max(0.0) * orders(row.l);
        stderr[row.l] = row.stderr * orders(row.l);
    }
    EnergyFile { energies: EnergyEstimates { per_degree, stderr }, negative }
}

#[cfg(test)]
mod tests {
    use super::{EnergyQuantity, energies};

    const ENERGY: Option<EnergyQuantity> = Some(EnergyQuantity::Energy);
    const CL: Option<EnergyQuantity> = Some(EnergyQuantity::AngularPower);

    #[test]
    fn energies_are_read_in_both_normalizations() {
        let read = |text: &str, quantity| {
            let file = energies(text.as_bytes(), "S", quantity);
            file.map(|file| file.energies.per_degree).map_err(|error| error.to_string())
        };
        for (text, quantity) in [
            ("1,3\n2,10\n", None),
            ("2 10\n1 3\n", ENERGY),
            ("1,1\n2,2\n", CL),
            ("l,Energy\n1,3\n2,10\n", None),
            ("l,E\n1,3\n2,10\n", ENERGY),
            ("l,cl\n1,1\n2,2\n", None),
            ("C_l l\n1 1\n2 2\n", CL),
            ("l,cl,energy\n1,1,3\n2,2,10\n", None),
            ("l,cl,energy\n1,1,9\n2,2,9\n", CL),
            ("# l cl\n1.0 1.0\n2.0 2.0\n", None),
            ("l cl\n1.000000e+00 1.000000e+00\n2.000000e+00 2.000000e+00\n", None),
            ("# C_l of a map\n0.0e+00\n1.0e+00\n2.0e+00\n", CL),
            ("0\n3\n10\n", ENERGY),
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
                CL,
                "S:1: expected columns l and cl (or c_l), and stderr, got the header l,energy",
            ),
            ("1,1\n2,-1\n", None, "S:2: energy: expected a finite number from 0, got \"-1\""),
            ("1,inf\n", CL, "S:1: cl: expected a finite number from 0, got \"inf\""),
            ("1,1\n1,1\n", None, "S:2: l: expected each degree once, got \"1\""),
            ("0,1\n2,1\n", None, "S: expected every degree from 1 to 2, got none of degree 1"),
            (
                "1\n2\n",
                None,
                "S:1: expected fields l, energy and stderr, or a header that names them (a column \
                 of energies or C_l alone needs quantity=energy or cl), got 1 without a header",
            ),
            (
                "SIMPLE  =                    T",
                CL,
                "S: expected text with columns l and energy or cl, or with quantity=cl the one that \
                 numpy.savetxt(\"cl.txt\", healpy.read_cl(FILE)) writes, got a FITS file",
            ),
        ] {
            assert_eq!(read(text, quantity), Err(message.to_owned()), "{text:?}");
        }
    }

    #[test]
    fn estimates_may_be_negative_by_noise() {
        let file = energies("l,cl,stderr\n1,-0.9,0.2\n2,2,0.1\n".as_bytes(), "S", None).unwrap();
        assert_eq!(file.energies.per_degree, [0.0, 0.0, 10.0]);
        let stderr = [0.0, 3.0 * 0.2, 0.5];
        assert!(file.energies.stderr.iter().zip(stderr).all(|(a, b)| (a - b).abs() < 1e-15));
        assert_eq!(file.negative, [1]);
        let error = energies("l,cl,stderr\n1,-1.1,0.2\n".as_bytes(), "S", None).unwrap_err();
        let message = "S:2: energy: expected a finite number from 0, or less by at most 5 times \
                       stderr, got \"-1.1\"";
        assert_eq!(error.to_string(), message);
    }
}
