//! Writes point sets as CSV, NPY, NPZ or PLY.

use std::io::{self, Write};
use std::path::Path;

use sphvar_samplers::PointSet;

use super::format::PointFormat;
use super::space::FilePoint;
use crate::files::array_archive::ArrayArchive;
use crate::files::atomic::AtomicFile;
use crate::files::file_error::{FileError, output_name};
use crate::files::npy::write_npy;
use crate::files::target::is_stream;

/// Writes point sets in the format of the extension; `-` is standard output, as CSV.
///
/// - `.csv`: the header `x,y,z`, or `u,v` on the square, with a column `w` if a set has weights, and a last column `set`
///   (counted from 0) for several sets. Every number has the shortest digits that are read back as
///   the same number, at most 17. The header is the first line, for readers that do not support
///   comments, so `provenance` is not stored.
/// - `.npy`: `(N, 3)` for one set, `(M, N, 3)` for several, or 2 instead of 3; 8-byte floats, little-endian, C order,
///   without weights. `provenance` is not stored either.
/// - `.npz`: the array of `.npy` as `points` and, if a set has weights, `(N,)` or `(M, N)` as
///   `weights`; uncompressed, without `provenance`.
/// - `.ply`: binary little-endian, vertices with doubles x y z, or u v, with a double `w` if a set has
///   weights and an int `set` for several sets, and `provenance` as comments.
///
/// If only some sets have weights, the points of others have weight 1. `format` overrides the
/// extension. The file appears when it is complete.
///
/// # Errors
///
/// If the extension is unknown, there are no sets, sets of different sizes or weights are written
/// to one array, or the file cannot be written.
pub(crate) fn write_points<P: FilePoint>(
    path: &Path,
    format: Option<PointFormat>,
    sets: &[PointSet<P>],
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
    let is_array = matches!(format, PointFormat::Npy | PointFormat::Npz);
    if is_array && sets.iter().any(|set| set.len() != first.len()) {
        return Err(FileError::InvalidTarget {
            path: name,
            reason: "the sets differ in size and do not fit one array (M, N, ...); write one file a set \
                     with {i} in the name, as in sets-{i}.npy, or .csv or .ply with the column set",
        });
    }
    let table = PointTable { sets, has_weights: sets.iter().any(|set| !set.weights.is_empty()) };
    if format == PointFormat::Npy && table.has_weights {
        return Err(FileError::InvalidTarget {
            path: name,
            reason: "an .npy array of points has no weights; write .npz, .csv or .ply",
        });
    }
    let mut file = AtomicFile::create(path)?;
    let written = match format {
        PointFormat::Csv => table.write_csv(&mut file),
        PointFormat::Npy => table.write_array(&mut file),
        PointFormat::Npz => table.write_archive(&mut file),
        _ => table.write_ply(&mut file, provenance),
    };
    written.map_err(|source| file.error(source))?;
    file.commit()
}

/// Sets to be written with the same columns.
struct PointTable<'a, P> {
    sets: &'a [PointSet<P>],
    has_weights: bool,
}

impl<P: FilePoint> PointTable<'_, P> {
    /// The number of coordinates of a point.
    const DIMENSION: u64 = (size_of::<P::Numbers>() / size_of::<f64>()) as u64;

    /// Returns the points of a set, each with its weight if there are any.
    fn rows<'s>(
        &self,
        set: &'s PointSet<P>,
    ) -> impl Iterator<Item = (P::Numbers, Option<f64>)> + use<'s, P> {
        let has_weights = self.has_weights;
        let weight = move |k| has_weights.then(|| set.weights.get(k).copied().unwrap_or(1.0));
        set.points.iter().enumerate().map(move |(k, p)| (p.numbers(), weight(k)))
    }

    fn write_csv(&self, out: &mut impl Write) -> io::Result<()> {
        let has_sets = self.sets.len() > 1;
        let weight = if self.has_weights { ",w" } else { "" };
        let set = if has_sets { ",set" } else { "" };
        writeln!(out, "{}{weight}{set}", P::SPACE.default_roles().join(","))?;
        for (index, set) in self.sets.iter().enumerate() {
            for (p, weight) in self.rows(set) {
                for (k, x) in p.into_iter().enumerate() {
                    write!(out, "{}{x:?}", if k > 0 { "," } else { "" })?;
                }
                if let Some(weight) = weight {
                    write!(out, ",{weight:?}")?;
                }
                if has_sets {
                    write!(out, ",{index}")?;
                }
                writeln!(out)?;
            }
        }
        Ok(())
    }

    /// Returns the shape of an array with a number for each point.
    fn shape(&self) -> Vec<u64> {
        let n_points = self.sets.first().map_or(0, PointSet::len) as u64;
        match self.sets.len() {
            1 => vec![n_points],
            several => vec![several as u64, n_points],
        }
    }

    fn write_array(&self, out: &mut impl Write) -> io::Result<()> {
        let shape = [self.shape(), vec![Self::DIMENSION]].concat();
        let numbers = self.sets.iter().flat_map(|set| &set.points).flat_map(FilePoint::numbers);
        write_npy(out, "<f8", &shape, numbers)
    }

    fn write_archive(&self, out: &mut impl Write) -> io::Result<()> {
        let numbers: u64 = self.sets.iter().map(|set| Self::DIMENSION * set.len() as u64).sum();
        let mut archive = ArrayArchive::new(numbers);
        self.write_array(archive.start("points")?)?;
        if self.has_weights {
            let weights = self.sets.iter().flat_map(|set| self.rows(set)).filter_map(|row| row.1);
            write_npy(archive.start("weights")?, "<f8", &self.shape(), weights)?;
        }
        archive.write(out)
    }

    fn write_ply(&self, out: &mut impl Write, provenance: Option<&str>) -> io::Result<()> {
        let count: usize = self.sets.iter().map(PointSet::len).sum();
        let several = self.sets.len() > 1;
        writeln!(out, "ply\nformat binary_little_endian 1.0")?;
        for line in comment_lines(provenance) {
            writeln!(out, "comment {line}")?;
        }
        writeln!(out, "element vertex {count}")?;
        for name in P::SPACE.default_roles() {
            writeln!(out, "property double {name}")?;
        }
        if self.has_weights {
            writeln!(out, "property double w")?;
        }
        if several {
            writeln!(out, "property int set")?;
        }
        writeln!(out, "end_header")?;
        for (index, set) in self.sets.iter().enumerate() {
            let label = i32::try_from(index)
                .map_err(|_| io::Error::other("more sets than the PLY type int can count"))?;
            for (point, weight) in self.rows(set) {
                for number in point.into_iter().chain(weight) {
                    out.write_all(&number.to_le_bytes())?;
                }
                if several {
                    out.write_all(&label.to_le_bytes())?;
                }
            }
        }
        Ok(())
    }
}

/// Returns the lines of the provenance without control characters, which would break a header.
fn comment_lines(provenance: Option<&str>) -> impl Iterator<Item = String> + '_ {
    provenance
        .unwrap_or_default()
        .lines()
        .filter(|line| !line.trim().is_empty())
        .map(|line| line.chars().map(|c| if c.is_control() { ' ' } else { c }).collect::<String>())
}
