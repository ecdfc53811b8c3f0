use std::f64::consts::PI;
use std::fmt;

use crate::Error;

/// The resolution of a grid: each of the 12 faces consists of `nside x nside` pixels.
///
/// [`Nside::new`] validates the value once; types built from it need no further check.
///
/// # Examples
///
/// ```
/// use sphvar_healpix::Nside;
///
/// let nside = Nside::new(18)?;
/// assert_eq!(nside.n_pixels(), 3888);
/// assert!(Nside::new(0).is_err());
/// # Ok::<(), sphvar_healpix::Error>(())
/// ```
///
/// # References
///
/// Gorski et al. 2005, ApJ 622, 759, doi:10.1086/427976.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Nside(u32);

impl Nside {
    /// The maximum value, 2^29: the pixel count `12 nside^2 = 3.5e18` fits 63 bits, and a pixel is
    /// 1.9e-9 rad wide, seven digits above the resolution of `f64` directions.
    pub const MAX: u32 = 1 << 29;

    /// Returns the resolution `nside`, any integer in `[1, 2^29]`.
    ///
    /// # Errors
    ///
    /// [`Error::NsideOutOfRange`] for 0 and above 2^29.
    pub const fn new(nside: u32) -> Result<Self, Error> {
        if nside == 0 || nside > Self::MAX {
            return Err(Error::NsideOutOfRange { nside, max: Self::MAX });
        }
        Ok(Self(nside))
    }

    /// Returns the resolution whose grid has exactly `n_pixels = 12 nside^2` pixels.
    ///
    /// # Errors
    ///
    /// [`Error::NotPixelCount`], with the nearest valid count, if there is none.
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_healpix::Nside;
    ///
    /// assert_eq!(Nside::from_n_pixels(972)?.value(), 9);
    /// let message = Nside::from_n_pixels(1024).unwrap_err().to_string();
    /// assert!(message.contains("the nearest valid count is 972 (nside 9)"), "{message}");
    /// # Ok::<(), sphvar_healpix::Error>(())
    /// ```
    pub fn from_n_pixels(n_pixels: u64) -> Result<Self, Error> {
        let nearest = Self::nearest(n_pixels);
        if nearest.n_pixels() == n_pixels {
            Ok(nearest)
        } else {
            Err(Error::NotPixelCount { n_pixels, nearest: nearest.n_pixels(), nside: nearest.0 })
        }
    }

    /// Returns the resolution whose pixel count is nearest to `n_points`, for ring order.
    ///
    /// For a count midway between two valid ones (`12 nside^2 + 6 (2 nside + 1)`), the lower
    /// resolution is returned.
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_healpix::Nside;
    ///
    /// assert_eq!(Nside::nearest(4096).n_pixels(), 3888);
    /// assert_eq!(Nside::nearest(0).n_pixels(), 12);
    /// assert_eq!(Nside::nearest(u64::MAX).value(), Nside::MAX);
    /// ```
    pub fn nearest(n_points: u64) -> Self {
        let root = (n_points / 12).isqrt();
        let below = u32::try_from(root).map_or(Self::MAX, |n| n.clamp(1, Self::MAX));
        let above = (below + 1).min(Self::MAX);
        Self::nearer(n_points, below, above)
    }

    /// Returns the power of two whose pixel count is nearest to `n_points`, for nested order; in
    /// case of a tie, the lower one.
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_healpix::Nside;
    ///
    /// assert_eq!(Nside::nearest_power_of_two(4096).n_pixels(), 3072);
    /// assert_eq!(Nside::nearest_power_of_two(1024).n_pixels(), 768);
    /// ```
    pub fn nearest_power_of_two(n_points: u64) -> Self {
        let root = (n_points / 12).isqrt();
        let limit = u32::try_from(root).map_or(Self::MAX, |n| n.clamp(1, Self::MAX));
        let below = 1 << limit.ilog2();
        let above = (2 * below).min(Self::MAX);
        Self::nearer(n_points, below, above)
    }

    fn nearer(n_points: u64, below: u32, above: u32) -> Self {
        let (below, above) = (Self(below), Self(above));
        if n_points.abs_diff(below.n_pixels()) <= n_points.abs_diff(above.n_pixels()) {
            below
        } else {
            above
        }
    }

