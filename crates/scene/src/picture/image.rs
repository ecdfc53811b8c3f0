/// The result of a render, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Image {
    /// The number of columns.
    pub width: usize,
    /// The number of rows.
    pub height: usize,
    /// The estimates, averaged over the primary rays of a pixel that meet a surface; 0 if none
    /// does.
    pub values: Vec<f64>,
    /// N times the variance for N independent uniform directions: the variance of the integrand
    /// over the hemisphere, estimated from these directions. If several primary rays meet a
    /// surface, it is divided by the square of their number. For ambient occlusion it is
    /// `p (1 - p)`.
    pub spreads: Vec<f64>,
    /// The fraction of a pixel's primary rays that meet a surface.
    pub coverage: Vec<f64>,
    /// The number of directions at a hit point; for halves of sphere sets, the expected number.
    pub n_points: usize,
    /// The number of occlusion rays traced.
    pub rays: u64,
    /// N times the variance for N independent directions of the density from which this picture was
    /// sampled, estimated from these directions; empty for uniform directions, for which it is
    /// [`Self::spreads`].
    pub sampled_spreads: Vec<f64>,
}

impl Image {
    /// Returns the number of pixels that show a surface.
    #[must_use]
    pub fn n_hits(&self) -> usize {
        self.coverage.iter().filter(|&&c| c > 0.0).count()
    }

    /// Returns the area that shows a surface, in pixels: the sum of [`Self::coverage`].
    #[must_use]
    pub fn covered_area(&self) -> f64 {
        self.coverage.iter().sum()
    }

    /// Returns the mean over the area that shows a surface; pixels are weighted by their coverage.
    /// NaN if there is none.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.weighted_mean(&self.values)
    }

    /// Returns N times the variance of a pixel for N independent directions of the sampled density.
    pub(crate) fn sampled_spread(&self, pixel: usize) -> f64 {
        self.sampled_spreads.get(pixel).copied().unwrap_or(self.spreads[pixel])
    }

    fn weighted_mean(&self, of_pixels: &[f64]) -> f64 {
        let products = of_pixels.iter().zip(&self.coverage).map(|(x, c)| x * c);
        products.sum::<f64>() / self.covered_area()
    }

    /// Returns the mean squared error of `n_points` independent uniform directions, exact if this
    /// image is exact: `1/N` times the mean of [`Self::spreads`] over the area that shows a
    /// surface; NaN if there is none.
    #[must_use]
    pub fn white_noise_variance(&self, n_points: usize) -> f64 {
        self.weighted_mean(&self.spreads) / n_points as f64
    }
}
