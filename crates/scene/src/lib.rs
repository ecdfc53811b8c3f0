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
//!
//! [`render`] makes the picture of an [`Integral`] over the hemisphere of each point, with the directions of a
//! [`DirectionPlan`]; [`RenderErrors`] says how far repeated renders are from a reference image, and how.

mod bounds;
mod bundle;
mod camera;
mod cone;
mod cornell;
mod direction_mode;
mod direction_plan;
mod direction_sets;
mod duplicates;
mod error;
mod estimate;
mod estimator;
mod frame;
mod hierarchy;
mod hit;
mod image;
mod integral;
mod mesh;
mod obj;
mod obj_lines;
mod obj_remarks;
mod order;
mod partition;
mod picture_bias;
mod quad;
mod quads;
mod ray;
mod render;
mod render_errors;
mod scene;
mod stream;
mod triangulation;
mod view;

pub use bounds::Bounds;
pub use camera::Camera;
pub use cornell::CornellBox;
pub use direction_mode::DirectionMode;
pub use direction_plan::DirectionPlan;
pub use direction_sets::DirectionSets;
pub use error::Error;
pub use estimate::Estimate;
pub use estimator::Estimator;
pub use hit::{Hit, Reach};
pub use image::Image;
pub use integral::Integral;
pub use mesh::Mesh;
pub use obj_remarks::ObjRemarks;
pub use picture_bias::PictureBias;
pub use quad::Quad;
pub use render::{pixel_work, render};
pub use render_errors::{ErrorReport, RenderErrors};
pub use scene::Scene;
pub use view::{CropWindow, View};

/// The largest coordinate of a vertex: products of three differences stay finite.
const MAX_COORDINATE: f64 = 1e100;
