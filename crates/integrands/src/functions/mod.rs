//! The list of integrands, with one file each, and the combinations of several.
//!
//! To add an integrand, add a file here that implements `Definition` and a line to the list. The
//! list declares the modules, so `cargo fmt` does not find these files; `.ci/run` checks them by
//! name.

mod adaptive;
mod closed_form;
mod deferred;
mod environment;
mod expansion;
mod fitted;
mod healpix_map;
mod inner_product;
mod lens;
mod map_parameters;
mod picture;
mod picture_parameters;
mod product;
mod random_field;
mod rotated;
mod sampled;
mod shared;
mod sum;
mod sum_square;
mod zonal_series;

pub use adaptive::{AdaptiveFunction, Tolerance};
pub use deferred::DeferredFunction;
pub use environment::EnvironmentMap;
pub use expansion::Expansion;
pub use fitted::FittedFunction;
pub use healpix_map::HealpixMap;
pub use map_parameters::MissingPixels;
pub use picture::{PictureLayout, Projection};
pub use picture_parameters::{PictureParameters, UpAxis};
pub use product::Product;
pub use random_field::RandomField;
pub use rotated::Rotated;
pub(crate) use rotated::rotation_to_angles;
pub use sampled::SampledFunction;
pub use shared::SharedFunction;
pub use sum::Sum;

use glam::DVec3;

use crate::Integrand;
use crate::definition::Definition;
use crate::named_terms::named_terms;

named_terms! {
    /// A named integrand with its parameters.
    ///
    /// `FromStr` reads what `Display` writes, such as `cap:degrees=60`.
    "integrand" Term: Definition -> Integrand, unlisted "function";
    "ylm" = harmonic::Harmonic(p: HarmonicParameters): "real spherical harmonic";
    "cap" = cap::Cap(p: CapParameters): "indicator of a spherical cap around +z";
    "double-cap" = double_cap::DoubleCap(p: DoubleCapParameters): "indicator of the caps around +z and -z";
    "half-space" = half_space::HalfSpace(p: HalfSpaceParameters): "indicator of z >= height";
    "vmf" = von_mises_fisher::VonMisesFisher(p: VonMisesFisherParameters): "von Mises-Fisher density around +z";
    "phong" = phong::Phong(p: PhongParameters): "Phong lobe max(0, z)^n";
    "ggx" = ggx::GgxLobe(p: GgxParameters): "GGX reflection lobe of a rough surface with normal +z";
    "cosine" = cosine::Cosine: "clamped cosine max(0, z)";
    "abs-cosine" = abs_cosine::AbsCosine: "absolute cosine |z|";
    "filtered" = filtered::Filtered(p: FilteredParameters): "Gaussian filter of an integrand";
    "env" = env::Environment(p: EnvironmentParameters): "environment map in a picture, EXR or HDR";
    "map" = map::HealpixMap(p: HealpixMapParameters): "HEALPix map in a FITS file";
    "energy" = energies::Energies(p: EnergiesParameters): "random function with energies per degree from a file";
    "band" = band::Band(p: BandParameters): "random function of a given bandwidth, of variance 1";
    "alm" = alm::Alm(p: AlmParameters): "function with harmonic coefficients from a file";
    "values" = values::Values(p: ValuesParameters): "least-squares fit to values at points in a file";
    "function" = function::Function(p: FunctionParameters): "function that the program supplies";
}

/// Returns `1 - z` of a unit vector, without cancellation near the pole, where narrow functions are
/// concentrated.
fn drop_from_pole(dir: DVec3) -> f64 {
    if dir.z > 0.0 { (dir.x * dir.x + dir.y * dir.y) / (1.0 + dir.z) } else { 1.0 - dir.z }
}

/// The degree to which `e^{-rate (1 - z)}` and functions like it have coefficients above rounding.
///
/// They fall as `e^{-l^2/(2 rate)}` (the asymptotic form of Bessel functions), eventually faster
/// than geometrically; `e^{-8.6^2/2}` is 1e-16.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "rates are positive and at most 1e22"
)]
fn exponential_degree(rate: f64) -> usize {
    (8.6 * rate.sqrt()).ceil() as usize + 24
}

/// Returns the angle from its axis beyond which `e^{-rate (1 - z)}` is less than 1e-22 of its peak.
fn exponential_support(rate: f64) -> f64 {
    let drop = 50.0 / rate;
    if drop < 2.0 { 2.0 * (0.5 * drop).sqrt().asin() } else { std::f64::consts::PI }
}
