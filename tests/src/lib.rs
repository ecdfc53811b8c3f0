//! Shared parts of the cross-crate tests: significance of families of comparisons, reference
//! spectra and quadrature on HEALPix cells.
//!
//! The tests are in `tests/integration/*.rs`, one topic per file. Their rules: seeds, counts and
//! significance levels are named constants, the unit of replication is the realization, and every
//! statistical test states its false-alarm probability.

mod family;
mod kolmogorov_smirnov;
mod point_list;
mod reference_spectrum;
mod significance;
mod strata;

pub use family::Family;
pub use kolmogorov_smirnov::{ks_distance, ks_p_value};
pub use point_list::PointList;
pub use reference_spectrum::ReferenceSpectrum;
pub use significance::{chi2_false_alarm, chi2_interval, sidak_z};
pub use strata::{Stratum, exact_jitter_orders, exact_jitter_spectrum, strata};
