use std::f64::consts::{FRAC_PI_4, PI};

use glam::DVec3;

use crate::azimuth::{Azimuth, sin_cos_eighths};
use crate::zone::Zone;
use crate::{Cell, Error, Nside};

/// The largest `f64` below 1, which keeps cell coordinates in `[0, 1)` for points on an upper edge.
const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;

/// Maximum deviation from 1 of the squared length of a direction in debug builds. Products of many
/// rotations pass; vectors read in single precision must be normalized first.
const UNIT_TOLERANCE: f64 = 1e-9;

/// Equal-area geometry.
impl Cell {
    /// Returns the direction at `(u, v)` in the cell, by an area-preserving map.
    ///
    /// `u` increases towards north-east and `v` towards north-west, as `ix` and `iy` do: `(0, 0)`
    /// is the southern corner, `(1, 0)` the eastern, `(0, 1)` the western, `(1, 1)` the northern,
    /// and `(1/2, 1/2)` the centre of the pixel. For independent uniform `u` and `v` the direction
    /// is uniform in the pixel. With `x = (ix + u)/nside`, `y = (iy + v)/nside` in a northern face
    /// of longitude index `c = face % 4`:
    ///
    /// ```text
    /// d = 2 - x - y
    /// d <  1:  z = 1 - d^2/3,    phi = pi/4 (2c + 1 + (x - y)/d)
    /// d >= 1:  z = (2 - d) 2/3,  phi = pi/4 (2c + 1 + x - y)
    /// ```
    ///
    /// The other rows are analogous. Domain: `u, v` in `[0, 1]`. The length of the result is 1
    /// within `4 * f64::EPSILON`, and near the poles x and y have full relative precision.
    ///
    /// # Panics
    ///
    /// Panics in debug builds if `u` or `v` is outside `[0, 1]`. In release builds the result is
    /// then meaningless.
    ///
    /// # Performance
    ///
    /// About 12 ns on a server core: two divisions, a square root and two polynomials, without
    /// calls to the mathematical library. Always inlined: a call would pass the cell through
    /// memory, which takes more than 50 % longer.
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_healpix::{Cell, Nside};
    ///
    /// let cell = Cell::new(Nside::new(1)?, 4, 0, 0)?;
    /// let east = cell.uniform_point(1.0, 0.0);
    /// assert!((east.x - east.y).abs() < 1e-15 && east.z == 0.0);
    /// # Ok::<(), sphvar_healpix::Error>(())
    /// ```
    ///
    /// # References
    ///
    /// - Gorski et al. 2005, ApJ 622, 759, section 4.
    /// - Calabretta and Roukema 2007, MNRAS 381, 865: the projection.
    #[inline(always)]
    pub fn uniform_point(self, u: f64, v: f64) -> DVec3 {
        let (zone, longitude) = self.place(u, v);
        let (sin_theta, z) = zone.sin_cos();
        let (sin, cos) = sin_cos_eighths(longitude.offset);
        let (cos, sin) = rotate_by_quarters(cos, sin, longitude.quarter);
        DVec3::new(sin_theta * cos, sin_theta * sin, z)
    }

    /// Returns the density of [`uniform_point`](Self::uniform_point) for uniform `u, v`, per
    /// steradian: the reciprocal of the area of the pixel, everywhere in the cell.
    #[inline]
    pub fn uniform_point_pdf(self) -> f64 {
        1.0 / self.nside().pixel_area()
    }

    /// Returns the cell that contains `dir` and the coordinates `(u, v)` in `[0, 1)` of `dir`
    /// within it.
    ///
    /// This is the inverse of [`uniform_point`](Self::uniform_point) up to rounding, which at
    /// resolution `nside` changes `u` and `v` by about `nside * f64::EPSILON`; a point within that
    /// distance of an edge may be located in the neighbour. A point on an edge belongs to the cell
    /// east of it in the belt, to the cell nearer to the equator in a cap, and to the eastern cell
    /// on a meridian between two faces, as in the reference implementation. Where that edge is the
    /// upper end of `u` or `v`, the largest number below 1 is returned.
    ///
    /// # Panics
    ///
    /// Panics in debug builds if `dir` is not a unit vector (see
    /// [`unit_direction`](crate::unit_direction)). In release builds the result is then an
    /// arbitrary valid cell.
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_healpix::{Cell, Nside};
    ///
    /// let cell = Cell::new(Nside::new(7)?, 2, 6, 5)?;
    /// let (found, u, v) = Cell::invert_uniform_point(cell.nside(), cell.uniform_point(0.3, 0.9));
    /// assert_eq!(found, cell);
    /// assert!((u - 0.3).abs() < 1e-14 && (v - 0.9).abs() < 1e-14);
    /// # Ok::<(), sphvar_healpix::Error>(())
    /// ```
    #[inline]
    pub fn invert_uniform_point(nside: Nside, dir: DVec3) -> (Self, f64, f64) {
        assert_unit(dir);
        locate_dir(nside, dir)
    }

