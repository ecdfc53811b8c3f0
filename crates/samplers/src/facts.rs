use std::fmt;

/// The properties of a pattern that are known without computation.
///
/// Powers and rates that the source does not give were measured with this program.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PatternFacts {
    /// The growth of the time for a set with its number of points N.
    pub cost: CostOrder,
    /// The power P(l), on the square P(k), as the degree l or the frequency |k| goes to 0, in words;
    /// 1 for white noise.
    pub low_degrees: &'static str,
    /// The rate at which the variance falls with N for smooth integrands; on the square for those
    /// that are smooth on the torus. A difference between opposite edges counts as a jump.
    pub smooth_rate: Rate,
    /// The rate at which the variance falls with N for integrands with jumps.
    pub jump_rate: Rate,
    /// Whether every prefix of a set is a set of the same pattern.
    pub is_extensible: bool,
    /// The publication that describes the pattern.
    pub source: &'static str,
}

/// The rate at which a variance falls with the number of points N; displayed as, for example,
/// `N^-1.5`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Rate {
    /// As `N^exponent (log N)^logarithm`.
    Power {
        /// The exponent of N, negative.
        exponent: f64,
        /// The exponent of log N.
        logarithm: f64,
    },
    /// The variance is 0 if the integrand is band-limited and N is large enough.
    Exact,
    /// Determined by the requested spectrum.
    AsRequested,
    /// The variance tends to that of a bias, because the points are not uniformly dense.
    Biased,
    /// Depends on the integrand and on the number of points; no rate is known.
    Depends,
}

/// The growth of the time for a set with its number of points N: `N^exponent (log N)^logarithm`,
/// times a factor that depends on the parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct CostOrder {
    /// The exponent of N.
    pub exponent: f64,
    /// The exponent of log N.
    pub logarithm: f64,
    /// The factor in words, such as `per step`; empty if there is none.
    pub factor: &'static str,
}

impl PatternFacts {
    /// Returns the rates of the variance in words, such as `N^-2 for smooth integrands, ...`.
    #[must_use]
    pub fn rates(&self) -> String {
        self.rates_for(["every integrand", "smooth integrands"])
    }

    /// Returns the same for a pattern of the square, where integrands are smooth if they are so
    /// across opposite sides too. Integrands of a special form, such as sums of functions of one
    /// coordinate with Latin hypercubes, may have better rates.
    #[must_use]
    pub fn rates_on_torus(&self) -> String {
        self.rates_for(["integrands in general", "smooth periodic integrands"])
    }

    fn rates_for(&self, [every, smooth]: [&str; 2]) -> String {
        let Self { smooth_rate, jump_rate, .. } = self;
        match smooth_rate {
            Rate::Power { .. } if smooth_rate == jump_rate => {
                format!("{smooth_rate} for {every}")
            }
            _ if smooth_rate == jump_rate => smooth_rate.to_string(),
            _ => format!("{smooth_rate} for {smooth}, {jump_rate} for those with jumps"),
        }
    }
}

impl Rate {
    /// Returns the rate `N^exponent`.
    pub(crate) const fn power(exponent: f64) -> Self {
        Self::Power { exponent, logarithm: 0.0 }
    }
}

impl CostOrder {
    /// A cost that grows as N.
    pub(crate) const LINEAR: Self = Self { exponent: 1.0, logarithm: 0.0, factor: "" };
    /// A cost that grows as N log N.
    pub(crate) const LINEARITHMIC: Self = Self { logarithm: 1.0, ..Self::LINEAR };
    /// A cost that grows as N^2.
    pub(crate) const QUADRATIC: Self = Self { exponent: 2.0, ..Self::LINEAR };
    /// A cost that grows as N^3.
    pub(crate) const CUBIC: Self = Self { exponent: 3.0, ..Self::LINEAR };

    /// Returns the same order with a factor that depends on the parameters.
    pub(crate) const fn times(self, factor: &'static str) -> Self {
        Self { factor, ..self }
    }
}

impl fmt::Display for Rate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Power { exponent, logarithm } => growth(f, exponent, logarithm),
            Self::Exact => f.write_str("exact"),
            Self::AsRequested => f.write_str("as requested"),
            Self::Biased => f.write_str("none, a bias remains"),
            Self::Depends => f.write_str("no known rate"),
        }
    }
}

impl fmt::Display for CostOrder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        growth(f, self.exponent, self.logarithm)?;
        if self.factor.is_empty() { Ok(()) } else { write!(f, " {}", self.factor) }
    }
}

/// Writes `N^a (log N)^b`.
fn growth(f: &mut fmt::Formatter<'_>, exponent: f64, logarithm: f64) -> fmt::Result {
    if exponent.to_bits() == 1_f64.to_bits() {
        f.write_str("N")?;
    } else {
        write!(f, "N^{exponent}")?;
    }
    if logarithm.to_bits() == 1_f64.to_bits() {
        f.write_str(" log N")?;
    } else if logarithm != 0.0 {
        write!(f, " (log N)^{logarithm}")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{CostOrder, Rate};

    #[test]
    fn orders_are_powers_of_n_or_words() {
        let rate = |exponent, logarithm| Rate::Power { exponent, logarithm }.to_string();
        assert_eq!(rate(-1.5, 0.0), "N^-1.5");
        assert_eq!(rate(-3.0, 2.0), "N^-3 (log N)^2");
        assert_eq!(Rate::Exact.to_string(), "exact");
        assert_eq!(CostOrder::LINEAR.to_string(), "N");
        assert_eq!(CostOrder::LINEARITHMIC.times("per step").to_string(), "N log N per step");
    }
}
