//! Reading FITS files.

mod hdu;
mod header;
mod map;
mod table;

pub(crate) use hdu::{Hdu, HduChoice, HduReader, keyword_error};
pub(crate) use map::{FitsField, FitsMap, read_fits_map};
pub(crate) use table::{Item, TableColumn};

#[cfg(test)]
mod tests;
