//! The integrands that there are, and what is made of several.

mod cap;
mod closed_form;
mod double_cap;
mod environment;
mod harmonic;
mod healpix_map;
mod inner_product;
mod lens;
mod phong;
mod picture;
mod product;
mod rotated;
mod sampled;
mod sum;
mod sum_square;
mod von_mises_fisher;

pub use cap::Cap;
pub use double_cap::DoubleCap;
pub use environment::EnvironmentMap;
pub use harmonic::Harmonic;
pub use healpix_map::HealpixMap;
pub use phong::{AbsCosine, ClampedCosine, PhongLobe};
pub use picture::{PictureLayout, Projection};
pub use product::Product;
pub use rotated::Rotated;
pub use sampled::SampledFunction;
pub use sum::Sum;
pub use von_mises_fisher::VonMisesFisher;

use glam::DVec3;

/// `1 - z` of a unit vector, without cancellation near the pole, where narrow functions live.
fn drop_from_pole(dir: DVec3) -> f64 {
    if dir.z > 0.0 { (dir.x * dir.x + dir.y * dir.y) / (1.0 + dir.z) } else { 1.0 - dir.z }
}

/// The degree to which `e^{-rate (1 - z)}` and functions like it have coefficients above rounding.
///
/// They fall as `e^{-l^2/(2 rate)}` (the asymptotic form of Bessel functions), from some point on faster
/// than geometrically; `e^{-8.6^2/2}` is 1e-16.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "rates are positive and at most a million"
)]
fn exponential_degree(rate: f64) -> usize {
    (8.6 * rate.sqrt()).ceil() as usize + 24
}

/// The angle from its axis beyond which `e^{-rate (1 - z)}` is less than 1e-22 of its peak.
fn exponential_support(rate: f64) -> f64 {
    let drop = 50.0 / rate;
    if drop < 2.0 { 2.0 * (0.5 * drop).sqrt().asin() } else { std::f64::consts::PI }
}