    /// Returns the cell that contains the unit vector `dir`.
    ///
    /// Edges and preconditions are as for [`invert_uniform_point`](Self::invert_uniform_point).
    ///
    /// # Panics
    ///
    /// Panics in debug builds if `dir` is not a unit vector.
    ///
    /// # Performance
    ///
    /// About 12 ns on a server core: a division, a polynomial, and in the caps a second division
    /// and a square root. Directions in random order take 50 % longer, because the branch between
    /// cap and belt is then mispredicted.
    #[inline(always)]
    pub fn containing(nside: Nside, dir: DVec3) -> Self {
        assert_unit(dir);
        Self::of_any_vector(nside, dir)
    }

    /// Implements [`containing`](Self::containing) without its check; vectors of other lengths and
    /// NaN give an arbitrary valid cell.
    #[inline(always)]
    pub(crate) fn of_any_vector(nside: Nside, v: DVec3) -> Self {
        locate_dir(nside, v).0
    }

    /// Returns the cell that contains colatitude `theta` in `[0, pi]` and longitude `phi`, any
    /// finite angle, in radians.
    ///
    /// # Errors
    ///
    /// [`Error::ThetaOutOfRange`] and [`Error::PhiNotFinite`].
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_healpix::{Cell, Nside};
    ///
    /// let nside = Nside::new(2)?;
    /// assert_eq!(Cell::containing_angles(nside, 0.1, -0.1)?.face(), 3);
    /// assert!(Cell::containing_angles(nside, 3.2, 0.0).is_err());
    /// # Ok::<(), sphvar_healpix::Error>(())
    /// ```
    #[inline]
    pub fn containing_angles(nside: Nside, theta: f64, phi: f64) -> Result<Self, Error> {
        if !(0.0..=PI).contains(&theta) {
            return Err(Error::ThetaOutOfRange { theta });
        }
        if !phi.is_finite() {
            return Err(Error::PhiNotFinite { phi });
        }
        Ok(locate(nside, Zone::of_theta(theta), Azimuth::of_phi(phi)).0)
    }

    /// Returns the direction of the centre.
    #[inline]
    pub fn centre(self) -> DVec3 {
        self.uniform_point(0.5, 0.5)
    }

    /// Returns the colatitude and the longitude of the centre in radians, `theta` in `(0, pi)`,
    /// `phi` in `[0, 2 pi)`.
    #[inline]
    pub fn centre_angles(self) -> (f64, f64) {
        let (zone, longitude) = self.place(0.5, 0.5);
        (zone.theta(), longitude.phi())
    }

    /// Returns the directions of the northern, western, southern and eastern corner.
    ///
    /// # Examples
    ///
    /// ```
    /// use glam::DVec3;
    /// use sphvar_healpix::{Cell, Nside};
    ///
    /// let [north, ..] = Cell::new(Nside::new(8)?, 1, 7, 7)?.corners();
    /// assert_eq!(north, DVec3::Z);
    /// # Ok::<(), sphvar_healpix::Error>(())
    /// ```
    pub fn corners(self) -> [DVec3; 4] {
        [(1.0, 1.0), (0.0, 1.0), (0.0, 0.0), (1.0, 0.0)].map(|(u, v)| self.uniform_point(u, v))
    }

