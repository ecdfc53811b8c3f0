//! The common closed form of the tables of Chapter 6: a power of `l` summed against a profile over
//! a run of degrees.

use crate::power_sum::power_sum;
use crate::zeta::{hurwitz_zeta, riemann_zeta, riemann_zeta_regular};
use crate::{Domain, Profile};

/// Below this argument the zeta term of the large-N form is left out.
const ZETA_NEGLIGIBLE: f64 = -150.0;

/// The energy `coefficient * l^-decay` on the degrees `first..=last`; `last` may be infinite if
/// `decay > 1`.
///
/// Degrees are integers stored as `f64`, so that a break beyond the range of the integers needs no
/// special case.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DegreeRun {
    pub(crate) coefficient: f64,
    pub(crate) decay: f64,
    pub(crate) first: f64,
    pub(crate) last: f64,
}

impl DegreeRun {
    /// Returns the run in the index `j` of `l = j * step`, over the degrees that exist in the
    /// domain.
    ///
    /// With `l = 2j` the rise `(l/L)^b` is `(j/(L/2))^b`, so the hemisphere's sum is the sphere's
    /// with half the break.
    fn in_domain(self, domain: Domain) -> Self {
        let step = domain.degree_step() as f64;
        Self {
            coefficient: self.coefficient * step.powf(-self.decay),
            decay: self.decay,
            first: (self.first / step).ceil(),
            last: (self.last / step).floor(),
        }
    }

    /// Returns `sum E(l) P(l)` over the degrees of this run that exist in the domain.
    pub(crate) fn sum(self, profile: &Profile, n_points: usize, domain: Domain) -> f64 {
        let run = self.in_domain(domain);
        let break_index = profile.break_degree(n_points) / domain.degree_step() as f64;
        let flat = run.flat_sum(run.first, run.last);
        // Zero times an infinite sum must be zero, so absent parts are left out.
        let mut total = 0.0;
        if profile.offset() > 0.0 {
            total += profile.offset() * flat;
        }
        if profile.gamma() > 0.0 {
            total += profile.gamma() * run.risen_sum(profile.exponent(), break_index);
        }
        run.coefficient * total
    }

    /// Returns the sum of `l^-decay` over a range, zero if it is empty.
    fn flat_sum(self, first: f64, last: f64) -> f64 {
        if first > last {
            0.0
        } else if last.is_infinite() {
            hurwitz_zeta(self.decay, first)
        } else {
            let sum = power_sum(first, last, self.decay);
            sum.reference.powf(-self.decay) * sum.scaled
        }
    }

    /// Returns the sum of `l^-decay min(1, (l/L)^b)`; `b` may be infinite.
    fn risen_sum(self, b: f64, break_index: f64) -> f64 {
        if b == 0.0 {
            return self.flat_sum(self.first, self.last);
        }
        // The last degree with l < L. At l = L both branches give 1; it is counted once, in the
        // plateau.
        let split = break_index.ceil() - 1.0;
        let plateau = self.flat_sum(self.first.max(split + 1.0), self.last);
        self.head_sum(b, break_index, self.last.min(split)) + plateau
    }

    /// Returns the sum of `l^-decay (l/L)^b` from the first degree to `last`.
    fn head_sum(self, b: f64, break_index: f64, last: f64) -> f64 {
        if self.first > last || b.is_infinite() || break_index.is_infinite() {
            return 0.0;
        }
        let sum = power_sum(self.first, last, self.decay - b);
        sum.reference.powf(-self.decay) * (sum.reference / break_index).powf(b) * sum.scaled
    }

    /// Returns the large-N form of [`DegreeRun::sum`] and the size of its first neglected term;
    /// `None` where the form is not yet valid.
    pub(crate) fn asymptotic(
        self,
        profile: &Profile,
        n_points: usize,
        domain: Domain,
    ) -> Option<(f64, f64)> {
        let run = self.in_domain(domain);
        let break_index = profile.break_degree(n_points) / domain.degree_step() as f64;
        if run.first > run.last {
            return Some((0.0, 0.0));
        }
        let (risen, error) = run.risen_asymptotic(profile.exponent(), break_index)?;
        let flat = run.flat_sum(run.first, run.last);
        let value = profile.offset() * flat + profile.gamma() * risen;
        Some((run.coefficient * value, run.coefficient * profile.gamma() * error))
    }

    fn risen_asymptotic(self, b: f64, break_index: f64) -> Option<(f64, f64)> {
        if b == 0.0 {
            return Some((self.flat_sum(self.first, self.last), 0.0));
        }
        if break_index.is_infinite() {
            return None;
        }
        if self.last.is_finite() {
            // Band-limited: exact as soon as the whole band lies below the break.
            return (self.last < break_index)
                .then(|| (self.head_sum(b, break_index, self.last), 0.0));
        }
        let p = self.decay;
        let log = break_index.ln();
        if b.is_infinite() {
            // Euler-Maclaurin at ceil(L): the neglected term is -B_1(ceil(L) - L) L^-p, at most
            // half of L^-p.
            let value = break_index.powf(1.0 - p) / (p - 1.0);
            return (break_index >= self.first.max(p)).then(|| (value, 0.5 * break_index.powf(-p)));
        }
        // b / 12 L^{-p-1} bounds the kink's term b B_2 / 2 L^{-p-1}; the next one is smaller by
        // about 0.1 |2p+1-b| / L.
        if break_index < self.first.max(p + b) {
            return None;
        }
        let epsilon = p - 1.0 - b;
        let growth = epsilon * log;
        let whole = if growth > 1.0 {
            // Here the two terms do not cancel, and L^epsilon may overflow.
            riemann_zeta(p - b) * break_index.powf(-b)
                - b / ((p - 1.0) * epsilon) * break_index.powf(1.0 - p)
        } else {
            let logarithmic = if growth == 0.0 { log } else { log * (growth.exp_m1() / growth) };
            // zeta(p-b) ~ Gamma(b) / (2 pi)^b: for large b and L >= b its term is far below an ulp.
            let zeta_regular = if p - b < ZETA_NEGLIGIBLE {
                -epsilon.recip()
            } else {
                riemann_zeta_regular(p - b)
            };
            break_index.powf(1.0 - p)
                * (zeta_regular * growth.exp() + logarithmic + (p - 1.0).recip())
        };
        let before = Self { first: 1.0, ..self }.head_sum(b, break_index, self.first - 1.0);
        Some((whole - before, b / 12.0 * break_index.powf(-p - 1.0)))
    }
}
