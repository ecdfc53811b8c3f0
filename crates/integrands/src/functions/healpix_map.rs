mod belt_rings;
mod cap_rings;
mod coefficients;
#[cfg(test)]
mod definition;
mod height_rule;

use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;
use sphvar_healpix::{Nested, Nside, PixelOrder, Ring};
use sphvar_sh::{Alm, ByParity, Domain};

use crate::energy::check_size;
use crate::{Coefficients, Error, Integrand, Shape, quadrature};

/// A HEALPix map as a function: constant on every pixel.
///
/// The integral is the mean value times the area and the square the mean square, exactly. The
/// coefficients are those of this function with its jumps between pixels, to rounding and for any
/// degree: at every height the Fourier integral over longitude is exact in closed form, since edges
/// of pixels are straight lines in (z, phi) near the equator and hyperbolas near the poles (Gorski
/// et al. 2005, section 5); the integral over height is Gauss-Legendre quadrature between the rings
/// of pixel centres, where it is smooth, with as many nodes as degree and nside require. The common estimate that treats pixels as points
/// (`map2alm`) has these coefficients up to the pixel window and aliasing.
///
/// # Examples
///
/// ```
/// use sphvar_healpix::Nside;
/// use sphvar_integrands::{Domain, HealpixMap, Integrand};
///
/// // The northern four base pixels.
/// let mut values = vec![0.0; 12];
/// values[..4].fill(1.0);
/// let map = HealpixMap::new(Nside::new(1)?, values)?;
/// assert!((map.exact(Domain::Sphere).unwrap() - 4.0 * std::f64::consts::PI / 3.0).abs() < 1e-14);
/// let energy = map.energy(Domain::Sphere, 100)?;
/// assert!(energy.beyond(100) > 0.0 && energy.beyond(100) < 0.03 * energy.total());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct HealpixMap {
    nside: Nside,
    values: Vec<f64>,
}

/// The value that healpy writes into pixels without data; single-precision readers return a rounded
/// value.
const UNSEEN: f64 = -1.6375e30;
/// Tolerance within which a value counts as UNSEEN.
const UNSEEN_TOLERANCE: f64 = 1e-5;
/// Smaller values are finite and not UNSEEN.
const ORDINARY: f64 = 1e30;
/// Number of values that are checked without a branch.
const CHECKED: usize = 1024;

impl HealpixMap {
    /// Returns the map with `values` in ring order.
    ///
    /// # Errors
    ///
    /// [`Error::PixelCount`] unless there are `12 nside^2`; [`Error::Pixels`] if some are NaN,
    /// infinite or the UNSEEN of healpy; [`Error::Magnitude`] if the largest is beyond
    /// [`Energy::MAGNITUDES`](crate::Energy::MAGNITUDES).
    pub fn new(nside: Nside, values: Vec<f64>) -> Result<Self, Error> {
        if values.len() as u64 != nside.n_pixels() {
            let expected = nside.n_pixels();
            return Err(Error::PixelCount { nside: nside.value(), expected, got: values.len() });
        }
        check_values(&values)?;
        Ok(Self { nside, values })
    }

    /// Returns the map with `values` in nested order, which are converted to ring order.
    ///
    /// # Errors
    ///
    /// Those of [`new`](Self::new); pixel indices are in nested order.
    pub fn from_nested(order: Nested, values: Vec<f64>) -> Result<Self, Error> {
        let nside = order.nside();
        if values.len() as u64 != nside.n_pixels() {
            // This call returns the error.
            return Self::new(nside, values);
        }
        check_values(&values)?;
        let value = |ring| usize::try_from(order.from_ring(ring)).map(|pixel| values[pixel]);
        // The number of pixels equals the number of values in memory.
        let rings = (0..nside.n_pixels()).into_par_iter();
        let ringed = rings.map(|ring| value(ring).unwrap_or(f64::NAN)).collect();
        Self::new(nside, ringed)
    }

    /// Returns whether a number is a valid pixel value: finite and not the UNSEEN value of healpy,
    /// -1.6375e30.
    #[must_use]
    #[inline]
    pub fn is_value(value: f64) -> bool {
        value.abs() < ORDINARY
            || value.is_finite() && (value / UNSEEN - 1.0).abs() >= UNSEEN_TOLERANCE
    }

