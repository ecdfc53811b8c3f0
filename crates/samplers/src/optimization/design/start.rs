use glam::DVec3;

use super::DesignEquations;
use crate::optimization::descent::ManifoldPoint;
use crate::patterns::white_noise;
use crate::{Domain, Error, Fibonacci, Purpose, Sampler, Streams};

/// The displacement of a point, in units of `sqrt(4 pi/N)`, the root of the area per point, is this
/// number divided by the fraction of degrees of freedom that the equations leave, within limits.
///
/// Larger displacements make systems better conditioned, but sets end with smaller separations and
/// more power beyond the degree. At degree 100 with 10 % more degrees of freedom than equations, 0.2
/// takes 4000 products instead of 10000 from 0.1, and the separation is 3.03 instead of
/// `3.11/sqrt(N)`; with 20 % more, 0.12 takes 1460 instead of 1880, and 0.25 ends below
/// `2.9/sqrt(N)`. Where many degrees of freedom are left, steps are short and do not separate points
/// that the displacement brought together. Near the limit of the degrees of freedom, where more than
/// `MAX_SHARE` are taken, sets from larger displacements than 0.1 have separations below
/// `2.9/sqrt(N)` and several times the power.
const DISPLACEMENT: f64 = 0.018;
const MIN_DISPLACEMENT: f64 = 0.05;
const MAX_DISPLACEMENT: f64 = 0.2;
const MAX_SHARE: f64 = 0.96;
const DISPLACEMENT_AT_LIMIT: f64 = 0.1;

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
    let share = equations.count() as f64 / (2 * n_points) as f64;
    let displacement = if share > MAX_SHARE {
        DISPLACEMENT_AT_LIMIT
    } else {
        (DISPLACEMENT / (1.0 - share)).clamp(MIN_DISPLACEMENT, MAX_DISPLACEMENT)
    };
    displacement * (equations.domain().area() / n_points as f64).sqrt()
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
