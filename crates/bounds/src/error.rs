use crate::{Family, Side};

/// An invalid profile, integrand class or spectrum, or a failed fit.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// The number of realizations is too small to limit the mean power.
    #[error(
        "too few realizations for a limit of the power of degree {degree} at this confidence; use about 30 or more"
    )]
    TooFewRealizations {
        /// The first degree without a limit.
        degree: usize,
    },
    /// A single number is outside its domain (NaN included).
    #[error("{name} is {got}; it must be {expected}")]
    Parameter {
        /// The name of the parameter.
        name: &'static str,
        /// The value that was given.
        got: f64,
        /// The domain, in words.
        expected: &'static str,
    },
    /// A per-degree value is negative, infinite or NaN.
    #[error("{quantity} of degree {degree} is {got}; it must be finite and not negative")]
    DegreeValue {
        /// The quantity in the slice.
        quantity: &'static str,
        /// The degree, which is the index in the slice.
        degree: usize,
        /// The value found there.
        got: f64,
    },
    /// The two slices of a measured spectrum differ in length.
    #[error(
        "the spectrum has {power} values of power but {stderr} standard errors; one is needed for each degree"
    )]
    LengthMismatch {
        /// Length of the slice of powers.
        power: usize,
        /// Length of the slice of standard errors.
        stderr: usize,
    },
    /// The number of points is zero.
    #[error("the number of points is 0; a spectrum needs at least 1 point")]
    NoPoints,
    /// The spectrum holds no degree that enters the variance.
    #[error("the spectrum has {got} values; at least {needed} are needed, for the degrees 0 to {}", needed - 1)]
    NoDegrees {
        /// Values in the spectrum, degree 0 included.
        got: usize,
        /// The smallest usable length.
        needed: usize,
    },
    /// No member of the family of profiles bounds the spectrum.
    #[error(
        "no {side} profile of this family bounds the spectrum: at degree {degree} the confidence limit is {limit} \
         and the family reaches from {lowest} to {highest}; give another offset, gamma or shape"
    )]
    NoFit {
        /// The requested side.
        side: Side,
        /// The first degree at which the family fails.
        degree: usize,
        /// Simultaneous confidence limit of the power at this degree.
        limit: f64,
        /// Smallest value that the family takes at this degree.
        lowest: f64,
        /// Largest value that the family takes at this degree.
        highest: f64,
    },
    /// An upper step was requested, but the first degree has power.
    #[error(
        "a step has no power below its break, but that of degree {degree} may be {limit:e}; give an offset that covers it"
    )]
    PowerBelowStep {
        /// The lowest degree.
        degree: usize,
        /// Simultaneous confidence limit of the power at this degree.
        limit: f64,
    },
    /// The largest lower bound is zero everywhere.
    #[error(
        "the largest {family} profile below the spectrum is 0: at degree {degree} the confidence limit is {limit:e}; \
         more realizations may raise it"
    )]
    OnlyZero {
        /// The requested family.
        family: Family,
        /// A degree that excludes every larger profile.
        degree: usize,
        /// Simultaneous confidence limit of the power at this degree.
        limit: f64,
    },
    /// The break `alpha` cannot be fitted, since no value of it is better than another.
    #[error(
        "alpha cannot be fitted: every alpha gives a {side} bound of this spectrum; fit gamma, or give a step or a \
         polynomial of exponent above 0 whose gamma matters"
    )]
    AlphaUndetermined {
        /// The requested side.
        side: Side,
    },
}

/// Returns `value` if it is finite and not negative.
pub(crate) fn not_negative(name: &'static str, value: f64) -> Result<f64, Error> {
    if value >= 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(Error::Parameter { name, got: value, expected: "finite and at least 0" })
    }
}

/// Returns `value` if it is finite and above zero.
pub(crate) fn positive(name: &'static str, value: f64) -> Result<f64, Error> {
    if value > 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(Error::Parameter { name, got: value, expected: "finite and above 0" })
    }
}

/// Checks every value of a slice indexed by degree.
pub(crate) fn per_degree(quantity: &'static str, values: &[f64]) -> Result<(), Error> {
    match values.iter().position(|v| !(v.is_finite() && *v >= 0.0)) {
        Some(degree) => Err(Error::DegreeValue { quantity, degree, got: values[degree] }),
        None => Ok(()),
    }
}
