//! The list of patterns, with one file per pattern for its sampler, parameters and known
//! properties.
//!
//! To add a pattern, add a file here that implements `Definition` and a line to the list. The list
//! declares the modules, so `cargo fmt` does not find these files; `.ci/run` checks them by name.

use crate::definition::Definition;

/// Declares the module, the variant, the name and the summary of every pattern. A variant with
/// parameters names their type; otherwise the definition is the type `Parameters` of its module.
/// Patterns without a default are not in `Pattern::ALL`.
macro_rules! patterns {
    (
        $($name:literal = $module:ident::$Variant:ident $(($parameters:ident: $Parameters:ident))?: $summary:literal;)*
        without default:
        $($file_name:literal = $file_module:ident::$FileVariant:ident ($FileParameters:ident): $file_summary:literal;)*
    ) => {
        $(
            pub(crate) mod $module;
            pub use $module::*;
        )*
        $(
            pub(crate) mod $file_module;
            pub use $file_module::*;
        )*

        /// The patterns of this crate, by name, with their parameters.
        ///
        /// `FromStr` reads what `Display` writes, such as `poisson-disk:radius=2`.
        #[derive(Clone, Debug, PartialEq)]
        #[non_exhaustive]
        pub enum Pattern {
            $(
                #[doc = concat!("`", $name, "`: ", $summary, ".")]
                $Variant $(($Parameters))?,
            )*
            $(
                #[doc = concat!("`", $file_name, "`: ", $file_summary, ".")]
                $FileVariant($FileParameters),
            )*
        }

        impl Pattern {
            /// All patterns with their default parameters, in the order of tables.
            pub const ALL: [Self; [$($name),*].len()] =
                [$(Self::$Variant $(($Parameters::DEFAULT))?),*];

            /// The patterns that have no default, since they need a file, with empty parameters.
            pub(crate) const WITHOUT_DEFAULT: [Self; [$($file_name),*].len()] =
                [$(Self::$FileVariant($FileParameters::DEFAULT)),*];

            /// Returns the name of the pattern in commands and files.
            #[must_use]
            pub const fn name(&self) -> &'static str {
                match self {
                    $(Self::$Variant { .. } => $name,)*
                    $(Self::$FileVariant(_) => $file_name,)*
                }
            }

            /// Returns a one-line description of the pattern.
            #[must_use]
            pub const fn summary(&self) -> &'static str {
                match self {
                    $(Self::$Variant { .. } => $summary,)*
                    $(Self::$FileVariant(_) => $file_summary,)*
                }
            }

            /// Calls a function with the definition of the pattern.
            pub(crate) fn with_definition<T>(
                &mut self,
                action: impl FnOnce(&mut dyn Definition) -> T,
            ) -> T {
                match self {
                    $(Self::$Variant $(($parameters))? => {
                        action(definition!($module $($parameters)?))
                    })*
                    $(Self::$FileVariant(parameters) => action(parameters),)*
                }
            }
        }
    };
}

macro_rules! definition {
    ($module:ident) => {
        &mut $module::Parameters
    };
    ($module:ident $parameters:ident) => {
        $parameters
    };
}

patterns! {
    "white-noise" = white_noise::WhiteNoise: "independent uniform directions";
    "jittered" = jittered::Jittered: "one uniform direction in every HEALPix pixel";
    "healpix" = healpix::Healpix: "the centres of the HEALPix pixels";
    "fibonacci" = fibonacci::Fibonacci(p: FibonacciParameters): "the spherical Fibonacci lattice";
    "poisson-disk" = poisson_disk::PoissonDisk(p: PoissonDiskParameters): "random points that keep a minimum distance";
    "ccvt" = ccvt::Ccvt(p: CcvtParameters): "sites of a capacity-constrained Voronoi tessellation";
    "step" = step::Step(p: StepParameters): "no power up to degree alpha sqrt(N), white noise's beyond";
    "blue" = blue::Blue(p: BlueParameters): "no power up to degree alpha sqrt(N), points well apart";
    "profile" = profile::Profile(p: ProfileParameters): "a prescribed power at every degree in every set";
    "equal-area" = equal_area::EqualArea(p: EqualAreaParameters): "one point in each of N zonal regions of equal area";
    "spiral" = spiral::Spiral: "the generalized spiral from pole to pole";
    "best-candidate" = best_candidate::BestCandidate(p: BestCandidateParameters): "each point the farthest of several uniform candidates";
    "lloyd" = lloyd::Lloyd(p: LloydParameters): "white noise after some steps of Lloyd's relaxation";
    "riesz" = riesz::Riesz(p: RieszParameters): "white noise after some steps down a Riesz energy";
    "sobol" = sobol::Sobol: "Owen-scrambled Sobol points by the equal-area map";
    "halton" = halton::Halton: "randomly shifted Halton points by the equal-area map";
    "hammersley" = hammersley::Hammersley: "randomly shifted Hammersley points by the equal-area map";
    "gauss-legendre" = gauss_legendre::GaussLegendre: "quadrature, rings at Gauss-Legendre nodes";
    "driscoll-healy" = driscoll_healy::DriscollHealy: "quadrature, equiangular rings and a pole";
    "mcewen-wiaux" = mcewen_wiaux::McEwenWiaux: "quadrature, half as many equiangular rings";
    "lebedev" = lebedev::Lebedev: "quadrature with the symmetry of the octahedron, degrees to 131";
    "icosahedral" = icosahedral::Icosahedral: "the vertices of a geodesic icosahedron, equal weights";
    "cube-sphere" = cube_sphere::CubeSphere(p: CubeSphereParameters): "the centres of the cells of a cube-sphere grid, equal weights";

    without default:
    "file" = point_file::PointFile(PointFileParameters): "your own point sets, with or without weights, from a file";
}
