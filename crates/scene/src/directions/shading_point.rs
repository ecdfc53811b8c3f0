use glam::DVec3;

use crate::{Hit, Scene};

/// A hit point as the origin of occlusion rays.
#[derive(Clone, Copy, Debug)]
pub struct ShadingPoint<'a> {
    hit: &'a Hit,
    origin: DVec3,
}

impl<'a> ShadingPoint<'a> {
    /// Returns the point of a hit on `scene`.
    #[must_use]
    pub fn new(scene: &Scene, hit: &'a Hit) -> Self {
        Self { hit, origin: scene.ray_origin(hit) }
    }

    /// Returns the unit normal of the surface on the visible side.
    #[must_use]
    pub fn normal(&self) -> DVec3 {
        self.hit.normal
    }

    /// Returns the origin of its rays, slightly above the surface.
    #[must_use]
    pub fn origin(&self) -> DVec3 {
        self.origin
    }
}
