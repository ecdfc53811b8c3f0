//! Patterns of rotations, elements of SO(3), with their measures and representations.
//!
//! A rotation is a unit quaternion; q and -q are the same one. To add a pattern, add a file here
//! that implements `RotationSampler` and `Definition<RotationGroup>` and a line to the list.

use crate::definition::Definition;
use crate::pattern_list::{PatternList, definition, pattern_list};

mod euler;
mod group;
mod quaternion_tree;
mod rotation_covering_radius;
mod rotation_pattern;
mod rotation_realizations;
mod rotation_sampler;
mod rotation_separation;
#[cfg(test)]
mod test_groups;
mod voronoi_cell;

pub use euler::{euler_zyz, rotation_from_euler_zyz};
pub use group::RotationGroup;
pub use rotation_covering_radius::rotation_covering_radius;
pub use rotation_realizations::RotationRealizations;
pub use rotation_sampler::{RotationSampler, RotationSet};
pub use rotation_separation::rotation_separation;

/// The number of rotations between two ticks of a progress, a few milliseconds.
const POINTS_PER_TICK: u32 = 1 << 16;

pattern_list! {
    /// The patterns of rotations, by name, with their parameters.
    ///
    /// `FromStr` reads what `Display` writes.
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_samplers::{Purpose, RotationPattern, RotationRealizations, Streams};
    ///
    /// let pattern: RotationPattern = "sukharev:weights=cell".parse()?;
    /// let grid = pattern.build(36)?;
    /// let streams = Streams::new(0, Purpose::Pattern, grid.stream_group());
    /// // A uniform rotation of the set makes its means right on average.
    /// let set = RotationRealizations::rotated(&*grid, streams).realize(0)?;
    /// assert_eq!((set.points.len(), set.weights.len()), (36, 36));
    /// # Ok::<(), sphvar_samplers::Error>(())
    /// ```
    pub enum RotationPattern of RotationGroup;

    "uniform" = uniform::Uniform: "independent uniform rotations";
    "super-fibonacci" = super_fibonacci::SuperFibonacci: "a double spiral on the unit quaternions, any number";
    "sukharev" = sukharev::Sukharev(p: SukharevRotationsParameters): "layered grids on the faces of a hypercube, a sequence";
    "healpix-hopf" = healpix_hopf::HealpixHopf(p: HealpixHopfParameters): "HEALPix directions times equal twists about them";

    without default:
}
