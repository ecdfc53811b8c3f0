//! The formats of point sets and their detection.

use std::path::Path;
use std::str::FromStr;

use crate::files::npy::MAGIC;

/// A format of point sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PointFormat {
    /// Text with commas, semicolons, tabs or spaces.
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

/// An unsupported format.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct OtherFormat {
    /// The first bytes of its files.
    magic: &'static [u8],
    pub(super) name: &'static str,
    /// Advice on how to obtain a supported file.
    pub(super) advice: &'static str,
}

const DECOMPRESS: &str = "decompress it first, or compress with gzip";

/// Formats that are recognized by their first bytes, to name them in errors.
const OTHERS: [OtherFormat; 13] = [
    other(
        b"PAR1",
        "Parquet",
        "convert it in Python: pandas.read_parquet(\"IN\").to_csv(\"OUT.csv\", index=False)",
    ),
    other(
        b"ARROW1",
        "Arrow (Feather)",
        "convert it in Python: pandas.read_feather(\"IN\").to_csv(\"OUT.csv\", index=False)",
    ),
    other(
        b"FEA1",
        "Feather",
        "convert it in Python: pandas.read_feather(\"IN\").to_csv(\"OUT.csv\", index=False)",
    ),
    other(
        b"\x89HDF",
        "HDF5",
        "convert it in Python: numpy.save(\"OUT.npy\", h5py.File(\"IN\")[\"NAME\"][()])",
    ),
    other(
        b"MATLAB 5.0 MAT-file",
        "a MATLAB file",
        "convert it in Python: numpy.save(\"OUT.npy\", scipy.io.loadmat(\"IN\")[\"NAME\"])",
    ),
    other(
        b"\x80\x04\x95",
        "a Python pickle",
        "save the array with numpy.save(\"OUT.npy\", array) instead",
    ),
    other(
        b"\x80\x05\x95",
        "a Python pickle",
        "save the array with numpy.save(\"OUT.npy\", array) instead",
    ),
    other(
        b"SQLite format 3",
        "SQLite",
        "convert it: sqlite3 -header -csv IN \"select * from NAME\" > OUT.csv",
    ),
    other(b"BZh", "bzip2", DECOMPRESS),
    other(b"\xfd7zXZ", "xz", DECOMPRESS),
    other(b"\x28\xb5\x2f\xfd", "zstd", DECOMPRESS),
    other(b"<?xml", "XML (VOTable?)", VOTABLE),
    other(b"<VOTABLE", "VOTable", VOTABLE),
];

const VOTABLE: &str = "convert a VOTable in Python: \
                       astropy.table.Table.read(\"IN\", format=\"votable\").write(\"OUT.fits\")";

const fn other(magic: &'static [u8], name: &'static str, advice: &'static str) -> OtherFormat {
    OtherFormat { magic, name, advice }
}

impl PointFormat {
    /// Every format.
    pub(crate) const ALL: [Self; 6] =
        [Self::Csv, Self::Npy, Self::Npz, Self::Ply, Self::Fits, Self::Json];

    /// Returns the extensions of its files, in lower case; outputs have the first.
    pub(crate) const fn extensions(self) -> &'static [&'static str] {
        match self {
            Self::Csv => &["csv", "txt", "dat", "tsv", "xyz"],
            Self::Npy => &["npy"],
            Self::Npz => &["npz"],
            Self::Ply => &["ply"],
            Self::Fits => &["fits", "fit", "fts"],
            Self::Json => &["json"],
        }
    }

    /// Returns whether points can be written in this format.
    pub(crate) const fn is_writable(self) -> bool {
        matches!(self, Self::Csv | Self::Npy | Self::Npz | Self::Ply)
    }

    /// The extensions of outputs of points, for messages: [`write_points`](super::write_points)
    /// supports the first ones; pictures of points are plots.
    pub(super) const WRITABLE: &'static str =
        ".csv, .npy, .npz, .ply (points), .svg, .png (a picture)";

    /// Returns the format of an extension in any case.
    pub(crate) fn of_path(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        let is_of = |format: &Self| format.extensions().contains(&extension.as_str());
        Self::ALL.into_iter().find(is_of)
    }

    /// Returns the format of an input's extension; that of a compressed file precedes `.gz`.
    pub(crate) fn of_input_path(path: &Path) -> Option<Self> {
        match path.extension() {
            Some(extension) if extension.eq_ignore_ascii_case("gz") => {
                Self::of_path(Path::new(path.file_stem()?))
            }
            _ => Self::of_path(path),
        }
    }

    /// Returns the format that the first bytes of a file indicate.
    ///
    /// # Errors
    ///
    /// An unsupported format.
    pub(super) fn of_content(start: &[u8]) -> Result<Option<Self>, &'static OtherFormat> {
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
            OTHERS.iter().find(|other| start.starts_with(other.magic)).map_or(Ok(None), Err)
        }
    }
}

impl FromStr for PointFormat {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.to_ascii_lowercase().as_str() {
            "csv" => Ok(Self::Csv),
            "npy" => Ok(Self::Npy),
            "npz" => Ok(Self::Npz),
            "ply" => Ok(Self::Ply),
            _ => Err(format!("expected csv, npy, npz or ply, got {text:?}")),
        }
    }
}
