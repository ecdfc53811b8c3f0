use std::f64::consts::{LN_2, PI};

use sphvar_grammar::{Declaration, Parametric, Range};
use sphvar_sh::{Alm, Domain};

use super::exponential_degree;
use super::zonal_series::ZonalSeries;
use crate::definition::Definition;
use crate::{
    Coefficients, Energy, Error, Expansion, Expression, Integrand, IntegrandResolver, Term,
};

/// The Gaussian filter of the sphere: the convolution with the zonal kernel of integral 1 whose
/// multiplier of degree l is
///
/// ```text
/// k_l = e^{-l (l + 1) sigma^2/2},   sigma = fwhm/sqrt(8 ln 2)
/// ```
///
/// the solution of the heat equation on the sphere at time sigma^2/2, which for small sigma is a
/// Gaussian of standard deviation sigma in each coordinate of the tangent plane. It multiplies
/// coefficients by `k_l` and energies by `k_l^2` and leaves the integral over the sphere unchanged.
///
/// The filter acts on the function on the whole sphere. The integral of the result over the
/// hemisphere therefore differs from that of the function: values from below the equator enter, and
/// others leave. So do integrals of products with filtered factors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussianFilter {
    sigma: f64,
}

/// A function after a [`GaussianFilter`], and its difference from the function.
pub struct Filtered {
    /// The band-limited result.
    pub function: Box<dyn Integrand>,
    /// The root mean square over the sphere of the difference,
    /// `sqrt(sum_l (1 - k_l)^2 E(l)/(4 pi))`.
    pub rms_change: f64,
    /// The root mean square over the sphere of the function minus its mean.
    pub rms: f64,
}

impl std::fmt::Debug for Filtered {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Filtered").field("rms_change", &self.rms_change).finish_non_exhaustive()
    }
}

impl GaussianFilter {
    /// Returns the filter of the full width at half maximum `fwhm_degrees` in (0, 180].
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] outside the range.
    pub fn new(fwhm_degrees: f64) -> Result<Self, Error> {
        if !(fwhm_degrees > 0.0 && fwhm_degrees <= 180.0) {
            let range = "in (0, 180] degrees";
            return Err(Error::Parameter { name: "fwhm", range, got: fwhm_degrees });
        }
        Ok(Self { sigma: fwhm_degrees.to_radians() / (8.0 * LN_2).sqrt() })
    }

    /// Returns the multiplier of a degree, in [0, 1].
    #[must_use]
    pub fn multiplier(&self, l: usize) -> f64 {
        (-self.exponent(l)).exp()
    }

    fn exponent(&self, l: usize) -> f64 {
        let l = l as f64;
        0.5 * l * (l + 1.0) * self.sigma * self.sigma
    }

    /// Returns the degree beyond which multipliers are less than 1e-16.
    #[must_use]
    pub fn degree(&self) -> usize {
        // Beyond 10^12 degrees the number does not matter.
        exponential_degree((self.sigma * self.sigma).recip().min(1e22))
    }

    /// Returns the function after the filter, as a series of harmonics up to the
    /// [`degree`](Self::degree) of the filter or of the function, if that is smaller. Values are
    /// accurate to 1e-13 of the largest value of any function with the same energy.
    ///
    /// Cost: the coefficients of `function` to that degree L; a value takes L steps if the function
    /// is zonal, otherwise L^2/2, or less in batches.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] if L exceeds 4096, or 100000 for zonal functions; those of
    /// [`Integrand::coefficients`] and [`Integrand::centred_square`].
    pub fn apply(&self, function: &dyn Integrand) -> Result<Filtered, Error> {
        const MAX_DEGREE: usize = 4096;
        const MAX_ZONAL_DEGREE: usize = 100_000;
        let sphere = Domain::Sphere;
        let lmax = self.degree().min(function.band_limit().unwrap_or(usize::MAX));
        // The coefficients to degree 1 show whether a function is zonal.
        let is_zonal = function.coefficients(sphere, lmax.min(1))?.as_zonal().is_some();
        if lmax > if is_zonal { MAX_ZONAL_DEGREE } else { MAX_DEGREE } {
            let got = self.sigma.to_degrees() * (8.0 * LN_2).sqrt();
            let range = "at least 0.29 degrees, or 0.012 for functions of the angle from one axis: \
                         narrower filters need too many harmonics";
            return Err(Error::Parameter { name: "fwhm", range, got });
        }
        let coefficients = function.coefficients(sphere, lmax)?;
        let energies = coefficients.energy_per_degree()?;
        let centred = function.centred_square(sphere)?;
        let changes =
            energies.iter().enumerate().map(|(l, e)| (-self.exponent(l)).exp_m1().powi(2) * e);
        let beyond = Energy::new(sphere, energies.clone(), centred).beyond(lmax);
        let mean_square = |energy: f64| (energy / (4.0 * PI)).sqrt();
        Ok(Filtered {
            rms_change: mean_square(changes.sum::<f64>() + beyond),
            rms: mean_square(centred.sum()),
            function: self.series(&coefficients)?,
        })
    }

    /// Returns the function of the coefficients times the multipliers.
    fn series(&self, coefficients: &Coefficients) -> Result<Box<dyn Integrand>, Error> {
        if let Some((axis, per_degree)) = coefficients.as_zonal() {
            let terms = per_degree.iter().enumerate().map(|(l, c)| self.multiplier(l) * c);
            return Ok(Box::new(ZonalSeries::new(axis, terms.collect())?));
        }
        let mut alm: Alm = coefficients.to_alm()?;
        let multipliers: Vec<f64> = (0..=alm.lmax()).map(|l| self.multiplier(l)).collect();
        for m in 0..=alm.lmax() {
            for (a, k) in alm.column_mut(m).iter_mut().zip(&multipliers[m..]) {
                *a *= k;
            }
        }
        Ok(Box::new(Expansion::new(alm)?))
    }
}

/// Parameters of an integrand after a [`GaussianFilter`].
#[derive(Clone, Debug, PartialEq)]
pub struct FilteredParameters {
    /// The full width at half maximum of the kernel, in degrees.
    pub fwhm: f64,
    /// The function before the filter.
    pub of: Expression,
}

/// An example.
impl Default for FilteredParameters {
    fn default() -> Self {
        Self { fwhm: 5.0, of: Term::Cosine.into() }
    }
}

impl Parametric for FilteredParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let summary = "full width at half maximum of the kernel in degrees";
        d.required_number("fwhm", Range::left_open(0.0, 180.0), summary, &mut self.fwhm);
        let summary = "the integrand, in quotes if it has commas or operators";
        d.required_text("of", "an integrand", summary, &mut self.of);
    }
}

impl Definition for FilteredParameters {
    fn build(&self, files: &dyn IntegrandResolver) -> Result<Box<dyn Integrand>, Error> {
        let filtered = GaussianFilter::new(self.fwhm)?.apply(&self.of.build(files)?)?;
        let Filtered { rms_change, rms, function } = filtered;
        let percent = if rms > 0.0 { 100.0 * rms_change / rms } else { 0.0 };
        files.remark(format!(
            "the filter of {} degrees changes {} by {rms_change:.2e} (root mean square over the \
             sphere), {percent:.2} % of its standard deviation",
            self.fwhm, self.of
        ));
        Ok(function)
    }
}
