/// The estimator of a mean over the visible half: the factor of the sum over the directions at a
/// hit point.
///
/// For hemisphere sets all N directions are used, and both factors are 1/N. Of a sphere set of M =
/// 2N points a random number n is visible. For weighted sets, sums of weights take the place of the
/// numbers: `sum w f/sum w` over the visible directions, and twice `sum w f` over the visible ones
/// divided by the sum of all weights.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Estimator {
    /// `(1/n) sum`: the mean of visible samples. Its bias is of order `Var(n)/M^2`; a constant is
    /// integrated without error. For n = 0, or visible weights that sum to 0, the estimate is 0.
    /// Unsuitable for weights of mixed sign, whose visible sum can be close to 0.
    Ratio,
    /// `(2/M) sum`: unbiased, but its variance includes that of the jump at the horizon.
    Unbiased,
}

impl Estimator {
    /// Both estimators.
    pub const ALL: [Self; 2] = [Self::Ratio, Self::Unbiased];

    /// Returns the name: `ratio` or `unbiased`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ratio => "ratio",
            Self::Unbiased => "unbiased",
        }
    }

    /// Returns the factor for directions of total weight `visible` where `expected` is expected.
    pub(crate) fn factor(self, visible: f64, expected: f64) -> f64 {
        match self {
            Self::Ratio if visible == 0.0 => 0.0,
            Self::Ratio => 1.0 / visible,
            Self::Unbiased => 1.0 / expected,
        }
    }
}
