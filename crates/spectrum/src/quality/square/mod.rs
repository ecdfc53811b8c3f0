//! Measures of one point set of the square.

mod dominance;
mod l2_discrepancy;
mod square_quality;
mod star_discrepancy;
#[cfg(test)]
mod tests;

pub use l2_discrepancy::{
    MAX_POINTS_OF_L2_DISCREPANCY, l2_star_discrepancy, wraparound_l2_discrepancy,
};
pub use square_quality::SquareQuality;
pub use star_discrepancy::{MAX_POINTS_OF_STAR_DISCREPANCY, star_discrepancy};
