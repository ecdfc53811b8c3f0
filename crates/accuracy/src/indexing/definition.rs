use crate::reference::DoubleDouble;
use glam::DVec3;
use sphvar_healpix::Cell;

/// HEALPix by its definition: integers in 128 bits, and the plane of the projection in twice the
/// working precision.
///
/// The plane is measured in quarter turns of longitude: `x = phi/(pi/2)`, and `y = (3/4) z` in the
/// belt `|z| <= 2/3`, `y = 1 - d/2` in the caps, where longitudes shrink by `d = sqrt(3 (1 - |z|))`
/// towards the middle of their quarter. A face is the square with half diagonal 1/2 around its
/// centre, oriented with a corner at the bottom; pixels divide it into `nside` by `nside`.
///
/// # References
///
/// Gorski et al. 2005, ApJ 622, 759, section 4 and equations 2 to 9; Calabretta and Roukema 2007,
/// MNRAS 381, 865, for the plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Definition {
    n: i128,
    row: i128,
    column: i128,
    ix: i128,
    iy: i128,
}

impl Definition {
    pub(super) fn of(cell: Cell) -> Self {
        Self {
            n: cell.nside().value().into(),
            row: (cell.face() / 4).into(),
            column: (cell.face() % 4).into(),
            ix: cell.ix().into(),
            iy: cell.iy().into(),
        }
    }

    /// Returns the ring number, counted from 1 at the north pole.
    fn ring(self) -> i128 {
        (self.row + 2) * self.n - self.ix - self.iy - 1
    }

    /// Returns the longitude of the centre as a fraction of integers, in quarter turns from -1/2 to
    /// 4.
    fn longitude(self) -> (i128, i128) {
        let Self { n, row, column, ix, iy } = self;
        let ring = self.ring();
        let across = if ring < n {
            ring
        } else if ring > 3 * n {
            4 * n - ring
        } else {
            n
        };
        // The middle of the face, and half a pixel of the ring for each step to the east.
        let middle = if row == 1 { 2 * column } else { 2 * column + 1 };
        (middle * across + ix - iy, 2 * across)
    }

    /// Returns the number in ring order: the count of pixels in rings further north and of those
    /// further west in the ring.
    pub(super) fn ring_number(self) -> i128 {
        let (n, ring) = (self.n, self.ring());
        let (before, length) = if ring < n {
            (2 * ring * (ring - 1), 4 * ring)
        } else if ring > 3 * n {
            let from_south = 4 * n - ring;
            (12 * n * n - 2 * from_south * (from_south + 1), 4 * from_south)
        } else {
            (2 * n * (n - 1) + (ring - n) * 4 * n, 4 * n)
        };
        // A pixel is 4/length quarter turns wide; the first centre is at 0 or half of that.
        let (quarters, unit) = self.longitude();
        before + (quarters * length).div_euclid(4 * unit).rem_euclid(length)
    }

    /// Returns the number in nested order, computed bit by bit.
    pub(super) fn nested_number(self) -> i128 {
        let face = 4 * self.row + self.column;
        let bits = |k: u32| ((self.ix >> k & 1) << (2 * k)) | ((self.iy >> k & 1) << (2 * k + 1));
        face * self.n * self.n + (0..32).map(bits).sum::<i128>()
    }

    /// Returns the distance of a direction from the pixel's centre, in units of the side of a
    /// square with the pixel's area.
    pub(super) fn distance_from_centre(self, dir: DVec3) -> f64 {
        let centre = self.centre();
        let squares = dir.to_array().into_iter().zip(centre).map(|(got, exact)| {
            let difference = DoubleDouble::from(got) - exact;
            difference * difference
        });
        let distance = squares.fold(DoubleDouble::ZERO, |sum, square| sum + square).sqrt().value();
        distance * self.n as f64 / (std::f64::consts::PI / 3.0).sqrt()
    }

    fn centre(self) -> [DoubleDouble; 3] {
        let (n, ring) = (self.n, self.ring());
        let n_squared = number(3 * n * n);
        // 1 - |z| in the caps, z in the belt.
        let (sin, cos) = if (n..=3 * n).contains(&ring) {
            let z = number(4 * n - 2 * ring) / number(3 * n);
            (((DoubleDouble::ONE - z) * (DoubleDouble::ONE + z)).sqrt(), z)
        } else {
            let from_pole = ring.min(4 * n - ring);
            let versine = number(from_pole * from_pole) / n_squared;
            let z = DoubleDouble::ONE - versine;
            let sin = (versine * (DoubleDouble::ONE + z)).sqrt();
            (sin, if ring > 2 * n { -z } else { z })
        };
        let (quarters, unit) = self.longitude();
        let phi = number(quarters) / number(unit) * DoubleDouble::pi().shifted(-1);
        let (sin_phi, cos_phi) = phi.sin_cos();
        [sin * cos_phi, sin * sin_phi, cos]
    }

