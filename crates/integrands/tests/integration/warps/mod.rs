//! Named warps and expressions of them.

mod grammar;
mod maps;
mod proposed;

use sphvar_integrands::grammar::ResolveError;
use sphvar_integrands::{
    EnvironmentMap, EnvironmentParameters, Error, IntegrandResolver, Projection, Strategy,
};

/// A resolver with one picture, whatever the file, of positive values with a bright texel.
struct Sky;

impl IntegrandResolver for Sky {
    fn environment(&self, wanted: &EnvironmentParameters) -> Result<EnvironmentMap, ResolveError> {
        let (width, height) = match wanted.picture.projection {
            Projection::Octahedral => (9, 9),
            _ => (18, 9),
        };
        let mut texels: Vec<f64> =
            (0..width * height).map(|k| 1.5 + (1.7 * k as f64).sin()).collect();
        texels[2 * width + 5] = 40.0;
        EnvironmentMap::from_picture(width, height, texels, wanted.picture.layout())
            .map_err(ResolveError::new)
    }
}

/// A resolver with one picture of 4 x 2 texels, whatever the file.
struct Picture(Vec<f64>);

impl IntegrandResolver for Picture {
    fn environment(&self, wanted: &EnvironmentParameters) -> Result<EnvironmentMap, ResolveError> {
        let [width, height] = match wanted.picture.projection {
            Projection::Octahedral => [2, 2],
            _ => [4, 2],
        };
        let texels = self.0[..width * height].to_vec();
        EnvironmentMap::from_picture(width, height, texels, wanted.picture.layout())
            .map_err(ResolveError::new)
    }
}

/// Returns the only error of an expression's warps.
fn message(result: Result<Vec<Strategy>, Error>) -> String {
    result.map(drop).unwrap_err().to_string()
}
