use num_complex::Complex;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use sphvar_sh::Alm;

use super::Expansion;
use crate::Error;

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
        let is_energy = |e: &f64| *e >= 0.0 && e.is_finite();
        if let Some(at) = energies.iter().position(|e| !is_energy(e)) {
            return Err(Error::Energy { l: at + 1, got: energies[at] });
        }
        let mut alm = Alm::zeros(energies.len())?;
        alm[(0, 0)] = Complex::new(mean * (4.0 * std::f64::consts::PI).sqrt(), 0.0);
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
    std::iter::once(zonal).chain(rest).collect()
}
