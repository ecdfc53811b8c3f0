//! The flags for the source of point sets: a sampler, or files.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{OsStringValueParser, TypedValueParser};

use crate::counts::parse_count;
use crate::files::{ColumnChoice, HduChoice, OptionSpelling, ReadOptions};
use crate::flags::{CountArgs, DomainArgs, NearestArgs, SamplerArgs};

/// A sampler with its number of points, or files of points.
#[derive(Debug, Args)]
#[command(
    mut_arg("sampler", |arg| arg.required_unless_present("points_from").conflicts_with("points_from")),
    mut_arg("count", |arg| arg.conflicts_with("points_from")),
    mut_arg("nearest", |arg| arg.conflicts_with("points_from"))
)]
pub(crate) struct SetsArgs {
    #[command(flatten)]
    pub(crate) sampler: SamplerArgs,
    #[command(flatten)]
    pub(crate) count: CountArgs,
    #[command(flatten)]
    pub(crate) nearest: NearestArgs,
    #[command(flatten)]
    pub(crate) files: PointFileArgs,
    #[command(flatten)]
    pub(crate) domain: DomainArgs,
}

/// Files of points and how they are read.
#[derive(Debug, Args)]
pub(crate) struct PointFileArgs {
    /// Point files, each set in which is a realization: CSV or other text, .npy, .npz, .ply, FITS tables (file.fits[2] or file.fits[NAME] selects an HDU), each possibly gzipped; - is standard input
    #[arg(long = "points", num_args = 1.., value_name = "FILE", id = "points_from", value_parser = point_file())]
    pub(crate) files: Vec<PathBuf>,
    /// Columns of point files: roles by position, as in ra,dec,_,w (_ skips a column), or by name, as in ra=RAJ2000,dec=DEJ2000,w=WEIGHT. Roles: x,y,z; theta,phi (radians); u,v (the unit square, with --square); lon,lat or ra,dec or glon,glat or l,b (degrees); w (weight); set (label of the realization)
    #[arg(long, value_name = "ROLES", conflicts_with = "sampler")]
    pub(crate) columns: Option<ColumnChoice>,
    /// HDU of FITS files with the table: its number (0 is the primary one) or its name [default: the first table]
    #[arg(long, value_name = "HDU", conflicts_with = "sampler")]
    pub(crate) hdu: Option<HduChoice>,
    /// Join all point files into one set, such as a catalogue in parts
    #[arg(long, conflicts_with = "sampler")]
    pub(crate) join: bool,
    /// Skip rows with empty, infinite or invalid numbers and report their number
    #[arg(long, conflicts_with = "sampler")]
    pub(crate) skip_invalid: bool,
    /// Accept vectors x,y,z of any length and scale them to unit length; with --square, take coordinates modulo 1 (those in a box of another size must first be divided by it)
    #[arg(long, conflicts_with = "sampler")]
    pub(crate) normalize: bool,
}

/// Returns a parser of the names of point files. A bare number is taken for the number of points
/// that `--points` accepted in earlier versions.
fn point_file() -> impl TypedValueParser<Value = PathBuf> {
    OsStringValueParser::new().try_map(|name| {
        let path = PathBuf::from(name);
        if path.to_str().is_some_and(|text| parse_count(text).is_ok()) && !path.exists() {
            return Err("--points requires a file; use '-n' or '--count' for a number of points");
        }
        Ok(path)
    })
}

impl PointFileArgs {
    /// Returns the names of the files in one text.
    pub(crate) fn name(&self) -> String {
        let names: Vec<String> = self.files.iter().map(|p| p.display().to_string()).collect();
        names.join(" ")
    }

    /// Returns the options for reading the files.
    pub(crate) fn options(&self) -> ReadOptions {
        ReadOptions {
            columns: self.columns.clone(),
            hdu: self.hdu.clone().unwrap_or_default(),
            skip_invalid: self.skip_invalid,
            normalize: self.normalize,
            spelling: OptionSpelling::Flags,
            ..ReadOptions::default()
        }
    }
}
