//! The list of patterns, with one file per pattern for its sampler, parameters and known
//! properties.
//!
//! To add a pattern, add a file here that implements `Definition` and a line to the list.

use crate::Domain;
use crate::definition::Definition;
use crate::pattern_list::{PatternList, definition, pattern_list};

mod mapped;

pub use mapped::{MappedParameters, MappedPattern, Randomization};

pattern_list! {
    /// The patterns of this crate, by name, with their parameters.
    ///
    /// `FromStr` reads what `Display` writes, such as `poisson-disk:radius=2`.
    pub enum Pattern of Domain;

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
    "leja" = leja::Leja(p: LejaParameters): "each point maximizes the product of its distances from the others";
    "lloyd" = lloyd::Lloyd(p: LloydParameters): "white noise after some steps of Lloyd's relaxation";
    "dpp" = dpp::Dpp: "the spherical ensemble, a determinantal point process";
    "riesz" = riesz::Riesz(p: RieszParameters): "white noise after some steps down a Riesz energy";
    "sobol" = sobol::Sobol(p: SobolParameters): "Sobol points, Owen-scrambled, by an equal-area map";
    "halton" = halton::Halton(p: HaltonParameters): "Halton points, randomly shifted, by an equal-area map";
    "hammersley" = hammersley::Hammersley(p: HammersleyParameters): "Hammersley points, randomly shifted, by an equal-area map";
    "r2" = r2::R2(p: R2Parameters): "the sequence R2, randomly shifted, by an equal-area map";
    "pmj02" = pmj02::Pmj02(p: Pmj02Parameters): "progressive multi-jittered (0,2) samples by an equal-area map";
    "gauss-legendre" = gauss_legendre::GaussLegendre: "quadrature, rings at Gauss-Legendre nodes";
    "driscoll-healy" = driscoll_healy::DriscollHealy: "quadrature, equiangular rings and a pole";
    "mcewen-wiaux" = mcewen_wiaux::McEwenWiaux: "quadrature, half as many equiangular rings";
    "lebedev" = lebedev::Lebedev: "quadrature with the symmetry of the octahedron, degrees to 131";
    "icosahedral" = icosahedral::Icosahedral: "the vertices of a geodesic icosahedron, equal weights";
    "cube-sphere" = cube_sphere::CubeSphere(p: CubeSphereParameters): "the centres of the cells of a cube-sphere grid, equal weights";
    "sukharev" = sukharev::Sukharev(p: SukharevParameters): "layered grids on the faces of a cube, a sequence";
    "design" = design::Design(p: DesignParameters): "a spherical design: exact for polynomials up to a degree";

    without default:
    "file" = point_file::PointFile(PointFileParameters): "your own point sets, with or without weights, from a file";
}