    /// Returns the distance of a direction from the pixel, in units of the pixel's side in the
    /// plane; 0 inside and on the edge.
    pub(super) fn excess(self, dir: DVec3) -> f64 {
        let [x, y, z] = dir.to_array().map(DoubleDouble::from);
        let across = x * x + y * y;
        let length = (across + z * z).sqrt();
        let quarters = DoubleDouble::atan2(y, x) / DoubleDouble::pi().shifted(-1);
        let middle = number(if self.row == 1 { 2 * self.column } else { 2 * self.column + 1 });
        let east = wrapped(quarters - middle.shifted(-1));

        let (half, one, two) = (DoubleDouble::ONE.shifted(-1), DoubleDouble::ONE, number(2));
        let sine = z / length;
        let in_cap = (sine.abs() * number(3)) > two;
        let (dx, dy) = if in_cap && self.row != 1 {
            let d = (number(3) * across / (length * (length + z.abs()))).sqrt();
            let y = one - d.shifted(-1);
            (east * d, if dir.z > 0.0 { y } else { -y })
        } else {
            (east, sine * number(3).shifted(-2))
        };
        let dy = dy - (one - number(self.row)).shifted(-1);
        let n = number(self.n);
        let (u, v) = ((dy + dx + half) * n, (dy - dx + half) * n);
        let outside = |w: DoubleDouble, start: i128| {
            let (below, above) = (number(start) - w, w - number(start + 1));
            below.value().max(above.value())
        };
        // `max` would ignore a NaN.
        let (in_u, in_v) = (outside(u, self.ix), outside(v, self.iy));
        if in_u.is_nan() || in_v.is_nan() { f64::NAN } else { in_u.max(in_v).max(0.0) }
    }
}

/// Returns the equivalent longitude between -2 and 2 quarter turns.
fn wrapped(quarters: DoubleDouble) -> DoubleDouble {
    let turns = (quarters.value() / 4.0).round();
    quarters - DoubleDouble::from(4.0 * turns)
}

/// Exact, since there are at most 106 bits here.
fn number(n: i128) -> DoubleDouble {
    let size = DoubleDouble::from(u64::try_from(n.unsigned_abs()).unwrap_or(u64::MAX));
    if n < 0 { -size } else { size }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use sphvar_healpix::Nside;

    use super::*;

    fn cells(n: u32) -> impl Iterator<Item = Cell> {
        let nside = Nside::new(n).unwrap();
        (0..12).flat_map(move |face| {
            (0..n).flat_map(move |ix| (0..n).map(move |iy| Cell::new(nside, face, ix, iy).unwrap()))
        })
    }

    #[test]
    fn numbers_are_a_permutation_from_0() {
        for n in [1, 2, 3, 4, 5, 8] {
            let all: BTreeSet<i128> = (0..12 * i128::from(n * n)).collect();
            let ring: BTreeSet<_> = cells(n).map(|c| Definition::of(c).ring_number()).collect();
            assert_eq!(ring, all, "ring order, nside {n}");
            if n.is_power_of_two() {
                let numbers = cells(n).map(|c| Definition::of(c).nested_number());
                assert_eq!(numbers.collect::<BTreeSet<_>>(), all, "nested order, nside {n}");
            }
        }
    }

    #[test]
    fn a_centre_is_only_in_its_own_pixel() {
        for n in [1, 2, 5] {
            for cell in cells(n) {
                let centre = Definition::of(cell).centre().map(DoubleDouble::value);
                for other in cells(n) {
                    let excess = Definition::of(other).excess(DVec3::from_array(centre));
                    // Half a side from every edge; the rounding of the centre does not move its
                    // longitude across an edge.
                    let right = if other == cell { excess <= 0.0 } else { excess > 0.49 };
                    assert!(right, "{centre:?} of {cell:?} in {other:?}: {excess}");
                }
            }
        }
    }
}
