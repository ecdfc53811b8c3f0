use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

use glam::DVec3;
use num_complex::Complex;
use sphvar_healpix::{Nested, Nside, PixelOrder, Ring};
use sphvar_nufft::parts::{FftDirection, Real};
use sphvar_sh::Domain;
use sphvar_sh::{Alm, ByParity, Colatitude, GaussLegendre};
use sphvar_sht::{RingTransform, RingWorkspace};

use crate::energy::check_size;
use crate::quadrature::node_count;
use crate::{Coefficients, Error, Integrand, Shape, quadrature};

/// A HEALPix map as a function: constant on every pixel.
///
/// The integral is the mean value times the area and the square the mean square, exactly. The
/// coefficients are those of this function with its jumps between pixels, to rounding and for any
/// degree: at every height the Fourier integral over longitude is exact in closed form, since edges
/// of pixels are straight lines in (z, phi) near the equator and hyperbolas near the poles (Gorski
/// et al. 2005, section 5); the integral over height is Gauss-Legendre quadrature between the rings
/// of pixel centres, where it is smooth. The common estimate that treats pixels as points
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
/// Minimum number of nodes of a panel, for the poles of `1/s` beyond its end.
const MIN_NODES: usize = 12;

/// A ring of the quadrature.
struct Node {
    colatitude: Colatitude,
    /// The weight in z.
    weight: f64,
    /// The two rings of pixels that it crosses, from the nearer pole or from the north.
    bands: [Option<Band>; 2],
}

