use std::f64::consts::PI;

use sphvar_sh::{Bands, Colatitude, LegendrePlan};

use crate::{Error, Spectrum};

/// Evaluates the smoothed pair correlation of a spectrum,
///
/// ```text
/// g_t(gamma) = sum_l (2l+1) (P(l) - 1) e^(-l(l+1)t) P_l(cos gamma)/N,   P(0) = N
/// ```
///
/// with the even degrees on the hemisphere and the effective N of weighted points. The heat kernel
/// of time t averages g over its neighbourhood: near a point it is a normal distribution of
/// standard deviation [`width`](Self::width) along each of two axes.
///
/// # References
///
/// Hartman and Watson 1974, "Normal distribution functions on spheres and the modified Bessel
/// functions", for the heat kernel on the sphere.
#[derive(Clone, Debug)]
pub struct HeatSmoothing {
    lmax: usize,
    time: f64,
    /// `(2l+1) e^(-l(l+1)t)`, by degree.
    damping: Vec<f64>,
    /// `(2l+1) e^(-l(l+1)t) P_l(cos gamma)`, by angle and degree.
    kernel: Vec<f64>,
}

impl HeatSmoothing {
    /// Returns the smoothing of spectra to degree `lmax` at these angles in radians, with
    /// `t = 6/(lmax (lmax + 1))`: the highest degree is damped by e^-6 = 0.0025.
    ///
    /// It uses 8 bytes for each angle and degree.
    ///
    /// # Errors
    ///
    /// [`Error::Setting`] if `lmax` is 0, [`Error::Transform`] if it is too large or an angle
    /// is not within `[0, pi]`.
    pub fn new(lmax: usize, angles: &[f64]) -> Result<Self, Error> {
        const LAST_DAMPING: f64 = 6.0;
        if lmax == 0 {
            let (what, expected) = ("the degree of a pair correlation", "at least 1");
            return Err(Error::Setting { what, expected, got: 0.0 });
        }
        let eigenvalue = |l: usize| l as f64 * (l as f64 + 1.0);
        let time = LAST_DAMPING / eigenvalue(lmax);
        let damping: Vec<f64> =
            (0..=lmax).map(|l| (2 * l + 1) as f64 * (-eigenvalue(l) * time).exp()).collect();
        let plan = LegendrePlan::new(lmax)?;
        let mut kernel = Vec::with_capacity(angles.len() * (lmax + 1));
        let mut column = vec![0.0; lmax + 1];
        for &angle in angles {
            // From the angle, because a cosine near 1 has lost its digits.
            plan.column_into(0, Colatitude::from_theta(angle)?, &mut column);
            let terms = column.iter().zip(&damping).enumerate();
            kernel.extend(terms.map(|(l, (y, d))| d * y * (4.0 * PI / (2 * l + 1) as f64).sqrt()));
        }
        Ok(Self { lmax, time, damping, kernel })
    }

    /// Returns the time t of the heat kernel.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Returns the standard deviation of the smoothing along each axis in radians, `sqrt(2 t)`.
    #[must_use]
    pub fn width(&self) -> f64 {
        (2.0 * self.time).sqrt()
    }

    /// Returns the smoothed pair correlation at every angle for a spectrum with the same lmax, for
    /// example one in closed form ([`ExactSpectrum`](crate::ExactSpectrum)).
    ///
    /// # Errors
    ///
    /// [`Error::Mismatch`] if the spectrum has another lmax.
    pub fn pair_correlation(&self, spectrum: &Spectrum) -> Result<Vec<f64>, Error> {
        self.check(spectrum)?;
        Ok(self.values(spectrum.power(), spectrum.n_effective(), spectrum.bands()))
    }

    /// Returns the sum rule's value,
    ///
    /// ```text
    /// sum_{l >= 1} (2l+1) (1 - P(l)) e^(-l(l+1)t)/(N - 1) = 1 - g_t(0) N/(N - 1)
    /// ```
    ///
    /// It is 1 if no two points are within a few [widths](Self::width), and 0 for white noise.
    ///
    /// # Errors
    ///
    /// [`Error::Mismatch`] if the spectrum has another lmax.
    pub fn sum_rule(&self, spectrum: &Spectrum) -> Result<f64, Error> {
        self.check(spectrum)?;
        Ok(self.sum(spectrum.power(), spectrum.n_effective(), spectrum.bands()))
    }

    fn check(&self, spectrum: &Spectrum) -> Result<(), Error> {
        if spectrum.lmax() == self.lmax {
            return Ok(());
        }
        let (left, right) = (spectrum.lmax().to_string(), self.lmax.to_string());
        Err(Error::Mismatch { what: "degrees", left, right })
    }

    pub(super) fn values(&self, power: &[f64], n_effective: f64, bands: &impl Bands) -> Vec<f64> {
        let excess: Vec<f64> = power
            .iter()
            .enumerate()
            .map(|(l, p)| if bands.has_band(l) { (p - 1.0) / n_effective } else { 0.0 })
            .collect();
        let rows = self.kernel.chunks_exact(self.lmax + 1);
        rows.map(|row| row.iter().zip(&excess).map(|(k, e)| k * e).sum()).collect()
    }

    pub(super) fn sum(&self, power: &[f64], n_effective: f64, bands: &impl Bands) -> f64 {
        let degrees = power.iter().zip(&self.damping).enumerate().skip(1);
        let terms = degrees.filter(|(l, _)| bands.has_band(*l)).map(|(_, (p, d))| d * (1.0 - p));
        terms.sum::<f64>() / (n_effective - 1.0)
    }
}
