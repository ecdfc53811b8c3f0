use std::f64::consts::PI;
use std::iter;
use std::sync::OnceLock;

use glam::DVec3;
use num_complex::Complex;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use sphvar_sh::{Alm, ByParity, Domain, LmIndex};

use super::Expansion;
use super::expansion::{energy_of, shape_of};
use crate::energy::{check_size, norm};
use crate::{Coefficients, Energy, Error, Integrand, Shape};

impl Expansion {
    /// Returns the random field number `field` with given mean and energies; `energies[l - 1]` is
    /// `E(l) = sum_m |a_lm|^2` of degree l = 1, 2, ...
    ///
    /// The coefficients of each degree are isotropic: independent normal numbers, scaled so that
    /// their energy is E(l) exactly. A prediction from the energies is therefore exact for every
    /// field, not only for their average. The numbers are a function of `field`, the degree and the
    /// order, so fields of the same number agree, up to the factor of each degree, whatever their
    /// energies and largest degree.
    ///
    /// # Errors
    ///
    /// [`Error::Energy`] if an energy is negative, NaN or infinite, [`Error::Coefficient`] if the
    /// mean is NaN or infinite; [`Error::Harmonics`] beyond the supported degrees or if memory is
    /// exhausted.
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_integrands::{Domain, Expansion, Integrand};
    ///
    /// let f = Expansion::random_field(1.0, &[3.0, 0.0, 0.5], 7)?;
    /// let energy = f.energy(Domain::Sphere, 3)?;
    /// assert!((energy.centred().odd - 3.5).abs() < 1e-14);
    /// assert!((f.exact(Domain::Sphere).unwrap() / (4.0 * std::f64::consts::PI) - 1.0).abs() < 1e-15);
    /// # Ok::<(), sphvar_integrands::Error>(())
    /// ```
    pub fn random_field(mean: f64, energies: &[f64], field: u64) -> Result<Self, Error> {
        check_energies(energies)?;
        let mut alm = Alm::zeros(energies.len())?;
        alm[(0, 0)] = Complex::new(mean * (4.0 * PI).sqrt(), 0.0);
        for (l, &energy) in (1..).zip(energies).filter(|(_, energy)| **energy > 0.0) {
            let drawn = isotropic(field, l);
            let both_signs = |m: usize| if m == 0 { 1.0 } else { 2.0 };
            let sum: f64 =
                drawn.iter().enumerate().map(|(m, a)| both_signs(m) * a.norm_sqr()).sum();
            let scale = (energy / sum).sqrt();
            for (m, a) in drawn.into_iter().enumerate() {
                alm[(l, m)] = a * scale;
            }
        }
        Self::new(alm)
    }
}

/// Checks energies from degree 1.
fn check_energies(energies: &[f64]) -> Result<(), Error> {
    let is_energy = |e: &f64| *e >= 0.0 && e.is_finite();
    match energies.iter().position(|e| !is_energy(e)) {
        Some(at) => Err(Error::Energy { l: at + 1, got: energies[at] }),
        None => Ok(()),
    }
}

/// A random field whose coefficients are drawn with the first value.
///
/// Predictions on the sphere take energies only, which need neither the time nor the memory of
/// coefficients. Otherwise it is the function of [`Expansion::random_field`].
///
/// # Examples
///
/// ```
/// use sphvar_integrands::{Domain, Integrand, RandomField};
///
/// let f = RandomField::new(0.0, &[1.0; 20_000], 0)?;
/// assert_eq!(f.energy(Domain::Sphere, 3)?.centred().sum(), 2e4);
/// # Ok::<(), sphvar_integrands::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct RandomField {
    mean: f64,
    /// From degree 0.
    energies: Vec<f64>,
    field: u64,
    memory_check: fn(usize) -> Result<(), String>,
    expansion: OnceLock<Result<Expansion, Error>>,
}

