use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Poisson-distributed numbers, by summation of probabilities.
#[derive(Clone, Copy, Debug)]
pub(super) struct PoissonCount {
    mean: f64,
    none: f64,
}

impl PoissonCount {
    /// The largest number: for means up to 4, larger numbers have probability below 1e-25.
    const MAX: u32 = 40;

    pub(super) fn new(mean: f64) -> Self {
        Self { mean, none: (-mean).exp() }
    }

    #[inline]
    pub(super) fn draw(&self, rng: &mut ChaCha8Rng) -> u32 {
        let mut left: f64 = rng.random();
        let (mut k, mut probability) = (0, self.none);
        while left >= probability && k < Self::MAX {
            left -= probability;
            k += 1;
            probability *= self.mean / f64::from(k);
        }
        k
    }
}
