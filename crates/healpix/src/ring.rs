use std::ops::Range;

use glam::DVec3;

use crate::cell_map::{belt_cell, face_in_row};
use crate::lanes::{LOW, LaneCell, LaneOrder};
use crate::lists;
use crate::order::{assert_pixel, assert_resolution};
use crate::ring_geometry::cap_start;
use crate::{Cell, Error, Nside, PixelOrder, RingGeometry};

/// Ring order: pixels numbered from the north pole southwards along rings of equal colatitude, and
/// eastwards within each ring.
///
/// Ring order exists for every resolution. Ring `i` counts from 1; the `nside - 1` rings nearest to
/// each pole have `4 i` pixels, the `2 nside + 1` rings of the belt have `4 nside`.
///
/// # Performance
///
/// Pixel to cell takes two integer divisions, in the caps also a square root; cell to pixel takes
/// neither.
///
/// # Examples
///
/// ```
/// use sphvar_healpix::{Nside, PixelOrder, Ring};
///
/// let order = Ring::new(Nside::new(7)?);
/// assert_eq!(order.pixel(glam::DVec3::Z), 0);
/// let (theta, phi) = order.centre_angles(300);
/// assert_eq!(order.pixel_of_angles(theta, phi)?, 300);
/// # Ok::<(), sphvar_healpix::Error>(())
/// ```
///
/// # References
///
/// Gorski et al. 2005, ApJ 622, 759, section 4.1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Ring {
    nside: Nside,
}

impl Ring {
    /// Returns the ring order of resolution `nside`.
    #[inline]
    pub const fn new(nside: Nside) -> Self {
        Self { nside }
    }

    /// Returns position, size and offset of ring `ring`, from 1 (north) to `4 nside - 1` (south).
    ///
    /// # Errors
    ///
    /// [`Error::RingOutOfRange`].
    pub fn ring(&self, ring: u32) -> Result<RingGeometry, Error> {
        RingGeometry::new(self.nside, ring)
    }

    /// Returns the pixels `0 .. 6 nside^2`, which contain one of every pair of antipodal pixels.
    ///
    /// They are the rings north of the equator and the half of the equatorial ring with `phi` in
    /// `[0, pi)`, and so the strata of the hemisphere and of antipodal (projective) sets.
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_healpix::{Nside, PixelOrder, Ring};
    ///
    /// let order = Ring::new(Nside::new(3)?);
    /// let half = order.antipodal_half();
    /// assert!(half.clone().all(|pixel| !half.contains(&order.antipode(pixel))));
    /// # Ok::<(), sphvar_healpix::Error>(())
    /// ```
    pub const fn antipodal_half(&self) -> Range<u64> {
        0..6 * self.nside.n_face_pixels()
    }
}

impl PixelOrder for Ring {
    #[inline]
    fn nside(&self) -> Nside {
        self.nside
    }

    #[inline(always)]
    fn cell(&self, pixel: u64) -> Cell {
        assert_pixel(self.nside, pixel);
        let n = self.nside.value();
        let n_cap = self.nside.n_cap_pixels();
        let n_pixels = self.nside.n_pixels();

        if pixel < n_cap {
            let (ring, place) = ring_and_place(pixel);
            let (column, step) = (place / ring, place % ring);
            Cell::in_range(self.nside, face_in_row(0, column), n - ring + step, n - 1 - step)
        } else if pixel < n_pixels - n_cap {
            let in_belt = pixel - n_cap;
            let ring_len = 4 * u64::from(n);
            let row = narrow(in_belt / ring_len);
            let place = narrow(in_belt % ring_len);
            let (quadrant, step) = (place / n, place % n);
            // Diagonal coordinates from the start of the quadrant; both are below 2 nside.
            let north_east = step + n - row.div_ceil(2);
            let south_east = step + row / 2;
            belt_cell(self.nside, quadrant, north_east, south_east)
        } else {
            // Counted from the end, the southern cap has the rings of the northern one, traversed
            // westwards.
            let (ring, from_end) = ring_and_place(n_pixels - 1 - pixel);
            let place = 4 * ring - 1 - from_end;
            let (column, step) = (place / ring, place % ring);
            Cell::in_range(self.nside, face_in_row(2, column), step, ring - 1 - step)
        }
    }

    #[inline]
    fn pixel_of_cell(&self, cell: Cell) -> u64 {
        assert_resolution(self.nside, cell);
        let n = self.nside.value();
        let ring = cell.ring();
        let column = u32::from(cell.face() % 4);
        if ring < n {
            // In a cap, a face has `ring` pixels of the ring, numbered from its western edge.
            let step = n - 1 - cell.iy();
            cap_start(ring) + u64::from(column * ring + step)
        } else if ring <= 3 * n {
            let row = ring - n;
            let start = self.nside.n_cap_pixels() + u64::from(row) * 4 * u64::from(n);
            // Twice the position of the centre, in pixels from longitude 0: the middle of the face
            // plus the offset from it. Odd rows of the belt start at longitude 0, even ones half a
            // pixel east of it.
            let face_middle = if cell.face() / 4 == 1 { 2 * column } else { 2 * column + 1 };
            let twice =
                i64::from(face_middle) * i64::from(n) + i64::from(cell.ix()) - i64::from(cell.iy());
            let place = (twice - i64::from((row & 1) ^ 1)) >> 1;
            let wrapped = if place < 0 { place + 4 * i64::from(n) } else { place };
            start + wrapped.unsigned_abs()
        } else {
            let ring = 4 * n - ring;
            self.nside.n_pixels() - cap_start(ring + 1) + u64::from(column * ring + cell.ix())
        }
    }

