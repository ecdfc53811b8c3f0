//! Integrands on the unit square: the list of named ones, with one file each, and the tools that
//! they share.
//!
//! To add an integrand, add a file here that implements `SquareDefinition` and a line to the list.
//! The list declares the modules, so `cargo fmt` does not find these files; `.ci/run` checks them by
//! name.

mod adaptive;
mod cells;
mod doubling;
mod energy;
mod grid;
mod integrand;
mod legendre_expansion;
mod panel_series;
mod pulled_back;
mod separable;
mod spherical_bessel;
mod sum;
mod turns;

pub use adaptive::AdaptiveSquareFunction;
pub use integrand::SquareIntegrand;
pub use pulled_back::{Heuristic, LargestRatio, PulledBack, Strategy};
pub use sum::{SquareExpression, SquareSum};

use sphvar_grammar::Parametric;

use crate::named_terms::named_terms;
use crate::{Error, IntegrandResolver};

/// The definition of an integrand on the square, apart from its name and summary in the list.
///
/// [`Parametric`] declares the parameters with their ranges and defaults.
pub(crate) trait SquareDefinition: Parametric {
    /// Returns the integrand with these parameters; `files` reads the files that they name.
    fn build(&self, files: &dyn IntegrandResolver) -> Result<Box<dyn SquareIntegrand>, Error>;
}

named_terms! {
    /// A named integrand on the square with its parameters.
    ///
    /// `FromStr` reads what `Display` writes, such as `wave:k1=3,k2=-2`.
    "integrand" SquareTerm: SquareDefinition -> SquareIntegrand;
    "disk" = disk::Disk(p: DiskParameters): "indicator of a disk, continued across the sides";
    "half-plane" = half_plane::HalfPlane(p: HalfPlaneParameters): "indicator of one side of a line";
    "gaussian" = gaussian::Gaussian(p: GaussianParameters): "Gaussian peak, exp(-distance^2/(2 width^2))";
    "exponential" = exponential::Exponential(p: ExponentialParameters): "exp(a u + b v), smooth but not periodic";
    "zone-plate" = zone_plate::ZonePlate(p: ZonePlateParameters): "sin(x^2 + y^2) with x = scale u, y = scale v";
    "image" = image::Image(p: ImageParameters): "picture on the square, row 0 at v = 0";
    "wave" = wave::Wave(p: WaveParameters): "cosine of one frequency, cos(2 pi (k1 u + k2 v))";
}
