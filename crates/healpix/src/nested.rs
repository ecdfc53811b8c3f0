use glam::DVec3;

use crate::lanes::{LaneCell, LaneOrder};
use crate::lists;
use crate::order::{assert_pixel, assert_resolution};
use crate::{Cell, Error, Nside, PixelOrder, Ring};

/// Nested order: pixels numbered face by face along a Z-order curve, for powers of two.
///
/// Pixel `p` of resolution `nside` consists of the pixels `4p .. 4p + 4` of resolution `2 nside`,
/// so pixels with similar numbers are close on the sphere.
///
/// ```text
/// pixel = face nside^2 + interleave(ix, iy)      (ix in the even bits)
/// ```
///
/// # Performance
///
/// An index map takes about twenty integer operations.
///
/// # Examples
///
/// ```
/// use sphvar_healpix::{Nested, Nside, PixelOrder};
///
/// let order = Nested::new(Nside::new(8)?)?;
/// assert_eq!(order.pixel(glam::DVec3::Z), 63);
/// assert!(Nested::new(Nside::new(7)?).is_err());
/// # Ok::<(), sphvar_healpix::Error>(())
/// ```
///
/// # References
///
/// Gorski et al. 2005, ApJ 622, 759, section 4.2.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Nested {
    nside: Nside,
    /// `2 log2(nside)`, the number of bits of a pixel number within its face.
    face_bits: u32,
}

impl Nested {
    /// Returns the nested order of resolution `nside`.
    ///
    /// # Errors
    ///
    /// [`Error::NotPowerOfTwo`].
    pub const fn new(nside: Nside) -> Result<Self, Error> {
        let n = nside.value();
        if !nside.is_power_of_two() {
            let below = 1 << n.ilog2();
            return Err(Error::NotPowerOfTwo { nside: n, below, above: 2 * below });
        }
        Ok(Self { nside, face_bits: 2 * n.ilog2() })
    }

    /// Returns the ring-order number of the pixel with nested number `pixel`.
    ///
    /// # Panics
    ///
    /// Panics if `pixel >= self.n_pixels()`.
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_healpix::{Nested, Nside};
    ///
    /// let order = Nested::new(Nside::new(2)?)?;
    /// assert_eq!(order.to_ring(3), 0);
    /// assert_eq!(order.from_ring(0), 3);
    /// # Ok::<(), sphvar_healpix::Error>(())
    /// ```
    #[inline]
    pub fn to_ring(&self, pixel: u64) -> u64 {
        Ring::new(self.nside).pixel_of_cell(self.cell(pixel))
    }

    /// Returns the nested number of the pixel with ring-order number `ring_pixel`.
    ///
    /// # Panics
    ///
    /// Panics if `ring_pixel >= self.n_pixels()`.
    #[inline]
    pub fn from_ring(&self, ring_pixel: u64) -> u64 {
        self.pixel_of_cell(Ring::new(self.nside).cell(ring_pixel))
    }

    #[inline(always)]
    fn number(&self, face: u64, ix: u64, iy: u64) -> u64 {
        (face << self.face_bits) | spread(ix) | (spread(iy) << 1)
    }
}

impl PixelOrder for Nested {
    #[inline]
    fn nside(&self) -> Nside {
        self.nside
    }

    #[inline]
    fn cell(&self, pixel: u64) -> Cell {
        assert_pixel(self.nside, pixel);
        let in_face = pixel & (self.nside.n_face_pixels() - 1);
        Cell::in_range(
            self.nside,
            face_number(pixel >> self.face_bits),
            even_bits(in_face),
            even_bits(in_face >> 1),
        )
    }

    #[inline]
    fn pixel_of_cell(&self, cell: Cell) -> u64 {
        assert_resolution(self.nside, cell);
        self.number(u64::from(cell.face()), u64::from(cell.ix()), u64::from(cell.iy()))
    }

    fn pixels_into(&self, dirs: &[DVec3], pixels: &mut [u64]) {
        lists::pixels_into(self, dirs, pixels);
    }

    fn pixels_of_angles_into(&self, angles: &[[f64; 2]], pixels: &mut [u64]) -> Result<(), Error> {
        lists::pixels_of_angles_into(self, angles, pixels)
    }
}

impl LaneOrder for Nested {
    /// Implements [`pixel_of_cell`](PixelOrder::pixel_of_cell) without branches.
    #[inline(always)]
    fn pixel_of_lane(&self, cell: LaneCell) -> u64 {
        let iy = i64::from(self.nside.value()) - 1 - cell.from_top;
        self.number(cell.face.cast_unsigned(), cell.ix.cast_unsigned(), iy.cast_unsigned())
    }
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "a pixel below 12 nside^2 is on a face below 12"
)]
#[inline]
fn face_number(face: u64) -> u8 {
    face as u8
}

/// Masks of the bits in use when runs of 16, 8, 4, 2 and 1 bits alternate with gaps of the same
/// length.
const RUNS: [u64; 5] = [
    0x0000_FFFF_0000_FFFF,
    0x00FF_00FF_00FF_00FF,
    0x0F0F_0F0F_0F0F_0F0F,
    0x3333_3333_3333_3333,
    0x5555_5555_5555_5555,
];

/// Moves bit k to bit 2k by splitting runs of adjacent bits in half five times; `value` has at most
/// 32 bits.
#[inline(always)]
fn spread(value: u64) -> u64 {
    let mut bits = value;
    let mut shift = 16;
    for mask in RUNS {
        bits = (bits | (bits << shift)) & mask;
        shift /= 2;
    }
    bits
}

/// Gathers the even bits, the inverse of [`spread`].
#[expect(
    clippy::cast_possible_truncation,
    reason = "the last step intentionally keeps the low 32 bits"
)]
#[inline]
fn even_bits(value: u64) -> u32 {
    let mut bits = value & RUNS[4];
    let mut shift = 1;
    for mask in [RUNS[3], RUNS[2], RUNS[1], RUNS[0]] {
        bits = (bits | (bits >> shift)) & mask;
        shift *= 2;
    }
    (bits | (bits >> 16)) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spread_bit_by_bit(value: u32) -> u64 {
        (0..32).map(|k| u64::from(value >> k & 1) << (2 * k)).sum()
    }

    #[test]
    fn bits_move_according_to_the_definition() {
        let mut value = 1_u32;
        for _ in 0..10_000 {
            // A full-period linear congruential generator (constants of Numerical Recipes).
            value = value.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let spread = spread(u64::from(value));
            assert_eq!(spread, spread_bit_by_bit(value), "{value:#x}");
            let noise = spread_bit_by_bit(!value) << 1;
            assert_eq!(even_bits(spread | noise), value, "{value:#x}");
        }
    }

    #[test]
    fn children_of_a_pixel_lie_in_it() {
        let parent = Nested::new(Nside::new(4).unwrap()).unwrap();
        let child = Nested::new(Nside::new(8).unwrap()).unwrap();
        for pixel in 0..child.n_pixels() {
            assert_eq!(parent.pixel(child.centre(pixel)), pixel / 4, "child {pixel}");
        }
    }

    #[test]
    #[should_panic(expected = "pixel 12 is out of range")]
    fn a_pixel_out_of_range_panics() {
        Nested::new(Nside::new(1).unwrap()).unwrap().cell(12);
    }

    #[test]
    #[should_panic(expected = "a cell of nside 2 was passed to an order of nside 1")]
    fn a_cell_of_another_resolution_panics() {
        let cell = Cell::new(Nside::new(2).unwrap(), 0, 1, 1).unwrap();
        Nested::new(Nside::new(1).unwrap()).unwrap().pixel_of_cell(cell);
    }
}
