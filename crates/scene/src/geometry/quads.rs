use glam::DVec3;
use pulp::{Arch, Simd, WithSimd};

use crate::geometry::bounds::Bounds;
use crate::geometry::bundle::Bundle;
use crate::geometry::cone::{CLOSE, Cone, NEAR};
use crate::{Error, Hit, Quad, Reach};

/// A small number of quadrilaterals, each tested for every ray.
#[derive(Clone, Debug)]
pub(crate) struct Quads {
    quads: Box<[Quad]>,
    /// The factor that scales lengths to order 1.
    scale: f64,
    arch: Arch,
}

/// The number of polygons and rays that are on the stack at a time.
const ROUND: usize = 32;
const BUNDLE: usize = 64;

impl Quads {
    pub(crate) fn new(quads: Vec<Quad>) -> Result<Self, Error> {
        if quads.is_empty() {
            return Err(Error::NoQuads);
        }
        let scale = 1.0 / Bounds::around(quads.iter().flat_map(Quad::corners)).size();
        Ok(Self { quads: quads.into(), scale, arch: Arch::new() })
    }

    pub(crate) fn as_slice(&self) -> &[Quad] {
        &self.quads
    }

    pub(crate) fn bounds(&self) -> Bounds {
        Bounds::around(self.quads.iter().flat_map(Quad::corners))
    }

    pub(crate) fn closest_hit(&self, origin: DVec3, dir: DVec3) -> Option<Hit> {
        let meetings = self.quads.iter().enumerate();
        let meetings = meetings.filter_map(|(i, q)| Some((i, q.intersect(origin, dir)?)));
        let (primitive, distance) = meetings.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let quad = &self.quads[primitive];
        let position = origin + distance * dir;
        // In the plane up to the rounding of coordinates, however far away the origin is.
        let height = (position - quad.corners()[0]).dot(quad.normal());
        Some(Hit::new(position - height * quad.normal(), dir, distance, quad.normal(), primitive))
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
        self.arch.dispatch(Occlusion { scene: self, origin, normal, dirs, reach, occluded });
    }
}

struct Occlusion<'a> {
    scene: &'a Quads,
    origin: DVec3,
    normal: DVec3,
    dirs: &'a [DVec3],
    reach: Reach<'a>,
    occluded: &'a mut [bool],
}

impl WithSimd for Occlusion<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { scene, origin, normal, dirs, reach, occluded } = self;
        occluded.fill(false);
        let farthest = match reach {
            Reach::Within(distance) => distance * scene.scale,
            Reach::Each(_) | Reach::ToLamp { .. } => f64::INFINITY,
        };
        let front = reach.front();
        let mut bundle = Bundle::<BUNDLE>::new();
        let mut cones = [Cone::<4>::UNSET; ROUND];
        let near = NEAR * (origin.abs().max_element() * scene.scale + 1.0);
        // A quadrilateral that contains the point has two cones.
        for quads in scene.quads.chunks(ROUND / 2) {
            let mut n_cones = 0;
            for quad in quads {
                if front.is_some_and(|front| !front.holds_part_of(&quad.corners())) {
                    continue;
                }
                let corners = quad.corners().map(|c| (c - origin) * scene.scale);
                let height = quad.normal().dot(corners[0]);
                let visible = corners.iter().any(|&c| c.dot(normal) > 0.0);
                if visible && height.abs() <= farthest {
                    cones[n_cones] = Cone::new(corners, quad.normal(), height);
                    n_cones += 1;
                    // The longest side of the scene is 1.
                    if height.abs() <= CLOSE.max(near) {
                        let goes_through = height.abs() <= near;
                        let cone = &mut cones[n_cones - 1];
                        cone.widen(corners, if goes_through { near } else { 0.0 });
                        if goes_through {
                            cones[n_cones] = cone.other_side();
                            n_cones += 1;
                        }
                    }
                }
            }
            for (i, occluded) in occluded.chunks_mut(BUNDLE).enumerate() {
                let first = i * BUNDLE;
                let dirs = dirs[first..first + occluded.len()].iter();
                match reach {
                    Reach::Within(distance) => {
                        let reach = distance * scene.scale;
                        bundle.fill(dirs.map(|&dir| (dir, reach)));
                    }
                    Reach::Each(distances) | Reach::ToLamp { distances, .. } => {
                        let rays = dirs.zip(&distances[first..]);
                        bundle.fill(rays.map(|(&dir, distance)| (dir, distance * scene.scale)));
                    }
                }
                bundle.decide_below(simd, normal.as_vec3());
                for v in 0..occluded.len().div_ceil(S::F32_LANES) {
                    let mut rays = bundle.rays(v);
                    for cone in &cones[..n_cones] {
                        rays = rays.without(simd, cone.meet(simd, &rays));
                        if rays.all_decided(simd) {
                            break;
                        }
                    }
                    bundle.set(v, rays);
                }
                bundle.report(occluded);
            }
        }
    }
}
