use crate::error::per_degree;
use crate::{Domain, Error};
use statrs::distribution::{ContinuousCDF, Normal};

/// A measured mean spectrum with its standard errors, borrowed and checked.
///
/// Both slices are indexed by the degree from 0; degree 0 is not used, nor are odd degrees on the hemisphere. A standard
/// error of 0 marks an exact value.
///
/// ```
/// use sphvar_bounds::{Domain, MeasuredSpectrum};
/// let spectrum = MeasuredSpectrum::new(4, Domain::Sphere, &[4.0, 0.9, 1.1], &[0.0, 0.1, 0.1])?;
/// assert_eq!(spectrum.degrees().collect::<Vec<_>>(), [1, 2]);
/// # Ok::<(), sphvar_bounds::Error>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct MeasuredSpectrum<'a> {
    n_points: usize,
    domain: Domain,
    power: &'a [f64],
    stderr: &'a [f64],
}

impl<'a> MeasuredSpectrum<'a> {
    /// Returns the spectrum of patterns of `n_points` points.
    ///
    /// # Errors
    ///
    /// [`Error::LengthMismatch`], [`Error::NoPoints`], [`Error::NoDegrees`] if no degree enters the variance, and
    /// [`Error::DegreeValue`] for a value that is negative, infinite or NaN.
    pub fn new(
        n_points: usize,
        domain: Domain,
        power: &'a [f64],
        stderr: &'a [f64],
    ) -> Result<Self, Error> {
        if power.len() != stderr.len() {
            return Err(Error::LengthMismatch { power: power.len(), stderr: stderr.len() });
        }
        if n_points == 0 {
            return Err(Error::NoPoints);
        }
        if power.len() <= domain.degree_step() {
            return Err(Error::NoDegrees { got: power.len(), needed: domain.degree_step() + 1 });
        }
        per_degree("power", power)?;
        per_degree("standard error", stderr)?;
        Ok(Self { n_points, domain, power, stderr })
    }

    /// Returns the number of points of the patterns.
    #[must_use]
    pub const fn n_points(&self) -> usize {
        self.n_points
    }

    /// Returns the degrees that enter the variance, ascending.
    pub fn degrees(&self) -> impl Iterator<Item = usize> + use<> {
        (self.domain.degree_step()..self.power.len()).step_by(self.domain.degree_step())
    }

    /// Returns the mean power of a degree.
    pub(crate) fn power(&self, l: usize) -> f64 {
        self.power[l]
    }

    /// Returns the standard error of a degree.
    pub(crate) fn stderr(&self, l: usize) -> f64 {
        self.stderr[l]
    }

    /// Returns the one-sided normal quantile that keeps all degrees together at `confidence` (Sidak).
    ///
    /// ```text
    /// z = Phi^-1(confidence^(1/K))     K degrees
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `0 < confidence < 1`.
    pub fn critical_z(&self, confidence: f64) -> Result<f64, Error> {
        if !(confidence > 0.0 && confidence < 1.0) {
            return Err(Error::Parameter {
                name: "confidence",
                got: confidence,
                expected: "above 0 and below 1",
            });
        }
        // The upper tail 1 - confidence^(1/K) without the rounding of a number near 1.
        let tail = -(confidence.ln() / self.degrees().count() as f64).exp_m1();
        Ok(-Normal::standard().inverse_cdf(tail))
    }
}
