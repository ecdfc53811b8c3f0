use glam::DVec3;

use crate::Quad;

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
    /// Each ray to its own distance, but what is in the plane of a lamp or behind it is not met: rays to a lamp, which may
    /// reach a little beyond it for rounding's sake.
    ToLamp {
        /// The lamp, which shines along its normal.
        lamp: &'a Quad,
        /// A distance for each ray, in the order of the directions.
        distances: &'a [f64],
    },
}

impl Reach<'_> {
    /// The distance of a ray, given by its number.
    pub(crate) fn of(&self, ray: usize) -> f64 {
        match *self {
            Self::Within(distance) => distance,
            Self::Each(distances) | Self::ToLamp { distances, .. } => distances[ray],
        }
    }

    /// What is not in front of this is not met.
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

/// Roundings of the coordinates of corners in a plane, in units of the largest: some for each of three.
const IN_PLANE: f64 = 16.0 * f64::EPSILON;

impl Front {
    /// Whether a polygon reaches into it, by more than roundings of its corners.
    pub(crate) fn holds_part_of(&self, corners: &[DVec3]) -> bool {
        corners.iter().any(|&corner| {
            let size = corner.abs().max(self.point.abs()).max_element();
            (corner - self.point).dot(self.normal) > IN_PLANE * size
        })
    }
}
