use crate::{Error, MeasuredSpectrum, Profile, Side};

/// A profile together with the claim that it bounds a spectrum from above or from below.
///
/// [`Bound::check`] tests the claim; [`Bound::fit_gamma`] and [`Bound::fit_alpha`] move the profile until the
/// claim is safe, and [`Bound::tightest`] finds the profile of a family that says most.
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
    /// The degree that speaks most against the bound: the largest excess in standard errors.
    pub worst_degree: usize,
    /// Measured power over bound at that degree; 1 if both are 0.
    pub worst_ratio: f64,
    /// Excess beyond the bound in standard errors at that degree; infinite for exact spectra.
    pub z: f64,
    /// What `z` may reach: the one-sided normal quantile for all degrees together.
    pub critical_z: f64,
    /// How many degrees were tested.
    pub n_degrees: usize,
    /// Whether the bound stands: no degree refutes it.
    pub holds: bool,
    /// Whether the data prove the bound at the same confidence: every degree's limit clears it.
    pub proved: bool,
    /// The degree that comes closest to the bound, or lies farthest beyond it, in proportion, whatever its error.
    pub extreme_degree: usize,
    /// Measured power over bound at that degree.
    pub extreme_ratio: f64,
}

/// Relative rounding allowed to a value that should lie exactly on the profile: a fitted profile takes a handful of
/// operations back to the limit that it was fitted to, and `powf` magnifies the error of `l / L` by `b`.
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

    /// Tests the claim against a measured mean spectrum, all degrees together.
    ///
    /// ```text
    /// z_l = +-(power_l - P(l)) / stderr_l        + for an upper, - for a lower bound
    /// the claim is refuted if z_l > critical_z = Phi^-1(confidence^(1/K)) for any of the K degrees
    /// ```
    ///
    /// False alarms: if the claim is true, the errors are normal and independent between degrees and the standard
    /// errors are right, then the claim is refuted with probability at most `1 - confidence`; exactly that if the
    /// spectrum lies on the profile at every degree. Positive correlation between degrees only lowers it (Slepian).
    /// Standard errors estimated from few realizations make the tails heavier than normal and raise it, unless the
    /// spectrum knows its number of realizations ([`MeasuredSpectrum::with_realizations`]), of which limits and z then
    /// take account. `holds` says that the data do not refute the bound; `proved`, which a fitted bound always has, says that
    /// the true spectrum is within it with probability at least `confidence`. For exact spectra the two are the same.
    /// Nothing is said about degrees beyond the spectrum.
    ///
    /// An exact value (standard error 0) refutes the claim if it lies beyond the bound by more than 1e-12 of it and
    /// [`MeasuredSpectrum::NO_POWER`].
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] unless `0 < confidence < 1`.
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
    /// Z. Sidak, J. Amer. Statist. Assoc. 62 (1967) 626; D. Slepian, Bell Syst. Tech. J. 41 (1962) 463.
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
            // Exact spectra have infinite z throughout; among equals the ratio decides.
            let worse = z > verdict.z
                || (z >= verdict.z && self.outwards(ratio) > self.outwards(verdict.worst_ratio));
            if first || worse {
                (verdict.worst_degree, verdict.worst_ratio, verdict.z) = (l, ratio, z);
            }
            // 0 below a step says nothing, so it comes close to nothing.
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

    /// Returns the difference counted positive where it speaks against the claim.
    pub(crate) fn outwards(&self, difference: f64) -> f64 {
        match self.side {
            Side::Upper => difference,
            Side::Lower => -difference,
        }
    }
}
