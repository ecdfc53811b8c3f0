//! Ensembles: point sets, random streams, rotations, realizations and progress.

mod point_files;
mod point_set;
mod point_sets;
pub(crate) mod progress;
mod realizations;
mod rotation;
mod streams;

pub use point_files::PointFile;
pub(crate) use point_files::PointFiles;
pub use point_set::PointSet;
pub use point_sets::PointSets;
pub use progress::{Progress, SECONDS_PER_WORK, Share, Stopped};
pub use realizations::{Ensemble, Realizations};
pub(crate) use rotation::uniform_quaternion;
pub use rotation::{rotate, uniform_rotation};
pub use streams::{Purpose, Streams};
