use rand::Rng;
use sphvar_warps::cosine_hemisphere;

use crate::{Error, PointSet, SquareSampler};

/// A pattern of the square mapped to cosine-weighted directions of the hemisphere by the concentric
/// map.
///
/// It is not a [`Sampler`](crate::Sampler): its directions have the density cos(theta)/pi, so
/// spectra and variances of uniform patterns do not apply. The mean of f over its directions
/// estimates `(1/pi) int f cos(theta) d omega`.
///
/// ```
/// use sphvar_samplers::{CosineHemisphere, Purpose, SobolSequence, Streams};
/// let pattern = CosineHemisphere::new(SobolSequence::new(256)?);
/// let rng = &mut Streams::new(0, Purpose::Pattern, 256).realization(0);
/// // The mean of cos(theta) is 2/3.
/// let mean = pattern.sample(rng)?.points.iter().map(|p| p.z).sum::<f64>() / 256.0;
/// assert!((mean - 2.0 / 3.0).abs() < 1e-2);
/// # Ok::<(), sphvar_samplers::Error>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct CosineHemisphere<P> {
    pattern: P,
}

impl<P: SquareSampler> CosineHemisphere<P> {
    /// Returns the directions of `pattern`.
    #[must_use]
    pub fn new(pattern: P) -> Self {
        Self { pattern }
    }

    /// Returns the number of directions of every realization.
    #[must_use]
    pub fn n_points(&self) -> usize {
        self.pattern.n_points()
    }

    /// Returns whether two realizations can differ.
    #[must_use]
    pub fn is_random(&self) -> bool {
        self.pattern.is_random()
    }

    /// Replaces the content of `set` by one realization: unit vectors with z >= 0, with the weights
    /// of the pattern.
    ///
    /// # Errors
    ///
    /// Those of [`SquareSampler::sample_into`].
    pub fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet) -> Result<(), Error> {
        let square = self.pattern.sample(rng)?;
        set.start().extend(square.points.iter().map(|&[u, v]| cosine_hemisphere(u, v)));
        set.weights.extend(square.weights);
        Ok(())
    }

    /// Returns one realization.
    ///
    /// # Errors
    ///
    /// Those of [`SquareSampler::sample_into`].
    pub fn sample(&self, rng: &mut dyn Rng) -> Result<PointSet, Error> {
        let mut set = PointSet::new(Vec::with_capacity(self.n_points()));
        self.sample_into(rng, &mut set)?;
        Ok(set)
    }
}
