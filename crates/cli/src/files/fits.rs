//! Reading FITS files.

mod hdu;
mod header;
mod map;
mod table;

pub(crate) use hdu::HduChoice;
pub(crate) use map::{FitsField, FitsMap, read_fits_map};

#[cfg(test)]
mod tests;
