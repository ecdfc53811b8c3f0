//! The subcommands, one file each.

pub(crate) mod accuracy;
mod adapted_rows;
pub(crate) mod audit;
pub(crate) mod bounds;
pub(crate) mod choose;
pub(crate) mod compare;
pub(crate) mod completions;
pub(crate) mod eval;
pub(crate) mod fit;
pub(crate) mod healpix;
pub(crate) mod integrate;
pub(crate) mod lights;
pub(crate) mod list;
pub(crate) mod merge;
pub(crate) mod plan;
pub(crate) mod progressive;
pub(crate) mod quality;
pub(crate) mod render;
pub(crate) mod reproduce;
pub(crate) mod rotations;
pub(crate) mod sample;
pub(crate) mod spectrum;
mod square_rows;
pub(crate) mod variance;
pub(crate) mod weights;

mod cases;
pub(crate) mod crossovers;
mod effort;
pub(crate) mod fixed_orientation;
pub(crate) mod over_rotations;
mod power_chart;
mod row_record;
mod rows;
mod sets_args;
mod visible_half;
mod warped_rows;

pub(crate) use self::sets_args::PointFileArgs;
