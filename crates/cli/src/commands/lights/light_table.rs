use std::fmt::Write;
use std::path::Path;

use schemars::JsonSchema;
use serde::Serialize;
use sphvar_scene::DirectionalLight;

use crate::error::CliError;
use crate::files::{AtomicFile, is_stream};
use crate::message::escape;
use crate::report::{Provenance, full};

/// The frame of directions, and where the picture lies in it.
pub(super) const AXES: &str = "x, y, z: unit vector towards the light, (sin theta cos phi, sin theta sin phi, cos theta); \
    row i and column j of a latlong picture of H rows and W columns are centred at theta = 180 (i + 1/2)/H, \
    phi = 90 - 360 (j + 1/2)/W degrees, before mirror=, rotate= and up= of the environment";
/// The unit of colours.
pub(super) const COLOURS: &str = "r, g, b: irradiance of a surface that faces the light, radiance times solid angle, in the units \
    of the picture";

/// A light.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub(super) struct LightRow {
    /// The x component of the unit vector towards the light.
    x: f64,
    /// The y component.
    y: f64,
    /// The z component.
    z: f64,
    /// The irradiance of a surface that faces the light, radiance times solid angle, in red.
    r: f64,
    /// The irradiance in green.
    g: f64,
    /// The irradiance in blue.
    b: f64,
}

impl From<&DirectionalLight> for LightRow {
    fn from(light: &DirectionalLight) -> Self {
        let [x, y, z] = light.direction.to_array();
        let [r, g, b] = light.irradiance;
        Self { x, y, z, r, g, b }
    }
}

/// A format of files of lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TableFormat {
    Csv,
    Json,
    /// Arrays for a shader.
    Glsl,
}

impl TableFormat {
    /// Returns the format of the extension, after a check that the file can be written; `-` is CSV.
    pub(super) fn of_path(path: &Path) -> Result<Self, CliError> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        let format = match extension.as_deref() {
            Some("csv") => Self::Csv,
            Some("json") => Self::Json,
            Some("glsl") => Self::Glsl,
            None if is_stream(path) => Self::Csv,
            _ => {
                return Err(CliError::Usage(format!(
                    "{}: lights are written as .csv, .json or .glsl",
                    path.display()
                )));
            }
        };
        AtomicFile::check(path)?;
        Ok(format)
    }
}

/// Returns the comments at the head of files, each line after `mark`: provenance, environment and
/// conventions.
pub(super) fn comments(mark: &str, environment: &str, provenance: &Provenance) -> String {
    let environment = format!("environment: {}", escape(environment));
    let lines = [provenance.line(), environment, AXES.to_owned(), COLOURS.to_owned()];
    lines.map(|line| format!("{mark} {line}\n")).concat()
}

/// Returns lights as constants of the OpenGL Shading Language, after `comments`.
pub(super) fn glsl(lights: &[LightRow], comments: &str) -> String {
    let n = lights.len();
    let mut text = format!(
        "{comments}// E(normal) = sum over i of LIGHT_IRRADIANCES[i] * max(0.0, dot(normal, LIGHT_DIRECTIONS[i]))\n\
         const int LIGHT_COUNT = {n};\n"
    );
    let mut array = |name: &str, of: &dyn Fn(&LightRow) -> [f64; 3]| {
        let vectors: Vec<String> = lights
            .iter()
            .map(|light| format!("    vec3({})", of(light).map(full).join(", ")))
            .collect();
        // Writing to a string does not fail.
        let _ = writeln!(text, "const vec3 {name}[{n}] = vec3[{n}](\n{}\n);", vectors.join(",\n"));
    };
    array("LIGHT_DIRECTIONS", &|light| [light.x, light.y, light.z]);
    array("LIGHT_IRRADIANCES", &|light| [light.r, light.g, light.b]);
    text
}

#[cfg(test)]
mod tests {
    use super::{AXES, COLOURS, LightRow, comments, glsl};
    use crate::report::Provenance;

    #[test]
    fn tables_for_shaders_are_constants() {
        let light = LightRow { x: 0.0, y: 0.6, z: -0.8, r: 1e20, g: 0.25, b: 0.0 };
        let provenance = Provenance::of("sphvar lights".to_owned(), 3);
        let text = glsl(&[light.clone(), light], &comments("//", "env:a\nb.exr", &provenance));
        let expected = "// sphvar lights (sphvar 0.2.0, seed 3)
// environment: env:a\\nb.exr
// AXES
// COLOURS
// E(normal) = sum over i of LIGHT_IRRADIANCES[i] * max(0.0, dot(normal, LIGHT_DIRECTIONS[i]))
const int LIGHT_COUNT = 2;
const vec3 LIGHT_DIRECTIONS[2] = vec3[2](
    vec3(0e0, 6e-1, -8e-1),
    vec3(0e0, 6e-1, -8e-1)
);
const vec3 LIGHT_IRRADIANCES[2] = vec3[2](
    vec3(1e20, 2.5e-1, 0e0),
    vec3(1e20, 2.5e-1, 0e0)
);
";
        let expected = expected.replace("0.2.0", env!("CARGO_PKG_VERSION"));
        assert_eq!(text, expected.replace("AXES", AXES).replace("COLOURS", COLOURS));
    }
}
