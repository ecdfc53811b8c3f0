use crate::{Error, MeasuredSpectrum, Profile, Side};

/// The claim that a profile bounds a spectrum from above or from below.
///
/// [`Bound::check`] tests the claim. [`Bound::fit_gamma`] and [`Bound::fit_alpha`] adjust the
/// profile until the claim holds at a given confidence, and [`Bound::tightest`] finds the tightest
/// profile of a family.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound {
    /// The side on which the profile lies.
    pub side: Side,
    /// The profile.
    pub profile: Profile,
}

/// The outcome of checking a [`Bound`] against a measured spectrum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundVerdict {
    /// The degree with the strongest evidence against the bound: the largest excess in standard
    /// errors.
    pub worst_degree: usize,
    /// The measured power divided by the bound at that degree; 1 if both are 0.
    pub worst_ratio: f64,
    /// The excess beyond the bound at that degree, in standard errors; infinite for exact spectra.
    pub z: f64,
    /// The critical value of `z`: the one-sided normal quantile for all degrees together.
    pub critical_z: f64,
    /// The number of degrees tested.
    pub n_degrees: usize,
    /// Whether the bound holds: no degree refutes it.
    pub holds: bool,
    /// Whether the data prove the bound at the same confidence: every degree's confidence limit is
    /// within it.
    pub proved: bool,
    /// The degree with the largest ratio of power to bound (smallest for a lower bound), whatever
    /// its error.
    pub extreme_degree: usize,
    /// The measured power divided by the bound at that degree.
    pub extreme_ratio: f64,
}

/// The relative rounding allowed for a value that should lie exactly on the profile. A fitted
/// profile reproduces the limit that it was fitted to only up to a few operations, and `powf`
/// magnifies the error of `l / L` by `b`.
const ROUNDING: f64 = 1e-12;

impl Bound {
    /// Returns the claim that spectra lie on or below the profile.
    #[must_use]
    pub const fn upper(profile: Profile) -> Self {
        Self { side: Side::Upper, profile }
    }

    /// Returns the claim that spectra lie on or above the profile.
    #[must_use]
    pub const fn lower(profile: Profile) -> Self {
        Self { side: Side::Lower, profile }
    }

    /// Returns the outcome of testing the claim against a measured mean spectrum, simultaneously at
    /// all degrees.
    ///
    /// ```text
    /// z_l = +-(power_l - P(l)) / stderr_l        + for an upper, - for a lower bound
    /// the claim is refuted if z_l > critical_z = Phi^-1(confidence^(1/K)) for any of the K degrees
    /// ```
    ///
    /// False alarms: if the claim is true, the errors are normal and independent between degrees
    /// and the standard errors are correct, the claim is refuted with probability at most
    /// `1 - confidence`, with equality if the spectrum lies on the profile at every degree.
    /// Positive correlation between degrees only lowers this probability (Slepian). Standard errors
    /// estimated from few realizations have heavier tails than normal and raise it, unless the
    /// spectrum has a known number of realizations ([`MeasuredSpectrum::with_realizations`]), for
    /// which limits and z then account. `holds` states that the data do not refute the bound.
    /// `proved`, which is true for every fitted bound, states that the true spectrum is within it
    /// with probability at least `confidence`. For exact spectra the two are equal. No statement is
    /// made about degrees beyond the spectrum.
    ///
    /// An exact value (standard error 0) refutes the claim if it lies beyond the bound by more than
    /// 1e-12 of it and [`MeasuredSpectrum::NO_POWER`].
    ///
    /// # Errors
    ///
    /// Returns [`Error::Parameter`] unless `0 < confidence < 1`.
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_bounds::{Bound, Domain, MeasuredSpectrum, Profile};
    /// let spectrum = MeasuredSpectrum::new(4, Domain::Sphere, &[4.0, 0.9, 1.5], &[0.0, 0.1, 0.1])?;
    /// let verdict = Bound::upper(Profile::constant(1.2)?).check(&spectrum, 0.95)?;
    /// assert_eq!((verdict.holds, verdict.worst_degree), (false, 2));
    /// assert!((verdict.z - 3.0).abs() < 1e-12);
    /// # Ok::<(), sphvar_bounds::Error>(())
    /// ```
    ///
    /// # References
    ///
    /// Z. Sidak, J. Amer. Statist. Assoc. 62 (1967) 626; D. Slepian, Bell Syst. Tech. J. 41 (1962)
    /// 463.
    pub fn check(
        &self,
        spectrum: &MeasuredSpectrum<'_>,
        confidence: f64,
    ) -> Result<BoundVerdict, Error> {
        let critical_z = spectrum.critical_z(confidence)?;
        let mut verdict = BoundVerdict {
            worst_degree: 0,
            worst_ratio: f64::NAN,
            z: f64::NEG_INFINITY,
            critical_z,
            n_degrees: 0,
            holds: true,
            proved: true,
            extreme_degree: 0,
            extreme_ratio: f64::NAN,
        };
        for l in spectrum.degrees() {
            let bound = self.profile.power(l, spectrum.n_points());
            let (power, stderr) = (spectrum.power(l), spectrum.stderr(l));
            let allowance = ROUNDING * bound + MeasuredSpectrum::NO_POWER;
            let difference = self.outwards(power - bound);
            let excess = if difference.abs() <= allowance { 0.0 } else { difference };
            let z = if excess == 0.0 {
                0.0
            } else if stderr > 0.0 {
                self.outwards(spectrum.score(l, bound))
            } else {
                excess * f64::INFINITY
            };
            let ratio = if excess == 0.0 { 1.0 } else { power / bound };
            let first = verdict.n_degrees == 0;
            // Exact spectra have infinite z throughout; the ratio breaks ties.
            let worse = z > verdict.z
                || (z >= verdict.z && self.outwards(ratio) > self.outwards(verdict.worst_ratio));
            if first || worse {
                (verdict.worst_degree, verdict.worst_ratio, verdict.z) = (l, ratio, z);
            }
            // A bound of 0 below a step makes no claim, so no degree there is close to it.
            let extreme = self.outwards(ratio) > self.outwards(verdict.extreme_ratio);
            if bound > 0.0 && (verdict.extreme_ratio.is_nan() || extreme) {
                (verdict.extreme_degree, verdict.extreme_ratio) = (l, ratio);
            }
            let beyond = |side| self.outwards(spectrum.limit(side, l, critical_z) - bound);
            verdict.holds &= beyond(self.side.opposite()) <= allowance;
            verdict.proved &= beyond(self.side) <= allowance;
            verdict.n_degrees += 1;
        }
        Ok(verdict)
    }

    /// Returns the difference with the sign that is positive if it contradicts the claim.
    pub(crate) fn outwards(&self, difference: f64) -> f64 {
        match self.side {
            Side::Upper => difference,
            Side::Lower => -difference,
        }
    }
}