    #[inline(always)]
    fn place(self, u: f64, v: f64) -> (Zone, Longitude) {
        debug_assert!(
            (0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v),
            "cell coordinates ({u}, {v}) are outside [0, 1]"
        );
        let n = self.nside().as_f64();
        let last = self.nside().value() - 1;
        let column = u32::from(self.face() % 4);
        let row = self.face() / 4;
        let belt_scale = 2.0 / (3.0 * n);

        if row == 1 {
            let x = f64::from(self.ix()) + u;
            let y = f64::from(self.iy()) + v;
            let longitude = Longitude { quarter: column, offset: (x - y) / n };
            return (Zone::Belt((x + y - n) * belt_scale), longitude);
        }
        // Distances from the corner at the pole along the eastern and western edge of the face.
        // They start from integers, so that they keep their digits at the pole.
        let (west, east) = if row == 0 {
            (f64::from(last - self.iy()) + (1.0 - v), f64::from(last - self.ix()) + (1.0 - u))
        } else {
            (f64::from(self.ix()) + u, f64::from(self.iy()) + v)
        };
        let distance = west + east;
        let zone = match (distance < n, row) {
            (true, 0) => Zone::North(distance / n),
            (true, _) => Zone::South(distance / n),
            (false, 0) => Zone::Belt((2.0 * n - distance) * belt_scale),
            (false, _) => Zone::Belt((distance - 2.0 * n) * belt_scale),
        };
        let width = distance.min(n);
        // The middle of the face is midway between two quarters; count from the nearer one.
        let from_middle = west - east;
        let longitude = Longitude {
            quarter: column + u32::from(west >= east),
            // The floor only affects 0/0, at the pole, where the longitude is arbitrary.
            offset: (from_middle - width.copysign(from_middle)) / width.max(f64::MIN_POSITIVE),
        };
        (zone, longitude)
    }
}

/// Rotates the vector `(x, y)` exactly, by `quarters` times pi/2. Uses bit operations, since a
/// branch between the four cases would be mispredicted.
#[inline]
fn rotate_by_quarters(x: f64, y: f64, quarters: u32) -> (f64, f64) {
    const SIGN_BIT: u32 = 63;
    let (x, y) = (x.to_bits(), y.to_bits());
    let swap = (x ^ y) & u64::from(quarters & 1).wrapping_neg();
    let x_sign = u64::from((quarters ^ (quarters >> 1)) & 1) << SIGN_BIT;
    let y_sign = u64::from((quarters >> 1) & 1) << SIGN_BIT;
    (f64::from_bits(x ^ swap ^ x_sign), f64::from_bits(y ^ swap ^ y_sign))
}

/// Panics in debug builds unless `dir` is a unit vector.
#[inline]
pub(crate) fn assert_unit(dir: DVec3) {
    debug_assert!(
        (dir.length_squared() - 1.0).abs() <= UNIT_TOLERANCE,
        "{dir} is not a unit vector"
    );
}

/// A longitude as the nearest multiple of pi/2, 0..=4, and the offset from it in units of pi/4, in
/// `[-1, 1]`.
#[derive(Debug, Clone, Copy)]
struct Longitude {
    quarter: u32,
    offset: f64,
}

impl Longitude {
    /// Returns the longitude in radians, in `[0, 2 pi)`.
    #[inline]
    fn phi(self) -> f64 {
        let mut eighths = f64::from(2 * self.quarter) + self.offset;
        if eighths < 0.0 {
            eighths += 8.0;
        }
        // Not `else`: a tiny negative number has just been rounded to 8.
        if eighths >= 8.0 {
            eighths -= 8.0;
        }
        eighths * FRAC_PI_4
    }
}

/// Returns the cell and the coordinates within it for any vector; vectors that are not finite also
/// get a cell.
///
/// Always inlined, as is [`locate`], so that callers that need only the cell do not compute the
/// coordinates.
#[inline(always)]
fn locate_dir(nside: Nside, dir: DVec3) -> (Cell, f64, f64) {
    let azimuth = Azimuth::of_xy(dir.x, dir.y);
    // Last, so that the computation and the use of the zone become one branch.
    let zone = Zone::of_xyz(dir.x, dir.y, dir.z);
    locate(nside, zone, azimuth)
}

