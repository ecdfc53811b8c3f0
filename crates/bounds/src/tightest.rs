use crate::branch_and_bound::search;
use crate::envelope::Envelope;
use crate::error::not_negative;
use crate::{Bound, Error, Family, IntegrandClass, MeasuredSpectrum, Profile, Side};

/// The criterion for the tightest profile of a family.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Criterion {
    /// The probability, for all degrees together, that the true spectrum lies on the correct side.
    pub confidence: f64,
    /// The decay p of the worst case, energy `l^-p`, by whose variance profiles are compared; 2 for
    /// a jump.
    pub decay: f64,
    /// The offset of the profile.
    pub offset: Offset,
}

/// The offset `g0` of a fitted profile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Offset {
    /// This value; 0 for none.
    Given(f64),
    /// The value that gives the tightest profile.
    Fitted,
}

/// The tightest profile of a family.
#[derive(Debug, Clone, PartialEq)]
pub struct Tightest {
    /// The family.
    pub family: Family,
    /// The profile and its side.
    pub bound: Bound,
    /// The largest possible improvement by another profile, relative to the variance of this one: 0
    /// if the fit is exact, otherwise about 1e-4.
    pub gap: f64,
    /// The degrees at which the profile touches the confidence limits: in general one below and one
    /// above the break.
    pub touching: Vec<usize>,
}

impl Default for Criterion {
    /// 99 % confidence, the worst case of a jump, no offset.
    fn default() -> Self {
        Self { confidence: 0.99, decay: 2.0, offset: Offset::Given(0.0) }
    }
}

impl Bound {
    /// Returns the smallest upper or the largest lower profile of a family over a measured mean
    /// spectrum.
    ///
    /// Profiles of a family cross each other, so "smallest" needs a measure. It is the variance in
    /// the worst case,
    ///
    /// ```text
    /// sum_{l >= 1} l^-p P(l)      over all degrees, p = criterion.decay
    /// ```
    ///
    /// at this number of points: among all profiles that satisfy the simultaneous confidence limits
    /// of [`MeasuredSpectrum::limits`] at every degree, an upper bound is the one with the least
    /// such variance and a lower bound that with the greatest. The free parameters are the break,
    /// the plateau, for [`Family::Polynomial`] the exponent, and the offset if it is fitted. The
    /// break lies within the spectrum, so that the plateau is measured.
    ///
    /// With probability at least `confidence` the true mean spectrum lies on the correct side at
    /// all degrees of the spectrum, if the errors are normal and independent between degrees, or
    /// positively correlated, and the standard errors are correct. The profiles of all families
    /// hold simultaneously at that level, since they satisfy the same limits; upper and lower ones
    /// together hold at `2 confidence - 1`. Beyond the spectrum there are no measurements, and the
    /// profile extrapolates its plateau. A rate derived from the profile assumes that the spectrum
    /// is a function of `l / sqrt N`, which a single number of points cannot confirm.
    ///
    /// The fit is exact for a given exponent and offset. If one of them is free, it is found by
    /// branch and bound, to within [`Tightest::gap`] of the optimum.
    ///
    /// # Errors
    ///
    /// Returns [`Error::Parameter`] unless `0 < confidence < 1`, `decay > 1` and the given offset
    /// is at least 0, all finite; [`Error::NoDegrees`] for a step over a single degree;
    /// [`Error::PowerBelowStep`] for an upper step over a spectrum that has power at its first
    /// degree (beyond the offset); [`Error::NoFit`] for a lower bound with a given offset above a
    /// limit; [`Error::OnlyZero`] if the largest lower bound is zero.
    ///
    /// # Performance
    ///
    /// `O(lmax)` powers for a given exponent and offset; about a hundred to ten thousand times that
    /// if one is free.
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_bounds::{Bound, Criterion, Domain, Family, MeasuredSpectrum, Profile, Side};
    /// // A spectrum that is a profile is its own tightest bound.
    /// let spectrum = Profile::quadratic(0.75, 1.25)?.spectrum(64, Domain::Sphere, 32);
    /// let measured = MeasuredSpectrum::from_spectrum(&spectrum)?;
    /// let fit = Bound::tightest(Side::Upper, Family::Quadratic, &measured, Criterion::default())?;
    /// assert!((fit.bound.profile.alpha() - 0.75).abs() < 1e-12);
    /// assert!((fit.bound.profile.gamma() - 1.25).abs() < 1e-12);
    /// # Ok::<(), sphvar_bounds::Error>(())
    /// ```
    pub fn tightest(
        side: Side,
        family: Family,
        spectrum: &MeasuredSpectrum<'_>,
        criterion: Criterion,
    ) -> Result<Tightest, Error> {
        let Criterion { confidence, decay, offset } = criterion;
        // `IntegrandClass` validates the decay.
        IntegrandClass::power_law(1.0, decay)?;
        let limits = spectrum.limits(side, confidence)?;
        if family == Family::Step && limits.len() < 2 {
            let (got, step) = (spectrum.len(), spectrum.domain().degree_step());
            return Err(Error::NoDegrees { got, needed: 2 * step + 1 });
        }
        let strictest = limits.iter().copied().reduce(|a, b| {
            let b_is = if side == Side::Upper { b.1 > a.1 } else { b.1 < a.1 };
            if b_is { b } else { a }
        });
        let (degree, limit) = strictest.unwrap_or((0, 0.0));
        let envelope = Envelope::new(side, spectrum, limits.iter().map(|x| x.1).collect(), decay);
        let offsets = match offset {
            Offset::Given(g) => {
                let g = not_negative("offset", g)?;
                if side == Side::Lower && g > limit {
                    return Err(Error::NoFit {
                        side,
                        degree,
                        limit,
                        lowest: g,
                        highest: f64::INFINITY,
                    });
                }
                (g, g)
            }
            // An offset of a constant is redundant.
            Offset::Fitted if family == Family::Constant => (0.0, 0.0),
            Offset::Fitted => (0.0, envelope.largest_offset()),
        };
        let found = search(&envelope, family.exponents(), offsets).ok_or_else(|| {
            let (degree, limit) = limits[0];
            Error::PowerBelowStep { degree, limit }
        })?;
        let best = found.best;
        if side == Side::Lower && best.value == 0.0 {
            return Err(Error::OnlyZero { family, degree, limit });
        }
        let alpha = best.break_degree / (spectrum.n_points() as f64).sqrt();
        let shape = family.shape(best.exponent);
        let alpha = if family == Family::Constant { 1.0 } else { alpha };
        let profile = Profile::new(shape, alpha, best.gamma)?.with_offset(best.offset)?;
        // Recomputed with the profile's own arithmetic, so that rounding cannot put it on the wrong
        // side.
        let bound = Self { side, profile };
        let bound =
            if family == Family::Step { bound } else { bound.fit_gamma(spectrum, confidence)? };
        let touching = limits
            .into_iter()
            .filter(|&(l, limit)| {
                let power = bound.profile.power(l, spectrum.n_points());
                power > 0.0 && (power - limit).abs() <= TOUCHING * limit
            })
            .map(|(l, _)| l)
            .collect();
        Ok(Tightest { family, bound, gap: found.gap, touching })
    }
}

/// The relative distance at which a profile touches a limit: the rounding of `(l/L)^b` for b up to
/// 16, with a margin.
const TOUCHING: f64 = 1e-10;
