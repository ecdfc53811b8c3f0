use glam::DQuat;
use rand::Rng;
use sphvar_grammar::{Declaration, Parametric};

use super::POINTS_PER_TICK;
use crate::cube_layers::{LayeredCell, project};
use crate::definition::Definition;
use crate::{
    CellWeights, CostOrder, CubeSpacing, Error, PatternFacts, Progress, Rate, RotationGroup,
    RotationSampler, RotationSet, count,
};

/// The layered Sukharev grid sequence of rotations (Yershova and `LaValle` 2004): centres of cells on
/// the faces of a hypercube in the space of quaternions, one face of each antipodal pair, projected
/// from the centre onto the unit quaternions.
///
/// The layers are the four faces, 4 * 8 cells, 4 * 64 cells and so on; the sequence has all cells of
/// a layer before the next layer begins. Every prefix is a set of the pattern. Cells differ in
/// volume, up to a factor of 16 where the grid lines are equidistant, so means with equal weights
/// are biased; weights by cell remove the bias.
///
/// # References
///
/// A. Yershova and S. M. `LaValle`, "Deterministic sampling methods for spheres and SO(3)", ICRA 2004.
#[derive(Clone, Copy, Debug)]
pub struct SukharevRotations {
    n: u32,
    parameters: SukharevRotationsParameters,
}

impl SukharevRotations {
    /// Returns the first `n_points` rotations.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `n_points` is from 1 to `u32::MAX`.
    pub fn new(n_points: usize, parameters: SukharevRotationsParameters) -> Result<Self, Error> {
        Ok(Self { n: count::checked(n_points)?, parameters })
    }

    /// Returns element `i` and its weight.
    #[expect(clippy::cast_possible_truncation, reason = "one of four faces")]
    fn element(&self, i: u32) -> (DQuat, f64) {
        // The faces around w, x, y and z in that order: DQuat has w last.
        let cell = LayeredCell::<3>::new(4, u64::from(i));
        let (on_face, weight) = project(self.parameters.spacing, cell.centre());
        let [u, v, w] = on_face;
        let mut q = [u, v, w, 1.0];
        q.rotate_right(cell.cube as usize);
        (DQuat::from_array(q).normalize(), weight)
    }
}

impl RotationSampler for SukharevRotations {
    fn n_points(&self) -> usize {
        self.n as usize
    }

    fn is_random(&self) -> bool {
        false
    }

    fn sample_into(
        &self,
        _: &mut dyn Rng,
        set: &mut RotationSet,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        set.start();
        for i in 0..self.n {
            if i.is_multiple_of(POINTS_PER_TICK) {
                progress.tick(0.0)?;
            }
            let (rotation, weight) = self.element(i);
            set.points.push(rotation);
            if self.parameters.weights == CellWeights::Cell {
                set.weights.push(weight);
            }
        }
        Ok(())
    }
}

/// Parameters of the pattern `sukharev` of rotations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SukharevRotationsParameters {
    /// The spacing of the lines of the grids.
    pub spacing: CubeSpacing,
    /// The weights.
    pub weights: CellWeights,
}

impl SukharevRotationsParameters {
    /// The default parameters.
    pub const DEFAULT: Self =
        Self { spacing: CubeSpacing::Equiangular, weights: CellWeights::Equal };
}

impl Default for SukharevRotationsParameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Parametric for SukharevRotationsParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        d.choice("spacing", "of the grid lines, by angle or on the hypercube", &mut self.spacing);
        d.choice("weights", "equal, or the sizes of the cells", &mut self.weights);
    }
}

impl Definition<RotationGroup> for SukharevRotationsParameters {
    fn facts(&self) -> PatternFacts {
        let is_biased = self.weights == CellWeights::Equal;
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees: if is_biased { "grows as N from degree 2" } else { "irregular" },
            // At the ends of layers; larger between them.
            smooth_rate: if is_biased { Rate::Biased } else { Rate::power(-1.33) },
            jump_rate: if is_biased { Rate::Biased } else { Rate::Depends },
            is_extensible: true,
            source: "Yershova and LaValle 2004",
        }
    }

    fn build(&self, n_points: usize, _: RotationGroup) -> Result<Box<dyn RotationSampler>, Error> {
        Ok(Box::new(SukharevRotations::new(n_points, *self)?))
    }
}
