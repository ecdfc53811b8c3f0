use crate::azimuth::{Azimuth, floor};
use crate::zone::{Z_BORDER, cap_distance, cap_distance_of_theta, z_of_theta};
use crate::{Nside, PixelOrder};

/// The low 31 bits, which hold every number that they are cut out of: coordinates and numbers of rings, below `4 nside`,
/// at most 2^31. A product of two such numbers, or of one up to `2 nside` and `4 nside`, is one instruction on lanes of
/// 64 bits, and leaves a bit of an `i64` for what is added to it.
pub(crate) const LOW: i64 = 0x7FFF_FFFF;

/// A cell in numbers as wide as an `f64`, so that a lane of a register keeps its width from direction to pixel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LaneCell {
    /// The face, 0..12.
    pub(crate) face: i64,
    /// The coordinate towards north-east, 0..nside.
    pub(crate) ix: i64,
    /// Cells from the north-western edge, `nside - 1 - iy`.
    pub(crate) from_top: i64,
    /// The ring, from 1 to `4 nside - 1`.
    pub(crate) ring: i64,
}

impl LaneCell {
    /// The cell of any vector, the one that [`Cell::containing`](crate::Cell::containing) finds: the same operations, but
    /// those of cap and belt are both carried out and one result is chosen. For a single direction that takes longer than
    /// the branches do.
    #[inline(always)]
    pub(crate) fn of_any_vector(nside: Nside, x: f64, y: f64, z: f64) -> Self {
        Self::at(nside, Azimuth::of_xy(x, y), z, cap_distance(x, y, z.abs()))
    }

    /// The cell that contains colatitude `theta` in `[0, pi]` and a longitude, the one that
    /// [`Cell::containing_angles`](crate::Cell::containing_angles) finds.
    #[inline(always)]
    pub(crate) fn of_angles(nside: Nside, theta: f64, azimuth: Azimuth) -> Self {
        let z = z_of_theta(theta);
        Self::at(nside, azimuth, z, cap_distance_of_theta(theta))
    }

    /// The cell at a longitude and a colatitude with cosine `z`, which counts in the belt, and cap distance `distance`, which
    /// counts in the caps. What is not chosen may be out of its range, so differences are signed.
    #[inline(always)]
    fn at(nside: Nside, azimuth: Azimuth, z: f64, distance: f64) -> Self {
        let Azimuth { quadrant, since, until } = azimuth;
        let (n, size) = (i64::from(nside.value()), nside.as_f64());
        let (belt, north, quadrant) = (z.abs() <= Z_BORDER, z > 0.0, i64::from(quadrant));

        let first = if belt { size * ((0.5 + 0.75 * z) + since) } else { since * distance * size };
        let second = if belt { size * ((0.5 - 0.75 * z) + since) } else { until * distance * size };
        let last = if belt { 2.0 * size - 1.0 } else { size - 1.0 };
        let (first, second) = (whole_part(first, last), whole_part(second, last));

        // In the belt these are north_east and south_east, see `belt_cell`.
        let (ne_far, se_far) = (i64::from(first >= n), i64::from(second >= n));
        let belt_face = 4 * (1 + se_far - ne_far) + ((quadrant + (ne_far & se_far)) & 3);
        let belt_ix = if first >= n { first - n } else { first };
        let belt_from_top = if second >= n { second - n } else { second };
        // In a cap, the distances from the pole along the western and the eastern edge of the face.
        let cap_face = if north { quadrant } else { 8 + quadrant };
        let cap_ix = if north { n - 1 - second } else { first };
        let cap_from_top = if north { first } else { n - 1 - second };
        let cap_ring = first + second + 1;
        let cap_ring = if north { cap_ring } else { 4 * n - cap_ring };
        Self {
            face: if belt { belt_face } else { cap_face },
            ix: if belt { belt_ix } else { cap_ix },
            from_top: if belt { belt_from_top } else { cap_from_top },
            ring: if belt { 2 * n + second - first } else { cap_ring },
        }
    }
}

/// A numbering of cells without branches. A trait and not a closure, which would not always be compiled into the loop for
/// wide registers, and then take four times as long.
pub(crate) trait LaneOrder: PixelOrder {
    /// The number of `cell`; to be inlined always.
    fn pixel_of_lane(&self, cell: LaneCell) -> u64;
}

/// The whole part of `coordinate` within 0 and `last < 2^31`, 0 for NaN.
#[inline(always)]
fn whole_part(coordinate: f64, last: f64) -> i64 {
    let from_zero = if coordinate > 0.0 { coordinate } else { 0.0 };
    let within = if from_zero < last { from_zero } else { last };
    floor(within).1.cast_signed() & LOW
}

#[cfg(test)]
pub(crate) mod tests {
    use glam::DVec3;

    use super::*;
    use crate::Cell;

    /// Signed zeros, the smallest and largest numbers, neighbours of the borders between the zones, and what is no number.
    const HOSTILE: [f64; 20] = [
        0.0,
        -0.0,
        5e-324,
        -5e-324,
        1e-310,
        f64::MIN_POSITIVE,
        1e-160,
        -1e-9,
        0.5,
        -0.5,
        Z_BORDER,
        -Z_BORDER,
        Z_BORDER + f64::EPSILON,
        -Z_BORDER - f64::EPSILON,
        1.0,
        -1.0,
        1e308,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::NAN,
    ];

    /// Any three of them, whatever the length; more than a block and no multiple of one.
    pub(crate) fn hostile_vectors() -> Vec<DVec3> {
        let mut vectors = Vec::new();
        for x in HOSTILE {
            for y in HOSTILE {
                vectors.extend(HOSTILE.map(|z| DVec3::new(x, y, z)));
            }
        }
        vectors.truncate(vectors.len() - 1);
        vectors
    }

    #[test]
    fn any_bits_have_the_cell_of_the_look_up_with_branches() {
        for n in [1, 2, 3, 1024, 12345, Nside::MAX - 1, Nside::MAX] {
            let nside = Nside::new(n).unwrap();
            for v in hostile_vectors() {
                let got = LaneCell::of_any_vector(nside, v.x, v.y, v.z);
                let cell = Cell::of_any_vector(nside, v);
                let expected = (
                    i64::from(cell.face()),
                    i64::from(cell.ix()),
                    i64::from(n - 1 - cell.iy()),
                    i64::from(cell.ring()),
                );
                assert_eq!(
                    (got.face, got.ix, got.from_top, got.ring),
                    expected,
                    "nside {n}, {v}: {got:?} against {cell:?}"
                );
            }
        }
    }

    #[test]
    fn whole_parts_are_those_of_a_cast() {
        for last in [0_u32, 1, 5, (1 << 30) - 1, u32::MAX / 2] {
            for coordinate in HOSTILE.into_iter().chain([
                1.5,
                2.0 - f64::EPSILON,
                4.999_999,
                5.0,
                1e9 + 0.5,
                f64::from(last),
                f64::from(last) + 0.5,
                f64::from(last) - 0.5,
                (f64::from(last) - 0.5).next_down(),
            ]) {
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "the cast that saturates is the definition"
                )]
                let expected = (coordinate as u32).min(last);
                assert_eq!(
                    whole_part(coordinate, f64::from(last)),
                    i64::from(expected),
                    "{coordinate}, at most {last}"
                );
            }
        }
    }
}
