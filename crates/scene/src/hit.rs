use glam::DVec3;

/// Where a ray meets a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The point on the surface.
    pub position: DVec3,
    /// The surface's unit normal, on the side that the ray came from: `normal . dir <= 0`.
    ///
    /// It is the normal of the plane of the quadrilateral or triangle; normals of a file are not used.
    pub normal: DVec3,
    /// Distance from the ray's origin.
    pub distance: f64,
    /// The number of the quadrilateral or triangle in the order they were given, from 0.
    pub primitive: usize,
}

impl Hit {
    /// The hit on a plane with this unit normal, on either side of it.
    pub(crate) fn new(
        position: DVec3,
        dir: DVec3,
        distance: f64,
        normal: DVec3,
        primitive: usize,
    ) -> Self {
        let normal = if normal.dot(dir) > 0.0 { -normal } else { normal };
        Self { position, normal, distance, primitive }
    }
}

/// How far rays from a point reach; what is at that distance or nearer is met.
#[derive(Clone, Copy, Debug)]
pub enum Reach<'a> {
    /// All rays this far; `f64::INFINITY` means without end. Nothing is within 0, a negative distance or NaN.
    Within(f64),
    /// Each ray to its own distance, in the order of the directions.
    Each(&'a [f64]),
}
