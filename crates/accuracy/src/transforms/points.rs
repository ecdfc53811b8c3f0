use glam::DVec3;
use sphvar_samplers::{Domain, Pattern, Purpose, Streams};

/// The seed of every set.
const SEED: u64 = 7;

/// Returns independent uniform directions.
pub(crate) fn white_noise(n: usize) -> Vec<DVec3> {
    realization(&Pattern::WhiteNoise, n, 0)
}

/// Returns realization `index` of a pattern on the sphere, without rotation.
pub(crate) fn realization(pattern: &Pattern, n: usize, index: u64) -> Vec<DVec3> {
    let sampler = pattern.build(n, Domain::Sphere).expect("the number of points is valid");
    let mut rng = Streams::new(SEED, Purpose::Pattern, n).realization(index);
    sampler.sample(&mut rng).expect("the set is feasible").points
}

/// Returns independent directions, each with the 15 others that differ by the signs of coordinates
/// or by an exchange of x and y: they share a Legendre function. `n` is rounded down to a multiple
/// of 16.
pub(super) fn mirrored(n: usize) -> Vec<DVec3> {
    let images = |p: DVec3| {
        (0..16).map(move |k: u32| {
            let sign = |bit: u32| if k >> bit & 1 == 1 { -1.0 } else { 1.0 };
            let (x, y) = if k >> 3 == 1 { (p.y, p.x) } else { (p.x, p.y) };
            DVec3::new(sign(0) * x, sign(1) * y, sign(2) * p.z)
        })
    };
    white_noise(n / 16).into_iter().flat_map(images).collect()
}

/// Returns points one or two units in the last place of a coordinate apart, and repeated ones: in
/// general position, at a pole, on the equator and at the meridian where longitudes jump.
pub(super) fn crowded() -> Vec<DVec3> {
    let places = [
        DVec3::new(0.36, -0.48, 0.8),
        DVec3::Z,
        DVec3::NEG_Z,
        DVec3::new(0.6, 0.8, 0.0),
        DVec3::new(-1.0, 0.0, 0.0),
        DVec3::new(-0.6, 0.0, -0.8),
    ];
    let mut points = Vec::new();
    for p in places {
        points.extend([p; 3]);
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            for size in [1e-16, -1e-16, 3e-17] {
                points.push(p + size * axis);
            }
            let along = p.dot(axis);
            for next in [along.next_up(), along.next_down()] {
                points.push(p + (next - along) * axis);
            }
        }
    }
    points
}
