use std::f64::consts::{PI, TAU};

use glam::DVec3;
use num_complex::Complex;
use sphvar_sh::{Alm, ByParity, Colatitude, Domain, GaussLegendre, LegendrePlan};
use sphvar_sht::{Method, Transform, TransformWorkspace};

use crate::energy::{check_size, norm};
use crate::{Coefficients, Energy, Error, Integrand, Shape, quadrature};

/// A real band-limited function given by its harmonic coefficients,
/// `f(x) = sum_{l <= lmax} sum_m a_lm Y_lm(x)`.
///
/// Energies are those of the coefficients, so predictions are exact. On the hemisphere the even
/// extension from z >= 0 is the even part of f plus the even extension G of its odd part,
///
/// ```text
/// G_lm = 2 int_{z > 0} f_odd conj Y_lm   for even l
/// ```
///
/// whose integrals over z are Gauss-Legendre sums, exact for any degree. Unless all odd degrees are
/// 0, the even extension has a kink or a jump on the equator and is not band-limited.
///
/// # Performance
///
/// A single value takes `lmax^2/2` steps of the recurrence; many values share a fast transform.
///
/// # Examples
///
/// ```
/// use glam::DVec3;
/// use num_complex::Complex;
/// use sphvar_integrands::{Domain, Expansion, Integrand};
/// use sphvar_sh::Alm;
///
/// // f = 1 + z, since Y_00 = 1/sqrt(4 pi) and Y_10 = sqrt(3/(4 pi)) z.
/// let pi = std::f64::consts::PI;
/// let mut alm = Alm::zeros(1)?;
/// alm[(0, 0)] = Complex::new((4.0 * pi).sqrt(), 0.0);
/// alm[(1, 0)] = Complex::new((4.0 * pi / 3.0).sqrt(), 0.0);
/// let f = Expansion::new(alm)?;
/// assert!((f.eval(DVec3::Z) - 2.0).abs() < 1e-15);
/// assert!((f.exact(Domain::Sphere).unwrap() - 4.0 * pi).abs() < 1e-14);
/// assert!((f.exact(Domain::Hemisphere).unwrap() - 3.0 * pi).abs() < 1e-14);
/// # Ok::<(), sphvar_integrands::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Expansion {
    alm: Alm,
    energies: Vec<f64>,
    legendre: LegendrePlan,
    /// For few points.
    exact: Transform,
    /// For many points.
    fast: Transform,
}

/// The accuracy of fast values, relative to the norm of the coefficients.
const EPSILON: f64 = 1e-13;
/// Imaginary parts of `a_l0` up to this fraction of the norm are rounding of single precision.
const IMAGINARY_ROUNDING: f64 = 1e-6;
/// Maximum number of rings of the grid of a kurtosis. It is exact up to degree 128, and beyond it
/// an average of 131072 values.
const KURTOSIS_RINGS: usize = 256;

impl Expansion {
    /// Returns the function with coefficients `alm`, orthonormal with the Condon-Shortley phase.
    ///
    /// # Errors
    ///
    /// [`Error::Coefficient`] if one is NaN or infinite, or has an imaginary part at m = 0, where
    /// those of a real function are real; parts below 1e-6 of the norm are dropped.
    /// [`Error::Magnitude`] if the root mean square is beyond [`Energy::MAGNITUDES`].
    /// [`Error::Harmonics`] if memory is exhausted.
    pub fn new(mut alm: Alm) -> Result<Self, Error> {
        let size = alm.values().iter().map(|a| a.norm()).fold(0.0, f64::max);
        let wrong =
            |(_, a): &((usize, usize), Complex<f64>)| !(a.re.is_finite() && a.im.is_finite());
        let is_complex = |((_, m), a): &((usize, usize), Complex<f64>)| {
            *m == 0 && a.im.abs() > IMAGINARY_ROUNDING * size
        };
        let all = || alm.index().iter().zip(alm.values().iter().copied());
        if let Some(((l, m), a)) = all().find(wrong).or_else(|| all().find(is_complex)) {
            return Err(Error::Coefficient { l, m, re: a.re, im: a.im });
        }
        alm.column_mut(0).iter_mut().for_each(|a| a.im = 0.0);
        let parts = (0..=alm.lmax()).flat_map(|m| {
            let weight: f64 = if m == 0 { 1.0 } else { 2.0 };
            alm.column(m).iter().flat_map(move |a| [a.re, a.im].map(|x| x * weight.sqrt()))
        });
        check_size(norm(parts) / (4.0 * PI).sqrt())?;
        let lmax = alm.lmax();
        Ok(Self {
            energies: alm.energy_per_degree(),
            legendre: LegendrePlan::new(lmax)?,
            exact: Transform::new(Method::Exact, lmax, 1, EPSILON)?,
            fast: Transform::new(Method::Fast, lmax, 1, EPSILON)?,
            alm,
        })
    }

