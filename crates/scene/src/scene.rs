use glam::DVec3;

use crate::bounds::Bounds;
use crate::mesh::Mesh;
use crate::quads::Quads;
use crate::{Error, Hit, Quad, Reach};

/// Rays for occlusion start this far above the surface, in units of the point's largest coordinate and of the largest
/// distance of a corner of what it lies on. The point is off by a few roundings of the former, its height above the
/// plane of the corners by some of both ([`NEAR`](crate::cone::NEAR)). From that far above an edge the plane of an edge is
/// off by less than a tenth of a radian ([`Cone`](crate::cone::Cone)).
const OF_COORDINATE: f64 = 64.0 * f64::EPSILON;
const OF_SIZE: f64 = 512.0 * f64::EPSILON;

/// Surfaces, and how rays meet them.
///
/// ```
/// use glam::DVec3;
/// use sphvar_scene::{CornellBox, Reach};
///
/// let cornell = CornellBox::new();
/// // The middle of the picture shows the tall block's front...
/// let dir = cornell.camera.direction(256.0, 256.0, [512, 512]);
/// let hit = cornell.scene.closest_hit(cornell.camera.position(), dir).expect("the box");
/// // ...from where one sees the camera, and no other wall within 10 mm.
/// let dirs = [-dir, hit.normal];
/// let mut occluded = [true; 2];
/// cornell.scene.occlusion_into(&hit, &dirs, Reach::Each(&[f64::INFINITY, 10.0]), &mut occluded);
/// assert_eq!(occluded, [false, false]);
/// ```
#[derive(Clone, Debug)]
pub struct Scene {
    geometry: Geometry,
    bounds: Bounds,
}

#[derive(Clone, Debug)]
enum Geometry {
    Quads(Quads),
    Mesh(Box<Mesh>),
}

impl Scene {
    /// A scene of a few plane walls, seen from both sides.
    ///
    /// # Errors
    /// [`Error::NoQuads`] if there are none.
    ///
    /// # Performance
    /// There is no hierarchy: every ray is tested with every wall, many rays at a time.
    pub fn from_quads(quads: Vec<Quad>) -> Result<Self, Error> {
        let quads = Quads::new(quads)?;
        let bounds = quads.bounds();
        Ok(Self { geometry: Geometry::Quads(quads), bounds })
    }

    /// A scene of a mesh, seen from both sides.
    pub fn from_mesh(mesh: Mesh) -> Self {
        let bounds = mesh.bounds();
        Self { geometry: Geometry::Mesh(Box::new(mesh)), bounds }
    }

    /// The smallest box around everything.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Number of quadrilaterals or triangles.
    pub fn n_primitives(&self) -> usize {
        match &self.geometry {
            Geometry::Quads(quads) => quads.as_slice().len(),
            Geometry::Mesh(mesh) => mesh.n_triangles(),
        }
    }

    /// The walls of a scene that has no mesh.
    pub fn quads(&self) -> &[Quad] {
        match &self.geometry {
            Geometry::Quads(quads) => quads.as_slice(),
            Geometry::Mesh(_) => &[],
        }
    }

    /// The nearest surface that a ray meets, in double precision.
    ///
    /// `dir` need not be of unit length. Surfaces through the origin itself and those that are edge on are not met. `None`
    /// for origins that are not finite and directions that have no length that can be computed.
    pub fn closest_hit(&self, origin: DVec3, dir: DVec3) -> Option<Hit> {
        let dir = dir.try_normalize().filter(|_| origin.is_finite())?;
        match &self.geometry {
            Geometry::Quads(quads) => quads.closest_hit(origin, dir),
            Geometry::Mesh(mesh) => mesh.closest_hit(origin, dir),
        }
    }

    /// Replaces `occluded[i]` by whether a ray from the hit point in the unit direction `dirs[i]` meets a surface
    /// within its reach.
    ///
    /// Directions below the surface, `normal . dir < 0`, are occluded by the surface itself, whatever their reach.
    /// Rays start at `position + clearance * normal`, see [`Self::clearance`], so that they do not meet the surface
    /// that they come from; other surfaces nearer than that are not seen. A surface that goes through the point where rays
    /// start, as far as rounding can tell, is met by rays to either side: from an edge or a corner of a closed room
    /// nothing outside is seen.
    ///
    /// Directions are judged in single precision: wrongly only if they pass an edge, the horizon or, at the end of
    /// their reach, a surface within 9 `f32::EPSILON` (1.1e-6) radians as seen from the point. No ray passes between
    /// faces that share edges or corners.
    ///
    /// # Panics
    /// If the lengths of the lists differ.
    ///
    /// # Performance
    /// Many directions at once are faster than few: what the point sees is prepared or fetched once for all of
    /// them, for walls up to any number, for meshes up to 256. Their order does not matter.
    pub fn occlusion_into(
        &self,
        at: &Hit,
        dirs: &[DVec3],
        reach: Reach<'_>,
        occluded: &mut [bool],
    ) {
        assert_eq!(dirs.len(), occluded.len(), "one answer for each direction");
        if let Reach::Each(distances) = reach {
            assert_eq!(dirs.len(), distances.len(), "one distance for each direction");
        }
        let origin = at.position + self.clearance(at) * at.normal;
        match &self.geometry {
            Geometry::Quads(quads) => {
                quads.occlusion_into(origin, at.normal, dirs, reach, occluded);
            }
            Geometry::Mesh(mesh) => mesh.occlusion_into(origin, at.normal, dirs, reach, occluded),
        }
    }

    /// How far above a surface rays for occlusion start.
    ///
    /// It is what rounding may do to the point: 64 EPSILON of its largest coordinate and 512 EPSILON of the largest
    /// distance of a corner of the quadrilateral or triangle `primitive`, if there is one of that number.
    pub fn clearance(&self, at: &Hit) -> f64 {
        let farthest = |corners: &[DVec3]| {
            let distances = corners.iter().map(|c| (c - at.position).abs().max_element());
            distances.fold(0.0, f64::max)
        };
        let size = match &self.geometry {
            Geometry::Quads(quads) => {
                quads.as_slice().get(at.primitive).map_or(0.0, |quad| farthest(&quad.corners()))
            }
            Geometry::Mesh(mesh) if at.primitive < mesh.n_triangles() => {
                farthest(&mesh.triangle(at.primitive))
            }
            Geometry::Mesh(_) => 0.0,
        };
        OF_COORDINATE * at.position.abs().max_element() + OF_SIZE * size
    }
}
