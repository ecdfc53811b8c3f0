//! Writes point sets as CSV, NPY or PLY.

use std::io::{self, Write};
use std::path::Path;

use glam::DVec3;

use super::format::PointFormat;
use crate::files::atomic::AtomicFile;
use crate::files::file_error::{FileError, output_name};
use crate::files::npy::write_npy;
use crate::files::target::is_stream;

/// Writes point sets in the format of the extension; `-` is standard output, as CSV.
///
/// - `.csv`: the header `x,y,z`, with a fourth column `set` (counted from 0) for several sets.
///   Every number has the shortest digits that are read back as the same number, at most 17. The
///   header is the first line, for readers that do not support comments, so `provenance` is not
///   stored.
/// - `.npy`: `(N, 3)` for one set, `(M, N, 3)` for several; 8-byte floats, little-endian, C order.
///   `provenance` is not stored either.
/// - `.ply`: binary little-endian, vertices with doubles x y z, with an int `set` for several sets,
///   and `provenance` as comments.
///
/// `format` overrides the extension. The file appears when it is complete.
///
/// # Errors
///
/// If the extension is unknown, there are no sets, sets of different sizes are written to one
/// array, or the file cannot be written.
pub(crate) fn write_points(
    path: &Path,
    format: Option<PointFormat>,
    sets: &[Vec<DVec3>],
    provenance: Option<&str>,
) -> Result<(), FileError> {
    let name = output_name(path);
    let format = match format.or_else(|| PointFormat::of_path(path)) {
        Some(format) if format.is_writable() => format,
        None if is_stream(path) => PointFormat::Csv,
        _ => {
            return Err(FileError::UnknownExtension { path: name, known: PointFormat::WRITABLE });
        }
    };
    let Some(first) = sets.first() else {
        return Err(FileError::InvalidTarget {
            path: name,
            reason: "there is no set of points to write",
        });
    };
    if format == PointFormat::Npy && sets.iter().any(|set| set.len() != first.len()) {
        return Err(FileError::InvalidTarget {
            path: name,
            reason: "the sets differ in size and do not fit one (M, N, 3) array; write one file a set \
                     with {i} in the name, as in sets-{i}.npy, or .csv or .ply with the column set",
        });
    }
    let mut file = AtomicFile::create(path)?;
    let written = match format {
        PointFormat::Csv => write_csv(&mut file, sets),
        PointFormat::Npy => write_array(&mut file, sets, first.len()),
        _ => write_ply(&mut file, sets, provenance),
    };
    written.map_err(|source| file.error(source))?;
    file.commit()
}

fn write_csv(out: &mut impl Write, sets: &[Vec<DVec3>]) -> io::Result<()> {
    if let [set] = sets {
        writeln!(out, "x,y,z")?;
        for p in set {
            writeln!(out, "{:?},{:?},{:?}", p.x, p.y, p.z)?;
        }
        return Ok(());
    }
    writeln!(out, "x,y,z,set")?;
    for (index, set) in sets.iter().enumerate() {
        for p in set {
            writeln!(out, "{:?},{:?},{:?},{index}", p.x, p.y, p.z)?;
        }
    }
    Ok(())
}

fn write_array(out: &mut impl Write, sets: &[Vec<DVec3>], points: usize) -> io::Result<()> {
    let (sets_u64, points_u64) = (sets.len() as u64, points as u64);
    let shape = match sets.len() {
        1 => vec![points_u64, 3],
        _ => vec![sets_u64, points_u64, 3],
    };
    write_npy(out, "<f8", &shape, sets.iter().flatten().flat_map(DVec3::to_array))
}

fn write_ply(
    out: &mut impl Write,
    sets: &[Vec<DVec3>],
    provenance: Option<&str>,
) -> io::Result<()> {
    let count: usize = sets.iter().map(Vec::len).sum();
    let several = sets.len() > 1;
    writeln!(out, "ply\nformat binary_little_endian 1.0")?;
    for line in comment_lines(provenance) {
        writeln!(out, "comment {line}")?;
    }
    writeln!(out, "element vertex {count}")?;
    writeln!(out, "property double x\nproperty double y\nproperty double z")?;
    if several {
        writeln!(out, "property int set")?;
    }
    writeln!(out, "end_header")?;
    for (index, set) in sets.iter().enumerate() {
        let label = i32::try_from(index)
            .map_err(|_| io::Error::other("more sets than the PLY type int can count"))?;
        for coordinate_row in set {
            for coordinate in coordinate_row.to_array() {
                out.write_all(&coordinate.to_le_bytes())?;
            }
            if several {
                out.write_all(&label.to_le_bytes())?;
            }
        }
    }
    Ok(())
}

/// Returns the lines of the provenance without control characters, which would break a header.
fn comment_lines(provenance: Option<&str>) -> impl Iterator<Item = String> + '_ {
    provenance
        .unwrap_or_default()
        .lines()
        .filter(|line| !line.trim().is_empty())
        .map(|line| line.chars().map(|c| if c.is_control() { ' ' } else { c }).collect::<String>())
}
