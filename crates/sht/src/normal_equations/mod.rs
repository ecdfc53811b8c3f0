//! The normal equations of harmonics at scattered points.
//!
//! [`Harmonics`] is the matrix B of harmonics as a pair of transforms, [`NormalMatrix`] the product
//! `B D B^T` without the points, and [`System`] solves with it.

mod conjugate_gradients;
mod harmonics;
mod normal_matrix;
mod ritz;

use glam::DVec3;
use sphvar_sh::Domain;

pub use conjugate_gradients::ConjugateGradients;
pub(crate) use conjugate_gradients::{SolveError, System, Watch};
pub(crate) use harmonics::{Harmonics, add, dot, project};
pub(crate) use normal_matrix::NormalMatrix;
pub use ritz::extreme_eigenvalues;

/// Returns the number of harmonics of the domain up to a degree.
pub(crate) fn n_harmonics(domain: Domain, degree: usize) -> usize {
    match domain {
        Domain::Sphere => degree.saturating_add(1).saturating_mul(degree.saturating_add(1)),
        Domain::Hemisphere => {
            let even = degree - degree % 2;
            even.saturating_add(1).saturating_mul(even / 2 + 1)
        }
    }
}

/// Returns the largest degree of the domain that has no more harmonics than there are distinct
/// points.
pub(crate) fn largest_degree(domain: Domain, n_distinct: usize) -> usize {
    let step = domain.degree_step();
    let degrees = (1..).map(|k| k * step);
    step * degrees.take_while(|&l| n_harmonics(domain, l) <= n_distinct).count()
}

/// Returns the number of distinct points; on the hemisphere antipodes are the same point.
pub(crate) fn n_distinct<'a>(points: impl Iterator<Item = &'a DVec3>, domain: Domain) -> usize {
    let key = |p: &DVec3| {
        let up = domain.representative(*p);
        let is_below = up.z == 0.0 && (up.y < 0.0 || (up.y == 0.0 && up.x < 0.0));
        let p = if domain == Domain::Hemisphere && is_below { -up } else { up };
        // Adding 0 removes the sign of a zero.
        (p + DVec3::ZERO).to_array().map(f64::to_bits)
    };
    let mut keys: Vec<_> = points.map(key).collect();
    keys.sort_unstable();
    keys.dedup();
    keys.len()
}
