//! The flags that say where point sets come from: a sampler, or files.

use std::path::PathBuf;

use clap::Args;

use crate::counts::parse_count;

/// A sampler with its number of points, or files of points.
#[derive(Debug, Args)]
pub(crate) struct SetsArgs {
    /// The sampler
    #[arg(required_unless_present = "points_from", conflicts_with = "points_from")]
    pub(crate) sampler: Option<String>,
    /// Read points from these files (.csv, .npy, .ply; - is standard input); each set in them is a
    /// realization
    #[arg(long = "points", num_args = 1.., value_name = "FILE", id = "points_from")]
    pub(crate) files: Vec<PathBuf>,
    /// Number of points
    #[arg(
        short = 'n',
        long = "n-points",
        value_name = "N",
        value_parser = parse_count,
        required_unless_present = "points_from"
    )]
    pub(crate) n: Option<usize>,
    /// Points on the hemisphere z >= 0; only even degrees exist
    #[arg(long)]
    pub(crate) hemisphere: bool,
    /// Take the nearest number of points that the pattern has
    #[arg(long)]
    pub(crate) nearest: bool,
    /// Names of the columns in point files without a header, or to choose among those of a header
    #[arg(long, value_delimiter = ',', value_name = "NAMES")]
    pub(crate) columns: Option<Vec<String>>,
}
