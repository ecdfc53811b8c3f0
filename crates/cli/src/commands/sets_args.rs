//! The flags that say where point sets come from: a sampler, or files.

use std::path::PathBuf;

use clap::Args;

use crate::counts::parse_count;
use crate::files::{ColumnChoice, HduChoice, ReadOptions};

/// A sampler with its number of points, or files of points.
#[derive(Debug, Args)]
pub(crate) struct SetsArgs {
    /// The sampler
    #[arg(required_unless_present = "points_from", conflicts_with = "points_from")]
    pub(crate) sampler: Option<String>,
    #[command(flatten)]
    pub(crate) files: PointFileArgs,
    /// Number of points
    #[arg(
        short = 'n',
        long = "n-points",
        value_name = "N",
        value_parser = parse_count,
        required_unless_present = "points_from",
        conflicts_with = "points_from"
    )]
    pub(crate) n: Option<usize>,
    /// Points on the hemisphere z >= 0; only even degrees exist
    #[arg(long)]
    pub(crate) hemisphere: bool,
    /// Take the nearest number of points that the pattern has
    #[arg(long, conflicts_with = "points_from")]
    pub(crate) nearest: bool,
}

/// Files of points and how they are read.
#[derive(Debug, Args)]
pub(crate) struct PointFileArgs {
    /// Read points from these files: CSV or other text, .npy, .npz, .ply, FITS tables (file.fits[2] or
    /// file.fits[NAME] selects an HDU), each possibly gzipped; - is standard input. Each set in them
    /// is a realization
    #[arg(long = "points", num_args = 1.., value_name = "FILE", id = "points_from")]
    pub(crate) files: Vec<PathBuf>,
    /// Columns of point files: roles by position, as in ra,dec,_,w (_ skips a column), or by name,
    /// as in ra=RAJ2000,dec=DEJ2000,w=WEIGHT. Roles: x,y,z; theta,phi (radians); lon,lat or ra,dec or
    /// glon,glat or l,b (degrees); w (weight); set (label of the realization)
    #[arg(long, value_name = "ROLES", conflicts_with = "sampler")]
    pub(crate) columns: Option<ColumnChoice>,
    /// HDU of FITS files with the table: its number (0 is the primary one) or its name [default: the
    /// first table]
    #[arg(long, value_name = "HDU", conflicts_with = "sampler")]
    pub(crate) hdu: Option<HduChoice>,
    /// Join all point files into one set, such as a catalogue in parts
    #[arg(long, conflicts_with = "sampler")]
    pub(crate) join: bool,
    /// Skip rows with empty, infinite or invalid numbers and report how many they were
    #[arg(long, conflicts_with = "sampler")]
    pub(crate) skip_invalid: bool,
    /// Accept vectors x,y,z of any length and scale them to unit length
    #[arg(long, conflicts_with = "sampler")]
    pub(crate) normalize: bool,
}

impl PointFileArgs {
    /// Returns how the files are read.
    pub(crate) fn options(&self) -> ReadOptions {
        ReadOptions {
            format: None,
            columns: self.columns.clone(),
            hdu: self.hdu.clone().unwrap_or_default(),
            skip_invalid: self.skip_invalid,
            normalize: self.normalize,
        }
    }
}