    /// Returns the resolution.
    #[must_use]
    pub fn nside(&self) -> Nside {
        self.nside
    }

    /// Returns the values in ring order.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Returns the coefficients of the map on the sphere, or of its upper half alone, to degree
    /// `lmax`.
    ///
    /// Uses the threads of the current pool of rayon; the result does not depend on their number.
    ///
    /// Cost: a Fourier transform of every ring of pixels, four to eleven nodes per ring and order
    /// while lmax is at most `3 nside`, and a [`RingTransform`](sphvar_sht::RingTransform) of
    /// `lmax + 2` rings.
    ///
    /// # Errors
    ///
    /// [`Error::Harmonics`] if `lmax` is out of range or memory is exhausted.
    pub fn alm(&self, domain: Domain, lmax: usize) -> Result<Alm, Error> {
        coefficients::coefficients(self, domain, lmax)
    }

    /// Returns the values of the rings of `4 nside` pixels, to the equator on the hemisphere.
    fn belt(&self, domain: Domain) -> &[f64] {
        let n = self.n();
        let start = 2 * n * (n - 1);
        let rings = if domain == Domain::Sphere { 2 * n + 1 } else { n + 1 };
        &self.values[start..start + rings * 4 * n]
    }

    fn n(&self) -> usize {
        self.nside.value() as usize
    }

    /// Returns the value of the antipode of every pixel of a ring: the pixel half a ring further in
    /// the opposite ring.
    fn opposite(&self, ring: usize) -> impl Iterator<Item = f64> {
        let across = self.ring(4 * self.n() - 2 - ring);
        let (first, second) = across.split_at(across.len() / 2);
        second.iter().chain(first).copied()
    }

    /// Returns the values of a ring, 0-based from the north.
    fn ring(&self, ring: usize) -> &[f64] {
        let n = self.n();
        let from_pole = (ring + 1).min(4 * n - 1 - ring);
        let (start, len) = if ring + 1 < n {
            (2 * ring * (ring + 1), 4 * (ring + 1))
        } else if from_pole < n {
            (self.values.len() - 2 * from_pole * (from_pole + 1), 4 * from_pole)
        } else {
            (2 * n * (n - 1) + (ring + 1 - n) * 4 * n, 4 * n)
        };
        &self.values[start..start + len]
    }

    /// Returns the integral over a domain of a function whose sum over the pixels of a ring, 0-based
    /// from the north, is `sum`; pixels on the equator count half on the hemisphere.
    fn integral<const K: usize>(
        &self,
        domain: Domain,
        sum: impl Fn(usize) -> [f64; K] + Sync,
    ) -> [f64; K] {
        let rings = match domain {
            Domain::Sphere => 4 * self.n() - 1,
            Domain::Hemisphere => 2 * self.n(),
        };
        // Added in the order of the rings, for any number of threads.
        let sums: Vec<[f64; K]> = (0..rings).into_par_iter().map(&sum).collect();
        let equator = (domain == Domain::Hemisphere).then_some(rings - 1);
        std::array::from_fn(|k| {
            let sums = sums
                .iter()
                .enumerate()
                .map(|(ring, sums)| if Some(ring) == equator { 0.5 * sums[k] } else { sums[k] });
            self.nside.pixel_area() * sums.sum::<f64>()
        })
    }

    /// Returns the integral of the values over a domain.
    fn sum(&self, domain: Domain) -> f64 {
        let [integral] = self.integral(domain, |ring| [self.ring(ring).iter().sum::<f64>()]);
        integral
    }
}

