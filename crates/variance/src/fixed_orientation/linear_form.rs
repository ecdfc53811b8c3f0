use std::f64::consts::PI;
use std::sync::Arc;

use sphvar_sh::{Alm, Domain};
use sphvar_spectrum::{Accumulator, Moments, Realization};

/// Accumulates the error of the estimate of each realization as a linear form in its coefficients,
///
/// ```text
/// I_N - I = (area/sum w) sum_{l >= 1, m} S_lm conj F_lm,   sum w = sqrt(4 pi) S_00
/// ```
///
/// and the sum of the squares of its terms. The variance of the form includes the covariances of
/// all coefficients, for which no matrix is needed.
#[derive(Clone, Debug)]
pub(super) struct LinearFormAccumulator {
    coefficients: Arc<Alm>,
    area: f64,
    values: Vec<(u64, f64)>,
    diagonal: Moments,
}

/// The sums of all realizations.
#[derive(Debug)]
pub(super) struct LinearForm {
    values: Vec<(u64, f64)>,
    /// The sum of squared terms, `(area/sum w)^2 sum_lm |S_lm|^2 |F_lm|^2`.
    pub(super) diagonal: Moments,
}

impl LinearFormAccumulator {
    /// Returns an empty accumulator for a function with these coefficients; on the hemisphere those
    /// of its even extension.
    pub(super) fn new(coefficients: Alm, domain: Domain) -> Self {
        Self {
            coefficients: Arc::new(coefficients),
            area: domain.area(),
            values: Vec::new(),
            diagonal: Moments::default(),
        }
    }

    pub(super) fn finish(mut self) -> LinearForm {
        self.values.sort_by_key(|value| value.0);
        LinearForm { values: self.values, diagonal: self.diagonal }
    }
}

impl LinearForm {
    /// Returns the errors of the estimates in the order of the realizations.
    pub(super) fn values(&self) -> Vec<f64> {
        self.values.iter().map(|value| value.1).collect()
    }
}

impl Accumulator for LinearFormAccumulator {
    fn push(&mut self, realization: &Realization<'_>) {
        let pattern = realization.alm();
        let function = &*self.coefficients;
        let factor = self.area / ((4.0 * PI).sqrt() * pattern[(0, 0)].re);
        let (mut form, mut squares) = (0.0, 0.0);
        for m in 0..=pattern.lmax().min(function.lmax()) {
            // Orders m and -m have conjugate products.
            let copies = if m == 0 { 1.0 } else { 2.0 };
            // Degree 0 is the integral itself.
            let first = usize::from(m == 0);
            let pairs = pattern.column(m).iter().zip(function.column(m)).skip(first);
            for (s, f) in pairs {
                form += copies * (s * f.conj()).re;
                squares += copies * s.norm_sqr() * f.norm_sqr();
            }
        }
        self.values.push((realization.index(), factor * form));
        self.diagonal.push(factor * factor * squares);
    }

    fn merge(&mut self, other: &Self) {
        self.values.extend_from_slice(&other.values);
        self.diagonal.merge(&other.diagonal);
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use sphvar_integrands::{Harmonic, Integrand, Sum};
    use sphvar_samplers::{Domain, Pattern, PointSet, PointSets, Purpose, Realizations, Streams};
    use sphvar_spectrum::{OrderAccumulator, Resolution, accumulate};

    use super::LinearFormAccumulator;

    const LMAX: usize = 7;

    /// A function with several degrees and orders.
    fn function() -> Sum {
        let terms = [(0, 0, 2.0), (2, 0, 0.5), (2, -1, 1.0), (4, 3, -0.7), (6, 6, 0.3)];
        terms.into_iter().fold(Sum::default(), |sum, (l, m, weight)| {
            sum.plus(weight, Harmonic::new(l, m).unwrap()).unwrap()
        })
    }

    /// Slow definition: the estimate from values. The degrees are even, so that the function is the
    /// even extension of its values on the hemisphere.
    #[test]
    fn linear_forms_are_errors_of_estimates() {
        let points = vec![DVec3::Z, DVec3::X, DVec3::new(0.6, 0.0, 0.8), DVec3::Z];
        let weights = vec![1e200, -3e199, 5e200, 1e190];
        let weighted = PointSet { points: points.clone(), weights };
        let f = function();
        for domain in [Domain::Sphere, Domain::Hemisphere] {
            let sets = [PointSet::new(points.clone()), weighted.clone()];
            let sets = PointSets::new(sets.to_vec(), domain).unwrap();
            let coefficients = f.coefficients(domain, LMAX).unwrap().to_alm().unwrap();
            let empty = LinearFormAccumulator::new(coefficients, domain);
            let sums = accumulate(&sets, Resolution::new(LMAX, 4), 0..2, &empty, &()).unwrap();
            for (set, got) in sets.sets().iter().zip(sums.finish().values()) {
                let values: Vec<f64> = set.points.iter().map(|p| f.eval(*p)).collect();
                let exact = f.exact(domain).unwrap();
                let expected = domain.area() * set.mean(&values) - exact;
                assert!((got - expected).abs() < 1e-12, "{domain}: {got}, {expected}");
            }
        }
    }

    /// Slow definition: the mean power of every order.
    #[test]
    fn diagonals_are_sums_over_orders() {
        let f = function();
        let jittered = Pattern::Jittered.build(48, Domain::Sphere).unwrap();
        let sets = Realizations::unrotated(&*jittered, Streams::new(0, Purpose::Pattern, 0));
        let coefficients = f.coefficients(Domain::Sphere, LMAX).unwrap().to_alm().unwrap();
        let form = LinearFormAccumulator::new(coefficients.clone(), Domain::Sphere);
        let empty = (form, OrderAccumulator::new(LMAX).unwrap());
        let sums = accumulate(&sets, Resolution::new(LMAX, 48), 0..30, &empty, &()).unwrap();
        let mut expected = 0.0;
        for order in sums.1.finish().into_iter().filter(|order| order.l > 0) {
            let copies = if order.m == 0 { 1.0 } else { 2.0 };
            expected += copies * order.power * coefficients[(order.l, order.m)].norm_sqr();
        }
        expected *= 4.0 * std::f64::consts::PI / 48.0;
        let got = sums.0.finish().diagonal.mean();
        assert!((got / expected - 1.0).abs() < 1e-12, "{got}, {expected}");
    }
}
