use glam::DVec3;

use super::separation::closest;
use crate::{Progress, Stopped};

/// Returns the smallest distance between two points of `[0, 1)^2` modulo 1: 0 if points coincide,
/// `None` for fewer than two points. Weights have no part in it.
///
/// # Errors
///
/// [`Stopped`] if `progress` stops the work.
///
/// # Performance
///
/// O(N log N) on any set that is not on few lines, as [`separation`](crate::separation).
///
/// # Examples
///
/// ```
/// use sphvar_samplers::toroidal_separation;
/// let distance = toroidal_separation(&[[0.125, 0.5], [0.875, 0.5], [0.5, 0.0]], &())?;
/// assert_eq!(distance, Some(0.25));
/// # Ok::<(), sphvar_samplers::Stopped>(())
/// ```
pub fn toroidal_separation(
    points: &[[f64; 2]],
    progress: &dyn Progress,
) -> Result<Option<f64>, Stopped> {
    if points.len() < 2 {
        return Ok(None);
    }
    let mut all: Vec<DVec3> = points.iter().map(|&[u, v]| DVec3::new(u, v, 0.0)).collect();
    // No two points differ by more than 1/2 modulo 1 in a coordinate.
    let bound = closest(&mut all, 0.5, progress)?;
    // Pairs across an edge: images of the points that are near it, without rounding by Sterbenz's
    // lemma. An image is a unit away from its own point.
    let nearest = 1.0 - (1.0 + 1e-9) * bound.sqrt();
    for axis in [0, 1] {
        let step = if axis == 0 { DVec3::X } else { DVec3::Y };
        let near: Vec<DVec3> =
            all.iter().filter(|p| p[axis] >= nearest).map(|p| p - step).collect();
        all.extend(near);
    }
    Ok(Some(closest(&mut all, bound, progress)?.sqrt()))
}

#[cfg(test)]
mod tests {
    use super::toroidal_separation;
    use crate::{Purpose, SquarePattern, Streams};

    fn definition(points: &[[f64; 2]]) -> f64 {
        let along = |a: f64, b: f64| {
            let (low, high) = (a.min(b), a.max(b));
            (high - low).min(low - (high - 1.0))
        };
        let mut smallest = f64::INFINITY;
        for (k, p) in points.iter().enumerate() {
            for q in &points[..k] {
                let [x, y] = [0, 1].map(|d: usize| along(p[d], q[d]));
                smallest = smallest.min(x * x + y * y);
            }
        }
        smallest.sqrt()
    }

    #[test]
    fn it_matches_all_pairs_on_hostile_sets() {
        let below = 1.0 - f64::EPSILON / 2.0;
        let mut sets = vec![
            vec![[0.0; 2], [0.5; 2]],
            vec![[0.0; 2], [below; 2]],
            vec![[0.0, below], [below, 0.0]],
            vec![[0.1, 0.2], [0.9, 0.25], [0.5, 0.98], [0.52, 0.01]],
            vec![[0.3, 0.7]; 100],
            (0..500).map(|k| [0.25, f64::from(k) / 500.0]).collect(),
            (0..500).map(|k| [f64::from(k) / 500.0, below]).collect(),
        ];
        for pattern in SquarePattern::ALL {
            for n in [2, 3, 4, 5, 16, 17, 100, 900].map(|n| pattern.nearest_count(n)) {
                let mut rng = Streams::new(6, Purpose::Pattern, n).realization(0);
                let points = pattern.build(n).unwrap().sample(&mut rng).unwrap().points;
                let in_corner = points.iter().map(|p| p.map(|x| (1.0 + 1e-9 * (x - 0.5)) % 1.0));
                sets.push(points.iter().copied().chain(in_corner).collect());
                sets.push(points);
            }
        }
        for points in sets.iter().filter(|points| points.len() > 1) {
            let got = toroidal_separation(points, &()).unwrap().unwrap();
            let expected = definition(points);
            assert!((got - expected).abs() <= 0.0, "{} points: {got}, {expected}", points.len());
        }
        assert_eq!(toroidal_separation(&[[0.5; 2]], &()), Ok(None));
    }

    #[test]
    fn the_shortest_vector_of_the_fibonacci_lattice() {
        // Its square is (F_k^2 + F_(k-1)^2)/N^2 = 1/N for N = F_(2k-1).
        for n in [5_usize, 13, 34, 89, 233, 610, 1597, 4181] {
            let mut rng = Streams::new(0, Purpose::Pattern, 0).realization(0);
            let sampler = SquarePattern::FibonacciLattice.build(n).unwrap();
            let points = sampler.sample(&mut rng).unwrap().points;
            let got = toroidal_separation(&points, &()).unwrap().unwrap();
            assert!((got * (n as f64).sqrt() - 1.0).abs() < 1e-12, "N = {n}: {got}");
        }
    }
}
