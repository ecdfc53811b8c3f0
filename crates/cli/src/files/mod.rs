//! Input and output files: reads point sets and writes results, complete or not at all.

mod alm;
mod array_archive;
mod atomic;
mod coefficients;
mod energies;
mod file_error;
mod fits;
mod folder_lock;
mod formats;
mod image;
mod input;
mod lists;
mod live_files;
mod memory_guard;
mod npy;
mod numbered_path;
mod pairs;
mod picture;
mod piece_store;
mod point_templates;
mod points;
mod regular;
mod rotations;
mod spectra;
mod target;
mod text_rows;
mod used_files;

pub(crate) use alm::{alm_of_array, read_alm};
pub(crate) use atomic::AtomicFile;
pub(crate) use coefficients::{CoefficientFormat, write_coefficients};
pub(crate) use energies::{EnergyFile, energies_of_array, read_energies};
pub(crate) use file_error::{FileError, Place, input_name};
pub(crate) use fits::{FitsField, FitsMap, HduChoice, read_fits_map};
pub(crate) use folder_lock::FolderLock;
pub(crate) use formats::{FileFormat, formats};
pub(crate) use image::{
    ChannelChoice, ChannelImage, PictureArray, decode_image, decode_picture, read_image,
};
pub(crate) use input::read_whole;
pub(crate) use lists::{Columns, Fault, ListWriter, Number, Written, read_list};
pub(crate) use live_files::{as_group, is_at, remove_all_and_exit};
pub(crate) use numbered_path::NumberedPath;
pub(crate) use pairs::read_profile;
pub(crate) use picture::{Picture, PictureFormat, srgb, write_png};
pub(crate) use piece_store::PieceStore;
pub(crate) use point_templates::point_files;
pub(crate) use points::{
    Block, BlockStream, BlockedFiles, ColumnChoice, FilePoint, FileSurvey, OptionSpelling,
    PointFile, ReadOptions, RowTally, points_of_array, read_points, survey, write_points,
};
pub(crate) use regular::{read_regular, write_regular};
pub use rotations::RotationFormat;
pub(crate) use rotations::{RotationFile, write_rotations};
pub(crate) use spectra::{SpectrumRow, read_spectrum};
pub(crate) use target::{is_stdout, is_stream};
pub(crate) use used_files::{
    inputs, record_input, record_output, record_used_files, set_last_output,
};
