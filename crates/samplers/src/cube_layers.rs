//! Layers of grids on cubes, each finer by half than the last, in an order of which every prefix is
//! spread out (the layered Sukharev grid sequence of Lindemann, Yershova and `LaValle` 2004), and their
//! projection onto spheres.

use std::f64::consts::{FRAC_PI_4, PI};

use sphvar_grammar::Choice;

use crate::CubeSpacing;

/// The weights of a pattern whose cells differ in size.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum CellWeights {
    /// Equal weights.
    #[default]
    Equal,
    /// The size of the cell, from the density at its centre, relative to the mean.
    Cell,
}

impl Choice for CellWeights {
    const CHOICES: &'static [(&'static str, Self)] =
        &[("equal", Self::Equal), ("cell", Self::Cell)];
}

/// A cell of one of several cubes of dimension `D`, divided into `2^level` cells along each edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct LayeredCell<const D: usize> {
    /// The number of the cube.
    pub(crate) cube: u64,
    pub(crate) level: u32,
    /// The place of the cell along each edge, from 0 to `2^level - 1`.
    pub(crate) place: [u32; D],
}

impl<const D: usize> LayeredCell<D> {
    /// The corners of a cube in the order of visits, each second one opposite to the one before;
    /// bit d is the coordinate d.
    const CORNERS: &[u32] = match D {
        1 => &[0, 1],
        2 => &[0, 3, 1, 2],
        _ => &[0, 7, 3, 4, 5, 2, 6, 1],
    };

    /// Returns cell `index` of the sequence over `cubes` cubes: the undivided cubes, then all cells
    /// of level 1, all of level 2 and so on.
    ///
    /// Of each layer, the first `cubes * 2^(D k)` cells lie in different cells of level k.
    /// Cubes of odd number begin at the opposite corner, so that a prefix is not displaced as a
    /// whole.
    pub(crate) fn new(cubes: u64, index: u64) -> Self {
        let (mut level, mut rest, mut size) = (0, index, cubes);
        while rest >= size {
            rest -= size;
            size <<= D;
            level += 1;
        }
        let cube = rest % cubes;
        let mut digits = rest / cubes;
        let flip = if cube.is_multiple_of(2) { 0 } else { (1 << D) - 1 };
        let mut place = [0; D];
        for _ in 0..level {
            #[expect(clippy::cast_possible_truncation, reason = "below 2^D")]
            let corner = Self::CORNERS[(digits & ((1 << D) - 1)) as usize] ^ flip;
            digits >>= D;
            for (d, place) in place.iter_mut().enumerate() {
                *place = 2 * *place + (corner >> d & 1);
            }
        }
        Self { cube, level, place }
    }

    /// Returns the centre of the cell, with coordinates from -1 to 1, exact.
    pub(crate) fn centre(&self) -> [f64; D] {
        let side = f64::from(self.level).exp2();
        self.place.map(|place| (f64::from(2 * place + 1) - side) / side)
    }
}

/// Returns a point of the face of a cube, which touches the unit sphere of the same number of
/// dimensions at its centre, and the area of the sphere that a unit of volume of the cube `[-1, 1]^D` there
/// is projected to, relative to the mean of the face.
pub(crate) fn project<const D: usize>(spacing: CubeSpacing, place: [f64; D]) -> ([f64; D], f64) {
    let (on_face, stretch) = match spacing {
        CubeSpacing::Equiangular => {
            let on_face = place.map(|x| (FRAC_PI_4 * x).tan());
            (on_face, on_face.map(|x| FRAC_PI_4 * (1.0 + x * x)).iter().product())
        }
        CubeSpacing::Equidistant => (place, 1.0),
    };
    let length_squared = 1.0 + on_face.iter().map(|x| x * x).sum::<f64>();
    // The area of the sphere in D + 1 dimensions over that of the 2 (D + 1) cubes of volume 2^D.
    let mean: f64 = match D {
        2 => 4.0 * PI / 24.0,
        _ => 2.0 * PI * PI / 64.0,
    };
    (on_face, stretch * length_squared.powf(-0.5 * (D + 1) as f64) / mean)
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::{LayeredCell, project};
    use crate::CubeSpacing;

    #[expect(clippy::cast_possible_truncation, reason = "small numbers")]
    fn check<const D: usize>(cubes: u64) {
        let mut start = 0;
        for level in 0..4u32 {
            let size = cubes << (D as u32 * level);
            let layer: Vec<_> =
                (start..start + size).map(|i| LayeredCell::<D>::new(cubes, i)).collect();
            assert!(layer.iter().all(|cell| cell.level == level));
            for coarse in 0..=level {
                let prefix = &layer[..(cubes << (D as u32 * coarse)) as usize];
                let seen: HashSet<_> = prefix
                    .iter()
                    .map(|cell| (cell.cube, cell.place.map(|x| x >> (level - coarse))))
                    .collect();
                assert_eq!(seen.len(), prefix.len(), "{D}, level {level}, prefix {coarse}");
            }
            start += size;
        }
    }

    #[test]
    fn prefixes_of_layers_have_one_cell_in_each_coarser_cell() {
        check::<1>(3);
        check::<2>(6);
        check::<3>(4);
        check::<3>(72);
        let centres = |i| LayeredCell::<2>::new(6, i).centre();
        assert_eq!((centres(0), centres(6)), ([0.0; 2], [-0.5; 2]));
    }

    /// The mean of the weights over a fine grid is 1; the midpoint rule of 32 cells along an edge has
    /// an error of about 32^-2.
    #[test]
    fn weights_have_mean_1() {
        #[expect(clippy::cast_possible_truncation, reason = "at most 3")]
        fn mean<const D: usize>(spacing: CubeSpacing) -> f64 {
            let start: u64 = (0..5).map(|level| 1 << (D as u32 * level)).sum();
            let n = 1 << (D as u32 * 5);
            let cells = (start..start + n).map(|i| LayeredCell::<D>::new(1, i));
            cells.map(|cell| project(spacing, cell.centre()).1).sum::<f64>() / n as f64
        }
        for spacing in [CubeSpacing::Equiangular, CubeSpacing::Equidistant] {
            for mean in [mean::<2>(spacing), mean::<3>(spacing)] {
                assert!((mean - 1.0).abs() < 1e-3, "{spacing:?}: {mean}");
            }
        }
    }
}
