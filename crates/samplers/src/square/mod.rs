//! Patterns of the unit square, and the maps from the square to directions.
//!
//! To add a pattern, add a file here that implements `SquareSampler` and `Definition<Square>` and a
//! line to the list.

use crate::Square;
use crate::definition::Definition;
use crate::pattern_list::{PatternList, definition, pattern_list};

pub mod checks;
mod cosine_hemisphere;
mod lattice;
mod on_faces;
mod on_sphere;
pub(crate) mod radical_inverse;
mod scrambled_pattern;
mod scrambling;
mod shift;
mod square_distribution;
mod square_pattern;
mod square_realizations;
mod square_sampler;
pub(crate) mod turns;

pub use cosine_hemisphere::CosineHemisphere;
pub use lattice::Lattice;
pub use on_faces::OnFaces;
pub use on_sphere::{OnSphere, SphereMap};
pub use scrambled_pattern::{ScrambledParameters, ScrambledPattern};
pub use scrambling::Scrambling;
pub use shift::{Shifted, shift, uniform_shift};
pub use square_distribution::SquareDistribution;
pub use square_realizations::SquareRealizations;
pub use square_sampler::SquareSampler;

/// The number of points between two ticks of a progress, a few milliseconds.
const POINTS_PER_TICK: u32 = 1 << 16;

pattern_list! {
    /// The patterns of the square, by name, with their parameters.
    ///
    /// `FromStr` reads what `Display` writes.
    pub enum SquarePattern of Square;

    "white-square" = white_square::WhiteSquare: "independent uniform points";
    "jittered-square" = jittered_square::JitteredSquare: "one uniform point in every cell of a square grid";
    "regular-square" = regular_square::RegularSquare: "the centres of the cells of a square grid";
    "latin-hypercube" = latin_hypercube::LatinHypercube: "one uniform point in each of N columns and of N rows";
    "fibonacci-lattice" = fibonacci_lattice::FibonacciLattice: "the Fibonacci lattice, a rank-1 lattice for every N";
    "r2" = r2::R2: "the sequence R2 of the plastic number";
    "pmj02" = pmj02::Pmj02: "progressive multi-jittered (0,2) samples";
    "sobol" = sobol_sequence::Sobol(p: SquareSobolParameters): "Sobol points, Owen-scrambled";
    "halton" = halton::Halton(p: SquareHaltonParameters): "Halton points in bases 2 and 3";
    "hammersley" = hammersley::Hammersley(p: SquareHammersleyParameters): "Hammersley points in base 2";
    "poisson-disk-square" = poisson_disk_square::PoissonDiskSquare(p: PoissonDiskSquareParameters): "random points that keep a minimum distance, toroidal or not";
    "tiled-disks" = tiled_disks::TiledDisks(p: TiledDisksParameters): "one toroidal set of Poisson disks in many small tiles";
    "ccvt-square" = ccvt_square::CcvtSquare(p: CcvtSquareParameters): "sites of a capacity-constrained Voronoi tessellation";
    "step-square" = step_square::StepSquare(p: StepSquareParameters): "no power up to |k| = alpha sqrt(N), white noise's beyond";
    "blue-square" = blue_square::BlueSquare(p: BlueSquareParameters): "no power up to |k| = alpha sqrt(N), points well apart";
    "profile-square" = profile_square::ProfileSquare(p: ProfileSquareParameters): "a prescribed power at every |k| in every set";

    without default:
    "file" = point_file::PointFile(SquarePointFileParameters): "your own point sets, with or without weights, from a file";
}
