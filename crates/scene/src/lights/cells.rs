use glam::DVec3;
use sphvar_samplers::Tessellation;

use super::DirectionalLight;
use super::environment::RgbEnvironment;

impl RgbEnvironment {
    /// Returns a light for each cell of a tessellation whose mass points have the density of
    /// [`luminance_warp`](Self::luminance_warp): all light of the cell, from the direction of its
    /// site.
    ///
    /// The integral over a cell is the mean over its mass points of radiance divided by density,
    /// times the mass of a cell, 1/N. So all lights have the same luminance, and sites are at the
    /// means of the luminance of their cells.
    ///
    /// # Examples
    ///
    /// ```
    /// use glam::DQuat;
    /// use sphvar_integrands::EnvironmentMap;
    /// use sphvar_samplers::{AdaptedCcvt, Purpose, Streams};
    /// use sphvar_scene::{RgbEnvironment, luminance};
    ///
    /// let map = EnvironmentMap::new(4, 2, vec![1.0, 2.0, 9.0, 3.0, 1.0, 0.0, 2.0, 1.0])?;
    /// let environment = RgbEnvironment::new([map.clone(), map.clone(), map], DQuat::IDENTITY)?;
    /// let ccvt = AdaptedCcvt::new(16, 64, environment.luminance_warp())?;
    /// let mut rng = Streams::new(0, Purpose::Pattern, 16).realization(0);
    /// let lights = environment.cell_lights(&ccvt.tessellate(&mut rng, &())?);
    /// let [first, second] = [0, 1].map(|k| luminance(lights[k].irradiance));
    /// assert!((first / second - 1.0).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn cell_lights(&self, tessellation: &Tessellation) -> Vec<DirectionalLight> {
        let sites = tessellation.sites();
        let (n, warp) = (sites.len() as f64, self.luminance_warp());
        let light = |(k, direction): (usize, DVec3)| {
            let cell = tessellation.cell(k);
            let share = 1.0 / (n * cell.len() as f64);
            let irradiance = cell.fold([0.0; 3], |sum, mass_point| {
                // Rounding may move a mass point across the edge of the support.
                let density = warp.density(mass_point);
                let solid_angle = if density > 0.0 { share / density } else { 0.0 };
                let radiance = self.radiance(mass_point);
                [0, 1, 2].map(|c| sum[c] + radiance[c] * solid_angle)
            });
            DirectionalLight { direction, irradiance }
        };
        sites.into_iter().enumerate().map(light).collect()
    }
}
