//! HEALPix indexing against its definition, healpy and cdshealpix.

mod cdshealpix;
mod healpy;
mod properties;
