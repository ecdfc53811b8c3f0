//! Named warps, maps from the unit square to directions with a density: the list, with one file
//! each, and expressions of them.
//!
//! To add a warp, add a file here that implements `WarpDefinition` and a line to the list. The list
//! declares the modules, so `cargo fmt` does not find these files; `.ci/run` checks them by name.

mod expression;
mod proposed;

pub use expression::{WarpExpression, WarpFactor};

use sphvar_grammar::Parametric;
use sphvar_sh::Domain;
use sphvar_warps::Warp;

use crate::named_terms::named_terms;
use crate::{CapParameters, Error, IntegrandResolver, PhongParameters, VonMisesFisherParameters};

/// The definition of a warp, apart from its name and summary in the list.
///
/// [`Parametric`] declares the parameters with their ranges and defaults.
pub(crate) trait WarpDefinition: Parametric {
    /// Returns the warp with these parameters for integrals over a domain; `files` reads the files
    /// that they name.
    fn build(&self, domain: Domain, files: &dyn IntegrandResolver) -> Result<Box<dyn Warp>, Error>;
}

named_terms! {
    /// A named warp with its parameters.
    ///
    /// `FromStr` reads what `Display` writes, such as `vmf:kappa=50`. Parameters that a warp shares with
    /// the integrand of its name have the same meaning, so that its density is proportional to this
    /// integrand.
    "warp" WarpTerm: WarpDefinition(domain: Domain) -> Warp;
    "cylinder" = cylinder::Cylinder: "uniform, by the cylinder map of Archimedes";
    "octahedral" = octahedral::Octahedral: "uniform, by the equal-area octahedral map or its upper half";
    "cosine" = cosine::Cosine: "clamped cosine max(0, z), by the concentric map";
    "cap" = cap::Cap(p: CapParameters): "uniform on a spherical cap around +z";
    "phong" = phong::Phong(p: PhongParameters): "Phong lobe max(0, z)^n";
    "vmf" = vmf::VonMisesFisher(p: VonMisesFisherParameters): "von Mises-Fisher density around +z";
    "env" = env::Environment(p: EnvironmentWarpParameters): "environment map in a picture, EXR or HDR";
}
