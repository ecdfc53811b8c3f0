use glam::DVec3;
use pulp::Arch;

use crate::geometry::bounds::Bounds;
use crate::geometry::duplicates::remove_duplicates;
use crate::geometry::hierarchy::Hierarchy;
use crate::geometry::order::coherent_order;
use crate::geometry::quad::normal_between;
use crate::geometry::ray::{Meeting, WatertightRay};
use crate::geometry::stream::Stream;
use crate::geometry::triangles::Triangles;
use crate::{Error, Hit, MAX_COORDINATE, Reach};

/// Triangles with a hierarchy over them.
///
/// Normals are those of the triangles' planes.
#[derive(Clone, Debug)]
pub struct Mesh {
    pub(crate) triangles: Triangles,
    /// For each triangle in the order given its place in the hierarchy's order.
    places: Box<[u32]>,
    bounds: Bounds,
    pub(crate) hierarchy: Hierarchy,
    arch: Arch,
}

const MAX_TRIANGLES: usize = 1 << 28;

/// Size of the mesh in the hierarchy's coordinates, at most: products of lengths are numbers in f32.
const SIZE: f64 = (1u32 << 16) as f64;

/// Steps of f64 along the size of a mesh, at least: what is farther from 0 has no shape left.
const MIN_STEPS: f64 = (1u32 << 12) as f64;

impl Mesh {
    /// The mesh of triangles given by the numbers of their vertices, from 0.
    ///
    /// Triangles without area are left out, as are those with no coordinates that differ by 1e-100 or more, and those
    /// whose corners are at the same places as those of one before; [`Hit::primitive`] counts the others in their
    /// order.
    ///
    /// # Errors
    /// [`Error::Vertex`] if a coordinate that is used is not finite or beyond 1e100, [`Error::FaceIndex`] if there is no
    /// vertex of a given number, [`Error::NoTriangles`] if no triangle has an area, [`Error::TooFar`] if
    /// the mesh is so far from 0 that coordinates have fewer than 4096 steps along it,
    /// [`Error::TooManyTriangles`] for more than 2^28.
    ///
    /// # Performance
    /// Makes the hierarchy: some microseconds a triangle, of which about 90 bytes stay for each. The time is of order
    /// n log n for any shape.
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
            // Not NaN either, of which the maximum would know nothing.
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
        let triangles = Triangles { corners: ordered.collect(), scale };
        Ok(Self { triangles, places: places.into(), bounds, hierarchy, arch: Arch::new() })
    }

    /// Number of different triangles that have an area.
    pub fn n_triangles(&self) -> usize {
        self.places.len()
    }

    /// The smallest box around the triangles.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// The corners of a triangle.
    ///
    /// # Panics
    /// If `index` is not below [`Self::n_triangles`].
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
                // Of triangles at one distance the first in the list.
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
        // On the triangle to a rounding of its coordinates, however far away the origin is.
        let position = a + v * (b - a) + w * (c - a);
        Some(Hit::new(position, dir, distance, normal, primitive))
    }

    /// See [`Scene::occlusion_into`](crate::Scene::occlusion_into); `origin` is clear of the surface.
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
        let mut answers = vec![false; dirs.len()];
        self.arch.dispatch(Stream {
            nodes: &self.hierarchy.nodes,
            triangles: &self.triangles,
            origin,
            normal,
            front: reach.front(),
            rays: &rays,
            occluded: &mut answers,
        });
        for (&i, &answer) in order.iter().zip(&answers) {
            occluded[i as usize] = answer;
        }
    }
}

/// The unit normal of a triangle, on the side from which the corners are counterclockwise, if it has an area.
fn normal_of([a, b, c]: [DVec3; 3]) -> Option<DVec3> {
    normal_between(b - a, c - a)
}
