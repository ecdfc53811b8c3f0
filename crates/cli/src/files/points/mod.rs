//! Point sets in files: CSV and other text, NPY, NPZ, PLY, FITS tables, and our own JSON.

mod angles;
mod array;
mod assignment;
mod blocks;
mod collector;
mod column;
mod columns;
mod fits;
mod format;
mod json;
mod lengths;
mod npy;
mod npz;
mod ply;
mod roles;
mod space;
mod spelling;
mod suggestion;
mod tally;
mod text;
mod write;

#[cfg(test)]
mod tests;

use std::fs::{self, File};
use std::io::{BufRead, BufReader, Cursor};
use std::path::Path;

use glam::DVec3;
use sphvar_samplers::PointSet;

use super::file_error::{FileError, Place, input_name, is_dash};
use super::fits::HduChoice;
use super::input::{Input, open_input, read_rest};

pub(crate) use array::points_of_array;
use blocks::BlockWriter;
pub(crate) use blocks::{Block, BlockStream, BlockedFiles, FileSurvey, survey};
pub(crate) use format::PointFormat;
pub(crate) use roles::ColumnChoice;
pub(crate) use space::{FilePoint, Space};
pub(crate) use spelling::OptionSpelling;
pub(crate) use tally::RowTally;
pub(crate) use write::write_points;

/// The content of a file: at least one set, each with at least one point.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct PointFile<P = DVec3> {
    /// The sets in the order of their first appearance: unit vectors, or points in [0, 1)^2, in the
    /// order of the file, and finite weights of any sign if the file has a column `w` or `weight`.
    pub(crate) sets: Vec<PointSet<P>>,
    /// The values of the points in the order of the file, if [`ReadOptions::values`] requests them.
    pub(crate) values: Vec<f64>,
    /// The column of the weights: `w`, or `sigma` for their inverse squares; `None` without
    /// weights.
    pub(crate) weight_role: Option<&'static str>,
    /// Where each set begins.
    pub(crate) starts: Vec<Place>,
    /// Where the first point is that the hemisphere does not have, for messages.
    pub(crate) first_below: Option<String>,
    /// Warnings about accepted but unusual content.
    pub(crate) warnings: Vec<String>,
    /// Remarks on further content of the file.
    pub(crate) remarks: Vec<String>,
}

/// Options for reading a file that its content does not determine.
#[derive(Debug, Clone, Default)]
pub(crate) struct ReadOptions {
    /// The space of the points; [`read_points`] sets it to that of its points.
    pub(crate) space: Space,
    /// The format; `None` takes it from the first bytes or, if these are inconclusive, from the
    /// extension.
    pub(crate) format: Option<PointFormat>,
    /// The option `--columns`.
    pub(crate) columns: Option<ColumnChoice>,
    /// The table of a FITS file.
    pub(crate) hdu: HduChoice,
    /// Whether rows without a direction or with an invalid weight are skipped.
    pub(crate) skip_invalid: bool,
    /// Whether vectors may have any length; on the square, whether coordinates are taken modulo 1.
    pub(crate) normalize: bool,
    /// How messages write these options.
    pub(crate) spelling: OptionSpelling,
    /// Whether each point has a value, in the column `value`, and possibly its standard error
    /// `sigma`, whose inverse square is the weight.
    pub(crate) values: bool,
}

