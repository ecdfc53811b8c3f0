use std::fmt;

use crate::ProfileShape;

/// A family of profiles, from which a fit selects the tightest member.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Family {
    /// The plateau from the first degree on.
    Constant,
    /// Zero below a break, with at least one degree there, and the plateau from the break on.
    Step,
    /// The exponent 1.
    Linear,
    /// The exponent 2.
    Quadratic,
    /// Any exponent from 0 to [`Family::STEEPEST`].
    Polynomial,
}

impl Family {
    /// Every family, in display order.
    pub const ALL: [Self; 5] =
        [Self::Constant, Self::Step, Self::Linear, Self::Quadratic, Self::Polynomial];

    /// The largest exponent of a fit. Between degrees 1 and 2 it is a step of five orders of
    /// magnitude; a steeper rise is indistinguishable from a [`Family::Step`] in a plot.
    pub const STEEPEST: f64 = 16.0;

    /// Returns the name: `constant`, `step`, `linear`, `quadratic`, `poly`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::Step => "step",
            Self::Linear => "linear",
            Self::Quadratic => "quadratic",
            Self::Polynomial => "poly",
        }
    }

    /// Returns the smallest and the largest exponent; both infinite for the step.
    pub(crate) const fn exponents(self) -> (f64, f64) {
        match self {
            Self::Constant => (0.0, 0.0),
            Self::Step => (f64::INFINITY, f64::INFINITY),
            Self::Linear => (1.0, 1.0),
            Self::Quadratic => (2.0, 2.0),
            Self::Polynomial => (0.0, Self::STEEPEST),
        }
    }

    pub(crate) const fn shape(self, exponent: f64) -> ProfileShape {
        match self {
            Self::Constant => ProfileShape::Constant,
            Self::Step => ProfileShape::Step,
            Self::Linear | Self::Quadratic | Self::Polynomial => {
                ProfileShape::Polynomial { exponent }
            }
        }
    }
}

impl fmt::Display for Family {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
