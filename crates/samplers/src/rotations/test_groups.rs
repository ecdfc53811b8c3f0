//! Finite groups of rotations, for tests.

use glam::DQuat;

/// Returns the 12 rotations of the tetrahedron.
pub(crate) fn tetrahedral() -> Vec<DQuat> {
    group(&[DQuat::from_xyzw(0.5, 0.5, 0.5, 0.5), DQuat::from_xyzw(1.0, 0.0, 0.0, 0.0)])
}

/// Returns the 24 rotations of the octahedron.
pub(crate) fn octahedral() -> Vec<DQuat> {
    let half = 0.5f64.sqrt();
    group(&[DQuat::from_xyzw(0.5, 0.5, 0.5, 0.5), DQuat::from_xyzw(0.0, 0.0, half, half)])
}

/// Returns the 60 rotations of the icosahedron.
pub(crate) fn icosahedral() -> Vec<DQuat> {
    let golden = 0.5 + 1.25f64.sqrt();
    group(&[
        DQuat::from_xyzw(0.5, 0.5, 0.5, 0.5),
        DQuat::from_xyzw(0.5, 0.5 / golden, 0.0, 0.5 * golden),
    ])
}

/// Returns all products of an element of one set and an element of the other.
pub(crate) fn product(left: &[DQuat], right: &[DQuat]) -> Vec<DQuat> {
    left.iter().flat_map(|p| right.iter().map(|q| (*p * *q).normalize())).collect()
}

/// Returns the group that rotations generate, one quaternion for each of its elements.
fn group(generators: &[DQuat]) -> Vec<DQuat> {
    let mut all = vec![DQuat::IDENTITY];
    let mut at = 0;
    while at < all.len() {
        for next in product(&[all[at]], generators) {
            if all.iter().all(|q| q.dot(next).abs() < 1.0 - 1e-9) {
                all.push(next);
            }
        }
        at += 1;
    }
    all
}

#[test]
fn groups_have_their_orders() {
    assert_eq!([tetrahedral().len(), octahedral().len(), icosahedral().len()], [12, 24, 60]);
}
