use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

use crate::Image;

/// The outcome of testing all pixels together for a bias.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureBias {
    /// The largest |t| of a pixel, which is its mean error in standard errors.
    pub largest: f64,
    /// The limit that |t| does not exceed in any pixel with probability 99 % without bias: the
    /// quantile of Student's t with one degree of freedom less than there are renders, or of a
    /// normal distribution if all renders are equal and only the reference is random; with Sidak's
    /// correction for the number of pixels.
    pub limit: f64,
    /// The number of pixels beyond the limit.
    pub beyond: usize,
}

impl PictureBias {
    /// The probability of a false alarm without bias, for normal errors.
    pub const ALPHA: f64 = 0.01;

    /// Tests the pixels with these numbers. `moments(k)` returns the mean and variance of the
    /// errors of the k-th pixel over `renders` renders with `n_points` directions, and
    /// `contribution(k)` N times the size of those directions that contribute. Returns `None` without
    /// pixels or with fewer than two renders.
    pub(crate) fn new(
        reference: &Image,
        pixels: &[usize],
        renders: usize,
        n_points: usize,
        moments: impl Fn(usize) -> (f64, f64),
        contribution: impl Fn(usize) -> f64,
    ) -> Option<Self> {
        let count = renders as f64;
        let student = StudentsT::new(0.0, 1.0, count - 1.0).ok()?;
        if pixels.is_empty() {
            return None;
        }
        let is_random = (0..pixels.len()).any(|k| moments(k).1 > 0.0);
        // 1 - (1 - alpha)^(1/k) without the rounding of numbers near 1.
        let single = -((-Self::ALPHA).ln_1p() / pixels.len() as f64).exp_m1();
        let quantile =
            |p| if is_random { student.inverse_cdf(p) } else { Normal::standard().inverse_cdf(p) };
        let limit = -quantile(0.5 * single);
        let scores = pixels.iter().enumerate().map(|(k, &i)| {
            let (mean, variance) = moments(k);
            // The reference is jittered, so its variance is at most that of independent directions.
            let of_reference = reference.sampled_spread(i) / reference.n_points as f64;
            // If all renders agree by chance, their scatter is not informative. The share of a
            // single direction, of the size of those that contribute, cannot be resolved.
            let value = reference.values[i];
            let resolution = if is_random && value > 0.0 {
                contribution(k) / (count * n_points as f64)
            } else {
                0.0
            };
            let squared_error = variance / count + of_reference + resolution * resolution;
            if mean == 0.0 { 0.0 } else { mean.abs() / squared_error.sqrt() }
        });
        let mut test = Self { largest: 0.0, limit, beyond: 0 };
        for t in scores {
            test.largest = test.largest.max(t);
            test.beyond += usize::from(t > limit);
        }
        Some(test)
    }

    /// Returns whether any pixel has a bias.
    #[must_use]
    pub fn is_biased(&self) -> bool {
        self.beyond > 0
    }
}
