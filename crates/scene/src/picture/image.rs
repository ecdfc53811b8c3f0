/// The result of a render, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Image {
    /// Number of columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// The estimates, means over the primary rays of a pixel that meet a surface; 0 where none does.
    pub values: Vec<f64>,
    /// N times the variance that N independent uniform directions would have: the variance of the integrand over
    /// the hemisphere, as these directions estimate it; for several primary rays that meet a surface, over the square of
    /// their number. Of ambient occlusion `p (1 - p)`.
    pub spreads: Vec<f64>,
    /// The share of a pixel's primary rays that meet a surface.
    pub coverage: Vec<f64>,
    /// Directions of a hit point; of halves of sphere sets the expected number.
    pub n_points: usize,
    /// Occlusion rays that were traced.
    pub rays: u64,
}

impl Image {
    /// Number of pixels in which a surface is seen.
    #[must_use]
    pub fn n_hits(&self) -> usize {
        self.coverage.iter().filter(|&&c| c > 0.0).count()
    }

    /// The area in which a surface is seen, in pixels: the sum of [`Self::coverage`].
    #[must_use]
    pub fn covered_area(&self) -> f64 {
        self.coverage.iter().sum()
    }

    /// The mean over the area in which a surface is seen: pixels count as they are covered. NaN if there is none.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.weighted_mean(&self.values)
    }

    fn weighted_mean(&self, of_pixels: &[f64]) -> f64 {
        let products = of_pixels.iter().zip(&self.coverage).map(|(x, c)| x * c);
        products.sum::<f64>() / self.covered_area()
    }

    /// The exact mean squared error of `n_points` independent uniform directions, as far as this image is exact:
    /// `1/N` times the mean of [`Self::spreads`] over the area in which a surface is seen; NaN if there is none.
    #[must_use]
    pub fn white_noise_variance(&self, n_points: usize) -> f64 {
        self.weighted_mean(&self.spreads) / n_points as f64
    }
}
