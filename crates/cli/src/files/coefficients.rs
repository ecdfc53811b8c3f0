//! Writes harmonic coefficients in the formats of healpy.

use std::io::{self, Write};
use std::path::Path;

use sphvar_sh::Alm;

use super::atomic::AtomicFile;
use super::file_error::FileError;
use super::npy::write_npy;

/// The length of a block of a FITS file and of a line of its headers, in bytes.
const BLOCK: usize = 2880;
const CARD: usize = 80;
/// The length of a row of the table of coefficients, in bytes.
const ROW: usize = 20;

/// A format of harmonic coefficients.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum CoefficientFormat {
    /// The complex array of `healpy.map2alm`, `i = m (2 lmax + 1 - m)/2 + l`.
    Npy,
    /// The table of `healpy.write_alm`.
    Fits,
}

impl CoefficientFormat {
    /// Returns the format of an extension in any case.
    pub(crate) fn of_path(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "npy" => Some(Self::Npy),
            "fits" => Some(Self::Fits),
            _ => None,
        }
    }
}

/// Writes coefficients of a real function, m >= 0.
///
/// # Errors
///
/// When the file cannot be written.
pub(crate) fn write_coefficients(
    path: &Path,
    format: CoefficientFormat,
    alm: &Alm,
) -> Result<(), FileError> {
    let mut file = AtomicFile::create(path)?;
    let written = match format {
        CoefficientFormat::Npy => {
            let shape = [alm.values().len() as u64];
            write_npy(&mut file, "<c16", &shape, alm.values().iter().copied())
        }
        CoefficientFormat::Fits => write_fits(&mut file, alm),
    };
    written.map_err(|source| file.error(source))?;
    file.commit()
}

/// Writes a FITS file with a table of index, `l^2 + l + m + 1`, real and imaginary part.
fn write_fits(out: &mut impl Write, alm: &Alm) -> io::Result<()> {
    let primary = [
        ("SIMPLE", "T".to_owned()),
        ("BITPIX", "8".to_owned()),
        ("NAXIS", "0".to_owned()),
        ("EXTEND", "T".to_owned()),
    ];
    out.write_all(&header(&primary))?;
    let text = |text: &str| format!("'{text:<8}'");
    let table = [
        ("XTENSION", text("BINTABLE")),
        ("BITPIX", "8".to_owned()),
        ("NAXIS", "2".to_owned()),
        ("NAXIS1", ROW.to_string()),
        ("NAXIS2", alm.values().len().to_string()),
        ("PCOUNT", "0".to_owned()),
        ("GCOUNT", "1".to_owned()),
        ("TFIELDS", "3".to_owned()),
        ("TTYPE1", text("index")),
        ("TFORM1", text("1J")),
        ("TTYPE2", text("real")),
        ("TFORM2", text("1D")),
        ("TTYPE3", text("imag")),
        ("TFORM3", text("1D")),
    ];
    out.write_all(&header(&table))?;
    let index = alm.index().iter().zip(alm.values());
    for ((l, m), a) in index {
        let number = i32::try_from(l * l + l + m + 1).map_err(io::Error::other)?;
        out.write_all(&number.to_be_bytes())?;
        out.write_all(&a.re.to_be_bytes())?;
        out.write_all(&a.im.to_be_bytes())?;
    }
    let bytes = alm.values().len() * ROW;
    out.write_all(&vec![0; bytes.next_multiple_of(BLOCK) - bytes])
}

/// Returns a header of these keywords, in whole blocks.
fn header(keywords: &[(&str, String)]) -> Vec<u8> {
    let mut text = String::new();
    for (keyword, value) in keywords {
        let card = format!("{keyword:<8}= {value:>20}");
        text += &format!("{card:<CARD$}");
    }
    text += &format!("{:<CARD$}", "END");
    let mut bytes = text.into_bytes();
    bytes.resize(bytes.len().next_multiple_of(BLOCK), b' ');
    bytes
}
