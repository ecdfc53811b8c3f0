//! A white sphere in an environment and under lights that replace it.

use std::path::Path;

use glam::DVec3;
use sphvar_scene::{DirectionalLight, IrradianceReference, irradiance_of};

use crate::error::CliError;
use crate::files::{AtomicFile, PictureFormat, srgb, write_png};
use crate::memory::check_memory;
use crate::plots::{ContactSheet, SheetPanel};
use crate::report::{Provenance, number};

/// The side of a panel in pixels.
const SIDE: usize = 200;
/// The distance of the sphere from the sides.
const MARGIN: f64 = 4.0;
/// The angle in longitude from the vector of the light to the viewer, so that the terminator is in
/// sight, and the height of the viewer, in degrees.
const VIEW: [f64; 2] = [55.0, 20.0];
/// The differences are magnified so that this share of them stays within the scale.
const WITHIN_SCALE: f64 = 0.99;
/// The largest number of spheres side by side.
const MAX_COLUMNS: usize = 5;

/// The lights of a panel.
pub(super) struct Panel<'a> {
    pub(super) sampler: &'a str,
    pub(super) lights: &'a [DirectionalLight],
    /// The error of the irradiance of the luminance.
    pub(super) error: Option<f64>,
}

/// Rejects paths of other formats and those that cannot be written.
pub(super) fn check(path: &Path, panels: usize) -> Result<(), CliError> {
    if PictureFormat::of_path(path)? != PictureFormat::Png {
        return Err(CliError::Usage(format!(
            "{}: pictures of lights are written as .png",
            path.display()
        )));
    }
    // Each sphere with its difference, and rows that are not full.
    let panels = 2 * (panels + MAX_COLUMNS);
    check_memory(&format!("a picture of {panels} panels"), ContactSheet::bytes([SIDE; 2], panels))?;
    Ok(AtomicFile::check(path)?)
}

