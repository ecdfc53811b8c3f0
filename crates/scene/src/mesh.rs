use glam::{DVec3, Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;
use obvhs::ploc::PlocBuilder;
use obvhs::ray::{Ray, RayHit};
use pulp::Arch;

use crate::bounds::Bounds;
use crate::order::coherent_order;
use crate::quad::{meet, normal_between};
use crate::stream::Stream;
use crate::{Error, Hit, MAX_COORDINATE, Reach};

/// Triangles with a hierarchy over them.
///
/// Normals are those of the triangles' planes.
#[derive(Clone, Debug)]
pub struct Mesh {
    vertices: Box<[DVec3]>,
    /// Numbers of the vertices of the triangles that have an area.
    faces: Box<[[u32; 3]]>,
    bounds: Bounds,
    /// Coordinates in the hierarchy are `(x - center) * scale`.
    center: DVec3,
    scale: f64,
    hierarchy: CwBvh,
    /// The triangles in the hierarchy's order and coordinates.
    corners: Box<[[Vec3; 3]]>,
    arch: Arch,
}

/// Size of the mesh in the hierarchy's coordinates. Its boxes are ignored where a ray leaves them before 1e-4, so
/// that should be less than the distance that rays start from surfaces.
pub(crate) const SIZE: u32 = 1 << 16;
/// How far before the mesh primary rays start, in units of its size.
const RUN_UP: f64 = 1.0 / 16.0;
/// Triangles of a leaf: the format has room for three.
const MAX_LEAF: u32 = 3;

const MAX_TRIANGLES: usize = 1 << 28;

impl Mesh {
    /// The mesh of triangles given by the numbers of their vertices, from 0.
    ///
    /// Triangles without area are left out, as are those with no coordinates that differ by 1e-100 or more;
    /// [`Hit::primitive`] counts the others in their order.
    ///
    /// # Errors
    /// [`Error::Vertex`] if a coordinate that is used is not finite or beyond 1e100, [`Error::FaceIndex`] if there is no
    /// vertex of a given number, [`Error::NoTriangles`] if no triangle has an area,
    /// [`Error::TooManyTriangles`] for more than 2^28.
    ///
    /// # Performance
    /// Makes the hierarchy: about a microsecond a triangle, of which 75 bytes stay for each.
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
        let bounds = Bounds::around(faces.iter().flat_map(corners_of));
        let (center, scale) = (bounds.center(), f64::from(SIZE) / bounds.size());
        let local = |face: &[u32; 3]| corners_of(face).map(|p| ((p - center) * scale).as_vec3());
        if faces.is_empty() {
            return Err(Error::NoTriangles { n_faces });
        }
        let boxes = faces.iter().map(|face| Aabb::from_points(&local(face).map(Vec3A::from)));
        let hierarchy = hierarchy_of(&boxes.collect::<Vec<_>>());
        let order = hierarchy.primitive_indices.iter();
        let corners = order.map(|&i| local(&faces[i as usize])).collect();
        Ok(Self {
            corners,
            vertices: vertices.into(),
            faces: faces.into(),
            bounds,
            center,
            scale,
            hierarchy,
            arch: Arch::new(),
        })
    }

    /// Number of triangles that have an area.
    pub fn n_triangles(&self) -> usize {
        self.faces.len()
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
        self.faces[index].map(|v| self.vertices[v as usize])
    }

    #[expect(clippy::cast_possible_truncation, reason = "for the hierarchy, which has a reserve")]
    pub(crate) fn closest_hit(&self, origin: DVec3, dir: DVec3) -> Option<Hit> {
        // Within the hierarchy, in f32, the way is counted from a little before the ray enters: what is met at once would
        // be ignored.
        let before = RUN_UP * self.bounds.size();
        let start = f64::max(0.0, self.bounds.crossing(origin, dir)?[0] - before);
        let entry = (origin + start * dir - self.center) * self.scale;
        if !entry.is_finite() {
            return None;
        }
        // It is near the box but for rounding, which is large if the origin is far away.
        let limit = DVec3::splat(f64::from(SIZE));
        let ray = Ray::new_inf(entry.clamp(-limit, limit).as_vec3a(), dir.as_vec3a());
        let mut best: Option<(f64, usize, DVec3)> = None;
        self.hierarchy.ray_traverse(ray, &mut RayHit::none(), |_, i| {
            let primitive = self.hierarchy.primitive_indices[i] as usize;
            let corners = self.triangle(primitive);
            let met = normal_of(corners)
                .and_then(|n| Some((meet(corners.map(|c| c - origin), n, dir)?, n)));
            match met {
                Some((distance, normal)) if best.is_none_or(|(d, ..)| distance < d) => {
                    best = Some((distance, primitive, normal));
                    // Boxes that begin here may have what is nearer by less than a rounding.
                    ((distance - start) * self.scale * (1.0 + 1e-6)) as f32
                }
                _ => f32::INFINITY,
            }
        });
        best.map(|(distance, primitive, normal)| Hit::new(origin, dir, distance, normal, primitive))
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
        let distance = |i: usize| match reach {
            Reach::Within(distance) => distance,
            Reach::Each(distances) => distances[i],
        };
        let rays = order.iter().map(|&i| (dirs[i as usize], distance(i as usize) * self.scale));
        let rays = rays.collect::<Vec<_>>();
        let mut answers = vec![false; dirs.len()];
        self.arch.dispatch(Stream {
            hierarchy: &self.hierarchy,
            corners: &self.corners,
            origin: (origin - self.center) * self.scale,
            normal,
            rays: &rays,
            occluded: &mut answers,
        });
        for (&i, &answer) in order.iter().zip(&answers) {
            occluded[i as usize] = answer;
        }
    }
}

/// The hierarchy over boxes, as the crate's own function of this purpose makes it, but without that one's check in
/// debug builds, which takes roundings for errors.
fn hierarchy_of(boxes: &[Aabb]) -> CwBvh {
    let parameters = BvhBuildParams::medium_build();
    let indices = (0..).take(boxes.len()).collect();
    let mut binary = PlocBuilder::with_capacity(boxes.len()).build(
        parameters.ploc_search_distance,
        boxes,
        indices,
        parameters.sort_precision,
        parameters.search_depth_threshold,
    );
    ReinsertionOptimizer::default().run(&mut binary, parameters.reinsertion_batch_ratio, None);
    bvh2_to_cwbvh(&binary, MAX_LEAF, true, false)
}

/// The unit normal of a triangle, on the side from which the corners are counterclockwise, if it has an area.
fn normal_of([a, b, c]: [DVec3; 3]) -> Option<DVec3> {
    normal_between(b - a, c - a)
}