/// Rejects invalid values.
fn check_values(values: &[f64]) -> Result<(), Error> {
    let is_missing = |v: &f64| !HealpixMap::is_value(*v);
    let has_missing = |values: &[f64]| {
        let ordinary = values.iter().fold(true, |all, v| all & (v.abs() < ORDINARY));
        !ordinary && values.iter().any(is_missing)
    };
    if values.par_chunks(CHECKED).any(has_missing) {
        let first = values.iter().position(is_missing).unwrap_or(0);
        return Err(Error::Pixels {
            count: values.iter().filter(|v| is_missing(v)).count(),
            first,
        });
    }
    // The root mean square is at most the largest value, whose square must not vanish.
    let largest = |values: &[f64]| values.iter().fold(0.0, |max: f64, v| max.max(v.abs()));
    check_size(values.par_chunks(CHECKED).map(largest).reduce(|| 0.0, f64::max))
}

impl Integrand for HealpixMap {
    fn eval(&self, dir: DVec3) -> f64 {
        let pixel = usize::try_from(Ring::new(self.nside).pixel(dir)).unwrap_or(usize::MAX);
        self.values.get(pixel).copied().unwrap_or(f64::NAN)
    }

    fn shape(&self) -> Result<Shape, Error> {
        Err(Error::NoEnergy {
            reason: "the edges of HEALPix pixels are not circles; on the sphere a map may be rotated, and added to or multiplied \
                     by functions without edges; on the hemisphere it must be used unchanged",
        })
    }

    fn exact(&self, domain: Domain) -> Option<f64> {
        Some(self.sum(domain))
    }

    fn coefficients(&self, domain: Domain, lmax: usize) -> Result<Coefficients, Error> {
        // The mean is known without a transform.
        let part = match lmax {
            0 => Coefficients::zonal(DVec3::Z, vec![self.sum(domain) / (4.0 * PI).sqrt()])?,
            _ => Coefficients::general(self.alm(domain, lmax)?),
        };
        Ok(if domain == Domain::Sphere { part } else { part.even_extension() })
    }

    fn centred_square(&self, domain: Domain) -> Result<ByParity, Error> {
        let mean = self.sum(domain) / domain.area();
        let square = |x: f64| x * x;
        if domain == Domain::Hemisphere {
            let [square] = self.integral(domain, |ring| {
                [self.ring(ring).iter().map(|v| square(v - mean)).sum::<f64>()]
            });
            return Ok(ByParity { even: 2.0 * square, odd: 0.0 });
        }
        let [even, odd] = self.integral(domain, |ring| {
            let pairs = self.ring(ring).iter().zip(self.opposite(ring));
            pairs.fold([0.0; 2], |[even, odd], (v, opposite)| {
                let (a, b) = (v - mean, opposite - mean);
                [even + square(0.5 * (a + b)), odd + square(0.5 * (a - b))]
            })
        });
        Ok(ByParity { even, odd })
    }

    fn squared_parts(&self, lmax: usize) -> Result<[Coefficients; 2], Error> {
        let part = |sign: f64| {
            let opposite = (0..4 * self.n() - 1).flat_map(|ring| self.opposite(ring));
            let pairs = self.values.iter().zip(opposite);
            let values = pairs.map(|(a, b)| (0.5 * (a + sign * b)).powi(2)).collect();
            Self { values, nside: self.nside }.coefficients(Domain::Sphere, lmax)
        };
        Ok([part(1.0)?, part(-1.0)?])
    }

    /// Exact except for pixels that the equator cuts, which count as whole.
    fn kurtosis(&self, domain: Domain) -> Option<f64> {
        let rings = match domain {
            Domain::Sphere => 4 * self.n() - 1,
            Domain::Hemisphere => 2 * self.n(),
        };
        let values = || (0..rings).flat_map(|r| self.ring(r)).map(|&value| (1.0, value));
        quadrature::weighted_kurtosis(values)
    }

    /// Returns that of the pixels; those of finer maps count as features of 0.1 degrees, and narrower ones
    /// may be missed.
    fn feature_degree(&self) -> Option<usize> {
        Some((4 * self.n()).min(quadrature::MAX_FEATURE_DEGREE))
    }

    fn energy_seconds(&self, _domain: Domain, lmax: usize) -> f64 {
        let (side, degrees) = (self.n() as f64, lmax as f64);
        // The transforms of the rings of pixels, the values at the nodes, and the recurrence.
        20e-9 * 12.0 * side * side + 1e-7 * side * degrees + 5e-11 * degrees.powi(3)
    }
}
