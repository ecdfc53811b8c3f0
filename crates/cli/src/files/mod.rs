//! Reading and writing of files: point sets in, results out, never half a file.

mod atomic;
mod file_error;
mod points;

pub(crate) use atomic::AtomicFile;
pub(crate) use file_error::{FileError, Place};
pub(crate) use points::{PointFile, PointFormat, PointSet, ReadOptions, read_points, write_points};