    /// Returns the coefficients.
    #[must_use]
    pub fn alm(&self) -> &Alm {
        &self.alm
    }

    /// Returns the coefficients of degree up to `lmax`, 0 beyond its own.
    fn padded(&self, lmax: usize) -> Result<Alm, Error> {
        let mut alm = Alm::zeros(lmax)?;
        for m in 0..=lmax.min(self.alm.lmax()) {
            for (to, from) in alm.column_mut(m).iter_mut().zip(self.alm.column(m)) {
                *to = *from;
            }
        }
        Ok(alm)
    }

    /// Returns the coefficients of the even extension of the odd part, to degree `lmax`.
    fn extension_of_odd_part(&self, lmax: usize) -> Result<Alm, Error> {
        let mut alm = Alm::zeros(lmax)?;
        if is_even(&self.energies) {
            return Ok(alm);
        }
        let own = self.alm.lmax();
        // The products are polynomials in z of degree own + lmax.
        let rule = GaussLegendre::new((own + lmax) / 2 + 1)?;
        let plan = LegendrePlan::new(own.max(lmax))?;
        let mut column = vec![0.0; own.max(lmax) + 1];
        for (&x, &w) in rule.nodes().iter().zip(rule.weights()) {
            let z = 0.5 * (1.0 + x);
            let sin = ((1.0 - z) * (1.0 + z)).sqrt();
            let colatitude = Colatitude::from_direction(DVec3::new(sin, 0.0, z));
            for m in 0..=own.min(lmax) {
                let lambda = &mut column[..=own.max(lmax) - m];
                plan.column_into(m, colatitude, lambda);
                let terms = self.alm.column(m).iter().zip(&*lambda);
                let odd_terms = terms.skip((m + 1) % 2).step_by(2);
                let value: Complex<f64> = odd_terms.map(|(a, lambda)| a * lambda).sum();
                // Twice the integral over z > 0 with half of the weight in x, and all longitudes.
                let value = value * (w * TAU);
                let even_sums = alm.column_mut(m).iter_mut().zip(&*lambda).skip(m % 2).step_by(2);
                even_sums.for_each(|(sum, lambda)| *sum += value * lambda);
            }
        }
        Ok(alm)
    }
}

/// Returns the shape of a function whose energies from degree 0 are these.
pub(super) fn shape_of(energies: &[f64]) -> Shape {
    let degrees = energies.len() as f64;
    let shape = Shape::smooth(energies.len() - 1).with_cost(1.0 + degrees * degrees / 16.0);
    if is_even(energies) { shape.even() } else { shape }
}

fn is_even(energies: &[f64]) -> bool {
    energies.iter().skip(1).step_by(2).all(|e| *e == 0.0)
}

/// Returns the energy on the sphere to degree `lmax` of a function whose energies from degree 0 are
/// these.
pub(super) fn energy_of(energies: &[f64], lmax: usize) -> Energy {
    let own = energies.iter().copied().chain(std::iter::repeat(0.0));
    Energy::new(Domain::Sphere, own.take(lmax + 1).collect(), centred_energy(energies))
}

/// Returns the energy of the degrees from 1 by parity.
fn centred_energy(energies: &[f64]) -> ByParity {
    let mut sums = ByParity::both(0.0);
    for (l, e) in energies.iter().enumerate().skip(1) {
        *sums.of_mut(l) += e;
    }
    sums
}

impl Integrand for Expansion {
    fn eval(&self, dir: DVec3) -> f64 {
        let colatitude = Colatitude::from_direction(dir);
        let phi = dir.y.atan2(dir.x);
        let mut column = vec![0.0; self.alm.lmax() + 1];
        let mut sum = 0.0;
        for m in 0..=self.alm.lmax() {
            let lambda = &mut column[..=self.alm.lmax() - m];
            self.legendre.column_into(m, colatitude, lambda);
            let part: Complex<f64> =
                self.alm.column(m).iter().zip(&*lambda).map(|(a, lambda)| a * lambda).sum();
            let both_signs = if m == 0 { 1.0 } else { 2.0 };
            sum += both_signs * (part * Complex::cis(m as f64 * phi)).re;
        }
        sum
    }