/// Writes the sphere in the environment and under each of the lights, with the magnified differences
/// below.
pub(super) fn write(
    path: &Path,
    pole: DVec3,
    reference: &IrradianceReference,
    panels: &[Panel<'_>],
    provenance: &Provenance,
) -> Result<(), CliError> {
    let sphere = Sphere::new(viewpoint(pole, reference)?, pole);
    let exact = reference.irradiance(&sphere.normals).map_err(CliError::failed)?;
    let lit: Vec<Vec<[f64; 3]>> =
        panels.iter().map(|panel| irradiance_of(panel.lights, &sphere.normals)).collect();
    let white = exact.as_flattened().iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let difference = |of: &[[f64; 3]]| -> Vec<[f64; 3]> {
        let pairs = of.iter().zip(&exact);
        pairs.map(|(a, b)| [0, 1, 2].map(|c| (a[c] - b[c]) / white)).collect()
    };
    let size = [SIDE; 2];
    let light = |colours: &[[f64; 3]]| sphere.pixels(colours, &|x| srgb(x / white));
    let caption = vec!["in the environment map".to_owned()];
    let exact_panel = SheetPanel { size, colours: light(&exact), caption };
    // No difference, and the key of the row.
    let caption = vec!["differences: grey is 0".to_owned()];
    let blank = vec![[0.0; 3]; sphere.normals.len()];
    let zero = SheetPanel { size, colours: sphere.pixels(&blank, &|_| srgb(0.5)), caption };
    let mut pairs = vec![[exact_panel, zero]];
    for (panel, lit) in panels.iter().zip(&lit) {
        let error = panel.error.map_or_else(String::new, |error| {
            format!("N = {}, error {}", panel.lights.len(), number::percent(error))
        });
        let caption = vec![panel.sampler.to_owned(), error];
        let shown = SheetPanel { size, colours: light(lit), caption };
        let difference = difference(lit);
        let factor = magnification(difference.as_flattened());
        let colours = sphere.pixels(&difference, &|x| srgb(0.5 + factor * x));
        let caption = vec![format!("difference times {factor}")];
        pairs.push([shown, SheetPanel { size, colours, caption }]);
    }
    let columns = pairs.len().min(MAX_COLUMNS);
    let (size, colours) = ContactSheet { panels: in_rows(pairs, columns), columns }.pixels()?;
    Ok(write_png(path, size, &colours, &provenance.line())?)
}

/// Returns the panels row by row, with the second of each pair below the first.
fn in_rows(pairs: Vec<[SheetPanel; 2]>, columns: usize) -> Vec<SheetPanel> {
    let empty = || SheetPanel {
        size: [SIDE; 2],
        colours: vec![u8::MAX; 3 * SIDE * SIDE],
        caption: Vec::new(),
    };
    let mut pairs = pairs.into_iter();
    let mut panels = Vec::new();
    while pairs.len() > 0 {
        let (mut upper, mut lower): (Vec<_>, Vec<_>) =
            pairs.by_ref().take(columns).map(|[upper, lower]| (upper, lower)).unzip();
        upper.resize_with(columns, empty);
        lower.resize_with(columns, empty);
        panels.append(&mut upper);
        panels.append(&mut lower);
    }
    panels
}

/// Returns the direction of the viewer.
fn viewpoint(pole: DVec3, reference: &IrradianceReference) -> Result<DVec3, CliError> {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let normals: Vec<DVec3> = axes.into_iter().chain(axes.map(|axis| -axis)).collect();
    let colours = reference.irradiance(&normals).map_err(CliError::failed)?;
    let values: Vec<f64> = colours.into_iter().map(sphvar_scene::luminance).collect();
    // The irradiance of opposite surfaces differs by the vector of the light along their normal.
    let light = DVec3::new(values[0] - values[3], values[1] - values[4], values[2] - values[5]);
    let across = (light - light.dot(pole) * pole)
        .try_normalize()
        .unwrap_or_else(|| pole.any_orthonormal_vector());
    let [turn, height] = VIEW.map(f64::to_radians);
    let horizontal = across * turn.cos() + pole.cross(across) * turn.sin();
    Ok(horizontal * height.cos() + pole * height.sin())
}

/// Returns a factor 1, 2, 5, 10, 20, ... that scales differences to about half of the scale.
fn magnification(differences: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = differences.iter().map(|x| x.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "an index within the list"
    )]
    let at = (WITHIN_SCALE * sizes.len().saturating_sub(1) as f64) as usize;
    let size = sizes.get(at).copied().unwrap_or(0.0);
    let steps = (0..12).flat_map(|power| [1.0, 2.0, 5.0].map(|digit| digit * 10f64.powi(power)));
    steps.take_while(|factor| factor * size <= 0.5).last().unwrap_or(1.0)
}

/// The visible half of a sphere in parallel projection.
struct Sphere {
    /// The normal of each pixel; of pixels beside the sphere that of the nearest point of its rim.
    normals: Vec<DVec3>,
    /// The covered fraction of each pixel.
    coverage: Vec<f64>,
}

impl Sphere {
    /// Returns the sphere with the pole upwards.
    fn new(viewpoint: DVec3, pole: DVec3) -> Self {
        let right = pole.cross(viewpoint).normalize();
        let up = viewpoint.cross(right);
        let radius = 0.5 * SIDE as f64 - MARGIN;
        let (mut normals, mut coverage) = (Vec::new(), Vec::new());
        for row in 0..SIDE {
            for column in 0..SIDE {
                let centred = |k: usize| (k as f64 + 0.5 - 0.5 * SIDE as f64) / radius;
                let (x, y) = (centred(column), -centred(row));
                let distance = x.hypot(y);
                let towards = (1.0 - distance * distance).max(0.0).sqrt();
                let scale = distance.max(1.0).recip();
                normals.push((x * scale) * right + (y * scale) * up + towards * viewpoint);
                coverage.push((0.5 + (1.0 - distance) * radius).clamp(0.0, 1.0));
            }
        }
        Self { normals, coverage }
    }

    /// Returns the pixels of the sphere in these colours on white.
    fn pixels(&self, colours: &[[f64; 3]], byte: &dyn Fn(f64) -> u8) -> Vec<u8> {
        let pixel = |(colour, coverage): (&[f64; 3], &f64)| {
            colour.map(|x| {
                let shown = 255.0 + coverage * (f64::from(byte(x)) - 255.0);
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "between 0 and 255"
                )]
                let shown = shown.round() as u8;
                shown
            })
        };
        colours.iter().zip(&self.coverage).flat_map(pixel).collect()
    }
}
