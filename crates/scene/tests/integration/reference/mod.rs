//! The slow definition: every triangle is tested for every ray in double precision, by Cramer's
//! rule (Moeller and Trumbore 1997), with the distance of a ray from where the result changes.

mod numbers;

use glam::DVec3;
pub(crate) use numbers::Numbers;
use sphvar_scene::{Hit, Quad};

/// Triangles and the primitives that they belong to.
pub(crate) struct Reference {
    triangles: Vec<([DVec3; 3], usize)>,
    /// Outlines only: the diagonal of a quadrilateral is not an edge.
    edges: Vec<[DVec3; 2]>,
}

impl Reference {
    pub(crate) fn of_quads(quads: &[Quad]) -> Self {
        let (mut triangles, mut edges) = (Vec::new(), Vec::new());
        for (i, quad) in quads.iter().enumerate() {
            let [a, b, c, d] = quad.corners();
            triangles.extend([([a, b, c], i), ([a, c, d], i)]);
            edges.extend([[a, b], [b, c], [c, d], [d, a]]);
        }
        Self { triangles, edges }
    }

    pub(crate) fn of_triangles(triangles: impl IntoIterator<Item = [DVec3; 3]>) -> Self {
        let triangles = triangles.into_iter().enumerate().map(|(i, t)| (t, i)).collect::<Vec<_>>();
        let edges = triangles.iter().flat_map(|&([a, b, c], _)| [[a, b], [b, c], [c, a]]);
        Self { edges: edges.collect(), triangles }
    }

    /// Returns the distance of the nearest hit and the number of the primitive.
    pub(crate) fn closest(&self, origin: DVec3, dir: DVec3) -> Option<(f64, usize)> {
        let hits = self.triangles.iter().filter_map(|&(t, i)| Some((distance(t, origin, dir)?, i)));
        hits.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Returns a bound on the angle by which the direction must be rotated for another result: to
    /// the next edge, to the horizon, or to where a surface is just within reach.
    pub(crate) fn margin(&self, at: &Hit, origin: DVec3, dir: DVec3, reach: f64) -> f64 {
        let to_edges = self.edges.iter().map(|e| angle_to_edge(e.map(|p| p - origin), dir));
        let to_ends = self.triangles.iter().filter(|_| reach.is_finite()).map(|&([a, b, c], _)| {
            let normal = of_order_1(b - a).cross(of_order_1(c - a)).normalize_or_zero();
            ((a - origin).dot(normal) / reach - dir.dot(normal)).abs()
        });
        to_edges.chain(to_ends).fold(dir.dot(at.normal).abs(), f64::min)
    }

    /// Returns points on edges, for rays that pass close to them.
    pub(crate) fn near_edges(&self, numbers: &mut Numbers) -> DVec3 {
        let [a, b] = self.edges[numbers.below(self.edges.len())];
        a.lerp(b, numbers.unit())
    }
}

fn distance([a, b, c]: [DVec3; 3], origin: DVec3, dir: DVec3) -> Option<f64> {
    let (u, v, w) = (b - a, c - a, origin - a);
    let determinant = u.dot(dir.cross(v));
    let x = w.dot(dir.cross(v)) / determinant;
    let y = dir.dot(w.cross(u)) / determinant;
    let t = v.dot(w.cross(u)) / determinant;
    (x >= 0.0 && y >= 0.0 && x + y <= 1.0 && t > 0.0 && t.is_finite()).then_some(t)
}

fn angle_to_edge([a, b]: [DVec3; 2], dir: DVec3) -> f64 {
    let [a, b] = [of_order_1(a), of_order_1(b)];
    let normal = a.cross(b).normalize_or_zero();
    let on_circle = dir - dir.dot(normal) * normal;
    let between = a.cross(on_circle).dot(normal) >= 0.0 && on_circle.cross(b).dot(normal) >= 0.0;
    let angle = |p: DVec3| dir.cross(p).length().atan2(dir.dot(p));
    if between { dir.dot(normal).abs().asin() } else { angle(a).min(angle(b)) }
}

/// Scales the vector to a length whose products neither overflow nor underflow.
fn of_order_1(v: DVec3) -> DVec3 {
    v / v.abs().max_element()
}
