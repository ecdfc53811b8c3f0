//! Point sets of tests.

use glam::DVec3;

pub(super) fn unit(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z).normalize()
}

/// Returns the vertices of an icosahedron.
pub(super) fn icosahedron() -> Vec<DVec3> {
    let golden = 0.5 + 1.25f64.sqrt();
    [(1.0, golden), (-1.0, golden), (1.0, -golden), (-1.0, -golden)]
        .iter()
        .flat_map(|&(a, b)| [unit(0.0, a, b), unit(a, b, 0.0), unit(b, 0.0, a)])
        .collect()
}
