use sphvar_sh::Domain;

use super::product_rule::{ProductRule, RuleSums};
use crate::{Energy, Error, Integrand};

/// The numbers of rings of the first two rules; each further one is twice the last but one.
const FIRST: [usize; 2] = [32, 45];
/// The values of the first three rules.
pub(crate) const FIRST_NODES: usize = ProductRule::n_nodes(FIRST[0])
    + ProductRule::n_nodes(FIRST[1])
    + 4 * ProductRule::n_nodes(FIRST[0]);

/// Integral and energies of a function from rules of growing degree, with their errors.
#[derive(Clone, Debug)]
pub(crate) struct Estimate {
    /// The energies that the last rule gives, to the degree for which it is exact.
    pub(crate) per_degree: Vec<f64>,
    pub(crate) n_evaluations: usize,
    /// The sum of the errors of all energies and totals relative to the total without the mean; 0 within
    /// rounding.
    pub(crate) relative_error: f64,
    /// `int f` over the domain and its error.
    pub(crate) integral: (f64, f64),
    /// To half the degree of the last rule.
    pub(crate) energy: Energy,
    pub(crate) kurtosis: Option<f64>,
    /// The largest absolute value.
    largest: f64,
}

/// Returns the estimate at which the relative error is at most `relative` after at least
/// `min_nodes` values, or the last one within `max_nodes`, at least [`FIRST_NODES`].
///
/// The error of every result, and of every sum of energies, is the larger of its differences to the
/// two rules before. Where the
/// errors of rules are independent and fall as the power p of the degree, the difference to the
/// rule of half the degree has the standard deviation `sqrt(1 + 4^p)` of the last error.
pub(crate) fn doubled(
    function: &dyn Integrand,
    domain: Domain,
    relative: f64,
    [min_nodes, max_nodes]: [usize; 2],
) -> Result<Estimate, Error> {
    let sums = |n_rings: usize| ProductRule::new(domain, n_rings)?.sums(function);
    let mut coarse = (FIRST[0], sums(FIRST[0])?);
    let mut middle = (FIRST[1], sums(FIRST[1])?);
    let mut n_evaluations = ProductRule::n_nodes(FIRST[0]) + ProductRule::n_nodes(FIRST[1]);
    loop {
        let n_rings = 2 * coarse.0;
        let fine = sums(n_rings)?;
        n_evaluations += ProductRule::n_nodes(n_rings);
        let next = n_evaluations.saturating_add(ProductRule::n_nodes(2 * middle.0));
        let estimate = Estimate::new(domain, n_evaluations, [&coarse.1, &middle.1, &fine]);
        let is_enough = estimate.relative_error <= relative
            && n_evaluations >= min_nodes
            && !estimate.is_lost();
        // Finer rules find larger values, not smaller ones.
        let overflows = !estimate.energy.total().is_finite();
        if is_enough || overflows || next > max_nodes {
            estimate.check_magnitude()?;
            return Ok(estimate);
        }
        (coarse, middle) = (middle, (n_rings, fine));
    }
}

impl Estimate {
    fn new(domain: Domain, n_evaluations: usize, [coarse, middle, fine]: [&RuleSums; 3]) -> Self {
        let n_known = coarse.per_degree.len();
        let energy =
            |s: &RuleSums| Energy::new(domain, s.per_degree[..n_known].to_vec(), s.centred);
        let energy = energy(fine).with_estimates(&[energy(middle), energy(coarse)]);
        let per_degree = energy.per_band_stderr().unwrap_or_default();
        let error = per_degree.iter().skip(1).sum::<f64>() + energy.centred_stderr().sum();
        let integral_error =
            (fine.integral - middle.integral).abs().max((fine.integral - coarse.integral).abs());
        let total = fine.centred.sum();
        let relative_error = if error <= rounding(&energy) { 0.0 } else { error / total };
        Self {
            per_degree: fine.per_degree.clone(),
            n_evaluations,
            relative_error,
            integral: (fine.integral, integral_error),
            energy,
            kurtosis: fine.kurtosis,
            largest: fine.largest,
        }
    }

    /// Returns whether squares of the values underflowed.
    fn is_lost(&self) -> bool {
        self.largest > 0.0 && self.energy.total() <= 0.0
    }

    /// Checks that squares of the values neither overflowed nor underflowed.
    fn check_magnitude(&self) -> Result<(), Error> {
        if self.is_lost() || !self.energy.total().is_finite() {
            return Err(Error::Magnitude { got: self.largest });
        }
        self.energy.check_magnitude()
    }

    /// Returns the degree beyond which a function that the rules resolve has no energy above
    /// rounding.
    pub(crate) fn effective_degree(&self) -> usize {
        /// The square of the relative rounding of coefficients and of values at high degrees.
        const OF_TRANSFORM: f64 = 1e-26;
        let of_values = (2.0 * f64::EPSILON).powi(2) * self.energy.total();
        let negligible = of_values.max(OF_TRANSFORM * self.energy.centred().sum());
        let mut beyond = 0.0;
        let is_beyond = |e: &&f64| {
            beyond += **e;
            beyond <= negligible
        };
        let n_beyond = self.per_degree.iter().rev().take_while(is_beyond).count();
        self.per_degree.len().saturating_sub(n_beyond + 1)
    }
}

/// Returns the error of all energies that rounding of the values alone produces: each value is
/// rounded by some units of its size, with the mean.
fn rounding(energy: &Energy) -> f64 {
    let value = 16.0 * f64::EPSILON * energy.total().sqrt();
    value * (energy.centred().sum().sqrt() + value)
}
