use glam::DVec3;

use super::DesignEquations;
use crate::optimization::descent::ManifoldPoint;
use crate::patterns::white_noise;
use crate::{Domain, Error, Fibonacci, Purpose, Sampler, Streams};

/// The displacement of a point, in units of `sqrt(4 pi/N)`, the root of the area per point, where
/// there are few or many degrees of freedom beyond the equations.
///
/// Larger displacements make systems better conditioned, but sets end with smaller separations and
/// more power beyond the degree: 0.12 takes a fifth fewer products than 0.1, 0.3 a fourth, with
/// separations below `2.7/sqrt(N)`. Where many degrees of freedom are left, steps are short, do not
/// separate points that the displacement brought together, and are few in any case.
const DISPLACEMENTS: [f64; 2] = [0.1, 0.05];

/// Returns points from which designs are sought: the Fibonacci lattice, of which each point is
/// displaced by the same small distance in a random direction. For symmetric sets the points are
/// those of the upper half, one of each pair of antipodes. Different `attempt`s have different
/// displacements; equal arguments give the same points.
///
/// A lattice has the separation and the low power that a design should keep, but its Jacobian is
/// nearly singular: a displacement that is a wave changes the coefficients of the harmonics that the
/// lattice aliases with each other in fixed proportions. Near the corners of the Brillouin zone, at
/// `l = 1.1 sqrt(N)` for hexagonal lattices, three such coefficients depend on the two components of
/// one displacement, and designs have degrees up to `1.4 sqrt(N)`. Disorder couples the waves.
/// Relaxed points, which are more regular, take several times as many steps.
///
/// # Errors
///
/// [`Error::NoPoints`] for 0 points.
pub(crate) fn perturbed_lattice(
    equations: DesignEquations,
    n_points: usize,
    attempt: u64,
) -> Result<Vec<DVec3>, Error> {
    let domain = equations.domain();
    let mut rng = Streams::new(0, Purpose::Pattern, n_points).realization(attempt);
    let mut points = Fibonacci::new(n_points, domain)?.sample(&mut rng)?.points;
    let length = displacement(equations, n_points);
    for point in &mut points {
        // The tangent part of a uniform direction has a uniform azimuth about the point.
        let direction = white_noise::uniform_direction(Domain::Sphere, &mut rng);
        let azimuth = DVec3::tangent(direction, *point).normalize_or_zero();
        *point = point.moved(length * azimuth);
    }
    Ok(points)
}

/// Returns the displacement of each point.
fn displacement(equations: DesignEquations, n_points: usize) -> f64 {
    let [most, least] = DISPLACEMENTS;
    let share = equations.count() as f64 / (2 * n_points) as f64;
    let scale = (equations.domain().area() / n_points as f64).sqrt();
    scale * (0.3 * (share - 0.5)).clamp(least, most)
}

#[cfg(test)]
mod tests {
    use super::{DesignEquations, displacement, perturbed_lattice};
    use crate::{Fibonacci, Purpose, Sampler, Streams};

    #[test]
    fn points_lie_near_those_of_the_lattice() {
        for is_symmetric in [false, true] {
            for (degree, n) in [(0, 1), (1, 2), (10, 100), (12, 100), (90, 5_000)] {
                let equations = DesignEquations { degree, is_symmetric };
                let points = perturbed_lattice(equations, n, 3).unwrap();
                let mut rng = Streams::new(0, Purpose::Pattern, n).realization(0);
                let lattice = Fibonacci::new(n, equations.domain()).unwrap();
                let lattice = lattice.sample(&mut rng).unwrap().points;
                let length = displacement(equations, n);
                assert_eq!(points.len(), n);
                for (from, to) in lattice.iter().zip(&points) {
                    let angle = from.angle_between(*to).tan();
                    assert!((angle - length).abs() < 1e-7, "{equations:?}, N = {n}: {angle}");
                }
                assert!(points.iter().all(|p| p.is_normalized()));
                assert_eq!(points, perturbed_lattice(equations, n, 3).unwrap());
                assert_ne!(points, perturbed_lattice(equations, n, 4).unwrap());
            }
        }
        let equations = DesignEquations { degree: 3, is_symmetric: false };
        assert!(perturbed_lattice(equations, 0, 0).is_err());
    }
}
