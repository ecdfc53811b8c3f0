use sphvar_samplers::{PointSet, Progress};
use sphvar_sh::Domain;
use sphvar_sht::TransformWorkspace;

use super::ensemble_quality::coefficients;
use crate::{Error, Realization};

/// A degree counts as exact if its power, in units of that of white noise, is at most this: the
/// root mean square error of its harmonics is at most 1e-8/sqrt(N) of their size. Coordinates of 10
/// digits and the residual of optimized designs are below; the smallest powers of lattices are
/// above.
pub const EXACT_POWER: f64 = 1e-16;

/// Degree at which the search starts; it doubles until a degree has power.
const FIRST_LMAX: usize = 16;

/// Returns the exact degree of a set with its weights: the largest t such that all harmonics of
/// degrees 1 to t (on the hemisphere the even ones) are integrated exactly, `P(l) <= 1e-16`
/// ([`EXACT_POWER`]). 0 if degree 1 (2 on the hemisphere) has power.
///
/// t is at most `2 sqrt(N)`, with any weights: a polynomial of degree t/2 vanishes at fewer than
/// `(t/2 + 1)^2` points, and its square does not integrate to 0.
///
/// # Errors
///
/// [`Error::Transform`] if a transform cannot be made, [`Error::Sampler`] if `progress` stops the
/// work.
///
/// # Performance
///
/// Transforms to 16, 32, ... up to the first degree with power: one for most sets.
///
/// # Examples
///
/// ```
/// use glam::DVec3;
/// use sphvar_samplers::{Domain, PointSet};
/// use sphvar_spectrum::quality::exact_degree;
///
/// let axes = vec![DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z];
/// assert_eq!(exact_degree(&PointSet::new(axes), Domain::Sphere, &())?, 3);
/// # Ok::<(), sphvar_spectrum::Error>(())
/// ```
pub fn exact_degree(
    set: &PointSet,
    domain: Domain,
    progress: &dyn Progress,
) -> Result<usize, Error> {
    let mut set = set.clone();
    set.normalize_weights();
    let (n_points, step) = (set.len(), domain.degree_step());
    // On the hemisphere the bound is that of the points with their antipodes.
    let bound = 2 * (n_points * step).isqrt();
    let mut workspace = TransformWorkspace::default();
    let (mut exact, mut lmax) = (0, FIRST_LMAX);
    loop {
        progress.tick(0.0)?;
        let alm = coefficients(&set, lmax, &mut workspace)?;
        let power: Vec<f64> = Realization::<Domain>::new(0, &set, &alm).power().collect();
        while exact + step <= lmax {
            let next = exact + step;
            if next > bound || power[next].is_nan() || power[next] > EXACT_POWER {
                return Ok(exact);
            }
            exact = next;
        }
        lmax *= 2;
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use sphvar_samplers::{Pattern, PointSet, Purpose, Realizations, Streams};

    use super::exact_degree;
    use crate::quality::test_sets::{icosahedron, unit};
    use sphvar_sh::Domain;

    fn degree(points: Vec<DVec3>, weights: Vec<f64>, domain: Domain) -> usize {
        exact_degree(&PointSet { points, weights }, domain, &()).unwrap()
    }

    #[test]
    fn degrees_of_known_designs() {
        let (x, z) = (DVec3::X, DVec3::Z);
        let sphere = Domain::Sphere;
        assert_eq!(degree(vec![z], vec![], sphere), 0);
        assert_eq!(degree(vec![z, -z], vec![], sphere), 1);
        assert_eq!(degree(vec![z, x], vec![], sphere), 0);
        assert_eq!(degree(icosahedron(), vec![], sphere), 5);
        // The icosahedron is antipodal, one of each pair of vertices is a 4-design of lines.
        let half: Vec<DVec3> =
            icosahedron().into_iter().filter(|p| (p.z, p.y, p.x) > (0.0, 0.0, 0.0)).collect();
        assert_eq!((half.len(), degree(half, vec![], Domain::Hemisphere)), (6, 4));
        // The tetrahedron, at any scale of its weights, and repeated with signs.
        let mut four: Vec<DVec3> = [(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]
            .map(|(x, y, z)| unit(f64::from(x), f64::from(y), f64::from(z)))
            .to_vec();
        assert_eq!(degree(four.clone(), vec![1e300; 4], sphere), 2);
        four.extend_from_within(..);
        let weights = [[3e-200; 4], [-1e-200; 4]].concat();
        assert_eq!(degree(four, weights, sphere), 2);
    }

    /// Gauss-Legendre points, 8 rings of 16: weights make them exact to degree 15.
    #[test]
    fn weights_count() {
        let rule = sphvar_sh::GaussLegendre::new(8).unwrap();
        let (mut points, mut weights) = (Vec::new(), Vec::new());
        for (z, w) in rule.nodes().iter().zip(rule.weights()) {
            let r = (1.0 - z * z).sqrt();
            for k in 0..16 {
                let phi = std::f64::consts::TAU * f64::from(k) / 16.0;
                points.push(DVec3::new(r * phi.cos(), r * phi.sin(), *z));
                weights.push(*w);
            }
        }
        assert_eq!(degree(points.clone(), weights, Domain::Sphere), 15);
        assert_eq!(degree(points, vec![], Domain::Sphere), 1);
    }

    #[test]
    fn optimized_sets_have_the_degree_that_they_state() {
        let step: Pattern = "step".parse().unwrap();
        let sampler = step.build(100, Domain::Sphere).unwrap();
        let sets = Realizations::rotated(&*sampler, Streams::new(0, Purpose::Pattern, 100));
        let set = sets.realize(0).unwrap();
        let got = exact_degree(&set, Domain::Sphere, &()).unwrap();
        assert_eq!(Some(got), sampler.last_empty_degree());
        // Those of lattices are small, but not 0.
        let lattice = Pattern::FIBONACCI.build(100_000, Domain::Sphere).unwrap();
        let set = Realizations::rotated(&*lattice, Streams::new(0, Purpose::Pattern, 0));
        assert_eq!(exact_degree(&set.realize(0).unwrap(), Domain::Sphere, &()).unwrap(), 0);
    }
}
