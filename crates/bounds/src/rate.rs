use std::fmt;

/// The rate at which the variance falls with the number of points N.
///
/// ```
/// use sphvar_bounds::ConvergenceRate;
/// assert_eq!(ConvergenceRate::Algebraic { exponent: -1.5, log: true }.to_string(), "N^-1.5 ln N");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ConvergenceRate {
    /// `Var ~ constant * N^exponent`, times `ln N` if `log`.
    Algebraic {
        /// The power of N, negative.
        exponent: f64,
        /// Whether there is a factor `ln N`.
        log: bool,
    },
    /// The variance is exactly zero for every `N > beyond`.
    Zero {
        /// `(l0 / alpha)^2` with `l0` the last degree of the band; 0 if the variance is zero for
        /// every N.
        beyond: f64,
    },
}

impl fmt::Display for ConvergenceRate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Algebraic { exponent, log } => {
                write!(f, "N^{exponent}{}", if *log { " ln N" } else { "" })
            }
            Self::Zero { beyond } => write!(f, "0 for N > {beyond}"),
        }
    }
}
