/// The result of a render, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Image {
    /// Number of columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// The estimates; 0 where no primary ray of a pixel meets a surface.
    pub values: Vec<f64>,
    /// N times the variance that N independent uniform directions would have: the variance of the integrand over
    /// the hemisphere, as these directions estimate it; for several primary rays, over the square of their number. Of
    /// ambient occlusion `p (1 - p)`.
    pub spreads: Vec<f64>,
    /// Whether a primary ray of the pixel meets a surface.
    pub hits: Vec<bool>,
    /// Directions of a hit point; of halves of sphere sets the expected number.
    pub n_points: usize,
    /// Occlusion rays that were traced.
    pub rays: u64,
}

impl Image {
    /// Number of pixels in which a surface is seen.
    #[must_use]
    pub fn n_hits(&self) -> usize {
        self.hits.iter().filter(|hit| **hit).count()
    }

    /// The mean over the pixels in which a surface is seen; NaN of none.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.values.iter().sum::<f64>() / self.n_hits() as f64
    }

    /// The exact mean squared error of `n_points` independent uniform directions, as far as this image is exact:
    /// `1/N` times the mean of [`Self::spreads`] over the pixels in which a surface is seen; NaN of none.
    #[must_use]
    pub fn white_noise_variance(&self, n_points: usize) -> f64 {
        self.spreads.iter().sum::<f64>() / (self.n_hits() as f64 * n_points as f64)
    }
}
