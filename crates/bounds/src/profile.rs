use crate::error::{not_negative, positive};
use crate::{Domain, Error, Family, ProfileShape};
use sphvar_spectrum::Spectrum;

/// A simple model of the power spectrum of a pattern of N points, used as its upper or lower bound.
///
/// ```text
/// P(l) = g0 + gamma min(1, (l / (alpha sqrt N))^b)     polynomial, b >= 0
/// P(l) = g0 + gamma [l >= alpha sqrt N]                step, the limit b -> infinity
/// P(l) = g0 + gamma                                    constant, the case b = 0
/// ```
///
/// `alpha > 0` is the break on the axis `omega = l / sqrt N`, `gamma >= 0` the height of the
/// plateau over the offset `g0 >= 0` (0 unless [`Profile::with_offset`] is used). Every profile is
/// non-decreasing in `l`, and non-increasing in `N`. Power is in the unit where white noise has 1.
///
/// # Examples
///
/// ```
/// use sphvar_bounds::Profile;
/// let jittered = Profile::quadratic(0.2, 1.0)?;
/// assert_eq!(jittered.power(1, 100), 0.25); // break at l = 2
/// assert_eq!(jittered.power(2, 100), 1.0);
/// assert!(Profile::step(f64::NAN, 1.0).is_err());
/// # Ok::<(), sphvar_bounds::Error>(())
/// ```
///
/// # References
///
/// G. Singh 2015, equations 6.3, 6.5 (with the square root of N, not its b-th root).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Profile {
    shape: ProfileShape,
    alpha: f64,
    gamma: f64,
    offset: f64,
}

impl Profile {
    /// Returns the profile of a shape with its break `alpha` and its plateau `gamma`, without
    /// offset.
    ///
    /// # Errors
    ///
    /// Returns [`Error::Parameter`] unless `alpha` is finite and above 0, and `gamma` and a
    /// polynomial's exponent are finite and at least 0.
    pub fn new(shape: ProfileShape, alpha: f64, gamma: f64) -> Result<Self, Error> {
        if let ProfileShape::Polynomial { exponent } = shape {
            not_negative("exponent", exponent)?;
        }
        Ok(Self {
            shape,
            alpha: positive("alpha", alpha)?,
            gamma: not_negative("gamma", gamma)?,
            offset: 0.0,
        })
    }

    /// Returns the profile of constants that are known to be valid.
    pub(crate) const fn trusted(shape: ProfileShape, alpha: f64, gamma: f64) -> Self {
        Self { shape, alpha, gamma, offset: 0.0 }
    }

    /// Returns the constant profile `P(l) = gamma`.
    ///
    /// # Errors
    ///
    /// Returns [`Error::Parameter`] unless `gamma` is finite and at least 0.
    pub fn constant(gamma: f64) -> Result<Self, Error> {
        Self::new(ProfileShape::Constant, 1.0, gamma)
    }

    /// Returns the step profile: 0 for `l < alpha sqrt N`, `gamma` from there on.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Profile::new`].
    pub fn step(alpha: f64, gamma: f64) -> Result<Self, Error> {
        Self::new(ProfileShape::Step, alpha, gamma)
    }

    /// Returns the profile that rises linearly, `b = 1`.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Profile::new`].
    pub fn linear(alpha: f64, gamma: f64) -> Result<Self, Error> {
        Self::polynomial(1.0, alpha, gamma)
    }

    /// Returns the profile that rises quadratically, `b = 2`.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Profile::new`].
    pub fn quadratic(alpha: f64, gamma: f64) -> Result<Self, Error> {
        Self::polynomial(2.0, alpha, gamma)
    }

    /// Returns the profile that rises with the power `exponent`.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Profile::new`].
    pub fn polynomial(exponent: f64, alpha: f64, gamma: f64) -> Result<Self, Error> {
        Self::new(ProfileShape::Polynomial { exponent }, alpha, gamma)
    }

    /// Returns this profile with the offset replaced by `offset`.
    ///
    /// Poisson disk patterns and CCVT with random mass points have such a floor at low degrees.
    ///
    /// # Errors
    ///
    /// Returns [`Error::Parameter`] unless `offset` is finite and at least 0.
    pub fn with_offset(self, offset: f64) -> Result<Self, Error> {
        Ok(Self { offset: not_negative("offset", offset)?, ..self })
    }

    /// Returns this profile with another plateau.
    ///
    /// # Errors
    ///
    /// Returns [`Error::Parameter`] unless `gamma` is finite and at least 0.
    pub fn with_gamma(self, gamma: f64) -> Result<Self, Error> {
        Ok(Self { gamma: not_negative("gamma", gamma)?, ..self })
    }

    /// Returns this profile with another break.
    ///
    /// # Errors
    ///
    /// Returns [`Error::Parameter`] unless `alpha` is finite and above 0.
    pub fn with_alpha(self, alpha: f64) -> Result<Self, Error> {
        Ok(Self { alpha: positive("alpha", alpha)?, ..self })
    }

    /// Returns the narrowest family that the profile belongs to.
    #[must_use]
    pub const fn family(&self) -> Family {
        match self.shape {
            ProfileShape::Constant => Family::Constant,
            ProfileShape::Step => Family::Step,
            ProfileShape::Polynomial { exponent: 1.0 } => Family::Linear,
            ProfileShape::Polynomial { exponent: 2.0 } => Family::Quadratic,
            ProfileShape::Polynomial { .. } => Family::Polynomial,
        }
    }

