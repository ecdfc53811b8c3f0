use glam::DVec3;

use crate::{Camera, Quad, Scene};

/// The size of the box: width (x), height (y) and depth (z).
const SIZE: DVec3 = DVec3::new(556.0, 548.8, 559.2);

/// The corners (x, z) of the blocks' tops in order, and their heights.
const SHORT_BLOCK: ([[f64; 2]; 4], f64) =
    ([[130.0, 65.0], [82.0, 225.0], [240.0, 272.0], [290.0, 114.0]], 165.0);
const TALL_BLOCK: ([[f64; 2]; 4], f64) =
    ([[423.0, 247.0], [265.0, 296.0], [314.0, 456.0], [472.0, 406.0]], 330.0);

/// The corners (x, z) of the light in the ceiling.
const LIGHT: [[f64; 2]; 4] = [[343.0, 227.0], [343.0, 332.0], [213.0, 332.0], [213.0, 227.0]];

/// Half the side of the film, and its distance from the pinhole, in metres.
const HALF_FILM: f64 = 0.0125;
const FOCAL_LENGTH: f64 = 0.035;

/// The Cornell box: five walls and two blocks, open in front, y upwards, lengths in millimetres.
///
/// Blocks, light and camera are those measured at Cornell. The measured walls are out of square by
/// up to 6.4 mm; here they are rectangles. The undersides of the blocks are omitted. The blocks
/// come first, with 5 faces each, then floor, ceiling, back wall, and the walls at x = 0 (right in
/// the picture) and x = 556.
///
/// # References
///
/// Cornell University Program of Computer Graphics, The Cornell Box, physical model data (1998).
#[derive(Clone, Debug)]
pub struct CornellBox {
    /// The walls and blocks.
    pub scene: Scene,
    /// The measured view, for square pictures: from (278, 273, -800) along z, 39.3 degrees high.
    pub camera: Camera,
    /// The light's surface; it emits downwards, along its normal, and is not part of the scene.
    pub light: Quad,
}

impl CornellBox {
    /// Returns the Cornell box.
    #[expect(clippy::missing_panics_doc, reason = "the data are known to be right")]
    pub fn new() -> Self {
        let known = "known data";
        let quad = |corners| Quad::new(corners).expect(known);
        let at_height = |[x, z]: [f64; 2], y: f64| DVec3::new(x, y, z);
        let mut quads = Vec::new();
        for (top, height) in [SHORT_BLOCK, TALL_BLOCK] {
            quads.push(quad(top.map(|p| at_height(p, height))));
            for i in 0..4 {
                let (p, q) = (top[i], top[(i + 1) % 4]);
                quads.push(quad([
                    at_height(p, height),
                    at_height(p, 0.0),
                    at_height(q, 0.0),
                    at_height(q, height),
                ]));
            }
        }
        let [x, y, z] = [DVec3::X * SIZE.x, DVec3::Y * SIZE.y, DVec3::Z * SIZE.z];
        for (corner, u, v) in
            [(DVec3::ZERO, z, x), (y, x, z), (z, y, x), (DVec3::ZERO, y, z), (x, z, y)]
        {
            quads.push(quad([corner, corner + u, corner + u + v, corner + v]));
        }
        Self {
            scene: Scene::from_quads(quads).expect(known),
            camera: Camera::look_at(
                DVec3::new(278.0, 273.0, -800.0),
                DVec3::new(278.0, 273.0, 0.0),
                DVec3::Y,
                2.0 * (HALF_FILM / FOCAL_LENGTH).atan(),
            )
            .expect(known),
            light: quad(LIGHT.map(|p| at_height(p, SIZE.y))),
        }
    }
}

impl Default for CornellBox {
    fn default() -> Self {
        Self::new()
    }
}
