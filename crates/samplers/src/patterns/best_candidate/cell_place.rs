use glam::DVec3;
use sphvar_healpix::{Cell, Nside};

/// The level of the smallest cells: the finest resolution that has an [`Nside`].
pub(super) const LAST_LEVEL: u8 = 29;

/// A HEALPix cell. At a level the faces have `2^level` cells a side.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellPlace {
    pub(super) face: u8,
    pub(super) level: u8,
    pub(super) ix: u32,
    pub(super) iy: u32,
}

impl CellPlace {
    /// Returns the largest cell of a face.
    pub(super) fn root(face: u8) -> Self {
        Self { face, level: 0, ix: 0, iy: 0 }
    }

    /// Returns a point of the cell by its coordinates in the cell.
    ///
    /// A point that belongs to cells of several levels, or to neighbours in a face, is the same
    /// to the last bit in all of them.
    #[inline]
    pub(super) fn point(self, u: f64, v: f64) -> DVec3 {
        let Self { face, level, ix, iy } = self;
        let cell = Nside::new(1 << level).and_then(|nside| Cell::new(nside, face, ix, iy));
        cell.map_or(DVec3::Z, |cell| cell.uniform_point(u, v))
    }

    /// Returns the corners in the order of the children that have them.
    pub(super) fn corners(self) -> [DVec3; 4] {
        [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(u, v)| self.point(u, v))
    }

    /// Returns one of the four cells of the next level in this one.
    pub(super) fn child(self, child: u32) -> Self {
        let (ix, iy) = (2 * self.ix + child % 2, 2 * self.iy + child / 2);
        Self { face: self.face, level: self.level + 1, ix, iy }
    }

    /// Returns a distance that points of the edges do not exceed from the chords between corners.
    ///
    /// An edge leaves its chord by at most `max |X''|/(8 nside^2)`, where `X''` is the second
    /// derivative with respect to a coordinate of the face: below 2 in the belt, below `1.3 +
    /// 2.02/d` in the caps at a distance of d sides of a face from the pole, and below 1 on the
    /// meridians through the pole.
    pub(super) fn sagitta(self) -> f64 {
        let side = 1 << self.level;
        let from_pole = match self.face / 4 {
            0 => 2 * (side - 1) - self.ix - self.iy,
            1 => side,
            _ => self.ix + self.iy,
        };
        let side = f64::from(side);
        let second = 2.0 + 2.02 * side / f64::from(from_pole.max(1));
        // Points are rounded by a few units in the last place.
        second / (8.0 * side * side) + 16.0 * f64::EPSILON
    }
}

/// Returns the area of a cell of a level in units of the smallest ones.
pub(super) fn area(level: u8) -> u64 {
    1 << (2 * (LAST_LEVEL - level))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_several_cells_are_bit_identical() {
        for (face, level) in (0..12).flat_map(|face| [0, 1, 2, 5].map(|level| (face, level))) {
            let side = 1 << level;
            for (ix, iy) in (0..side).flat_map(|ix| (0..side).map(move |iy| (ix, iy))) {
                let parent = CellPlace { face, level, ix, iy };
                for child in 0..4 {
                    let cell = parent.child(child);
                    let [u, v] = [child % 2, child / 2].map(f64::from);
                    for (a, b) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (0.5, 0.25)] {
                        let of_parent = parent.point((u + a) / 2.0, (v + b) / 2.0);
                        assert_eq!(cell.point(a, b), of_parent, "{cell:?} {a} {b}");
                    }
                }
            }
        }
    }
}