/// The contribution of a ring of pixels at a height: equal intervals of longitude.
#[derive(Clone, Copy)]
struct Band {
    /// The ring of pixels, 0-based from the north.
    ring: usize,
    /// Half of the width of the intervals.
    half: f64,
    /// The middle of the first interval.
    first: f64,
    /// Their distance within a quarter turn, near the poles; `None` in the belt, where they are
    /// equidistant.
    step: Option<f64>,
}

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
        let ringed = (0..nside.n_pixels()).map(|ring| value(ring).unwrap_or(f64::NAN)).collect();
        Self::new(nside, ringed)
    }

    /// Returns whether a number is a valid pixel value: finite and not the UNSEEN value of healpy,
    /// -1.6375e30.
    #[must_use]
    pub fn is_value(value: f64) -> bool {
        value.is_finite() && (value / UNSEEN - 1.0).abs() >= UNSEEN_TOLERANCE
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
    /// Cost: `R = 4 nside (12 + lmax/nside)` rings, each `lmax^2/4` steps of the recurrence, and
    /// some `R lmax nside/4` for the Fourier integrals near the poles.
    ///
    /// # Errors
    ///
    /// [`Error::Harmonics`] if `lmax` is out of range or memory is exhausted.
    pub fn alm(&self, domain: Domain, lmax: usize) -> Result<Alm, Error> {
        let nodes = self.nodes(domain, lmax)?;
        let spectra = self.belt_spectra();
        let mut alm = Alm::zeros(lmax)?;
        RingTransform::new(lmax)?.adjoint_into(
            nodes.iter().map(|n| n.colatitude),
            |m, fourier| {
                for (f, node) in fourier.iter_mut().zip(&nodes) {
                    let bands = node.bands.iter().flatten();
                    let sum: Complex<f64> = bands.map(|&b| self.band(b, m, &spectra)).sum();
                    *f = sum * node.weight;
                }
            },
            &mut RingWorkspace::default(),
            &mut alm,
        );
        Ok(alm)
    }

    /// Returns the discrete Fourier transforms of the rings of `4 nside` pixels, one after another.
    fn belt_spectra(&self) -> Vec<Complex<f64>> {
        let n = self.n();
        let belt = &self.values[2 * n * (n - 1)..self.values.len() - 2 * n * (n - 1)];
        let mut spectra: Vec<_> = belt.iter().map(|&v| Complex::new(v, 0.0)).collect();
        f64::fourier_plan(4 * n, FftDirection::Forward).process(&mut spectra);
        spectra
    }

    /// `int e^{-i m phi}` over the intervals of a ring of pixels, times its values.
    fn band(&self, band: Band, m: usize, spectra: &[Complex<f64>]) -> Complex<f64> {
        let order = m as f64;
        let width = if m == 0 { 2.0 * band.half } else { 2.0 * (order * band.half).sin() / order };
        let values = if let Some(step) = band.step {
            quarters(self.ring(band.ring), m, Complex::cis(-order * step))
        } else {
            let row = 4 * self.n();
            spectra[(band.ring + 1 - self.n()) * row + m % row]
        };
        values * Complex::cis(-order * band.first) * width
    }

    /// Returns the rings of the quadrature for degrees up to `lmax`.
    fn nodes(&self, domain: Domain, lmax: usize) -> Result<Vec<Node>, Error> {
        let n = self.n();
        let side = n as f64;
        let end = if domain == Domain::Sphere { 4 * n } else { 2 * n };
        let mut nodes = Vec::new();
        // Edges of pixels move by at most a quarter turn over nside where high orders contribute.
        let phase = |angle: f64| lmax as f64 * (angle + FRAC_PI_2 / side);
        let rule = |angle: f64| GaussLegendre::new(node_count(0.5 * phase(angle)).max(MIN_NODES));
        // Panels between the centres of rings i and i + 1; ring 0 is the pole.
        for i in 0..end {
            let from_pole = i.min(4 * n - 1 - i);
            if from_pole < n {
                // theta = 2 asin(s/(nside sqrt 6)), whose slope is at most 1.1 times that of its
                // start.
                let (from, angle) = (from_pole as f64, 2.0 / (side * 6f64.sqrt()) * 1.3);
                let rule = rule(angle)?;
                for (&x, &w) in rule.nodes().iter().zip(rule.weights()) {
                    // 1 - |z| = s^2/(3 nside^2)
                    let (s, w) = (from + 0.5 * (1.0 + x), 0.5 * w);
                    let half_sin = s / (side * 6f64.sqrt());
                    let dir = 2.0 * half_sin * (1.0 - half_sin * half_sin).sqrt();
                    let z = 1.0 - 2.0 * half_sin * half_sin;
                    let z = if i < 2 * n { z } else { -z };
                    nodes.push(Node {
                        colatitude: Colatitude::from_direction(DVec3::new(dir, 0.0, z)),
                        weight: w * 2.0 * s / (3.0 * side * side),
                        bands: self.cap_bands(from_pole, s, i < 2 * n),
                    });
                }
            } else {
                let step = 2.0 / (3.0 * side);
                // dz = sin theta dtheta, and sin theta is at least sqrt(5)/3.
                let rule = rule(1.4 * step)?;
                for (&x, &w) in rule.nodes().iter().zip(rule.weights()) {
                    let share = 0.5 * (1.0 + x);
                    let z = (2.0 * side - (i as f64 + share)) * step;
                    let sin = ((1.0 - z) * (1.0 + z)).sqrt();
                    nodes.push(Node {
                        colatitude: Colatitude::from_direction(DVec3::new(sin, 0.0, z)),
                        weight: 0.5 * w * step,
                        bands: [self.belt_band(i, 1.0 - share), self.belt_band(i + 1, share)],
                    });
                }
            }
        }
        Ok(nodes)
    }

    /// Returns ring `i` (from 1) of the belt, whose pixels cover a fraction `share` of the circle.
    fn belt_band(&self, i: usize, share: f64) -> Option<Band> {
        let step = TAU / (4 * self.n()) as f64;
        let first = if (i - self.n()).is_multiple_of(2) { 0.5 * step } else { 0.0 };
        Some(Band { ring: i - 1, half: 0.5 * step * share, first, step: None })
    }

    /// Returns the rings `i` and `i + 1` from a pole at the distance `s` between them, in which
    /// quarter turns have i and i + 1 pixels.
    fn cap_bands(&self, i: usize, s: f64, north: bool) -> [Option<Band>; 2] {
        let (share, step) = (s - i as f64, FRAC_PI_2 / s);
        let ring = |i: usize| if north { i - 1 } else { 4 * self.n() - 1 - i };
        let band = |i: usize, from: f64, width: f64| {
            let half = FRAC_PI_4 * width / s;
            Band { ring: ring(i), half, first: from * step + half, step: Some(step) }
        };
        [(i > 0).then(|| band(i, share, 1.0 - share)), Some(band(i + 1, 0.0, share))]
    }

    fn n(&self) -> usize {
        self.nside.value() as usize
    }

    /// Returns the value of the antipode of every pixel: the pixel half a ring further in the
    /// opposite ring.
    fn opposite(&self) -> impl Iterator<Item = f64> {
        let rings = 4 * self.n() - 1;
        (0..rings).flat_map(move |ring| {
            let across = self.ring(rings - 1 - ring);
            let (first, second) = across.split_at(across.len() / 2);
            second.iter().chain(first).copied()
        })
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

    /// Returns the sum of a power of the values over the pixels of a domain; pixels on the equator
    /// count half.
    fn moment(&self, domain: Domain, power: i32) -> f64 {
        let sum = |values: &[f64]| values.iter().map(|v| v.powi(power)).sum::<f64>();
        let rings = 4 * self.n() - 1;
        let total: f64 = match domain {
            Domain::Sphere => (0..rings).map(|r| sum(self.ring(r))).sum(),
            Domain::Hemisphere => {
                let equator = 2 * self.n() - 1;
                (0..equator).map(|r| sum(self.ring(r))).sum::<f64>() + 0.5 * sum(self.ring(equator))
            }
        };
        self.nside.pixel_area() * total
    }
}

/// Rejects invalid values.
fn check_values(values: &[f64]) -> Result<(), Error> {
    let is_missing = |v: &f64| !HealpixMap::is_value(*v);
    match values.iter().position(is_missing) {
        Some(first) => {
            Err(Error::Pixels { count: values.iter().filter(|v| is_missing(v)).count(), first })
        }
        // The root mean square is at most the largest value, whose square must not vanish.
        None => check_size(values.iter().fold(0.0, |max: f64, v| max.max(v.abs()))),
    }
}

/// `sum_q (-i)^{m q} sum_k v_{q,k} phase^k` over the quarters q of a ring.
fn quarters(values: &[f64], m: usize, phase: Complex<f64>) -> Complex<f64> {
    let (first, rest) = values.split_at(values.len() / 4);
    let (second, rest) = rest.split_at(first.len());
    let (third, fourth) = rest.split_at(first.len());
    let mut sum = Complex::ZERO;
    for k in (0..first.len()).rev() {
        let (a, b, c, d) = (first[k], second[k], third[k], fourth[k]);
        let value = match m % 4 {
            0 => Complex::new(a + b + c + d, 0.0),
            1 => Complex::new(a - c, d - b),
            2 => Complex::new(a - b + c - d, 0.0),
            _ => Complex::new(a - c, b - d),
        };
        sum = sum * phase + value;
    }
    sum
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
        Some(self.moment(domain, 1))
    }

    fn coefficients(&self, domain: Domain, lmax: usize) -> Result<Coefficients, Error> {
        // The mean is known without a transform.
        let part = match lmax {
            0 => Coefficients::zonal(DVec3::Z, vec![self.moment(domain, 1) / (4.0 * PI).sqrt()])?,
            _ => Coefficients::general(self.alm(domain, lmax)?),
        };
        Ok(if domain == Domain::Sphere { part } else { part.even_extension() })
    }

    fn centred_square(&self, domain: Domain) -> Result<ByParity, Error> {
        let mean = self.moment(domain, 1) / domain.area();
        let square = |values: Vec<f64>| Self { values, nside: self.nside }.moment(domain, 2);
        let centred: Vec<f64> = self.values.iter().map(|v| v - mean).collect();
        if domain == Domain::Hemisphere {
            return Ok(ByParity { even: 2.0 * square(centred), odd: 0.0 });
        }
        let opposite: Vec<f64> = self.opposite().map(|v| v - mean).collect();
        let pairs = || centred.iter().zip(&opposite);
        Ok(ByParity {
            even: square(pairs().map(|(a, b)| 0.5 * (a + b)).collect()),
            odd: square(pairs().map(|(a, b)| 0.5 * (a - b)).collect()),
        })
    }

    fn squared_parts(&self, lmax: usize) -> Result<[Coefficients; 2], Error> {
        let part = |sign: f64| {
            let pairs = self.values.iter().zip(self.opposite());
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
        let rings = 4.0 * side * (MIN_NODES as f64).max(4.0 + degrees / side);
        // The recurrence, and the Fourier integrals near the poles, a third of the rings.
        rings * (0.3e-9 * degrees * degrees + 0.7e-9 * degrees * side)
    }
}