/// Returns the point sets of a file; the path `-` is standard input. Files may be compressed with
/// gzip.
///
/// Every format is a table: text, the last dimension of an NPY array or the fields of its records,
/// the arrays of an NPZ file, the properties of the vertices of a PLY file, the columns of a FITS
/// table. A direction is `x,y,z`, or `theta,phi` (colatitude and longitude in radians), or
/// `lon,lat`, `ra,dec`, `glon,glat` or `l,b` (degrees); `w` is its weight, and `set` the label of
/// its set. A point of the square is `u,v` or `x,y` in [0, 1). Names in catalogues such as `RAJ2000` and `ALPHA_J2000` are recognized;
/// [`ReadOptions::columns`] supports others. Of several celestial systems in a catalogue `ra,dec`
/// is taken, and `glon,glat` before `l,b`; other pairs of directions are an error.
///
/// In text `#` starts a comment line. Without a header three fields are x y z, on the square two are
/// u v, and a line that is a bare `#` starts the next set. The other dimensions of an array are `(N,)` or `(M, N)`.
///
/// Vectors are scaled to unit length; a warning is returned where that moved a length by more than
/// 1e-6. Vectors that are unit to rounding keep their bits.
///
/// # Errors
///
/// If the file cannot be read, contains no points, or contains anything else than the
/// above, if most vectors are far from unit length, or if the points do not fit in memory; the
/// message names the file, the line (or row, or vertex), the field, and the expected content.
pub(crate) fn read_points<P: FilePoint>(
    path: &Path,
    options: &ReadOptions,
) -> Result<PointFile<P>, FileError> {
    read_for(path, options, Purpose::Keep)
}

/// What is done with the rows of a file.
enum Purpose<'a, P> {
    /// They are kept.
    Keep,
    /// They are counted.
    Count(&'a mut FileSurvey),
    /// Some of them are divided into blocks.
    Blocks(&'a mut BlockWriter<P>),
}

/// Reads a file as [`read_points`] does, for a purpose.
fn read_for<P: FilePoint>(
    path: &Path,
    options: &ReadOptions,
    purpose: Purpose<'_, P>,
) -> Result<PointFile<P>, FileError> {
    let (file, hdu) = HduChoice::of_path(path);
    let hdu = if hdu == HduChoice::First { options.hdu.clone() } else { hdu };
    let options = &ReadOptions { space: P::SPACE, hdu, ..options.clone() };
    let input = open_input(&file)?;
    let bytes = if is_dash(&file) { None } else { fs::metadata(&file).ok().map(|m| m.len()) };
    read_stream(input, &file, bytes, options, purpose)
}

fn read_stream<P: FilePoint>(
    mut input: Input,
    file: &Path,
    bytes: Option<u64>,
    options: &ReadOptions,
    purpose: Purpose<'_, P>,
) -> Result<PointFile<P>, FileError> {
    let name = input_name(file);
    let start =
        input.fill_buf().map_err(|source| FileError::Read { path: name.clone(), source })?;
    let shown = PointFormat::of_content(start).map_err(|format| FileError::Layout {
        path: name.clone(),
        place: Place::Whole,
        expected: "points as CSV or other text, NPY, NPZ, PLY or a FITS table".to_owned(),
        got: format!("{}, which is not supported; {}", format.name, format.advice),
    })?;
    let format = options.format.or(shown).or_else(|| PointFormat::of_input_path(file));
    let format = format.unwrap_or(PointFormat::Csv);
    if options.hdu != HduChoice::First && format != PointFormat::Fits {
        return Err(FileError::Layout {
            path: name,
            place: Place::Whole,
            expected: format!("a FITS file with {}", options.hdu),
            got: "another format".to_owned(),
        });
    }
    match format {
        PointFormat::Csv => text::read_text(input, &name, options, purpose),
        PointFormat::Npy => npy::read_npy(input, &name, options, bytes, purpose),
        PointFormat::Ply => ply::read_ply(input, &name, options, bytes, purpose),
        PointFormat::Json => json::read_json(input, &name, options, purpose),
        PointFormat::Fits => fits::read_fits(input, &name, options, bytes, purpose),
        PointFormat::Npz => {
            // An archive is read from its end. A plain file need not be stored.
            let is_plain = !is_dash(file) && plain_archive(file);
            match File::open(file) {
                Ok(file) if is_plain => {
                    npz::read_npz(BufReader::new(file), &name, options, purpose)
                }
                _ => npz::read_npz(Cursor::new(read_rest(input, &name)?), &name, options, purpose),
            }
        }
    }
}

/// Returns whether a file starts like a zip archive that is not itself compressed.
fn plain_archive(file: &Path) -> bool {
    let mut start = [0; 2];
    fs::metadata(file).is_ok_and(|m| m.is_file())
        && File::open(file).is_ok_and(|mut f| std::io::Read::read_exact(&mut f, &mut start).is_ok())
        && &start == b"PK"
}
