use std::f64::consts::FRAC_PI_4;
use std::ops::Range;

use crate::zone::Zone;
use crate::{Error, Nside};

/// The pixels and the position of one ring of equal colatitude.
///
/// # Examples
///
/// ```
/// use sphvar_healpix::{Nside, Ring};
///
/// let ring = Ring::new(Nside::new(4)?).ring(3)?;
/// assert_eq!(ring.pixels(), 12..24);
/// assert!(ring.is_shifted());
/// assert!((ring.phi(0) - std::f64::consts::PI / 12.0).abs() < 1e-15);
/// # Ok::<(), sphvar_healpix::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RingGeometry {
    index: u32,
    first_pixel: u64,
    n_pixels: u32,
    shifted: bool,
    zone: Zone,
}

impl RingGeometry {
    pub(crate) fn new(nside: Nside, index: u32) -> Result<Self, Error> {
        let n = nside.value();
        if index == 0 || index > nside.n_rings() {
            return Err(Error::RingOutOfRange { ring: index, n_rings: nside.n_rings() });
        }
        let from_pole = index.min(4 * n - index);
        if from_pole < n {
            let distance = f64::from(from_pole) / nside.as_f64();
            let northern = index == from_pole;
            Ok(Self {
                index,
                first_pixel: if northern {
                    cap_start(index)
                } else {
                    nside.n_pixels() - cap_start(from_pole + 1)
                },
                n_pixels: 4 * from_pole,
                shifted: true,
                zone: if northern { Zone::North(distance) } else { Zone::South(distance) },
            })
        } else {
            let row = index - n;
            let z = 2.0 * (2.0 * nside.as_f64() - f64::from(index)) / (3.0 * nside.as_f64());
            Ok(Self {
                index,
                first_pixel: nside.n_cap_pixels() + 4 * u64::from(n) * u64::from(row),
                n_pixels: 4 * n,
                shifted: row.is_multiple_of(2),
                zone: Zone::Belt(z),
            })
        }
    }

    /// Returns the number of the ring, from 1 (north) to `4 nside - 1` (south).
    pub const fn index(&self) -> u32 {
        self.index
    }

    /// Returns the first pixel of the ring, in ring order.
    pub const fn first_pixel(&self) -> u64 {
        self.first_pixel
    }

    /// Returns the number of pixels in the ring, `4 min(i, 4 nside - i, nside)`.
    pub const fn n_pixels(&self) -> u32 {
        self.n_pixels
    }

    /// Returns the pixels of the ring, in ring order.
    pub const fn pixels(&self) -> Range<u64> {
        self.first_pixel..self.first_pixel + self.n_pixels as u64
    }

    /// Returns the cosine of the colatitude of the pixel centres.
    pub fn z(&self) -> f64 {
        self.zone.sin_cos().1
    }

    /// Returns the sine of the colatitude of the pixel centres, with full relative precision at the
    /// poles.
    pub fn sin_theta(&self) -> f64 {
        self.zone.sin_cos().0
    }

    /// Returns the colatitude of the pixel centres in radians, with full relative precision at the
    /// north pole.
    pub fn theta(&self) -> f64 {
        self.zone.theta()
    }

    /// Returns whether the first centre is half a pixel east of longitude 0 instead of on it.
    pub const fn is_shifted(&self) -> bool {
        self.shifted
    }

    /// Returns the longitude in radians of the centre of pixel `place` of the ring, counted from 0.
    ///
    /// For `place` beyond the length of the ring, longitudes continue beyond 2 pi.
    pub fn phi(&self, place: u32) -> f64 {
        // In half pixels, of which pi/4 has n_pixels/4: exact up to the division.
        let half_pixels = 2.0 * f64::from(place) + f64::from(u8::from(self.shifted));
        FRAC_PI_4 * (4.0 * half_pixels / f64::from(self.n_pixels))
    }
}

/// Returns the number of pixels north of ring `ring` of the northern cap, `2 ring (ring - 1)`.
#[inline]
pub(crate) const fn cap_start(ring: u32) -> u64 {
    2 * ring as u64 * (ring as u64 - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{PixelOrder, Ring};

    #[test]
    fn rings_tile_the_pixels_and_agree_with_the_centres() {
        for n in [1, 2, 3, 4, 7, 16] {
            let order = Ring::new(Nside::new(n).unwrap());
            let mut next = 0;
            for index in 1..=order.nside().n_rings() {
                let ring = order.ring(index).unwrap();
                assert_eq!(ring.first_pixel(), next, "nside {n}, ring {index}");
                next = ring.pixels().end;
                for (place, pixel) in (0..).zip(ring.pixels()) {
                    let (theta, phi) = order.centre_angles(pixel);
                    // Both sides round once or twice; longitudes reach 2 pi.
                    let tolerance = 8.0 * f64::EPSILON;
                    assert!(
                        (theta - ring.theta()).abs() <= tolerance
                            && (phi - ring.phi(place)).abs() <= tolerance,
                        "nside {n}, pixel {pixel}: ({theta}, {phi}) against {ring:?}"
                    );
                    assert_eq!(order.cell(pixel).ring(), index);
                }
            }
            assert_eq!(next, order.n_pixels());
        }
    }

    #[test]
    fn rings_out_of_range_are_rejected() {
        let order = Ring::new(Nside::new(2).unwrap());
        for ring in [0, 8, u32::MAX] {
            assert_eq!(order.ring(ring), Err(Error::RingOutOfRange { ring, n_rings: 7 }));
        }
        let top = Ring::new(Nside::new(Nside::MAX).unwrap());
        assert_eq!(top.ring(top.nside().n_rings()).unwrap().pixels().end, top.n_pixels());
    }
}
