//! Measures of sets of rotations: their power per degree, and the errors of means over SO(3).

mod matrix_fisher;
mod moments;
mod power;
mod rotation_quality;

pub use matrix_fisher::matrix_fisher_coefficients;
pub use power::{rotation_exact_degree, rotation_power};
pub use rotation_quality::RotationQuality;
