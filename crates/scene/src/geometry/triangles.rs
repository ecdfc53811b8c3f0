use glam::DVec3;

use crate::geometry::pages::Pages;

/// Triangles in the order of the hierarchy.
#[derive(Clone, Debug)]
pub(crate) struct Triangles {
    /// Copies of shared corners cost memory, but vertex indices would cost a ray two memory
    /// accesses.
    pub(crate) corners: Pages<[DVec3; 3]>,
    /// The hierarchy's coordinates are those of vertices times this power of two, which scales the
    /// size to about 2^16.
    pub(crate) scale: f64,
}

impl Triangles {
    pub(crate) fn corners(&self, place: usize) -> [DVec3; 3] {
        self.corners[place]
    }
}
