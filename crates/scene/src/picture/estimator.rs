/// The estimator of a mean over the visible half: the factor of the sum over the directions at a
/// hit point.
///
/// For hemisphere sets all N directions are used, and both factors are 1/N. Of a sphere set of M =
/// 2N points a random number n is visible.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Estimator {
    /// `(1/n) sum`: the mean of visible samples. Its bias is of order `Var(n)/M^2`; a constant is
    /// integrated without error. For n = 0 the estimate is 0.
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

    /// Returns the factor for `visible` directions where `n_points` are expected.
    pub(crate) fn weight(self, visible: usize, n_points: usize) -> f64 {
        match self {
            Self::Ratio if visible == 0 => 0.0,
            Self::Ratio => 1.0 / visible as f64,
            Self::Unbiased => 1.0 / n_points as f64,
        }
    }
}
