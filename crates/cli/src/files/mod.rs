//! Reading and writing of files: point sets in, results out, never half a file.

mod atomic;
mod file_error;
mod fits;
mod image;
mod input;
mod lists;
mod memory_guard;
mod npy;
mod picture;
mod piece_store;
mod points;
mod shard;
mod spectra;
mod text_rows;

pub(crate) use atomic::AtomicFile;
pub(crate) use file_error::{FileError, Place};
pub(crate) use fits::{FitsField, FitsMap, HduChoice, read_fits_map};
pub(crate) use image::{ChannelChoice, decode_image, read_image};
pub(crate) use input::read_whole;
pub(crate) use lists::{Columns, Fault, ListWriter, Number, Written, read_list};
pub(crate) use picture::{Picture, PictureFormat, srgb, write_png};
pub(crate) use piece_store::PieceStore;
pub(crate) use points::{ColumnChoice, PointSet, ReadOptions, read_points, write_points};
pub(crate) use shard::{SavedEnsemble, Shard};
pub(crate) use spectra::read_spectrum;
