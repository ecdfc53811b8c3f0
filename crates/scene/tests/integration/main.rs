//! Visibility and pictures against slow definitions.

mod closest_hit;
mod exact_rays;
mod lights;
mod obj;
mod occlusion;
mod reference;
mod rendering;
mod watertight;
