use crate::error::per_degree;
use crate::{Domain, Error, Side};
use sphvar_spectrum::Spectrum;
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// A validated view of a measured mean spectrum with its standard errors.
///
/// Both slices are indexed by the degree from 0. Degree 0 is not used, and on the hemisphere
/// neither are odd degrees. A standard error of 0 marks an exact value.
///
/// Confidence limits treat the errors as normal and the standard errors as exact, unless the number
/// of realizations is known ([`Self::with_realizations`]): then both are treated as estimates.
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
    /// The number of realizations, if it is known and the values are not exact.
    realizations: Option<u64>,
}

impl<'a> MeasuredSpectrum<'a> {
    /// Returns the spectrum of patterns of `n_points` points.
    ///
    /// # Errors
    ///
    /// Returns [`Error::LengthMismatch`], [`Error::NoPoints`], [`Error::NoDegrees`] if no degree
    /// enters the variance, and [`Error::DegreeValue`] for a value that is negative, infinite or
    /// NaN.
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
        Ok(Self { n_points, domain, power, stderr, realizations: None })
    }

    /// Returns the same spectrum as a mean over `realizations` (at least 2), whose standard errors
    /// are estimates too.
    ///
    /// The mean power of few realizations is skewed like a chi-square variable, and its standard
    /// error is uncertain. Instead of `power +- z stderr` the limits are those of a chi-square
    /// distribution with the measured relative error r, in the cube-root approximation of Wilson
    /// and Hilferty, with Student's quantile q for R - 1 degrees of freedom:
    ///
    /// ```text
    /// power/(1 - w -+ q sqrt(w))^3,   w = r^2/9,   r = stderr/power
    /// ```
    ///
    /// The power of a realization is close to chi-square with 2l+1 degrees of freedom over their
    /// number, so r is at least `sqrt(2/((2l+1) R))`: among many degrees the estimated error of
    /// some is far too small.
    #[must_use]
    pub fn with_realizations(self, realizations: u64) -> Self {
        Self { realizations: (realizations >= 2).then_some(realizations), ..self }
    }

    /// Returns the same spectrum as a mean over a number of realizations inferred from its errors:
    /// the median over degrees of `2 (power/stderr)^2/(2l+1)`, at least 2.
    ///
    /// A spectrum with exact values is returned unchanged.
    #[must_use]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "positive, and the cast saturates"
    )]
    pub fn with_inferred_realizations(self) -> Self {
        let of = |l: usize| 2.0 * (self.power(l) / self.stderr(l)).powi(2) / (2 * l + 1) as f64;
        let mut each: Vec<f64> = self.degrees().map(of).filter(|r| r.is_finite()).collect();
        each.sort_by(f64::total_cmp);
        match each.get(each.len() / 2) {
            Some(median) => self.with_realizations((*median as u64).max(2)),
            None => self,
        }
    }

    /// Returns a measured spectrum that borrows the values of an estimated or exact one.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`MeasuredSpectrum::new`]: a single realization of a random pattern
    /// has no standard errors (NaN).
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_bounds::{Domain, MeasuredSpectrum, Profile};
    /// let spectrum = Profile::quadratic(1.0, 1.0)?.spectrum(64, Domain::Sphere, 32);
    /// assert_eq!(MeasuredSpectrum::from_spectrum(&spectrum)?.n_points(), 64);
    /// # Ok::<(), sphvar_bounds::Error>(())
    /// ```
    pub fn from_spectrum(spectrum: &'a Spectrum) -> Result<Self, Error> {
        Self::new(spectrum.n_points(), spectrum.domain(), spectrum.power(), spectrum.stderr())
            .map(|measured| measured.with_realizations(spectrum.realizations()))
    }

    /// Power up to this counts as zero; white noise has 1. Transforms of points return rounding
    /// errors of coefficients (about 1e-24 at an accuracy of 1e-12), and patterns optimized to zero
    /// power have a residual of about 1e-20.
    pub const NO_POWER: f64 = 1e-18;

    /// Returns the number of points of the patterns.
    #[must_use]
    pub const fn n_points(&self) -> usize {
        self.n_points
    }

    /// Returns the domain of the points.
    #[must_use]
    pub const fn domain(&self) -> Domain {
        self.domain
    }

    /// Returns the number of values, degree 0 included.
    pub(crate) const fn len(&self) -> usize {
        self.power.len()
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

    /// Returns the simultaneous confidence limit of a degree on one side, for the quantile of
    /// [`Self::critical_z`]. The upper limit is infinite if the realizations are too few to
    /// determine it.
    pub(crate) fn limit(&self, side: Side, l: usize, critical_z: f64) -> f64 {
        let (power, sign) = match side {
            Side::Upper => (self.power(l), 1.0),
            Side::Lower => (self.power(l), -1.0),
        };
        match self.relative_cube_error(l) {
            None => {
                // Power is never negative, so the lower limit is at least 0.
                (power + sign * critical_z * self.stderr(l)).max(0.0)
            }
            Some(error) => {
                let base = 1.0 - error * error - sign * critical_z * error;
                if base > 0.0 { power / base.powi(3) } else { f64::INFINITY }
            }
        }
    }

    /// Returns the number of standard errors by which the power of a degree exceeds `bound`, in the
    /// scale of the limits.
    pub(crate) fn score(&self, l: usize, bound: f64) -> f64 {
        let power = self.power(l);
        match self.relative_cube_error(l) {
            None => (power - bound) / self.stderr(l),
            Some(error) => ((power / bound).cbrt() - 1.0 + error * error) / error,
        }
    }

    /// Returns `sqrt(w) = stderr/(3 power)`, the relative standard error of the cube root of the
    /// power, if the limits account for estimated errors.
    fn relative_cube_error(&self, l: usize) -> Option<f64> {
        let error = self.stderr(l) / (3.0 * self.power(l));
        let realizations = self.realizations.filter(|_| error > 0.0 && error.is_finite())?;
        let normal = (2.0 / ((2 * l + 1) as f64 * realizations as f64)).sqrt() / 3.0;
        Some(error.max(normal))
    }

    /// Returns the simultaneous confidence limits of all degrees on one side, with their degrees.
    ///
    /// ```text
    /// power_l + critical_z stderr_l   or   max(0, power_l - critical_z stderr_l)
    /// ```
    ///
    /// or, where the number of realizations is known, those of [`Self::with_realizations`].
    ///
    /// They are the values themselves where the spectrum is exact.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::critical_z`].
    pub fn limits(&self, side: Side, confidence: f64) -> Result<Vec<(usize, f64)>, Error> {
        let critical_z = self.critical_z(confidence)?;
        Ok(self.degrees().map(|l| (l, self.limit(side, l, critical_z))).collect())
    }

    /// Returns the one-sided quantile for which all degrees together have the confidence
    /// `confidence` (Sidak): normal, or Student's if the number of realizations is known.
    ///
    /// ```text
    /// z = Phi^-1(confidence^(1/K))     K degrees
    /// ```
    ///
    /// # Errors
    ///
    /// Returns [`Error::Parameter`] unless `0 < confidence < 1`, and [`Error::TooFewRealizations`]
    /// if a degree has no upper limit.
    pub fn critical_z(&self, confidence: f64) -> Result<f64, Error> {
        if !(confidence > 0.0 && confidence < 1.0) {
            return Err(Error::Parameter {
                name: "confidence",
                got: confidence,
                expected: "above 0 and below 1",
            });
        }
        // The upper tail 1 - confidence^(1/K), computed without the rounding of a number near 1.
        let tail = -(confidence.ln() / self.degrees().count() as f64).exp_m1();
        // For that many degrees of freedom the normal quantile is accurate, and fast.
        let dof = self.realizations.map(|r| r as f64 - 1.0).filter(|&dof| dof < 1e5);
        let student = dof.and_then(|dof| StudentsT::new(0.0, 1.0, dof).ok());
        let critical_z =
            student.map_or_else(|| -Normal::standard().inverse_cdf(tail), |t| -t.inverse_cdf(tail));
        match self.degrees().find(|&l| self.limit(Side::Upper, l, critical_z).is_infinite()) {
            Some(degree) => Err(Error::TooFewRealizations { degree }),
            None => Ok(critical_z),
        }
    }
}
