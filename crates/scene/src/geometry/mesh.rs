use glam::DVec3;
use pulp::Arch;

use crate::geometry::bounds::Bounds;
use crate::geometry::duplicates::remove_duplicates;
use crate::geometry::hierarchy::Hierarchy;
use crate::geometry::order::coherent_order;
use crate::geometry::pages::Pages;
use crate::geometry::quad::normal_between;
use crate::geometry::ray::{Meeting, WatertightRay};
use crate::geometry::stream::Stream;
use crate::geometry::triangles::Triangles;
use crate::{Error, Hit, MAX_COORDINATE, Reach};

/// Triangles with a bounding-volume hierarchy.
///
/// Normals are those of the triangles' planes.
#[derive(Clone, Debug)]
pub struct Mesh {
    pub(crate) triangles: Triangles,
    /// The place in the hierarchy's order of each triangle in input order.
    places: Box<[u32]>,
    bounds: Bounds,
    pub(crate) hierarchy: Hierarchy,
    arch: Arch,
}

const MAX_TRIANGLES: usize = 1 << 28;

/// The maximum size of the mesh in the hierarchy's coordinates, chosen such that products of
/// lengths do not overflow in f32.
const SIZE: f64 = (1u32 << 16) as f64;

/// The minimum number of f64 steps along the size of a mesh; meshes farther from the origin have
/// lost their shape to rounding.
const MIN_STEPS: f64 = (1u32 << 12) as f64;

impl Mesh {
    /// Returns the mesh of triangles given by 0-based vertex indices.
    ///
    /// Triangles without area are left out. So are triangles in which no two coordinates differ by
    /// at least 1e-100, and triangles whose corners coincide with those of an earlier one.
    /// [`Hit::primitive`] counts the remaining triangles in input order.
    ///
    /// # Errors
    ///
    /// Returns [`Error::Vertex`] if a coordinate that is used is not finite or beyond 1e100,
    /// [`Error::FaceIndex`] if a vertex index is out of range, [`Error::NoTriangles`] if no
    /// triangle has an area, [`Error::TooFar`] if the mesh is so far from the origin that its size
    /// is fewer than 4096 steps of its coordinates, and [`Error::TooManyTriangles`] for more than
    /// 2^28 triangles.
    ///
    /// # Performance
    ///
    /// Building the hierarchy takes several microseconds per triangle and about 90 bytes of memory.
    /// The time is of order n log n for any shape.
    pub fn new(vertices: Vec<DVec3>, faces: Vec<[u32; 3]>) -> Result<Self, Error> {
        let n_faces = faces.len();
        if n_faces > MAX_TRIANGLES {
            return Err(Error::TooManyTriangles { n_triangles: n_faces, max: MAX_TRIANGLES });
        }
        for (face, &vertex) in
            faces.iter().enumerate().flat_map(|(i, f)| f.iter().map(move |v| (i, v)))
        {
            let Some(p) = vertices.get(vertex as usize) else {
                return Err(Error::FaceIndex { face, vertex, n_vertices: vertices.len() });
            };
            // This rejects NaN too, which a maximum would ignore.
            if !p.to_array().iter().all(|x| x.abs() <= MAX_COORDINATE) {
                return Err(Error::Vertex { vertex, x: p.x, y: p.y, z: p.z });
            }
        }
        let corners_of = |face: &[u32; 3]| face.map(|v| vertices[v as usize]);
        let mut faces = faces;
        faces.retain(|face| normal_of(corners_of(face)).is_some());
        if faces.is_empty() {
            return Err(Error::NoTriangles { n_faces });
        }
        remove_duplicates(&vertices, &mut faces);
        let bounds = Bounds::around(faces.iter().flat_map(corners_of));
        let (size, magnitude) = (bounds.size(), bounds.magnitude());
        if size < MIN_STEPS * f64::EPSILON * magnitude {
            return Err(Error::TooFar { size, magnitude });
        }
        let scale = (SIZE / size).log2().floor().exp2();
        let boxes = faces.iter().map(|face| Bounds::around(corners_of(face).map(|p| p * scale)));
        let hierarchy = Hierarchy::new(&boxes.collect::<Vec<_>>());
        let mut places = vec![0; faces.len()];
        for (place, &number) in (0..).zip(&hierarchy.order) {
            places[number as usize] = place;
        }
        let ordered = hierarchy.order.iter().map(|&i| corners_of(&faces[i as usize]));
        let triangles = Triangles { corners: Pages::new(ordered), scale };
        Ok(Self { triangles, places: places.into(), bounds, hierarchy, arch: Arch::new() })
    }

    /// Returns the number of distinct triangles that have an area.
    pub fn n_triangles(&self) -> usize {
        self.places.len()
    }

    /// Returns the smallest box around the triangles.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Returns the corners of a triangle.
    ///
    /// # Panics
    ///
    /// Panics if `index` is not below [`Self::n_triangles`].
    pub fn triangle(&self, index: usize) -> [DVec3; 3] {
        self.triangles.corners(self.places[index] as usize)
    }

    /// `dir` is of unit length.
    pub(crate) fn closest_hit(&self, origin: DVec3, dir: DVec3) -> Option<Hit> {
        let ray = WatertightRay::new(origin, dir);
        let mut best: Option<(Meeting, usize)> = None;
        let scale = self.triangles.scale;
        self.hierarchy.visit_along(origin * scale, dir, |first, count| {
            for place in first..first + count {
                let Some(meeting) = ray.meet(self.triangles.corners(place)) else { continue };
                let number = self.hierarchy.order[place] as usize;
                // Of several triangles at the same distance, the first in the list is returned.
                let is_nearer =
                    best.is_none_or(|(b, n)| (meeting.distance, number) < (b.distance, n));
                if is_nearer {
                    best = Some((meeting, number));
                }
            }
            best.map_or(f64::INFINITY, |(meeting, _)| meeting.distance * scale)
        });
        let (Meeting { distance, weights: [v, w] }, primitive) = best?;
        let [a, b, c] = self.triangle(primitive);
        let normal = normal_of([a, b, c])?;
        // On the triangle up to the rounding of its coordinates, however far away the origin is.
        let position = a + v * (b - a) + w * (c - a);
        Some(Hit::new(position, dir, distance, normal, primitive))
    }

    /// See [`Scene::occlusion_into`](crate::Scene::occlusion_into); `origin` is clear of the
    /// surface.
    pub(crate) fn occlusion_into(
        &self,
        origin: DVec3,
        normal: DVec3,
        dirs: &[DVec3],
        reach: Reach<'_>,
        occluded: &mut [bool],
    ) {
        let order = coherent_order(dirs);
        let scale = self.triangles.scale;
        let rays = order.iter().map(|&i| (dirs[i as usize], reach.of(i as usize) * scale));
        let rays = rays.collect::<Vec<_>>();
        let mut results = vec![false; dirs.len()];
        self.arch.dispatch(Stream {
            nodes: &self.hierarchy.nodes,
            triangles: &self.triangles.corners,
            scale,
            origin,
            normal,
            front: reach.front(),
            rays: &rays,
            occluded: &mut results,
        });
        for (&i, &result) in order.iter().zip(&results) {
            occluded[i as usize] = result;
        }
    }
}

/// Returns the unit normal of a triangle, on the side from which the corners are counterclockwise,
/// or `None` if it has no area.
fn normal_of([a, b, c]: [DVec3; 3]) -> Option<DVec3> {
    normal_between(b - a, c - a)
}