    /// Returns the shape.
    #[must_use]
    pub const fn shape(&self) -> ProfileShape {
        self.shape
    }

    /// Returns the break on the axis `omega = l / sqrt N`.
    #[must_use]
    pub const fn alpha(&self) -> f64 {
        self.alpha
    }

    /// Returns the height of the plateau over the offset.
    #[must_use]
    pub const fn gamma(&self) -> f64 {
        self.gamma
    }

    /// Returns the offset `g0`.
    #[must_use]
    pub const fn offset(&self) -> f64 {
        self.offset
    }

    /// Returns the exponent `b`: 0 for a constant, infinite for a step.
    #[must_use]
    pub const fn exponent(&self) -> f64 {
        match self.shape {
            ProfileShape::Constant => 0.0,
            ProfileShape::Step => f64::INFINITY,
            ProfileShape::Polynomial { exponent } => exponent,
        }
    }

    /// Returns the break in degrees, `L = alpha sqrt N`, in general not an integer.
    #[must_use]
    pub fn break_degree(&self, n_points: usize) -> f64 {
        self.alpha * (n_points as f64).sqrt()
    }

    /// Returns the least upper bound of the profile over all degrees, `g0 + gamma`.
    #[must_use]
    pub fn supremum(&self) -> f64 {
        self.offset + self.gamma
    }

    /// Returns the power at degree `l` of a pattern of `n_points` points.
    ///
    /// Degree 0 follows the formula too, but it never enters a variance: a pattern has `P(0) = N`.
    /// Whether a degree lies on a step's break is decided by `l as f64 < alpha * sqrt(N)` in
    /// floating point, here and in every closed form of this crate.
    #[must_use]
    pub fn power(&self, l: usize, n_points: usize) -> f64 {
        self.offset + self.gamma * self.rise(l, n_points)
    }

    /// Returns the profile as an exact spectrum of patterns of `n_points`.
    ///
    /// It can be used wherever an estimated spectrum can. Like any spectrum it ends at `lmax`,
    /// beyond which predictions assume power 1, so `lmax` should be large if the plateau is not 1.
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_bounds::{Domain, Profile};
    /// let spectrum = Profile::linear(0.5, 1.0)?.spectrum(64, Domain::Sphere, 5);
    /// assert!(spectrum.is_exact());
    /// assert_eq!(spectrum.power(), [64.0, 0.25, 0.5, 0.75, 1.0, 1.0]);
    /// # Ok::<(), sphvar_bounds::Error>(())
    /// ```
    #[must_use]
    pub fn spectrum(&self, n_points: usize, domain: Domain, lmax: usize) -> Spectrum {
        let power = (0..=lmax).map(|l| self.power(l, n_points)).collect();
        Spectrum::exact(domain, n_points, power)
    }

    /// Returns the profile without offset and with `gamma = 1`.
    pub(crate) fn rise(&self, l: usize, n_points: usize) -> f64 {
        let (l, break_degree) = (l as f64, self.break_degree(n_points));
        match self.shape {
            ProfileShape::Constant => 1.0,
            ProfileShape::Step if l < break_degree => 0.0,
            ProfileShape::Polynomial { exponent } if l < break_degree => {
                (l / break_degree).powf(exponent)
            }
            ProfileShape::Step | ProfileShape::Polynomial { .. } => 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invalid_parameters_are_rejected_by_name() {
        let bad = [f64::NAN, f64::INFINITY, -1.0];
        for value in bad {
            for (name, result) in [
                ("alpha", Profile::step(value, 1.0)),
                ("gamma", Profile::step(1.0, value)),
                ("gamma", Profile::constant(value)),
                ("exponent", Profile::polynomial(value, 1.0, 1.0)),
                ("offset", Profile::linear(1.0, 1.0).and_then(|p| p.with_offset(value))),
                ("alpha", Profile::linear(1.0, 1.0).and_then(|p| p.with_alpha(value))),
                ("gamma", Profile::linear(1.0, 1.0).and_then(|p| p.with_gamma(value))),
            ] {
                match result {
                    Err(Error::Parameter { name: found, .. }) => {
                        assert_eq!(found, name, "value {value}");
                    }
                    other => panic!("{name} = {value} gave {other:?}"),
                }
            }
        }
        assert!(Profile::linear(0.0, 1.0).is_err(), "alpha = 0 has no break");
    }

    #[test]
    fn values_on_both_sides_of_the_break() -> Result<(), Error> {
        let step = Profile::step(0.5, 3.0)?;
        // sqrt(64) = 8, so the break is exactly at l = 4, which belongs to the plateau.
        let values = [3, 4, 5].map(|l| step.power(l, 64).to_bits());
        assert_eq!(values, [0.0, 3.0, 3.0].map(f64::to_bits), "step");
        let lifted = Profile::linear(0.5, 3.0)?.with_offset(0.25)?;
        let values = [0, 2, 4, 400].map(|l| lifted.power(l, 64).to_bits());
        assert_eq!(values, [0.25, 1.75, 3.25, 3.25].map(f64::to_bits), "linear with offset");
        assert_eq!(
            Profile::polynomial(0.0, 9.0, 2.0)?.power(1, 64).to_bits(),
            2.0_f64.to_bits(),
            "b = 0 is constant"
        );
        // Without points the break is at 0 and every degree is on the plateau.
        assert_eq!(step.power(1, 0).to_bits(), 3.0_f64.to_bits());
        Ok(())
    }
}
