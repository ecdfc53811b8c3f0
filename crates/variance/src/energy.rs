use sphvar_samplers::Domain;
use sphvar_sh::ByParity;

use crate::Error;

/// The energy of a function per degree, `E(l) = sum_m |F_lm|^2`, and its total over all degrees.
///
/// `P_F(l) = E(l)/(2l+1)`. For an integrand on the hemisphere F is the even extension to the
/// sphere, so odd degrees are 0 and the total is twice the hemisphere's `int f^2`.
///
/// The total is known apart for the mean (degree 0), the even degrees from 2 on and the odd degrees: a point set may have
/// another mean power at high even degrees than at high odd ones.
#[derive(Clone, Debug, PartialEq)]
pub struct Energy {
    domain: Domain,
    per_degree: Vec<f64>,
    centred: ByParity,
    kurtosis: Option<f64>,
}

impl Energy {
    /// The range of root mean squares of functions whose variances are computed with all digits: beyond it variances
    /// or their errors leave the range of numbers.
    pub const MAGNITUDES: [f64; 2] = [1e-151, 1e151];

    /// From E(l), l = 0 ..= lmax (at least l = 0), and the totals of even degrees from 2 on and of odd
    /// degrees, `int (F - mean)^2` of the even and of the odd part of F.
    ///
    /// # Panics
    ///
    /// If `per_degree` is empty.
    #[must_use]
    pub fn new(domain: Domain, per_degree: Vec<f64>, centred: ByParity) -> Self {
        assert!(!per_degree.is_empty(), "the energy of degree 0 is always there");
        Self { domain, per_degree, centred, kurtosis: None }
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
        self.per_degree[0] + self.centred.sum()
    }

    /// `int (F - mean)^2`, the energy of all even degrees from 2 on and of all odd degrees.
    #[must_use]
    pub fn centred(&self) -> ByParity {
        self.centred
    }

    /// The variance that is no more than rounding of a prediction: power and energies are squares of sums whose terms have
    /// the size of the integrand less its mean.
    pub(crate) fn prediction_rounding(&self, domain: Domain) -> f64 {
        (4.0 * f64::EPSILON).powi(2) * domain.area() * self.centred.sum()
    }

    /// The energy beyond degree `lmax` (or beyond what is given, if that is less), never negative; that of degrees from 1
    /// on for lmax = 0.
    #[must_use]
    pub fn beyond(&self, lmax: usize) -> f64 {
        self.beyond_by_parity(lmax).sum()
    }

    /// The energy beyond degree `lmax` by parity of the degree.
    ///
    /// The difference of two nearly equal numbers: what is within the rounding of the sum,
    /// `4 EPSILON sqrt(lmax + 1) int (F - mean)^2`, is taken for the 0 that it may be.
    #[must_use]
    pub fn beyond_by_parity(&self, lmax: usize) -> ByParity {
        let known = &self.per_degree[..self.per_degree.len().min(lmax.saturating_add(1))];
        let mut sums = ByParity::both(0.0);
        for (l, e) in known.iter().enumerate().skip(1) {
            *sums.of_mut(l) += e;
        }
        // Each coefficient of the sum and the sum itself round by some EPSILON of the total.
        let rounding = 4.0 * f64::EPSILON * self.centred.sum() * (known.len() as f64).sqrt();
        self.centred.zip(sums).map(|(total, sum)| {
            let tail = total - sum;
            if tail > rounding { tail } else { 0.0 }
        })
    }

    /// Checks that the function's root mean square is 0 or within [`MAGNITUDES`](Self::MAGNITUDES).
    ///
    /// # Errors
    ///
    /// [`Error::Magnitude`] if it is not.
    pub fn check_magnitude(&self) -> Result<(), Error> {
        let size = (self.total() / self.domain.area()).sqrt();
        let [least, most] = Self::MAGNITUDES;
        if size == 0.0 || (least..=most).contains(&size) {
            Ok(())
        } else {
            Err(Error::Magnitude { got: size })
        }
    }
}
