use glam::DVec3;
use sphvar_samplers::Tessellation;
use sphvar_warps::Warp;

use super::DirectionalLight;
use super::environment::RgbEnvironment;

impl RgbEnvironment {
    /// Returns a light for each cell of a tessellation whose mass points have this density: the
    /// light of the cell, from the direction of its site.
    ///
    /// The integral over a cell is the mean over its mass points of radiance divided by density,
    /// times the mass of a cell, 1/N. With the [luminance](Self::luminance_density) as the density
    /// all lights have the same luminance, and sites are at the means of the luminance of their
    /// cells.
    #[must_use]
    pub fn lights_of_cells(
        &self,
        tessellation: &Tessellation,
        density: &dyn Warp,
    ) -> Vec<DirectionalLight> {
        let sites = tessellation.sites();
        let n = sites.len() as f64;
        let light = |(k, direction): (usize, DVec3)| {
            let cell = tessellation.cell(k);
            let share = 1.0 / (n * cell.len() as f64);
            let irradiance = cell.fold([0.0; 3], |sum, mass_point| {
                // Rounding may move a mass point across the edge of the support.
                let density = density.density(mass_point);
                let solid_angle = if density > 0.0 { share / density } else { 0.0 };
                let radiance = self.radiance(mass_point);
                [0, 1, 2].map(|c| sum[c] + radiance[c] * solid_angle)
            });
            DirectionalLight { direction, irradiance }
        };
        sites.into_iter().enumerate().map(light).collect()
    }
}
