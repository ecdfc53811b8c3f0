use glam::DVec3;
use rand::Rng;
use sphvar_grammar::{Declaration, Parametric};

use crate::cube_layers::{LayeredCell, project};
use crate::definition::Definition;
use crate::{
    CellWeights, CostOrder, CubeSpacing, Domain, Error, PatternFacts, PointSet, Rate, Sampler,
    SetDistribution, count,
};

/// The layered Sukharev grid sequence (Yershova and `LaValle` 2004): centres of cells on the faces of
/// a cube, projected from the centre onto the sphere.
///
/// The layers are the six faces, 6 * 4 cells, 6 * 16 cells and so on; the sequence has all cells of a
/// layer before the next layer begins. On the hemisphere it has one face of each pair. Every prefix
/// is a set of the pattern. Cells differ in area, up to a factor of 5.2 where the grid lines are
/// equidistant, so means with equal weights are biased; weights by cell remove the bias. The
/// pattern is deterministic: all realizations are the same set.
///
/// # References
///
/// A. Yershova and S. M. `LaValle`, "Deterministic sampling methods for spheres and SO(3)", ICRA 2004.
#[derive(Clone, Copy, Debug)]
pub struct Sukharev {
    n: u32,
    domain: Domain,
    parameters: SukharevParameters,
}

impl Sukharev {
    /// Returns the first `n_points` points.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `n_points` is from 1 to `u32::MAX`.
    pub fn new(
        n_points: usize,
        domain: Domain,
        parameters: SukharevParameters,
    ) -> Result<Self, Error> {
        Ok(Self { n: count::checked(n_points)?, domain, parameters })
    }

    /// Returns point `i` and its weight.
    #[expect(clippy::cast_possible_truncation, reason = "one of six faces")]
    fn point(&self, i: u32) -> (DVec3, f64) {
        let faces = if self.domain == Domain::Sphere { 6 } else { 3 };
        let cell = LayeredCell::<2>::new(faces, u64::from(i));
        // The faces around z, x, y, -z, -x and -y in that order, so that few are evenly spread.
        let side = if cell.cube < 3 { 1.0 } else { -1.0 };
        let ([u, v], weight) = project(self.parameters.spacing, cell.centre());
        let mut p = [u, v, side];
        p.rotate_right(cell.cube as usize % 3);
        (self.domain.representative(DVec3::from_array(p).normalize()), weight)
    }
}

impl Sampler for Sukharev {
    fn n_points(&self) -> usize {
        self.n as usize
    }

    fn domain(&self) -> Domain {
        self.domain
    }

    fn distribution(&self) -> SetDistribution<'_> {
        SetDistribution::Fixed
    }

    fn sample_into(&self, _: &mut dyn Rng, set: &mut PointSet) -> Result<(), Error> {
        set.start();
        for (point, weight) in (0..self.n).map(|i| self.point(i)) {
            set.points.push(point);
            if self.parameters.weights == CellWeights::Cell {
                set.weights.push(weight);
            }
        }
        Ok(())
    }
}

/// Parameters of the pattern `sukharev`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SukharevParameters {
    /// The spacing of the lines of the grids.
    pub spacing: CubeSpacing,
    /// The weights.
    pub weights: CellWeights,
}

impl SukharevParameters {
    /// The default parameters.
    pub const DEFAULT: Self =
        Self { spacing: CubeSpacing::Equiangular, weights: CellWeights::Equal };
}

impl Default for SukharevParameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Parametric for SukharevParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        d.choice("spacing", "of the grid lines, by angle or on the cube", &mut self.spacing);
        d.choice("weights", "equal, or the sizes of the cells", &mut self.weights);
    }
}

impl Definition for SukharevParameters {
    fn facts(&self) -> PatternFacts {
        let is_biased = self.weights == CellWeights::Equal;
        PatternFacts {
            cost: CostOrder::LINEAR,
            low_degrees: if is_biased { "grows as N at even l from 4" } else { "irregular" },
            smooth_rate: if is_biased { Rate::Biased } else { Rate::Depends },
            jump_rate: if is_biased { Rate::Biased } else { Rate::Depends },
            is_extensible: true,
            source: "Yershova and LaValle 2004",
        }
    }

    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        Ok(Box::new(Sukharev::new(n_points, domain, *self)?))
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::{CellWeights, CubeSpacing, Domain, Sampler, Sukharev, SukharevParameters};
    use crate::{PointSet, Purpose, Streams};

    fn set(n: usize, domain: Domain, parameters: SukharevParameters) -> PointSet {
        let mut rng = Streams::new(0, Purpose::Pattern, 0).realization(0);
        Sukharev::new(n, domain, parameters).unwrap().sample(&mut rng).unwrap()
    }

    #[test]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_possible_wrap,
        reason = "small numbers"
    )]
    fn layers_are_grids_of_cells_on_a_cube() {
        for domain in [Domain::Sphere, Domain::Hemisphere] {
            let faces = if domain == Domain::Sphere { 6 } else { 3 };
            let points = set(faces * 21, domain, SukharevParameters::DEFAULT).points;
            let mut start = 0;
            for side in [1, 2, 4] {
                let layer = &points[start..start + faces * side * side];
                start += layer.len();
                // The cell of a point: its face, and angles in parts of a right angle.
                let mut cells: Vec<[i32; 3]> = layer
                    .iter()
                    .map(|p| {
                        let axis = p.abs().max_position();
                        let part = |at: usize| {
                            let turn =
                                (p[(axis + at) % 3] / p[axis]).atan() / std::f64::consts::FRAC_PI_4;
                            ((turn + 1.0) * side as f64 / 2.0).floor() as i32
                        };
                        let face = axis as i32 + if p[axis] < 0.0 { 3 } else { 0 };
                        [face, part(1), part(2)]
                    })
                    .collect();
                cells.sort_unstable();
                cells.dedup();
                assert_eq!(cells.len(), layer.len(), "{domain}, side {side}");
            }
        }
    }

    /// Weights integrate what the faces do not resolve: the mean of z^4, 1/5.
    #[test]
    fn weights_remove_the_bias() {
        for domain in [Domain::Sphere, Domain::Hemisphere] {
            for spacing in [CubeSpacing::Equiangular, CubeSpacing::Equidistant] {
                let mean = |weights| {
                    let set = set(6 * 5461, domain, SukharevParameters { spacing, weights });
                    let values: Vec<f64> = set.points.iter().map(|p: &DVec3| p.z.powi(4)).collect();
                    set.mean(&values) - 0.2
                };
                let (weighted, equal) = (mean(CellWeights::Cell), mean(CellWeights::Equal));
                assert!(weighted.abs() < 1e-4, "{domain}, {spacing:?}: {weighted}");
                assert!(equal.abs() > 1e-3, "{domain}, {spacing:?}: {equal}");
            }
        }
    }
}
