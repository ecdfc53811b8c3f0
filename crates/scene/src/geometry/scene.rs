use glam::DVec3;

use crate::geometry::bounds::Bounds;
use crate::geometry::mesh::Mesh;
use crate::geometry::quads::Quads;
use crate::{Error, Hit, Quad, Reach};

/// Rays for occlusion start this far above the surface, in units of the point's largest coordinate
/// and of the largest distance of a corner of its polygon. The error of the point is several
/// roundings of the former, and that of its height above the plane of the corners several roundings
/// of both ([`NEAR`](crate::geometry::cone::NEAR)). From that height above an edge, the error of
/// the plane of an edge is less than a tenth of a radian ([`Cone`](crate::geometry::cone::Cone)).
const OF_COORDINATE: f64 = 64.0 * f64::EPSILON;
const OF_SIZE: f64 = 512.0 * f64::EPSILON;

/// They start this many times as far from the sides of the surface. A surface that rises from a
/// side at an angle with a smaller cotangent is then in front of them.
const FROM_SIDES: f64 = 64.0;

/// The maximum distance of the start from a side, as a fraction of the distance to the centre of
/// the surface: thin triangles have little space.
const MAX_SHARE: f64 = 1.0 / 64.0;

/// Surfaces, with their ray intersections.
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
    /// Returns a scene of several plane walls, visible from both sides.
    ///
    /// # Errors
    ///
    /// Returns [`Error::NoQuads`] if there are none.
    ///
    /// # Performance
    ///
    /// There is no hierarchy: every ray is tested against every wall, many rays at a time.
    pub fn from_quads(quads: Vec<Quad>) -> Result<Self, Error> {
        let quads = Quads::new(quads)?;
        let bounds = quads.bounds();
        Ok(Self { geometry: Geometry::Quads(quads), bounds })
    }

    /// Returns a scene of a mesh, visible from both sides.
    pub fn from_mesh(mesh: Mesh) -> Self {
        let bounds = mesh.bounds();
        Self { geometry: Geometry::Mesh(Box::new(mesh)), bounds }
    }

    /// Returns the smallest box around the scene.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Returns the number of quadrilaterals or triangles.
    pub fn n_primitives(&self) -> usize {
        match &self.geometry {
            Geometry::Quads(quads) => quads.as_slice().len(),
            Geometry::Mesh(mesh) => mesh.n_triangles(),
        }
    }

    /// Returns the walls of a scene without a mesh.
    pub fn quads(&self) -> &[Quad] {
        match &self.geometry {
            Geometry::Quads(quads) => quads.as_slice(),
            Geometry::Mesh(_) => &[],
        }
    }

    /// Returns the nearest surface that a ray meets, in double precision.
    ///
    /// `dir` need not be of unit length. Surfaces that contain the origin and surfaces seen edge-on
    /// are not intersected. Returns `None` for origins that are not finite and for directions whose
    /// length is zero or out of range.
    pub fn closest_hit(&self, origin: DVec3, dir: DVec3) -> Option<Hit> {
        let dir = dir.try_normalize().filter(|_| origin.is_finite())?;
        match &self.geometry {
            Geometry::Quads(quads) => quads.closest_hit(origin, dir),
            Geometry::Mesh(mesh) => mesh.closest_hit(origin, dir),
        }
    }

    /// Replaces `occluded[i]` by whether a ray from the hit point in the unit direction `dirs[i]`
    /// meets a surface within its reach.
    ///
    /// Directions below the surface, `normal . dir < 0`, are occluded by the surface itself,
    /// whatever their reach. Rays start slightly above the point, see [`Self::ray_origin`], so that
    /// they do not meet the surface that they start from; other surfaces closer than that are not
    /// detected. A surface that contains the start of the rays, up to rounding, is intersected by
    /// rays to either side: from an edge or a corner of a closed box nothing outside is visible.
    ///
    /// Directions are tested in single precision. A result can be wrong only if the ray passes an
    /// edge, the horizon or, at the end of its reach, a surface within 9 `f32::EPSILON` (1.1e-6)
    /// radians as seen from the point. No ray passes between faces that share edges or corners.
    ///
    /// # Panics
    ///
    /// Panics if the lengths of the slices differ.
    ///
    /// # Performance
    ///
    /// Large numbers of directions are faster per direction than small ones: the data of the point
    /// are prepared or fetched once for all of them, for walls up to any number, for meshes up to
    /// 256. Their order does not matter.
    pub fn occlusion_into(
        &self,
        at: &Hit,
        dirs: &[DVec3],
        reach: Reach<'_>,
        occluded: &mut [bool],
    ) {
        assert_eq!(dirs.len(), occluded.len(), "one result per direction");
        if let Reach::Each(distances) | Reach::ToLamp { distances, .. } = reach {
            assert_eq!(dirs.len(), distances.len(), "one distance per direction");
        }
        let origin = self.ray_origin(at);
        match &self.geometry {
            Geometry::Quads(quads) => {
                quads.occlusion_into(origin, at.normal, dirs, reach, occluded);
            }
            Geometry::Mesh(mesh) => mesh.occlusion_into(origin, at.normal, dirs, reach, occluded),
        }
    }

    /// Returns the origin of the rays of [`Self::occlusion_into`].
    ///
    /// It lies above the surface by the possible rounding of the point: 64 EPSILON of its largest
    /// coordinate and 512 EPSILON of the largest distance of a corner of the quadrilateral or
    /// triangle `primitive`, if that number is valid. A point within 64 times that of a side is
    /// moved away from the side within the surface, so that it stays in front of surfaces that rise
    /// from there at 1 degree or more.
    pub fn ray_origin(&self, at: &Hit) -> DVec3 {
        match &self.geometry {
            Geometry::Quads(quads) => match quads.as_slice().get(at.primitive) {
                Some(quad) => clear_of(at, quad.corners()),
                None => clear_of(at, []),
            },
            Geometry::Mesh(mesh) if at.primitive < mesh.n_triangles() => {
                clear_of(at, mesh.triangle(at.primitive))
            }
            Geometry::Mesh(_) => clear_of(at, []),
        }
    }
}

/// See [`Scene::ray_origin`]; the point is on the convex polygon of the corners, if there are any.
fn clear_of<const N: usize>(at: &Hit, corners: [DVec3; N]) -> DVec3 {
    let distances = corners.iter().map(|c| (c - at.position).abs().max_element());
    let size = distances.fold(0.0, f64::max);
    let clearance = OF_COORDINATE * at.position.abs().max_element() + OF_SIZE * size;
    let center = corners.iter().sum::<DVec3>() / N.max(1) as f64;
    let from_sides = FROM_SIDES * clearance;
    let mut share = 0.0;
    for i in 0..N {
        let (a, b) = (corners[i], corners[(i + 1) % N]);
        // Distances from the side are products with this vector divided by its length.
        let inwards = at.normal.cross(b - a);
        let [point, middle] = [at.position, center].map(|p| inwards.dot(p - a));
        let (point, middle) = if middle < 0.0 { (-point, -middle) } else { (point, middle) };
        if point < from_sides * (inwards.x.abs() + inwards.y.abs() + inwards.z.abs()) {
            let wanted = from_sides * inwards.length();
            if point < wanted && point < middle {
                share = f64::max(share, (wanted - point) / (middle - point));
            }
        }
    }
    at.position + share.min(MAX_SHARE) * (center - at.position) + clearance * at.normal
}
