use crate::{Bound, Error, MeasuredSpectrum, ProfileShape, Side};

impl Bound {
    /// Returns the tightest bound of this family: same side, shape, `alpha` and offset, with
    /// `gamma` fitted.
    ///
    /// The result has the smallest `gamma` of an upper (the largest of a lower) bound for which the
    /// profile satisfies the simultaneous one-sided confidence limits at every degree of the
    /// spectrum,
    ///
    /// ```text
    /// power_l +- critical_z stderr_l          critical_z = Phi^-1(confidence^(1/K))
    /// ```
    ///
    /// so that the true mean spectrum lies on the correct side of it at all K degrees with
    /// probability at least `confidence`, if the errors are normal and independent between degrees
    /// and the standard errors are correct. In general the probability is larger, since only one
    /// degree touches. A fitted bound always passes [`Bound::check`] on the same data.
    ///
    /// # Errors
    ///
    /// Returns [`Error::Parameter`] unless `0 < confidence < 1`; [`Error::NoFit`] if no `gamma` is
    /// sufficient, as for an upper step profile with power below its break, or a lower bound whose
    /// offset lies above a limit.
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_bounds::{Bound, Domain, MeasuredSpectrum, Profile};
    /// // An exact spectrum: P = omega^2 at l = 1 and 2 of N = 16 points.
    /// let spectrum = MeasuredSpectrum::new(16, Domain::Sphere, &[16.0, 0.0625, 0.25], &[0.0; 3])?;
    /// let fitted = Bound::upper(Profile::quadratic(1.0, 9.0)?).fit_gamma(&spectrum, 0.99)?;
    /// assert_eq!(fitted.profile.gamma(), 1.0);
    /// # Ok::<(), sphvar_bounds::Error>(())
    /// ```
    pub fn fit_gamma(
        &self,
        spectrum: &MeasuredSpectrum<'_>,
        confidence: f64,
    ) -> Result<Self, Error> {
        let critical_z = spectrum.critical_z(confidence)?;
        let profile = self.profile;
        let mut gamma: Option<f64> = None;
        for l in spectrum.degrees() {
            let limit = spectrum.limit(self.side, l, critical_z);
            let rise = profile.rise(l, spectrum.n_points());
            let over_offset = limit - profile.offset();
            let impossible = match self.side {
                Side::Upper => rise == 0.0 && over_offset > 0.0,
                Side::Lower => over_offset < 0.0,
            };
            if impossible {
                let highest = if rise > 0.0 { f64::INFINITY } else { profile.offset() };
                return Err(self.no_fit(l, limit, profile.offset(), highest));
            }
            if rise > 0.0 {
                let here = (over_offset / rise).clamp(0.0, f64::MAX);
                gamma = Some(match self.side {
                    Side::Upper => gamma.map_or(here, |g| g.max(here)),
                    Side::Lower => gamma.map_or(here, |g| g.min(here)),
                });
            }
        }
        // If no degree lies on the profile's rise (a step beyond the spectrum), gamma is
        // undetermined: the lower bound is 0, and for an upper bound any gamma is valid.
        let gamma = gamma.unwrap_or(0.0);
        Ok(Self { profile: profile.with_gamma(gamma)?, ..*self })
    }

    /// Returns the tightest bound of this family: same side, shape, `gamma` and offset, with the
    /// break `alpha` fitted.
    ///
    /// The result has the largest `alpha` of an upper (the smallest of a lower) bound for which the
    /// profile satisfies the same limits as in [`Bound::fit_gamma`], with the same meaning. A step
    /// profile is constant while its break moves between two degrees; the middle is returned.
    ///
    /// # Errors
    ///
    /// Returns [`Error::Parameter`] unless `0 < confidence < 1`; [`Error::NoFit`] if a limit lies
    /// above the plateau of an upper bound, or not above the offset of a lower one;
    /// [`Error::AlphaUndetermined`] if no degree constrains `alpha`, as for a constant profile that
    /// satisfies them all.
    pub fn fit_alpha(
        &self,
        spectrum: &MeasuredSpectrum<'_>,
        confidence: f64,
    ) -> Result<Self, Error> {
        let critical_z = spectrum.critical_z(confidence)?;
        let profile = self.profile;
        let mut alpha: Option<f64> = None;
        for l in spectrum.degrees() {
            let limit = spectrum.limit(self.side, l, critical_z);
            match self.alpha_at(l, spectrum.n_points(), limit) {
                Constraint::None => {}
                Constraint::Impossible => {
                    return Err(self.no_fit(l, limit, profile.offset(), profile.supremum()));
                }
                Constraint::Limit(here) => {
                    alpha = Some(match self.side {
                        Side::Upper => alpha.map_or(here, |a| a.min(here)),
                        Side::Lower => alpha.map_or(here, |a| a.max(here)),
                    });
                }
            }
        }
        let alpha = alpha.ok_or(Error::AlphaUndetermined { side: self.side })?;
        Ok(Self { profile: profile.with_alpha(alpha)?, ..*self })
    }

    /// Returns the constraint of one degree on `alpha`: an upper limit for an upper bound, a lower
    /// limit for a lower one.
    fn alpha_at(&self, l: usize, n_points: usize, limit: f64) -> Constraint {
        let (offset, gamma, b) =
            (self.profile.offset(), self.profile.gamma(), self.profile.exponent());
        let (low, high) = (offset, self.profile.supremum());
        let (free, impossible) = match self.side {
            Side::Upper => (limit <= low, limit > high),
            Side::Lower => (limit >= high, limit < low),
        };
        // A rising polynomial never decreases to its offset.
        let never_low_enough = self.side == Side::Lower && limit <= low && b.is_finite();
        let root_n = (n_points as f64).sqrt();
        if free {
            Constraint::None
        } else if impossible || b == 0.0 || never_low_enough {
            Constraint::Impossible
        } else if self.profile.shape() == ProfileShape::Step {
            let half = match self.side {
                Side::Upper => -0.5,
                Side::Lower => 0.5,
            };
            Constraint::Limit((l as f64 + half) / root_n)
        } else {
            let rise = (limit - offset) / gamma;
            Constraint::Limit(l as f64 / root_n * rise.powf(-b.recip()))
        }
    }

    fn no_fit(&self, degree: usize, limit: f64, lowest: f64, highest: f64) -> Error {
        Error::NoFit { side: self.side, degree, limit, lowest, highest }
    }
}

/// The constraint of one degree on the break.
enum Constraint {
    None,
    Impossible,
    Limit(f64),
}
