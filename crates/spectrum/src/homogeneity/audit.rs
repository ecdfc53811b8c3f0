use sphvar_samplers::Domain;

use crate::Error;

/// How an audit judges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AuditSettings {
    /// The probability that an audit objects to a homogeneous ensemble, at most; [1e-4, 0.5].
    pub alpha: f64,
    /// The relative error of a variance that must be seen for a positive verdict, above 0.
    pub tolerance: f64,
    /// The seed of the turned copies.
    pub seed: u64,
}

impl AuditSettings {
    /// The smallest alpha.
    pub const MIN_ALPHA: f64 = 1e-4;

    /// The largest alpha.
    pub const MAX_ALPHA: f64 = 0.5;

    /// Objects to 1 of 100 homogeneous ensembles, and wants to see an error of 20 %.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self { alpha: 0.01, tolerance: 0.2, seed }
    }

    /// How many turned copies of the ensemble are made: `2 k/alpha - 1` for k = 5 families, so that
    /// the smallest p-value, 1 in that and one more, is half of what rejects.
    #[must_use]
    pub fn replicates(&self) -> u64 {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a legal alpha gives 19 to 100000, and casts saturate"
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

/// What is tested: one statistic each, the largest of its scores.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AuditFamily {
    /// `E S_lm = 0` for l >= 1: bias.
    Means,
    /// `arg S_lm` uniform on the circle, m >= 1: Rayleigh's test of the phase and of its double.
    Phases,
    /// `E |S_lm|^2` the same for all orders of a degree.
    Orders,
    /// `E S_lm conj S_l'm' = 0` and `E S_lm S_l'm' = 0` for different coefficients, and
    /// `E S_lm^2 = 0` for m >= 1, degrees up to 4.
    Covariances,
    /// `E R = 0` for the rotations that were used.
    Rotations,
}

impl AuditFamily {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Means, Self::Phases, Self::Orders, Self::Covariances, Self::Rotations];

    /// A short name.
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
    /// What was tested.
    pub family: AuditFamily,
    /// How many numbers were compared; 0 if there was nothing to test.
    pub comparisons: usize,
    /// The largest score: in standard deviations, for phases and rotations Rayleigh's and the
    /// corresponding chi-square.
    pub statistic: f64,
    /// The probability of as large a statistic in a homogeneous ensemble.
    pub p_value: f64,
    /// The same, adjusted for the number of families (Holm 1979).
    pub adjusted: f64,
    /// Whether the family objects.
    pub rejected: bool,
    /// Where the largest score is.
    pub worst: String,
    /// The value there: the mean in units of `sqrt(P(l))`, the mean resultant length,
    /// `P(l, m)/P(l)`, the correlation, the entry of the mean rotation.
    pub value: f64,
}

/// `P(l, m)/P(l)`, by which the mean squared error for `Y_lm` differs from the formula's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrderRatio {
    /// The degree.
    pub l: usize,
    /// The order.
    pub m: usize,
    /// The estimate.
    pub ratio: f64,
    /// Its standard error; NaN of a single realization.
    pub stderr: f64,
    /// The interval's lower end; the intervals of all (l, m) hold together with probability
    /// `1 - alpha`, about.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
}

/// `|E S_lm|^2` relative to the power of the degree: what the bias adds to the mean squared error for
/// `Y_lm`, in units of the formula's variance. Noise alone leaves 1/R.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanBias {
    /// The degree.
    pub l: usize,
    /// The order.
    pub m: usize,
    /// The share.
    pub share: f64,
}

/// Whether the variance formula may be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AuditVerdict {
    /// No family objects, and an error of the tolerance would have been seen.
    Homogeneous,
    /// A family objects.
    Inhomogeneous,
    /// No family objects, but an error of the tolerance could have been missed.
    Undecided,
}

/// What [`HomogeneityAccumulator::audit`](crate::HomogeneityAccumulator::audit) found about whether
/// the law of an ensemble is invariant under rotations, as the variance formula demands.
///
/// The null distribution is made of the ensemble itself: under invariance, turning every realization
/// by a uniform rotation of its own changes no law, so the statistics of the ensemble and of its
/// turned copies are exchangeable, and `p = (1 + #{copies with T_b >= T})/(1 + copies)` is valid for
/// any number of points and realizations and any law of the coefficients (Lehmann and Romano 2005,
/// theorem 15.2.1). The scores within a family are judged by the largest (Westfall and Young 1993),
/// the families by Holm's method. Only degrees up to lmax are looked at, and only these statistics.
#[derive(Clone, Debug, PartialEq)]
pub struct HomogeneityAudit {
    /// Where the points live.
    pub domain: Domain,
    /// The largest degree.
    pub lmax: usize,
    /// The number of realizations.
    pub realizations: usize,
    /// Degrees that were left out, as they have no power in any realization.
    pub vanishing: Vec<usize>,
    /// One result for each family that could be tested.
    pub findings: Vec<Finding>,
    /// `P(l, m)/P(l)` of every (l, m) that was tested.
    pub ratios: Vec<OrderRatio>,
    /// The largest bias.
    pub bias: Option<MeanBias>,
    /// The relative error of the variance of any `Y_lm` that would have been seen in 9 of 10 audits;
    /// infinite if nothing was tested.
    pub detectable: f64,
    /// What follows.
    pub verdict: AuditVerdict,
}

impl HomogeneityAudit {
    /// The largest `P(l, m)/P(l)`, the worst factor of a mean squared error.
    #[must_use]
    pub fn worst_ratio(&self) -> Option<OrderRatio> {
        self.ratios.iter().copied().max_by(|a, b| a.ratio.total_cmp(&b.ratio))
    }

    /// The result of a family, if it was tested.
    #[must_use]
    pub fn finding(&self, family: AuditFamily) -> Option<&Finding> {
        self.findings.iter().find(|f| f.family == family)
    }
}
