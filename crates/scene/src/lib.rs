//! Geometry and visibility for ambient occlusion and direct light: walls or meshes, and a pinhole
//! camera.
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
//! [`Scene::closest_hit`] computes the intersections of primary rays in double precision;
//! [`Scene::occlusion_into`] determines which of many directions at such a point are occluded.
//!
//! [`render`] computes the picture of an [`Integral`] over the hemisphere of each point, with the
//! uniform directions of a [`DirectionPlan`], or those of a [`WarpedPlan`], which have the density of
//! a cosine, an environment map or a light; [`RenderErrors`] reports the errors of repeated renders
//! relative to a reference image and their structure.
//!
//! [`RgbEnvironment`] is converted to directional lights, and [`IrradianceReference`] has the error
//! of the irradiance that these cast.
//!
//! # Features
//!
//! - `serde`: serialization of [`Image`] with serde. Off by default.

mod directions;
mod error;
mod geometry;
mod lights;
mod obj;
mod picture;

pub use directions::density::Density;
pub use directions::light_warp::LightMap;
pub use directions::mode::DirectionMode;
pub use directions::plan::DirectionPlan;
pub use directions::sets::DirectionSets;
pub use directions::shading_point::ShadingPoint;
pub use directions::source::{Directions, SetWeight};
pub use directions::warped_plan::WarpedPlan;
pub use directions::warped_sets::WarpedSets;
pub use error::Error;
pub use geometry::bounds::Bounds;
pub use geometry::hit::{Hit, Reach};
pub use geometry::mesh::Mesh;
pub use geometry::quad::Quad;
pub use geometry::scene::Scene;
pub use lights::environment::RgbEnvironment;
pub use lights::irradiance::{IrradianceError, IrradianceReference};
pub use lights::{DirectionalLight, irradiance_of, luminance};
pub use obj::remarks::ObjRemarks;
pub use picture::camera::Camera;
pub use picture::cornell::CornellBox;
pub use picture::crop_window::CropWindow;
pub use picture::estimate::Estimate;
pub use picture::estimator::Estimator;
pub use picture::image::Image;
pub use picture::integral::Integral;
pub use picture::picture_bias::PictureBias;
pub use picture::render::{pixel_work, render};
pub use picture::render_errors::{ErrorReport, RenderErrors};
pub use picture::view::View;

/// The largest coordinate of a vertex, chosen such that products of three differences stay finite.
const MAX_COORDINATE: f64 = 1e100;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
