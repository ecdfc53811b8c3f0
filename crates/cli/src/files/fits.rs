//! Reading FITS files.

mod field;
mod hdu;
mod header;
mod map;
mod table;

pub(crate) use field::FitsField;
pub(crate) use hdu::{Hdu, HduChoice, HduReader};
pub(crate) use map::{FitsMap, read_fits_map};
pub(crate) use table::{Item, TableColumn};

#[cfg(test)]
mod tests;
