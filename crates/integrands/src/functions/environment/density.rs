use sphvar_warps::DensityMap;

use super::EnvironmentMap;
use crate::{Error, Interpolation};

impl EnvironmentMap {
    /// Returns the density proportional to the map with bilinear interpolation, to rounding
    /// everywhere; or to its texels, which jumps between them.
    ///
    /// Negative texels, which filters leave next to bright ones, have the density of their
    /// magnitudes: the variance is smallest with a density proportional to |f|, and it is positive
    /// where the map is not 0.
    ///
    /// # Errors
    ///
    /// [`Error::Warp`] if all texels are 0 or memory is exhausted.
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_integrands::{Domain, EnvironmentMap, Integrand, Interpolation};
    /// use sphvar_warps::Warp;
    ///
    /// let map = EnvironmentMap::new(4, 2, vec![1.0, 2.0, 3.0, 4.0, 0.0, 5.0, 9.0, 5.0])?;
    /// let integral = map.exact(Domain::Sphere).unwrap();
    /// let density = map.clone().into_density(Interpolation::Bilinear)?;
    /// let sample = density.sample([0.3, 0.9]);
    /// assert!((map.eval(sample.point) / sample.density - integral).abs() < 1e-13 * integral);
    /// # Ok::<(), sphvar_integrands::Error>(())
    /// ```
    pub fn into_density(mut self, interpolation: Interpolation) -> Result<DensityMap, Error> {
        self.texels.iter_mut().for_each(|texel| *texel = texel.abs());
        let interpolation = match interpolation {
            Interpolation::Bilinear => sphvar_warps::Interpolation::Bilinear,
            Interpolation::Constant => sphvar_warps::Interpolation::Constant,
        };
        let map = DensityMap::new(self.width, self.height, self.texels, interpolation)?;
        Ok(map.with_first_longitude(self.first_longitude))
    }
}
