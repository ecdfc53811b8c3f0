use sphvar_samplers::Domain;

use crate::Error;

/// Settings of an audit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AuditSettings {
    /// The maximum probability of rejecting a homogeneous ensemble, in [1e-4, 0.5].
    pub alpha: f64,
    /// The relative error of a variance that must be detectable for a positive verdict, above 0.
    pub tolerance: f64,
    /// The seed of the randomly rotated copies.
    pub seed: u64,
}

impl AuditSettings {
    /// The minimum alpha.
    pub const MIN_ALPHA: f64 = 1e-4;

    /// The maximum alpha.
    pub const MAX_ALPHA: f64 = 0.5;

    /// Returns the default settings: rejects 1 of 100 homogeneous ensembles, tolerance 20 %.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self { alpha: 0.01, tolerance: 0.2, seed }
    }

    /// Returns the number of randomly rotated copies of the ensemble: `2 k/alpha - 1` for k = 5
    /// families, so that the smallest possible p-value, 1/(copies + 1), is half the rejection
    /// threshold.
    #[must_use]
    pub fn replicates(&self) -> u64 {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a valid alpha gives 19 to 100000, and casts saturate"
        )]
        let copies = (2.0 * AuditFamily::ALL.len() as f64 / self.alpha).ceil() as u64;
        copies.saturating_sub(1)
    }

    pub(super) fn check(&self) -> Result<(), Error> {
        if !(Self::MIN_ALPHA..=Self::MAX_ALPHA).contains(&self.alpha) {
            return Err(Error::Setting {
                what: "alpha of an audit",
                expected: "in [1e-4, 0.5]",
                got: self.alpha,
            });
        }
        if !(self.tolerance > 0.0 && self.tolerance.is_finite()) {
            return Err(Error::Setting {
                what: "tolerance of an audit",
                expected: "finite and above 0",
                got: self.tolerance,
            });
        }
        Ok(())
    }
}

/// A family of tests with one statistic, the maximum of its scores.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AuditFamily {
    /// `E S_lm = 0` for l >= 1: bias.
    Means,
    /// `arg S_lm` uniform on the circle, m >= 1: Rayleigh test of the phase and of the doubled
    /// phase.
    Phases,
    /// `E |S_lm|^2` equal for all orders of a degree.
    Orders,
    /// `E S_lm conj S_l'm' = 0` and `E S_lm S_l'm' = 0` for different coefficients, and
    /// `E S_lm^2 = 0` for m >= 1, degrees up to 4.
    Covariances,
    /// `E R = 0` for the rotations of the realizations.
    Rotations,
}

impl AuditFamily {
    /// All families.
    pub const ALL: [Self; 5] =
        [Self::Means, Self::Phases, Self::Orders, Self::Covariances, Self::Rotations];

    /// Returns a short name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Means => "means",
            Self::Phases => "phases",
            Self::Orders => "orders",
            Self::Covariances => "covariances",
            Self::Rotations => "rotations",
        }
    }
}

/// The result of one family.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The family.
    pub family: AuditFamily,
    /// The number of comparisons; 0 if there was nothing to test.
    pub comparisons: usize,
    /// The maximum score: in standard deviations; for phases the Rayleigh statistic and for
    /// rotations the corresponding chi-square statistic.
    pub statistic: f64,
    /// The probability of a statistic at least this large in a homogeneous ensemble.
    pub p_value: f64,
    /// The p-value adjusted for the number of families (Holm 1979).
    pub adjusted: f64,
    /// Whether the family rejects homogeneity.
    pub rejected: bool,
    /// The comparison with the maximum score.
    pub worst: String,
    /// The value of that comparison: the mean in units of `sqrt(P(l))`, the mean resultant length,
    /// `P(l, m)/P(l)`, the correlation, the entry of the mean rotation.
    pub value: f64,
}

/// `P(l, m)/P(l)`, the ratio of the mean squared error for `Y_lm` to the variance formula.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrderRatio {
    /// The degree.
    pub l: usize,
    /// The order.
    pub m: usize,
    /// The estimate.
    pub ratio: f64,
    /// Its standard error; NaN for a single realization.
    pub stderr: f64,
    /// The lower end of the confidence interval. The intervals of all (l, m) hold simultaneously
    /// with probability about `1 - alpha`.
    pub low: f64,
    /// The upper end of the confidence interval.
    pub high: f64,
}

/// `|E S_lm|^2` relative to the power of the degree: the contribution of the bias to the mean
/// squared error for `Y_lm`, in units of the variance by the formula. An unbiased ensemble of R
/// realizations has about 1/R.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanBias {
    /// The degree.
    pub l: usize,
    /// The order.
    pub m: usize,
    /// The relative contribution.
    pub share: f64,
}

/// Verdict on the validity of the variance formula.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AuditVerdict {
    /// No family rejects, and an error as large as the tolerance would have been detected.
    Homogeneous,
    /// At least one family rejects.
    Inhomogeneous,
    /// No family rejects, but an error as large as the tolerance may have been missed.
    Undecided,
}

/// Result of testing whether the distribution of an ensemble is rotation-invariant, the assumption
/// of the variance formula.
///
/// Returned by [`HomogeneityAccumulator::audit`](crate::HomogeneityAccumulator::audit).
///
/// The null distribution is generated from the ensemble itself. Under invariance, independent
/// uniform rotations of the realizations do not change their distribution, so the statistics of the
/// ensemble and of its rotated copies are exchangeable. Therefore
/// `p = (1 + #{copies with T_b >= T})/(1 + copies)` is a valid p-value for any number of points and
/// realizations and any distribution of the coefficients (Lehmann and Romano 2005, theorem 15.2.1).
/// The maximum corrects for multiple scores within a family (Westfall and Young 1993), Holm's
/// method for multiple families. The audit covers only degrees up to lmax, and only these
/// statistics.
#[derive(Clone, Debug, PartialEq)]
pub struct HomogeneityAudit {
    /// The domain of the points.
    pub domain: Domain,
    /// The maximum degree.
    pub lmax: usize,
    /// The number of realizations.
    pub realizations: usize,
    /// Degrees excluded because no realization has power in them.
    pub vanishing: Vec<usize>,
    /// One result per family that could be tested.
    pub findings: Vec<Finding>,
    /// `P(l, m)/P(l)` of every tested (l, m).
    pub ratios: Vec<OrderRatio>,
    /// The maximum bias.
    pub bias: Option<MeanBias>,
    /// The relative error of the variance of any `Y_lm` that is detected with probability 0.9;
    /// infinite if nothing was tested.
    pub detectable: f64,
    /// The verdict.
    pub verdict: AuditVerdict,
}

impl HomogeneityAudit {
    /// Returns the largest `P(l, m)/P(l)`, the worst-case factor of a mean squared error.
    #[must_use]
    pub fn worst_ratio(&self) -> Option<OrderRatio> {
        self.ratios.iter().copied().max_by(|a, b| a.ratio.total_cmp(&b.ratio))
    }

    /// Returns the result of a family, if it was tested.
    #[must_use]
    pub fn finding(&self, family: AuditFamily) -> Option<&Finding> {
        self.findings.iter().find(|f| f.family == family)
    }
}
