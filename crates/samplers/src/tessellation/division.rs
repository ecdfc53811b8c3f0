use rand::Rng;

use super::mass_space::MassSpace;
use crate::vector::Vector;

/// A mass point with its coordinate along the direction in which its region is divided.
#[derive(Clone, Copy, Debug)]
struct Placed<P> {
    key: f64,
    point: P,
}

/// Sorts mass points so that those of site k, the `capacity` points from index `k capacity`, lie
/// close together.
///
/// The set is bisected recursively along a random tangent direction, each part holding the points
/// of its sites. (Bisection along the long axis of the region, random filling of its corners, and
/// random numbers of sites in the parts all lead to energies within 0.3 % of each other after the
/// relaxation.)
pub(crate) fn divide<S: MassSpace<D>, const D: usize>(
    space: S,
    points: &mut [S::Point],
    capacity: usize,
    rng: &mut dyn Rng,
) {
    space.prepare(points, rng);
    let mut placed: Vec<_> = points.iter().map(|&point| Placed { key: 0.0, point }).collect();
    halve(space, &mut placed, capacity, rng);
    for (p, placed) in points.iter_mut().zip(placed) {
        *p = placed.point;
    }
}

fn halve<S: MassSpace<D>, const D: usize>(
    space: S,
    placed: &mut [Placed<S::Point>],
    capacity: usize,
    rng: &mut dyn Rng,
) {
    let n = placed.len() / capacity;
    if n < 2 {
        return;
    }
    let mean = placed.iter().map(|p| p.point).sum::<S::Point>() / placed.len() as f64;
    let direction = space.cut(mean, rng);
    for p in &mut *placed {
        p.key = p.point.dot(direction);
    }
    let below = n / 2 * capacity;
    placed.select_nth_unstable_by(below, |a, b| a.key.total_cmp(&b.key));
    let (low, high) = placed.split_at_mut(below);
    halve(space, low, capacity, rng);
    halve(space, high, capacity, rng);
}