#[inline(always)]
fn locate(nside: Nside, zone: Zone, azimuth: Azimuth) -> (Cell, f64, f64) {
    let n = nside.as_f64();
    let last = nside.value() - 1;
    let (distance, southern) = match zone {
        Zone::Belt(z) => {
            // In the belt the cells are squares rotated by pi/4. Their two diagonal coordinates,
            // counted from the start of the quadrant, split it into four triangles: of the northern
            // face, the southern face and two equatorial faces.
            let (north_east, u) =
                split_integer(n * ((0.5 + 0.75 * z) + azimuth.since), 2 * last + 1);
            let (south_east, down) =
                split_integer(n * ((0.5 - 0.75 * z) + azimuth.since), 2 * last + 1);
            let cell = belt_cell(nside, azimuth.quadrant, north_east, south_east);
            return (cell, u.min(BELOW_ONE), (1.0 - down).min(BELOW_ONE));
        }
        Zone::North(distance) => (distance, false),
        Zone::South(distance) => (distance, true),
    };
    // Distances from the pole along the western and eastern edge of the face.
    let (west, west_part) = split_integer(azimuth.since * distance * n, last);
    let (east, east_part) = split_integer(azimuth.until * distance * n, last);
    let (row, ix, iy) = if southern { (2, west, east) } else { (0, last - east, last - west) };
    let (u, v) = if southern { (west_part, east_part) } else { (1.0 - east_part, 1.0 - west_part) };
    (
        Cell::in_range(nside, face_in_row(row, azimuth.quadrant), ix, iy),
        u.min(BELOW_ONE),
        v.min(BELOW_ONE),
    )
}

/// Returns the cell of the belt at the diagonal coordinates `north_east` and `south_east`, both in
/// `0..2 nside`, counted from the start of `quadrant`.
#[inline]
pub(crate) fn belt_cell(nside: Nside, quadrant: u32, north_east: u32, south_east: u32) -> Cell {
    let n = nside.value();
    let (ne_far, se_far) = (north_east >= n, south_east >= n);
    let ix = if ne_far { north_east - n } else { north_east };
    let from_top = if se_far { south_east - n } else { south_east };
    // Beyond the first face on one diagonal only: the row on that side; on both: the next face of
    // the equator.
    let row = 1 + u8::from(se_far) - u8::from(ne_far);
    let column = quadrant + u32::from(ne_far & se_far);
    Cell::in_range(nside, face_in_row(row, column), ix, n - 1 - from_top)
}

#[inline]
pub(crate) fn face_in_row(row: u8, column: u32) -> u8 {
    4 * row + (column & 3) as u8
}

/// Returns the integer part, at most `last`, and the rest, in `[0, 1]`.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "coordinates are 0 to 2^30 within rounding; the cast saturates and maps NaN to 0"
)]
#[inline]
fn split_integer(coordinate: f64, last: u32) -> (u32, f64) {
    let whole = (coordinate as u32).min(last);
    (whole, (coordinate - f64::from(whole)).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arbitrary_vectors_have_a_cell() {
        let hostile =
            [0.0, -0.0, 1.0, -1.0, 5e-324, 1e308, f64::INFINITY, f64::NEG_INFINITY, f64::NAN];
        for n in [1, 3, Nside::MAX] {
            let nside = Nside::new(n).unwrap();
            for x in hostile {
                for y in hostile {
                    for z in hostile {
                        let (cell, _, _) = locate_dir(nside, DVec3::new(x, y, z));
                        assert!(
                            Cell::new(nside, cell.face(), cell.ix(), cell.iy()).is_ok(),
                            "({x}, {y}, {z}): {cell:?}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn rotations_are_exact() {
        let (x, y) = (0.6, -0.8);
        for (quarters, rotated) in
            [(0, (x, y)), (1, (-y, x)), (2, (-x, -y)), (3, (y, -x)), (4, (x, y))]
        {
            assert_eq!(rotate_by_quarters(x, y, quarters), rotated, "{quarters}");
        }
    }

    #[test]
    fn a_point_on_the_prime_meridian_has_longitude_zero() {
        for (quarter, offset) in [(4, 0.0), (0, 0.0), (0, -1e-17)] {
            let phi = Longitude { quarter, offset }.phi();
            assert!((0.0..2.0 * PI).contains(&phi), "{quarter} {offset}: {phi}");
        }
    }
}