    /// Writes values whose difference from those of [`eval`](Self::eval) is at most 1e-13 of the
    /// largest value of any function with the same norm of coefficients.
    fn eval_into(&self, dirs: &[DVec3], values: &mut [f64]) -> Result<(), Error> {
        let work = |method: Method| method.nominal_work(dirs.len(), self.alm.lmax());
        let is_fast = work(Method::Fast) < work(Method::Exact);
        let transform = if is_fast { &self.fast } else { &self.exact };
        transform.synthesis_into(&self.alm, dirs, &mut TransformWorkspace::default(), values);
        Ok(())
    }

    fn shape(&self) -> Result<Shape, Error> {
        Ok(shape_of(&self.energies))
    }

    fn exact(&self, domain: Domain) -> Option<f64> {
        let mean = match domain {
            Domain::Sphere => self.alm[(0, 0)].re,
            Domain::Hemisphere => 0.5 * self.coefficients(domain, 0).ok()?.mean(),
        };
        Some((4.0 * PI).sqrt() * mean)
    }

    /// On the hemisphere takes some `(lmax + L)/2` rings of `lmax L` steps, L being the degree of
    /// the function, unless it is even.
    fn coefficients(&self, domain: Domain, lmax: usize) -> Result<Coefficients, Error> {
        let whole = Coefficients::general(self.padded(lmax)?);
        if domain == Domain::Sphere {
            return Ok(whole);
        }
        let extension = Coefficients::general(self.extension_of_odd_part(lmax)?);
        whole.even_part().plus(1.0, &extension)
    }

    /// On the hemisphere, with the even part e, the odd part o and its even extension G,
    /// `int (F - mean)^2 = int (e - mean e)^2 + int o^2 + 2 sum_{l >= 2} <e, G>_l - G_00^2`.
    fn centred_square(&self, domain: Domain) -> Result<ByParity, Error> {
        let sphere = centred_energy(&self.energies);
        if domain == Domain::Sphere {
            return Ok(sphere);
        }
        let extension = Coefficients::general(self.extension_of_odd_part(self.alm.lmax())?);
        let even = Coefficients::general(self.alm.clone()).even_part();
        let cross: f64 = even.inner_per_degree(&extension)?.iter().skip(1).sum();
        let square = sphere.sum() + 2.0 * cross - extension.mean().powi(2);
        // Cancellation leaves rounding errors of either sign.
        Ok(ByParity { even: square.max(0.0), odd: 0.0 })
    }

    /// On the sphere, returns the energies without the coefficients.
    fn energy(&self, domain: Domain, lmax: usize) -> Result<Energy, Error> {
        if domain == Domain::Sphere {
            return Ok(energy_of(&self.energies, lmax));
        }
        let per_degree = self.coefficients(domain, lmax)?.energy_per_degree()?;
        Ok(Energy::new(domain, per_degree, self.centred_square(domain)?))
    }

    /// Exact up to degree 128; beyond it an average over a grid of 131072 values.
    fn kurtosis(&self, domain: Domain) -> Option<f64> {
        let rings = (2 * self.alm.lmax() + 1).min(KURTOSIS_RINGS);
        let rule = GaussLegendre::new(rings).ok()?;
        let (mut points, mut weights) = (Vec::new(), Vec::new());
        for (&x, &w) in rule.nodes().iter().zip(rule.weights()) {
            let z = if domain == Domain::Sphere { x } else { 0.5 * (1.0 + x) };
            let sin = ((1.0 - z) * (1.0 + z)).sqrt();
            for j in 0..2 * rings {
                let (s, c) = (TAU * j as f64 / (2 * rings) as f64).sin_cos();
                points.push(DVec3::new(sin * c, sin * s, z).normalize());
                weights.push(w);
            }
        }
        let mut values = vec![0.0; points.len()];
        self.eval_into(&points, &mut values).ok()?;
        quadrature::weighted_kurtosis(|| weights.iter().copied().zip(values.iter().copied()))
    }

    fn band_limit(&self) -> Option<usize> {
        Some(self.alm.lmax())
    }
}
