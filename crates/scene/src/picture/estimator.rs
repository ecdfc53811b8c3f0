/// What a sum over the directions of a hit point is multiplied with.
///
/// For hemisphere sets, of which all N directions are kept, both are 1/N. Of a sphere set of M = 2N points n are
/// kept, a random number (`docs/theory.md`, section on the hemisphere).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Estimator {
    /// `(1/n) sum`: a mean of the kept directions. Its bias is of order `Var(n)/M^2`; a constant is
    /// integrated without error. With n = 0 the estimate is 0.
    Ratio,
    /// `(2/M) sum`: unbiased, but pays for the jump at the horizon.
    Unbiased,
}

impl Estimator {
    /// Both of them.
    pub const ALL: [Self; 2] = [Self::Ratio, Self::Unbiased];

    /// The name: `ratio` or `unbiased`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ratio => "ratio",
            Self::Unbiased => "unbiased",
        }
    }

    /// The factor for `kept` directions where `n_points` are expected.
    pub(crate) fn weight(self, kept: usize, n_points: usize) -> f64 {
        match self {
            Self::Ratio if kept == 0 => 0.0,
            Self::Ratio => 1.0 / kept as f64,
            Self::Unbiased => 1.0 / n_points as f64,
        }
    }
}
