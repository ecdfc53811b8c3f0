use glam::DVec3;

use crate::Quad;

/// An intersection of a ray with a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The point on the surface.
    pub position: DVec3,
    /// The surface's unit normal, on the side that the ray came from: `normal . dir <= 0`.
    ///
    /// It is the normal of the plane of the quadrilateral or triangle; normals in a file are
    /// ignored.
    pub normal: DVec3,
    /// The distance from the ray's origin.
    pub distance: f64,
    /// The 0-based number of the quadrilateral or triangle in input order.
    pub primitive: usize,
}

impl Hit {
    /// Returns the hit on a plane with this unit normal, on either side of it.
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

/// The reach of rays from a point. Surfaces at that distance or closer are intersected.
#[derive(Clone, Copy, Debug)]
pub enum Reach<'a> {
    /// All rays have this reach; `f64::INFINITY` means no limit. A reach of 0, a negative reach and
    /// NaN include nothing.
    Within(f64),
    /// A separate reach for each ray, in the order of the directions.
    Each(&'a [f64]),
    /// A separate reach for each ray to a lamp. Surfaces in the plane of the lamp or behind it are
    /// not intersected, so the reach may extend slightly beyond the lamp to cover rounding.
    ToLamp {
        /// The lamp, which emits along its normal.
        lamp: &'a Quad,
        /// The distance for each ray, in the order of the directions.
        distances: &'a [f64],
    },
}

impl Reach<'_> {
    /// Returns the distance of a ray with this number.
    pub(crate) fn of(&self, ray: usize) -> f64 {
        match *self {
            Self::Within(distance) => distance,
            Self::Each(distances) | Self::ToLamp { distances, .. } => distances[ray],
        }
    }

    /// Returns the half space outside which nothing is intersected.
    pub(crate) fn front(&self) -> Option<Front> {
        match self {
            Self::ToLamp { lamp, .. } => {
                Some(Front { point: lamp.corners()[0], normal: lamp.normal() })
            }
            _ => None,
        }
    }
}

/// The half space in front of a plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Front {
    point: DVec3,
    normal: DVec3,
}

/// The rounding of the coordinates of corners in a plane, in units of the largest coordinate, for
/// all three components.
const IN_PLANE: f64 = 16.0 * f64::EPSILON;

impl Front {
    /// Returns whether a polygon extends into the half space by more than the rounding of its
    /// corners.
    pub(crate) fn holds_part_of(&self, corners: &[DVec3]) -> bool {
        corners.iter().any(|&corner| {
            let size = corner.abs().max(self.point.abs()).max_element();
            (corner - self.point).dot(self.normal) > IN_PLANE * size
        })
    }
}
