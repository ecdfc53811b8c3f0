use glam::DVec3;
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

/// Regions with mean vectors shorter than this have no meaningful tangent plane.
const SHORTEST_MEAN: f64 = 0.2;

/// A mass point with its coordinate along the direction in which its region is divided.
#[derive(Clone, Copy, Debug)]
struct Placed {
    key: f64,
    point: DVec3,
}

/// Sorts mass points so that those of site k, the `capacity` points from index `k capacity`, lie
/// close together.
///
/// The set is bisected recursively along a random tangent direction, each part holding the points
/// of its sites. (Bisection along the long axis of the region, random filling of its corners, and
/// random numbers of sites in the parts all lead to energies within 0.3 % of each other after the
/// relaxation.) Points up to sign are first moved to one side of a random plane.
///
/// If the distribution of the mass points is invariant under rotations, so is that of the order.
pub(super) fn divide(points: &mut [DVec3], capacity: usize, antipodal: bool, rng: &mut dyn Rng) {
    if antipodal {
        let up = random_direction(rng);
        for p in &mut *points {
            if p.dot(up) < 0.0 {
                *p = -*p;
            }
        }
    }
    let mut placed: Vec<Placed> = points.iter().map(|&point| Placed { key: 0.0, point }).collect();
    halve(&mut placed, capacity, rng);
    for (p, placed) in points.iter_mut().zip(placed) {
        *p = placed.point;
    }
}

fn halve(placed: &mut [Placed], capacity: usize, rng: &mut dyn Rng) {
    let n = placed.len() / capacity;
    if n < 2 {
        return;
    }
    let direction = cut(placed, rng);
    for p in &mut *placed {
        p.key = p.point.dot(direction);
    }
    let below = n / 2 * capacity;
    placed.select_nth_unstable_by(below, |a, b| a.key.total_cmp(&b.key));
    let (low, high) = placed.split_at_mut(below);
    halve(low, capacity, rng);
    halve(high, capacity, rng);
}

/// Returns a uniform direction of the tangent plane at the middle of the region, or any direction
/// for a region as large as the sphere.
fn cut(placed: &[Placed], rng: &mut dyn Rng) -> DVec3 {
    let mean = placed.iter().map(|p| p.point).sum::<DVec3>() / placed.len() as f64;
    let direction = random_direction(rng);
    if mean.length() < SHORTEST_MEAN {
        return direction;
    }
    // Any positive multiple of the direction gives the same order; even the zero vector gives a
    // valid one.
    let normal = mean.normalize();
    direction - direction.dot(normal) * normal
}

/// Returns a uniform direction.
pub(super) fn random_direction(rng: &mut dyn Rng) -> DVec3 {
    loop {
        let mut normal = || -> f64 { StandardNormal.sample(&mut *rng) };
        let v = DVec3::new(normal(), normal(), normal());
        // A vector this short (probability 1e-19) would lose digits when normalised.
        if v.length_squared() > 1e-12 {
            return v.normalize();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{DVec3, divide, random_direction};
    use crate::{Purpose, Streams};

    #[test]
    fn the_order_is_a_permutation_into_compact_groups() {
        let mut rng = Streams::new(5, Purpose::Pattern, 0).realization(0);
        for (n, capacity, antipodal) in
            [(1, 7, false), (2, 5, true), (37, 16, false), (64, 9, true)]
        {
            let mut points: Vec<DVec3> =
                (0..n * capacity).map(|_| random_direction(&mut rng)).collect();
            // The key shared by a point and its antipode.
            let sorted = |points: &[DVec3]| {
                let mut all: Vec<_> =
                    points.iter().map(|p| if antipodal && p.z < 0.0 { -*p } else { *p }).collect();
                all.sort_by(|a, b| a.x.total_cmp(&b.x));
                all
            };
            let before = sorted(&points);
            divide(&mut points, capacity, antipodal, &mut rng);
            assert_eq!(before, sorted(&points), "n = {n}, capacity = {capacity}");
            // Random groups would have mean vectors of length about 1/sqrt(capacity), 0.25.
            if n > 16 {
                for group in points.chunks_exact(capacity) {
                    let mean = group.iter().sum::<DVec3>().length() / capacity as f64;
                    assert!(mean > 0.7, "a group of n = {n} has mean length {mean}");
                }
            }
        }
    }
}