    fn pixels_into(&self, dirs: &[DVec3], pixels: &mut [u64]) {
        lists::pixels_into(self, dirs, pixels);
    }

    fn pixels_of_angles_into(&self, angles: &[[f64; 2]], pixels: &mut [u64]) -> Result<(), Error> {
        lists::pixels_of_angles_into(self, angles, pixels)
    }
}

impl LaneOrder for Ring {
    /// Implements [`pixel_of_cell`](PixelOrder::pixel_of_cell) without branches: computes the
    /// numbers for all three regions and selects one.
    #[inline(always)]
    fn pixel_of_lane(&self, cell: LaneCell) -> u64 {
        let LaneCell { face, ix, from_top, ring } = cell;
        let n = i64::from(self.nside.value());
        let column = face & 3;
        let north = ring < n;
        let from_pole = if north { ring } else { 4 * n - ring } & LOW;
        let square = from_pole * from_pole;
        let start =
            if north { 2 * (square - from_pole) } else { 12 * n * n - 2 * (square + from_pole) };
        let in_cap = start + column * from_pole + if north { from_top } else { ix };

        let row = ring - n;
        let face_middle = 2 * column + i64::from(face & 4 == 0);
        let twice = face_middle * n + ix - (n - 1 - from_top);
        let place = (twice - ((row & 1) ^ 1)) >> 1;
        let wrapped = if place < 0 { place + 4 * n } else { place };
        let in_belt = 2 * n * (n - 1) + (row & LOW) * (4 * n) + wrapped;

        let pixel = if north | (ring > 3 * n) { in_cap } else { in_belt };
        pixel.cast_unsigned()
    }
}

/// Returns the ring of a pixel of the northern cap, and its position in the ring.
#[inline]
fn ring_and_place(pixel: u64) -> (u32, u32) {
    let ring = cap_ring(pixel);
    (ring, narrow(pixel - cap_start(ring)))
}

/// Returns the largest `i` with `2 i (i - 1) <= pixel`.
#[expect(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the root is positive and below 2^29.1; the comparison corrects its rounding"
)]
#[inline]
fn cap_ring(pixel: u64) -> u32 {
    // The root of 2 i (i - 1) = pixel. For pixels below 2^59 it is below 2^29 with an error below
    // 2^-20, so the integer part is wrong by one at most.
    let guess = (0.5 + (0.25 + 0.5 * pixel as f64).sqrt()) as u32;
    if cap_start(guess) > pixel {
        guess - 1
    } else if cap_start(guess + 1) <= pixel {
        guess + 1
    } else {
        guess
    }
}

/// Converts the position in a ring or the number of a row to 32 bits: both are at most
/// `4 nside <= 2^31`.
#[expect(clippy::cast_possible_truncation, reason = "at most 2^31 by contract")]
#[inline]
fn narrow(place: u64) -> u32 {
    debug_assert!(u32::try_from(place).is_ok(), "{place}");
    place as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_is_by_ring_and_then_longitude() {
        for n in 1..=9 {
            let order = Ring::new(Nside::new(n).unwrap());
            let mut before = (0, -1.0);
            for pixel in 0..order.n_pixels() {
                let cell = order.cell(pixel);
                let key = (cell.ring(), cell.centre_angles().1);
                assert!(key > before, "nside {n}, pixel {pixel}: {key:?} after {before:?}");
                before = key;
                assert_eq!(order.pixel_of_cell(cell), pixel, "nside {n}");
            }
        }
    }

    #[test]
    fn ring_starts_of_a_cap_are_exact() {
        let last = Nside::MAX - 1;
        for ring in (1..=2000).chain(last - 2000..=last) {
            let start = cap_start(ring);
            assert_eq!(cap_ring(start), ring);
            assert_eq!(cap_ring(start + 4 * u64::from(ring) - 1), ring);
        }
    }

    #[test]
    fn antipodal_half_has_one_of_each_pair() {
        for n in 1..=12 {
            let order = Ring::new(Nside::new(n).unwrap());
            let half = order.antipodal_half();
            for pixel in 0..order.n_pixels() {
                let other = order.antipode(pixel);
                assert_ne!(
                    half.contains(&pixel),
                    half.contains(&other),
                    "nside {n}: {pixel} and {other}"
                );
            }
        }
    }

    #[test]
    #[should_panic(expected = "pixel 108 is out of range")]
    fn a_pixel_out_of_range_panics() {
        Ring::new(Nside::new(3).unwrap()).cell(108);
    }
}
