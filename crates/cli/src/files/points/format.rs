//! The formats of point sets and how a file tells which it is.

use std::path::Path;
use std::str::FromStr;

use crate::files::npy::MAGIC;

/// A format of point sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PointFormat {
    /// Text with commas or blanks.
    Csv,
    /// The array format of `NumPy`.
    Npy,
    /// The polygon format of Stanford.
    Ply,
}

impl PointFormat {
    /// The extensions that [`write_points`](super::write_points) knows, for messages.
    pub(super) const WRITABLE: &'static str = ".csv, .npy, .ply";

    /// Returns the format that the extension names, whatever its case.
    pub(crate) fn of_path(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "csv" | "txt" | "dat" | "tsv" | "xyz" => Some(Self::Csv),
            "npy" => Some(Self::Npy),
            "ply" => Some(Self::Ply),
            _ => None,
        }
    }

    /// Returns the format that the first bytes of a file show; text where they show nothing.
    pub(super) fn of_content(start: &[u8]) -> Self {
        if start.starts_with(MAGIC) {
            Self::Npy
        } else if start.starts_with(b"ply\n") || start.starts_with(b"ply\r") {
            Self::Ply
        } else {
            Self::Csv
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