    /// Returns nside as an integer.
    #[inline]
    pub const fn value(self) -> u32 {
        self.0
    }

    /// Returns the number of pixels, `12 nside^2`.
    #[inline]
    pub const fn n_pixels(self) -> u64 {
        12 * self.n_face_pixels()
    }

    /// Returns the number of rings of equal colatitude, `4 nside - 1`.
    #[inline]
    pub const fn n_rings(self) -> u32 {
        4 * self.0 - 1
    }

    /// Returns the solid angle of every pixel in steradians, `4 pi / (12 nside^2)`.
    #[inline]
    pub fn pixel_area(self) -> f64 {
        PI / (3.0 * self.as_f64() * self.as_f64())
    }

    /// Returns whether nested order exists at this resolution.
    #[inline]
    pub const fn is_power_of_two(self) -> bool {
        self.0.is_power_of_two()
    }

    /// Returns `pixel` if it is a valid pixel number, for ring and nested order alike.
    ///
    /// # Errors
    ///
    /// [`Error::PixelOutOfRange`] if `pixel >= 12 nside^2`.
    #[inline]
    pub const fn check_pixel(self, pixel: u64) -> Result<u64, Error> {
        if pixel < self.n_pixels() {
            Ok(pixel)
        } else {
            Err(Error::PixelOutOfRange { pixel, n_pixels: self.n_pixels() })
        }
    }

    #[inline]
    pub(crate) fn as_f64(self) -> f64 {
        f64::from(self.0)
    }

    /// Returns the number of pixels of one face, `nside^2`.
    #[inline]
    pub(crate) const fn n_face_pixels(self) -> u64 {
        self.0 as u64 * self.0 as u64
    }

    /// Returns the number of pixels of one polar cap, the rings strictly north of `z = 2/3`:
    /// `2 nside (nside - 1)`.
    #[inline]
    pub(crate) const fn n_cap_pixels(self) -> u64 {
        2 * self.0 as u64 * (self.0 as u64 - 1)
    }
}

impl fmt::Display for Nside {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl TryFrom<u32> for Nside {
    type Error = Error;

    fn try_from(nside: u32) -> Result<Self, Error> {
        Self::new(nside)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits() {
        assert_eq!(Nside::new(0), Err(Error::NsideOutOfRange { nside: 0, max: Nside::MAX }));
        assert!(Nside::new(Nside::MAX + 1).is_err());
        assert!(Nside::new(u32::MAX).is_err());
        let top = Nside::new(Nside::MAX).unwrap();
        assert_eq!(top.n_pixels(), 3_458_764_513_820_540_928);
        assert_eq!(top.n_rings(), 2_147_483_647);
        assert!(top.check_pixel(top.n_pixels() - 1).is_ok());
        assert!(top.check_pixel(top.n_pixels()).is_err());
    }

    #[test]
    fn nearest_agrees_with_a_scan() {
        for n_points in 0..20_000_u64 {
            let scan = |candidates: &[u32]| {
                *candidates
                    .iter()
                    .min_by_key(|&&n| (12 * u64::from(n * n)).abs_diff(n_points))
                    .unwrap()
            };
            let all: Vec<u32> = (1..64).collect();
            assert_eq!(Nside::nearest(n_points).value(), scan(&all), "n_points {n_points}");
            let powers = [1, 2, 4, 8, 16, 32, 64];
            assert_eq!(
                Nside::nearest_power_of_two(n_points).value(),
                scan(&powers),
                "n_points {n_points}"
            );
        }
    }

    #[test]
    fn pixel_counts_are_inverted_up_to_the_maximum() {
        for nside in [1, 2, 3, 1000, 65_535, 65_536, Nside::MAX - 1, Nside::MAX] {
            let nside = Nside::new(nside).unwrap();
            assert_eq!(Nside::from_n_pixels(nside.n_pixels()), Ok(nside));
            assert!(Nside::from_n_pixels(nside.n_pixels() + 1).is_err(), "{nside}");
        }
        assert!(Nside::from_n_pixels(0).is_err());
        assert!(Nside::from_n_pixels(u64::MAX).is_err());
    }
}
