use glam::{DVec2, DVec3};
use robust::{Coord, orient2d};

/// Returns the triangulation of a polygon as indices into `corners`, and whether the polygon is
/// simple in the projection along the normal of its best plane.
///
/// The polygon is projected along the largest component of its area vector (Newell), and ears are
/// clipped there, starting at the first corner, so that convex polygons become fans around it.
/// Signs of areas are exact. All corners are retained, including those on a straight side, so that
/// neighbours share whole sides.
///
/// A polygon that is not simple there, because sides cross or its projection has no area, has no
/// ear at some point; the remaining part is split into a fan.
///
/// # Performance
///
/// An ear is compared only with the reflex corners within its range of x.
pub(crate) fn triangulate(corners: &[DVec3]) -> (Vec<[usize; 3]>, bool) {
    let n = corners.len();
    if n <= 3 {
        return ((n == 3).then_some([0, 1, 2]).into_iter().collect(), true);
    }
    let mut clipper = Clipper::new(projected(corners));
    let mut triangles = Vec::with_capacity(n - 2);
    // The number of corners visited since the last ear; after a full cycle there is none.
    let (mut left, mut without, mut is_simple) = (n, 0, true);
    let mut corner = 1;
    while left > 3 && without <= left {
        let [before, after] = [clipper.before[corner], clipper.after[corner]];
        if clipper.is_ear(corner) {
            triangles.push([before, corner, after]);
            clipper.cut(corner);
            (left, without) = (left - 1, 0);
        } else {
            without += 1;
        }
        corner = after;
    }
    if left > 3 {
        is_simple = false;
    }
    let first = corner;
    let mut last = clipper.after[first];
    while clipper.after[last] != first {
        let next = clipper.after[last];
        is_simple &= clipper.signed_area(first, last, next) >= 0.0;
        triangles.push([first, last, next]);
        last = next;
    }
    // Clipping is cyclic, so the first corner of a triangle need not be its first in the polygon.
    for triangle in &mut triangles {
        let first = (0..3).min_by_key(|&i| triangle[i]).unwrap_or(0);
        triangle.rotate_left(first);
    }
    (triangles, is_simple)
}

/// Returns the corners without the coordinate along which the area vector is largest,
/// counterclockwise.
fn projected(corners: &[DVec3]) -> Vec<DVec2> {
    let origin = corners[0];
    let size = corners.iter().map(|c| (c - origin).abs().max_element()).fold(0.0, f64::max);
    let relative = |c: &DVec3| (c - origin) / size.max(f64::MIN_POSITIVE);
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    let area: DVec3 = sides.map(|(a, b)| relative(a).cross(relative(b))).sum();
    let axis = area.abs().max_position();
    let place = |c: &DVec3| {
        let [x, y, z] = c.to_array();
        let [u, v] = [[y, z], [z, x], [x, y]][axis];
        if area[axis] < 0.0 { DVec2::new(v, u) } else { DVec2::new(u, v) }
    };
    corners.iter().map(place).collect()
}

/// The remaining part of a polygon in a plane.
struct Clipper {
    places: Vec<DVec2>,
    before: Vec<usize>,
    after: Vec<usize>,
    is_reflex: Vec<bool>,
    /// The corners that were initially reflex, sorted by x; only those that are still reflex can
    /// lie in an ear.
    reflex: Vec<usize>,
}

impl Clipper {
    fn new(places: Vec<DVec2>) -> Self {
        let n = places.len();
        let before = (0..n).map(|i| (i + n - 1) % n).collect();
        let after = (0..n).map(|i| (i + 1) % n).collect();
        let mut clipper = Self { places, before, after, is_reflex: vec![], reflex: vec![] };
        clipper.is_reflex = (0..n).map(|i| clipper.signed_area_at(i) <= 0.0).collect();
        clipper.reflex = (0..n).filter(|&i| clipper.is_reflex[i]).collect();
        let places = &clipper.places;
        clipper.reflex.sort_by(|&i, &j| places[i].x.total_cmp(&places[j].x));
        clipper
    }

    /// Returns twice the signed area of a triangle, with the correct sign.
    fn signed_area(&self, a: usize, b: usize, c: usize) -> f64 {
        let at = |i: usize| Coord { x: self.places[i].x, y: self.places[i].y };
        orient2d(at(a), at(b), at(c))
    }

    fn signed_area_at(&self, corner: usize) -> f64 {
        self.signed_area(self.before[corner], corner, self.after[corner])
    }

    fn is_ear(&self, corner: usize) -> bool {
        if self.is_reflex[corner] {
            return false;
        }
        let ear = [self.before[corner], corner, self.after[corner]];
        let xs = ear.map(|i| self.places[i].x);
        let [low, high] =
            [xs.iter().copied().fold(f64::INFINITY, f64::min), f64::max(xs[0], xs[1].max(xs[2]))];
        let from = self.reflex.partition_point(|&i| self.places[i].x < low);
        let within = self.reflex[from..].iter().take_while(|&&i| self.places[i].x <= high);
        within.copied().filter(|&i| self.is_reflex[i] && !ear.contains(&i)).all(|i| {
            // Corners at the position of an ear's corner are points where a polygon touches itself.
            let is_corner = ear.iter().any(|&j| self.places[i] == self.places[j]);
            let [a, b, c] = ear;
            is_corner
                || [(a, b), (b, c), (c, a)].iter().any(|&(p, q)| self.signed_area(p, q, i) < 0.0)
        })
    }

    fn cut(&mut self, corner: usize) {
        let [before, after] = [self.before[corner], self.after[corner]];
        self.after[before] = after;
        self.before[after] = before;
        self.is_reflex[corner] = false;
        // A corner can only change from reflex to convex.
        for i in [before, after] {
            self.is_reflex[i] = self.is_reflex[i] && self.signed_area_at(i) <= 0.0;
        }
    }
}
