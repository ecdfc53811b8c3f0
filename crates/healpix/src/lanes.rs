use crate::azimuth::{Azimuth, floor};
use crate::zone::{Z_BORDER, cap_distance, cap_distance_of_theta, z_of_theta};
use crate::{Nside, PixelOrder};

/// Mask of the low 31 bits. All masked numbers fit: coordinates, and numbers of rings below
/// `4 nside <= 2^31`. A product of two such numbers, or of factors up to `2 nside` and `4 nside`,
/// is one instruction on 64-bit lanes, and leaves one bit of an `i64` for an addition.
pub(crate) const LOW: i64 = 0x7FFF_FFFF;

/// A cell in 64-bit integers, so that lanes keep the width of an `f64` from direction to pixel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LaneCell {
    /// The face, 0..12.
    pub(crate) face: i64,
    /// The coordinate towards north-east, 0..nside.
    pub(crate) ix: i64,
    /// The number of cells from the north-western edge, `nside - 1 - iy`.
    pub(crate) from_top: i64,
    /// The ring, from 1 to `4 nside - 1`.
    pub(crate) ring: i64,
}

impl LaneCell {
    /// Returns the cell of any vector, as [`Cell::containing`](crate::Cell::containing) does. The
    /// operations are the same, but both cap and belt are computed and one result is selected. For
    /// a single direction this takes longer than branches.
    #[inline(always)]
    pub(crate) fn of_any_vector(nside: Nside, x: f64, y: f64, z: f64) -> Self {
        Self::at(nside, Azimuth::of_xy(x, y), z, cap_distance(x, y, z.abs()))
    }

    /// Returns the cell that contains colatitude `theta` in `[0, pi]` and a longitude, as
    /// [`Cell::containing_angles`](crate::Cell::containing_angles) does.
    #[inline(always)]
    pub(crate) fn of_angles(nside: Nside, theta: f64, azimuth: Azimuth) -> Self {
        let z = z_of_theta(theta);
        Self::at(nside, azimuth, z, cap_distance_of_theta(theta))
    }

    /// Returns the cell at a longitude and a colatitude, which is given by its cosine `z` (used in
    /// the belt) and its cap distance `distance` (used in the caps). The result that is not
    /// selected may be out of range, so differences are signed.
    #[inline(always)]
    fn at(nside: Nside, azimuth: Azimuth, z: f64, distance: f64) -> Self {
        let Azimuth { quadrant, since, until } = azimuth;
        let (n, size) = (i64::from(nside.value()), nside.as_f64());
        let (belt, north, quadrant) = (z.abs() <= Z_BORDER, z > 0.0, i64::from(quadrant));

        let first = if belt { size * ((0.5 + 0.75 * z) + since) } else { since * distance * size };
        let second = if belt { size * ((0.5 - 0.75 * z) + since) } else { until * distance * size };
        let last = if belt { 2.0 * size - 1.0 } else { size - 1.0 };
        let (first, second) = (integer_part(first, last), integer_part(second, last));

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

/// A branch-free numbering of cells. It is a trait because a closure would not always be inlined
/// into the vectorized loop, which would then take four times as long.
pub(crate) trait LaneOrder: PixelOrder {
    /// Returns the number of `cell`; implementations must be `#[inline(always)]`.
    fn pixel_of_lane(&self, cell: LaneCell) -> u64;
}

/// Returns the integer part of `coordinate`, clamped to 0 and `last < 2^31`; 0 for NaN.
#[inline(always)]
fn integer_part(coordinate: f64, last: f64) -> i64 {
    let from_zero = if coordinate > 0.0 { coordinate } else { 0.0 };
    let within = if from_zero < last { from_zero } else { last };
    floor(within).1.cast_signed() & LOW
}

#[cfg(test)]
pub(crate) mod tests {
    use glam::DVec3;

    use super::*;
    use crate::Cell;

    /// Signed zeros, the smallest and largest numbers, neighbours of the borders between the zones,
    /// infinities and NaN.
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

    /// Returns all triples of these, more than a block and not a multiple of one.
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
    fn lanes_match_the_scalar_lookup_for_arbitrary_vectors() {
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
    fn integer_parts_match_a_cast() {
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
                    reason = "the saturating cast is the definition"
                )]
                let expected = (coordinate as u32).min(last);
                assert_eq!(
                    integer_part(coordinate, f64::from(last)),
                    i64::from(expected),
                    "{coordinate}, at most {last}"
                );
            }
        }
    }
}
