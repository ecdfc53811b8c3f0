use std::cell::OnceCell;

use sphvar_samplers::PointSet;
use sphvar_sh::{Alm, Domain};

use crate::{ExactSum, SpectralBands};

/// One realization of an ensemble and its coefficients, the input of accumulators.
#[derive(Debug)]
pub struct Realization<'a, B: SpectralBands = Domain> {
    index: u64,
    set: &'a PointSet<B::Point>,
    coefficients: &'a B::Coefficients,
    normalization: f64,
    tail: OnceCell<B::Tail>,
}

impl<'a, B: SpectralBands> Realization<'a, B> {
    /// Returns the realization for coefficients computed with the weights of `set`.
    pub(crate) fn new(
        index: u64,
        set: &'a PointSet<B::Point>,
        coefficients: &'a B::Coefficients,
    ) -> Self {
        let squares =
            if set.weights.is_empty() { set.len() as f64 } else { sum_of_squares(&set.weights) };
        let normalization = if squares > 0.0 { B::UNIT_POWER / squares } else { 0.0 };
        Self { index, set, coefficients, normalization, tail: OnceCell::new() }
    }

    /// Returns the index in the ensemble.
    #[must_use]
    pub fn index(&self) -> u64 {
        self.index
    }

    /// Returns the points, with weights of the scale of [`coefficients`](Self::coefficients).
    #[must_use]
    pub fn set(&self) -> &PointSet<B::Point> {
        self.set
    }

    /// Returns the coefficients: on the sphere [`alm`](Realization::alm), on the square
    /// `S_k = sum_j w_j exp(-2 pi i (k1 u_j + k2 v_j))` for every band. The weights are scaled by a
    /// power of two such that the largest is in [1/2, 1); equal weights are 1.
    #[must_use]
    pub fn coefficients(&self) -> &B::Coefficients {
        self.coefficients
    }

    /// Returns [`PointSet::n_effective`] of the points: N for equal weights.
    #[must_use]
    pub fn n_effective(&self) -> f64 {
        self.set.n_effective()
    }

    /// Returns the factor that normalizes the power of white noise to 1: on the sphere
    /// `4 pi / sum_k w_k^2`, which is 4 pi/N for unit weights, on the square `1 / sum_k w_k^2`; 0
    /// if all weights are 0.
    #[must_use]
    pub fn normalization(&self) -> f64 {
        self.normalization
    }

    /// Returns the mean power at large radii by class of bands, [`SpectralBands::tail_power`] of
    /// the points.
    #[must_use]
    pub fn tail(&self) -> B::Tail {
        *self.tail.get_or_init(|| B::tail_power(self.set))
    }

    /// Returns the power of every band from 0, P(l) on the sphere.
    pub fn power(&self) -> impl Iterator<Item = f64> {
        B::powers(self.coefficients, self.normalization).into_iter()
    }
}

impl Realization<'_> {
    /// Returns `S_lm = sum_k w_k conj Y_lm(s_k)`. The weights are scaled by a power of two such
    /// that the largest is in [1/2, 1); equal weights are 1.
    #[must_use]
    pub fn alm(&self) -> &Alm {
        self.coefficients
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
    /// weights would have a power of N sum w^2/(sum w)^2 with the other normalization. 20 degrees
    /// at 5 standard errors: a false alarm in 1e5 runs of other seeds.
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
