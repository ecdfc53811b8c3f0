//! Geometry and visibility for pictures lit from all around: walls or meshes, and a pinhole camera.
//!
//! ```
//! use glam::DVec3;
//! use sphvar_scene::{CornellBox, Reach};
//!
//! let CornellBox { scene, camera, .. } = CornellBox::new();
//! let dir = camera.direction(100.5, 400.5, [512, 512]);
//! let hit = scene.closest_hit(camera.position(), dir).expect("the camera looks into the box");
//! let mut occluded = [false; 2];
//! scene.occlusion_into(&hit, &[hit.normal, -dir], Reach::Within(f64::INFINITY), &mut occluded);
//! assert_eq!(occluded, [true, false]);
//! ```
//!
//! [`Scene::closest_hit`] finds where primary rays meet a surface, in double precision;
//! [`Scene::occlusion_into`] which of many directions at such a point are blocked.

mod bounds;
mod bundle;
mod camera;
mod cone;
mod cornell;
mod error;
mod hit;
mod mesh;
mod obj;
mod order;
mod quad;
mod quads;
mod scene;
mod stream;

pub use bounds::Bounds;
pub use camera::Camera;
pub use cornell::CornellBox;
pub use error::Error;
pub use hit::{Hit, Reach};
pub use mesh::Mesh;
pub use quad::Quad;
pub use scene::Scene;

/// The largest coordinate of a vertex: products of three differences stay finite.
const MAX_COORDINATE: f64 = 1e100;
