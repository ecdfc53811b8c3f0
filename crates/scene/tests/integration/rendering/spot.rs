use std::f64::consts::PI;

use glam::DVec3;
use sphvar_scene::{Camera, Directions, Estimator, Image, Integral, Quad, Scene, View, render};

/// All pixels of a picture see the same point of a floor, up to this times the height above the
/// floor.
const FIELD_OF_VIEW: f64 = 1e-6;
/// Half the side of a plane that represents an infinite one.
pub(crate) const FAR: f64 = 1e6;

/// A point on a floor at z = 0 with other surfaces about it, as a picture in which every pixel is a
/// replication.
pub(crate) struct Spot {
    scene: Scene,
    camera: Camera,
}

impl Spot {
    /// Returns the point (0, 0, 0) with these surfaces and the floor.
    pub(crate) fn with(mut surfaces: Vec<Quad>) -> Self {
        surfaces.push(horizontal([-FAR, FAR], [-FAR, FAR], 0.0));
        let scene = Scene::from_quads(surfaces).unwrap();
        let eye = 0.25 * DVec3::Z;
        let camera = Camera::look_at(eye, DVec3::ZERO, DVec3::Y, FIELD_OF_VIEW).unwrap();
        Self { scene, camera }
    }

    /// Renders a picture of `side` by `side` replications.
    pub(crate) fn render(
        &self,
        integral: &Integral<'_>,
        estimator: Estimator,
        directions: &dyn Directions,
        side: usize,
    ) -> Image {
        let view = View::new(&self.scene, &self.camera, [side, side]).unwrap();
        render(&view, integral, estimator, directions, &()).unwrap()
    }
}

/// Returns a rectangle at height z whose corners are counterclockwise as seen from above.
pub(crate) fn horizontal([x0, x1]: [f64; 2], [y0, y1]: [f64; 2], z: f64) -> Quad {
    let corner = |x, y| DVec3::new(x, y, z);
    Quad::new([corner(x0, y0), corner(x1, y0), corner(x1, y1), corner(x0, y1)]).unwrap()
}

/// Returns the fraction of the hemisphere that a rectangle at height `z` covers.
pub(crate) fn covered_share([x0, x1]: [f64; 2], [y0, y1]: [f64; 2], z: f64) -> f64 {
    let corner = |x: f64, y: f64| {
        let slant = (x * x + y * y + z * z).sqrt();
        (x * y / (z * slant)).atan()
    };
    (corner(x1, y1) - corner(x0, y1) - corner(x1, y0) + corner(x0, y0)) / (2.0 * PI)
}

/// Returns the form factor of a polygon above the horizon, seen from the point, by Lambert's
/// formula (1760): half the mean over its edges of the angle that an edge spans times the cosine
/// between the floor's normal and the edge's plane.
pub(crate) fn form_factor(corners: &[DVec3]) -> f64 {
    let edges = (0..corners.len()).map(|i| (corners[i], corners[(i + 1) % corners.len()]));
    let sum: f64 = edges
        .map(|(a, b)| {
            let normal = a.cross(b);
            // The angle between a and b, without the rounding of acos near 1.
            let angle = if normal.length() == 0.0 { 0.0 } else { normal.length().atan2(a.dot(b)) };
            angle * normal.normalize_or_zero().z
        })
        .sum();
    (sum / (2.0 * PI)).abs()
}

/// Mean and its standard error over the pixels.
pub(crate) fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
    (mean, (squares / (n - 1.0) / n).sqrt())
}