impl RandomField {
    /// Returns the field of the arguments of [`Expansion::random_field`].
    ///
    /// # Errors
    ///
    /// Those of [`Expansion::random_field`], except that of memory, which values return.
    pub fn new(mean: f64, energies: &[f64], field: u64) -> Result<Self, Error> {
        check_energies(energies)?;
        LmIndex::new(energies.len())?;
        let root = (4.0 * PI).sqrt();
        if !mean.is_finite() {
            return Err(Error::Coefficient { l: 0, m: 0, re: mean * root, im: 0.0 });
        }
        let sizes = energies.iter().map(|e| e.sqrt() / root).chain([mean]);
        check_size(norm(sizes))?;
        let energies = iter::once((mean * root).powi(2)).chain(energies.iter().copied()).collect();
        let memory_check = |_| Ok(());
        Ok(Self { mean, energies, field, memory_check, expansion: OnceLock::new() })
    }

    /// Returns the field with a check that a function of a degree fits in memory, which precedes
    /// the first value.
    #[must_use]
    pub fn with_memory_check(self, memory_check: fn(usize) -> Result<(), String>) -> Self {
        Self { memory_check, ..self }
    }

    /// Returns the function, whose coefficients the first call draws.
    ///
    /// # Errors
    ///
    /// [`Error::Evaluation`] with the reason of the check of memory, [`Error::Harmonics`] if memory
    /// is exhausted.
    pub fn expansion(&self) -> Result<&Expansion, Error> {
        let draw = || {
            let lmax = self.energies.len() - 1;
            (self.memory_check)(lmax).map_err(|reason| Error::Evaluation { reason })?;
            Expansion::random_field(self.mean, &self.energies[1..], self.field)
        };
        self.expansion.get_or_init(draw).as_ref().map_err(Clone::clone)
    }
}

impl Integrand for RandomField {
    /// NaN if the coefficients do not fit in memory, where [`eval_into`](Self::eval_into) returns
    /// the error.
    fn eval(&self, dir: DVec3) -> f64 {
        self.expansion().map_or(f64::NAN, |function| function.eval(dir))
    }

    fn eval_into(&self, dirs: &[DVec3], values: &mut [f64]) -> Result<(), Error> {
        self.expansion()?.eval_into(dirs, values)
    }

    fn shape(&self) -> Result<Shape, Error> {
        Ok(shape_of(&self.energies))
    }

    fn exact(&self, domain: Domain) -> Option<f64> {
        match domain {
            Domain::Sphere => Some((4.0 * PI).sqrt() * (self.mean * (4.0 * PI).sqrt())),
            Domain::Hemisphere => self.expansion().ok()?.exact(domain),
        }
    }

    fn coefficients(&self, domain: Domain, lmax: usize) -> Result<Coefficients, Error> {
        self.expansion()?.coefficients(domain, lmax)
    }

    fn centred_square(&self, domain: Domain) -> Result<ByParity, Error> {
        match domain {
            Domain::Sphere => Ok(self.energy(domain, 0)?.centred()),
            Domain::Hemisphere => self.expansion()?.centred_square(domain),
        }
    }

    fn energy(&self, domain: Domain, lmax: usize) -> Result<Energy, Error> {
        match domain {
            Domain::Sphere => Ok(energy_of(&self.energies, lmax)),
            Domain::Hemisphere => self.expansion()?.energy(domain, lmax),
        }
    }

    fn kurtosis(&self, domain: Domain) -> Option<f64> {
        self.expansion().ok()?.kurtosis(domain)
    }

    fn band_limit(&self) -> Option<usize> {
        Some(self.energies.len() - 1)
    }
}

/// Returns the coefficients of orders 0 to l of an isotropic Gaussian field of unit power.
fn isotropic(field: u64, l: usize) -> Vec<Complex<f64>> {
    let mut key = [0; 32];
    key[..8].copy_from_slice(&field.to_le_bytes());
    key[24..].copy_from_slice(b"field  1");
    let mut rng = ChaCha8Rng::from_seed(key);
    rng.set_stream(l as u64);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let zonal = Complex::new(normal(), 0.0);
    let rest = (0..l).map(|_| {
        let (re, im) = (normal(), normal());
        Complex::new(re, im) * std::f64::consts::FRAC_1_SQRT_2
    });
    iter::once(zonal).chain(rest).collect()
}
