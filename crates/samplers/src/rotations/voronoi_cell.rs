use std::f64::consts::PI;

use glam::DVec3;

/// Rodrigues vectors beyond this length count as half turns, which have none.
const HALF_TURN: f64 = 1e6;

/// Vertices within this distance of a plane, relative to their own size, are on it.
const TOLERANCE: f64 = 1e-13;

/// The cell of a rotation in a Voronoi tessellation of SO(3), in the space of the Rodrigues vectors
/// `tan(angle/2) axis` of rotations relative to its own: a convex polyhedron, because rotations
/// nearer to one of two others are a half space there.
#[derive(Clone, Debug)]
pub(super) struct VoronoiCell {
    /// The vertices of each face, in order.
    faces: Vec<Vec<DVec3>>,
}

impl VoronoiCell {
    /// Returns the cell of a rotation without others: all of SO(3), a cube beyond [`HALF_TURN`].
    pub(super) fn whole() -> Self {
        let side = 2.0 * HALF_TURN;
        let corners = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];
        let face = |axis: usize, end: f64| {
            corners
                .map(|[u, v]| {
                    let mut corner = [end, u, v];
                    corner.rotate_right(axis);
                    side * DVec3::from_array(corner)
                })
                .to_vec()
        };
        Self { faces: (0..3).flat_map(|axis| [face(axis, 1.0), face(axis, -1.0)]).collect() }
    }

    /// Removes what is beyond the plane `normal . x = offset`, with a unit normal and an offset of
    /// at least 0.
    pub(super) fn cut(&mut self, normal: DVec3, offset: f64) {
        let beyond = |p: DVec3| {
            let height = normal.dot(p) - offset;
            if height.abs() <= TOLERANCE * (1.0 + p.length()) { 0.0 } else { height }
        };
        if self.faces.iter().flatten().all(|&p| beyond(p) <= 0.0) {
            return;
        }
        let mut section: Vec<DVec3> = Vec::new();
        for face in &mut self.faces {
            let mut kept = Vec::with_capacity(face.len() + 1);
            for (k, &p) in face.iter().enumerate() {
                let next = face[(k + 1) % face.len()];
                let (at, then) = (beyond(p), beyond(next));
                if at <= 0.0 {
                    kept.push(p);
                }
                if at == 0.0 {
                    section.push(p);
                }
                if at * then < 0.0 {
                    // From the inner end, so that the two faces of an edge agree.
                    let (inner, outer, low, high) =
                        if at < 0.0 { (p, next, at, then) } else { (next, p, then, at) };
                    let crossing = inner + (outer - inner) * (low / (low - high));
                    kept.push(crossing);
                    section.push(crossing);
                }
            }
            *face = kept;
        }
        self.faces.retain(|face| face.len() >= 3);
        self.close(section, normal);
    }

    /// Adds the face with these vertices, in any order and repeated.
    fn close(&mut self, mut section: Vec<DVec3>, normal: DVec3) {
        let centre = section.iter().sum::<DVec3>() / section.len().max(1) as f64;
        let (right, up) = normal.any_orthonormal_pair();
        let angle = |p: DVec3| up.dot(p - centre).atan2(right.dot(p - centre));
        section.sort_unstable_by(|p, q| angle(*p).total_cmp(&angle(*q)));
        let is_same =
            |p: &mut DVec3, q: &mut DVec3| p.distance(*q) <= TOLERANCE * (1.0 + p.length());
        section.dedup_by(is_same);
        if section.len() >= 3 {
            self.faces.push(section);
        }
    }

    /// Returns the angle of the rotation from the centre to the farthest point of the cell, from 0
    /// to pi.
    pub(super) fn radius(&self) -> f64 {
        let squared = self.faces.iter().flatten().map(|p| p.length_squared()).fold(0.0, f64::max);
        if squared.sqrt() >= HALF_TURN { PI } else { 2.0 * squared.sqrt().atan() }
    }
}

#[cfg(test)]
mod tests {
    use super::{DVec3, PI, VoronoiCell};

    #[test]
    fn cells_are_cut_by_planes() {
        let mut cell = VoronoiCell::whole();
        assert!((cell.radius() - PI).abs() <= 0.0);
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        for normal in axes.iter().flat_map(|&axis| [axis, -axis]) {
            cell.cut(normal, 0.5);
        }
        // A cube of edge 1.
        assert_eq!(cell.faces.len(), 6);
        let corner = 0.75f64.sqrt();
        assert!((cell.radius() - 2.0 * corner.atan()).abs() < 1e-14);
        // Planes through vertices, through edges, and outside change nothing.
        let diagonal = DVec3::ONE.normalize();
        cell.cut(diagonal, corner);
        cell.cut(DVec3::new(1.0, 1.0, 0.0).normalize(), 0.5f64.sqrt());
        cell.cut(DVec3::X, 0.7);
        assert_eq!(cell.faces.len(), 6);
        // Near the centre, the section of a cube across a diagonal is a hexagon.
        cell.cut(diagonal, corner / 6.0);
        assert_eq!(cell.faces.len(), 7);
        assert_eq!(cell.faces[6].len(), 6);
        // Near the opposite corner it is a triangle.
        cell.cut(-diagonal, 0.9 * corner);
        assert_eq!(cell.faces.last().map(Vec::len), Some(3));
    }
}
