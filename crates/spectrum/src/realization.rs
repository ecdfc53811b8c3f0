use std::cell::OnceCell;
use std::f64::consts::PI;

use sphvar_samplers::PointSet;
use sphvar_sh::{Alm, ByParity};

use crate::{ExactSum, tail_power};

/// One realization of an ensemble and its coefficients, the input of accumulators.
#[derive(Debug)]
pub struct Realization<'a> {
    index: u64,
    set: &'a PointSet,
    alm: &'a Alm,
    normalization: f64,
    tail: OnceCell<ByParity>,
}

impl<'a> Realization<'a> {
    /// Returns the realization for coefficients computed with the weights of `set`.
    pub(crate) fn new(index: u64, set: &'a PointSet, alm: &'a Alm) -> Self {
        let squares =
            if set.weights.is_empty() { set.len() as f64 } else { sum_of_squares(&set.weights) };
        let normalization = if squares > 0.0 { 4.0 * PI / squares } else { 0.0 };
        Self { index, set, alm, normalization, tail: OnceCell::new() }
    }

    /// Returns the index in the ensemble.
    #[must_use]
    pub fn index(&self) -> u64 {
        self.index
    }

    /// Returns the points, with weights of the scale of [`alm`](Self::alm).
    #[must_use]
    pub fn set(&self) -> &PointSet {
        self.set
    }

    /// Returns `S_lm = sum_k w_k conj Y_lm(s_k)`. The weights are scaled by a power of two such
    /// that the largest is in [1/2, 1); equal weights are 1.
    #[must_use]
    pub fn alm(&self) -> &Alm {
        self.alm
    }

    /// Returns [`PointSet::n_effective`] of the points: N for equal weights.
    #[must_use]
    pub fn n_effective(&self) -> f64 {
        self.set.n_effective()
    }

    /// Returns the factor that normalizes the power of white noise to 1: `4 pi / sum_k w_k^2`,
    /// which is 4 pi/N for unit weights; 0 if all weights are 0.
    #[must_use]
    pub fn normalization(&self) -> f64 {
        self.normalization
    }

    /// Returns the mean power of even and of odd degrees at high degrees, [`tail_power`] of the
    /// points.
    #[must_use]
    pub fn tail(&self) -> ByParity {
        *self.tail.get_or_init(|| tail_power(&self.set.points, &self.set.weights))
    }

    /// Returns P(l) for every degree from 0.
    pub fn power(&self) -> impl Iterator<Item = f64> {
        let normalization = self.normalization;
        self.alm.power_per_degree().into_iter().map(move |p| normalization * p)
    }
}

/// Returns the exact sum of squares. In a plain sum of equal numbers, all rounding errors can have
/// the same sign.
fn sum_of_squares(weights: &[f64]) -> f64 {
    let mut sum = ExactSum::default();
    for w in weights {
        sum.add(w * w);
    }
    sum.value()
}

#[cfg(test)]
mod tests {
    use rand::RngExt;
    use sphvar_samplers::{Domain, Pattern, PointSet, PointSets, Purpose, Streams};

    use super::sum_of_squares;
    use crate::{Resolution, SpectrumAccumulator, accumulate};

    /// Independent weights, whatever their signs and sizes, leave white noise at P = 1; the same
    /// weights would have a power of N sum w^2/(sum w)^2 with the other normalization. 20 degrees at
    /// 5 standard errors: a false alarm in 1e5 runs of other seeds.
    #[test]
    fn white_noise_with_independent_weights_has_power_1() {
        const N: usize = 60;
        const COUNT: u64 = 400;
        const LMAX: usize = 20;
        let white = Pattern::WhiteNoise.build(N, Domain::Sphere).unwrap();
        for is_positive in [false, true] {
            let sets = (0..COUNT).map(|k| {
                let mut rng = Streams::new(5, Purpose::Pattern, N).realization(k);
                let points = white.sample(&mut rng).unwrap().points;
                let mut weight = || {
                    let size = 10f64.powf(rng.random_range(-2.0..2.0));
                    if is_positive || rng.random_range(0.0..1.0) < 0.7 { size } else { -size }
                };
                let weights = (0..N).map(|_| weight()).collect();
                PointSet { points, weights }
            });
            let sets = PointSets::new(sets.collect(), Domain::Sphere).unwrap();
            let empty = SpectrumAccumulator::new(Domain::Sphere, N, LMAX);
            let resolution = Resolution::new(LMAX, N);
            let sums = accumulate(&sets, resolution, 0..COUNT, &empty, &()).unwrap();
            let spectrum = sums.finish().unwrap();
            for l in 1..=LMAX {
                let (power, stderr) = (spectrum.power()[l], spectrum.stderr()[l]);
                assert!((power - 1.0).abs() < 5.0 * stderr, "l = {l}: {power} +- {stderr}");
            }
            assert!(spectrum.power()[0] < 0.5 * N as f64, "{}", spectrum.power()[0]);
        }
    }

    /// A plain sum has a relative error of 1.7e-11.
    #[test]
    fn the_sum_of_many_equal_weights_is_accurate() {
        const N: usize = 1_000_000;
        let got = sum_of_squares(&[0.1; N]);
        let exact = N as f64 * (0.1 * 0.1);
        assert!((got / exact - 1.0).abs() <= 2.0 * f64::EPSILON, "{got}, not {exact}");
        let plain: f64 = [0.1; N].iter().map(|w| w * w).sum();
        assert!((plain / exact - 1.0).abs() > 1e-13, "a plain sum is accurate enough: {plain}");
    }
}
