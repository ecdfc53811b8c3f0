//! Point sets in files: CSV and other text, NPY, PLY.

mod angles;
mod collector;
mod columns;
mod format;
mod npy;
mod ply;
mod text;
mod write;

#[cfg(test)]
mod tests;

use std::io::BufRead;
use std::path::Path;

use glam::DVec3;

use super::file_error::{FileError, input_name};
use super::input::open_input;

pub(crate) use format::PointFormat;
pub(crate) use write::write_points;

/// One set of directions, with what the file said about each of them.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct PointSet {
    /// Unit vectors, in the order of the file.
    pub(crate) directions: Vec<DVec3>,
    /// The column `w` or `weight`, where the file has one; finite, of any sign.
    pub(crate) weights: Option<Vec<f64>>,
    /// The column `value`, where the file has one; finite.
    pub(crate) values: Option<Vec<f64>>,
}

/// What a file holds: at least one set, each with at least one direction.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PointFile {
    /// The sets in the order of their first appearance.
    pub(crate) sets: Vec<PointSet>,
    /// Lines for the user about what was accepted but looks odd.
    pub(crate) warnings: Vec<String>,
}

/// How to read a file where the file itself leaves it open.
#[derive(Debug, Clone, Default)]
pub(crate) struct ReadOptions {
    /// The format; `None` takes it from the extension, and where that says nothing from the
    /// first bytes.
    pub(crate) format: Option<PointFormat>,
    /// The names of the option `--columns`. In a file with a header they choose among its columns;
    /// in a file without one they name the fields from left to right (any other name skips one).
    pub(crate) columns: Option<Vec<String>>,
}

/// Returns the point sets of a file; the path `-` is standard input.
///
/// Text has a header with `x,y,z`, or `theta,phi` (colatitude and longitude in radians), or
/// `lon,lat` or `ra,dec` (degrees), and optionally `w` or `weight`, `value`, `set`; other columns
/// are skipped. Fields are divided by commas or by blanks; `#` starts a comment line. Without a
/// header three fields are x y z, and a line that is a bare `#` starts the next set. NPY is
/// `(N, 3)` or `(M, N, 3)` of 4 or 8 byte floats. PLY has the vertex properties x y z.
///
/// Vectors are scaled to unit length; a warning is returned where that moved a length by more than
/// 1e-6. Vectors that are unit to rounding keep their bits.
///
/// # Errors
/// When the file cannot be read, holds no point, or holds something else than the above; the
/// message names the file, the line (or row, or vertex), the field, and what would be right.
pub(crate) fn read_points(path: &Path, options: &ReadOptions) -> Result<PointFile, FileError> {
    let input = open_input(path)?;
    let format = options.format.or_else(|| PointFormat::of_path(path));
    read_stream(input, &input_name(path), format, options)
}

fn read_stream(
    mut input: impl BufRead,
    path: &str,
    format: Option<PointFormat>,
    options: &ReadOptions,
) -> Result<PointFile, FileError> {
    let format = match format {
        Some(format) => format,
        None => {
            let start = input
                .fill_buf()
                .map_err(|source| FileError::Read { path: path.to_owned(), source })?;
            PointFormat::of_content(start)
        }
    };
    match format {
        PointFormat::Csv => text::read_text(input, path, options.columns.as_deref()),
        PointFormat::Npy => npy::read_npy(input, path),
        PointFormat::Ply => ply::read_ply(input, path),
    }
}
