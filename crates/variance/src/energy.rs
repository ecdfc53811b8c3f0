use sphvar_samplers::Domain;

/// The energy of a function per degree, `E(l) = sum_m |F_lm|^2`, and its total `int F^2`.
///
/// `P_F(l) = E(l)/(2l+1)`. For an integrand on the hemisphere F is the even extension to the
/// sphere, so odd degrees are 0 and the total is twice the hemisphere's `int f^2`.
#[derive(Clone, Debug, PartialEq)]
pub struct Energy {
    domain: Domain,
    per_degree: Vec<f64>,
    total: f64,
    kurtosis: Option<f64>,
}

impl Energy {
    /// From E(l), l = 0 ..= lmax (at least l = 0), and the total over all degrees.
    ///
    /// # Panics
    ///
    /// If `per_degree` is empty.
    #[must_use]
    pub fn new(domain: Domain, per_degree: Vec<f64>, total: f64) -> Self {
        assert!(!per_degree.is_empty(), "the energy of degree 0 is always there");
        Self { domain, per_degree, total, kurtosis: None }
    }

    /// With the kurtosis of the integrand's values ([`Integrand::kurtosis`](crate::Integrand::kurtosis)), by
    /// which measured variances are judged.
    #[must_use]
    pub fn with_kurtosis(self, kurtosis: Option<f64>) -> Self {
        Self { kurtosis, ..self }
    }

    /// The kurtosis of the integrand's values, if it has been stated.
    #[must_use]
    pub fn kurtosis(&self) -> Option<f64> {
        self.kurtosis
    }

    /// The domain of the integrand.
    #[must_use]
    pub fn domain(&self) -> Domain {
        self.domain
    }

    /// E(l), index l from 0.
    #[must_use]
    pub fn per_degree(&self) -> &[f64] {
        &self.per_degree
    }

    /// The largest degree given, inclusive.
    #[must_use]
    pub fn lmax(&self) -> usize {
        self.per_degree.len() - 1
    }

    /// `int F^2`, the energy of all degrees.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.total
    }

    /// The energy beyond degree `lmax` (or beyond what is given, if that is less), never negative.
    ///
    /// The difference of two nearly equal numbers: what is within the rounding of the sum is
    /// taken for the 0 that it may be.
    #[must_use]
    pub fn beyond(&self, lmax: usize) -> f64 {
        let known = &self.per_degree[..self.per_degree.len().min(lmax.saturating_add(1))];
        let tail = self.total - known.iter().sum::<f64>();
        // Each coefficient of the sum and the sum itself round by some EPSILON of the total.
        let rounding = 4.0 * f64::EPSILON * self.total * (known.len() as f64).sqrt();
        if tail > rounding { tail } else { 0.0 }
    }
}
