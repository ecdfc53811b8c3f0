//! The formats of point sets and how a file tells which it is.

use std::path::Path;
use std::str::FromStr;

use crate::files::npy::MAGIC;

/// A format of point sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PointFormat {
    /// Text with commas, semicolons, tabs or blanks.
    Csv,
    /// The array format of `NumPy`.
    Npy,
    /// An archive of arrays of `NumPy`.
    Npz,
    /// The polygon format of Stanford.
    Ply,
    /// Tables of FITS files.
    Fits,
    /// The document of `sphvar sample --json`.
    Json,
}

/// Formats that are told by how they start, to name them in errors.
const OTHERS: [(&[u8], &str); 9] = [
    (b"PAR1", "Parquet"),
    (b"\x89HDF", "HDF5"),
    (b"ARROW1", "Arrow"),
    (b"SQLite format 3", "SQLite"),
    (b"BZh", "bzip2"),
    (b"\xfd7zXZ", "xz"),
    (b"\x28\xb5\x2f\xfd", "zstd"),
    (b"<?xml", "XML (VOTable?)"),
    (b"<VOTABLE", "VOTable"),
];

impl PointFormat {
    /// The extensions of outputs of points, for messages: [`write_points`](super::write_points) knows the first ones,
    /// pictures of points are plots.
    pub(super) const WRITABLE: &'static str = ".csv, .npy, .ply (points), .svg, .png (a picture)";

    /// Returns the format that the extension names, whatever its case.
    pub(crate) fn of_path(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "csv" | "txt" | "dat" | "tsv" | "xyz" => Some(Self::Csv),
            "npy" => Some(Self::Npy),
            "npz" => Some(Self::Npz),
            "ply" => Some(Self::Ply),
            "json" => Some(Self::Json),
            "fits" | "fit" | "fts" => Some(Self::Fits),
            _ => None,
        }
    }

    /// Returns the format that the extension of an input names; that of a compressed file is before
    /// `.gz`.
    pub(crate) fn of_input_path(path: &Path) -> Option<Self> {
        match path.extension() {
            Some(extension) if extension.eq_ignore_ascii_case("gz") => {
                Self::of_path(Path::new(path.file_stem()?))
            }
            _ => Self::of_path(path),
        }
    }

    /// Returns the format that the first bytes of a file show.
    ///
    /// # Errors
    /// The name of a format that is not supported.
    pub(super) fn of_content(start: &[u8]) -> Result<Option<Self>, &'static str> {
        if start.starts_with(MAGIC) {
            Ok(Some(Self::Npy))
        } else if start.starts_with(b"ply\n") || start.starts_with(b"ply\r") {
            Ok(Some(Self::Ply))
        } else if start.starts_with(b"SIMPLE  =") {
            Ok(Some(Self::Fits))
        } else if start.starts_with(b"PK\x03\x04") || start.starts_with(b"PK\x05\x06") {
            Ok(Some(Self::Npz))
        } else if start.starts_with(b"{\"") {
            Ok(Some(Self::Json))
        } else {
            match OTHERS.iter().find(|(magic, _)| start.starts_with(magic)) {
                Some((_, name)) => Err(name),
                None => Ok(None),
            }
        }
    }
}

impl FromStr for PointFormat {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.to_ascii_lowercase().as_str() {
            "csv" => Ok(Self::Csv),
            "npy" => Ok(Self::Npy),
            "ply" => Ok(Self::Ply),
            _ => Err(format!("expected csv, npy or ply, got {text:?}")),
        }
    }
}
