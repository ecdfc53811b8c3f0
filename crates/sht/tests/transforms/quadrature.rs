//! Quadrature weights of given points, compared with dense linear algebra.

use std::f64::consts::PI;
use std::ops::ControlFlow;

use glam::DVec3;
use nalgebra::{DMatrix, DVector};
use sphvar_sh::{Domain, real_ylm_at};
use sphvar_sht::{
    QuadratureError, QuadratureProblem, QuadratureWeights, WeightSigns, exact_degree,
};

use crate::points::Lcg;

pub(crate) fn proceed() -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn solve(
    points: &[DVec3],
    domain: Domain,
    signs: WeightSigns,
    degree: usize,
) -> Result<QuadratureWeights, QuadratureError> {
    QuadratureProblem::new(points, domain, signs)?.solve(degree, &mut proceed)
}

/// Returns independent uniform directions of a domain.
pub(crate) fn white(n: usize, domain: Domain, seed: u64) -> Vec<DVec3> {
    let mut random = Lcg::new(seed);
    let mut direction = || {
        let (z, phi) = (random.signed(), 2.0 * PI * random.uniform());
        let s = (1.0 - z * z).sqrt();
        domain.representative(DVec3::new(s * phi.cos(), s * phi.sin(), z))
    };
    (0..n).map(|_| direction()).collect()
}

/// Returns points of the Fibonacci lattice, which are well apart.
pub(crate) fn spread(n: usize) -> Vec<DVec3> {
    let golden = (5f64.sqrt() - 1.0) / 2.0;
    let point = |k: usize| {
        let z = 1.0 - (2 * k + 1) as f64 / n as f64;
        let (sin, cos) = (2.0 * PI * (k as f64 * golden).fract()).sin_cos();
        let s = (1.0 - z * z).sqrt();
        DVec3::new(s * cos, s * sin, z)
    };
    (0..n).map(point).collect()
}

/// Returns the matrix of the real orthonormal harmonics of a domain at the points, by the
/// definition.
pub(crate) fn matrix(points: &[DVec3], domain: Domain, degree: usize) -> DMatrix<f64> {
    let degrees = (0..=degree).filter(|&l| domain.has_degree(l));
    let rows: Vec<(usize, i64)> = degrees
        .flat_map(|l| {
            let order = i64::try_from(l).unwrap();
            (-order..=order).map(move |m| (l, m))
        })
        .collect();
    DMatrix::from_fn(rows.len(), points.len(), |i, k| {
        real_ylm_at(rows[i].0, rows[i].1, points[k]).unwrap()
    })
}

fn right_hand_side(n_rows: usize, domain: Domain) -> DVector<f64> {
    let mut b = DVector::zeros(n_rows);
    b[0] = domain.area() / (4.0 * PI).sqrt();
    b
}

/// Hostile sets that have weights: a pole, the equator, repeated and antipodal points, a cluster.
pub(crate) fn hostile() -> Vec<(&'static str, Vec<DVec3>, Domain, usize)> {
    let mut clustered = white(90, Domain::Sphere, 5);
    clustered
        .extend(white(200, Domain::Sphere, 6).iter().map(|p| (p * 0.1 + DVec3::X).normalize()));
    let mut repeated = white(60, Domain::Sphere, 7);
    repeated.extend(repeated.clone().iter().take(25).copied());
    let mut antipodal = white(80, Domain::Sphere, 8);
    antipodal.extend(antipodal.clone().iter().map(|p| -*p));
    let mut poles = white(50, Domain::Sphere, 9);
    poles.extend([DVec3::Z, -DVec3::Z, DVec3::new(1e-9, 0.0, 1.0)]);
    vec![
        ("one", vec![DVec3::new(0.48, 0.6, 0.64)], Domain::Sphere, 0),
        ("random", white(150, Domain::Sphere, 1), Domain::Sphere, 8),
        ("half", white(150, Domain::Hemisphere, 2), Domain::Hemisphere, 12),
        ("spread", spread(120), Domain::Sphere, 9),
        ("clustered", clustered, Domain::Sphere, 6),
        ("repeated", repeated, Domain::Sphere, 5),
        ("antipodal", antipodal, Domain::Sphere, 6),
        ("poles", poles, Domain::Sphere, 5),
    ]
}

/// The definition: `B^T (B B^T)^-1 b`, by the pseudoinverse.
#[test]
fn weights_of_least_norm_match_the_pseudoinverse() {
    for (name, points, domain, degree) in hostile() {
        let got = solve(&points, domain, WeightSigns::Any, degree).unwrap();
        let matrix = matrix(&points, domain, degree);
        let b = right_hand_side(matrix.nrows(), domain);
        let svd = matrix.clone().svd(true, true);
        let singular = &svd.singular_values;
        let condition = singular.max() / singular.min();
        let exact = svd.solve(&b, 0.0).unwrap();
        let scale = exact.amax();
        for (w, e) in got.weights.iter().zip(&exact) {
            // Both sides lose up to the condition number.
            let tolerance = 100.0 * f64::EPSILON * condition.powi(2) * scale;
            assert!((w - e).abs() < tolerance, "{name}: {w}, not {e}; condition {condition}");
        }
        assert!(got.residual < 1e-13, "{name}: {:e}", got.residual);
        // Lanczos approximates from within.
        let ratio = got.condition / condition;
        assert!((1.0 - 1e-3..1.0 + 1e-6).contains(&ratio), "{name}: {} {condition}", got.condition);
        assert!(got.exact_degree >= degree, "{name}: {}", got.exact_degree);
    }
}

/// Points of rules have weights to degrees with more harmonics than points, and only to these.
#[test]
fn points_of_rules_have_their_weights() {
    let golden = 0.5 + 1.25f64.sqrt();
    let signs = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
    let icosahedron = signs.iter().flat_map(|(s, t)| {
        let p = DVec3::new(0.0, *s, t * golden).normalize();
        [p, DVec3::new(p.y, p.z, p.x), DVec3::new(p.z, p.x, p.y)]
    });
    let icosahedron: Vec<DVec3> = icosahedron.collect();
    let half: Vec<DVec3> = icosahedron.iter().copied().filter(|p| p.z + 0.1 * p.y > 0.0).collect();
    let axes = DVec3::AXES;
    for (name, points, domain, degree, beyond) in [
        ("icosahedron", icosahedron, Domain::Sphere, 5, 6),
        ("octahedron", axes.iter().flat_map(|p| [*p, -*p]).collect(), Domain::Sphere, 3, 4),
        ("half an icosahedron", half, Domain::Hemisphere, 4, 6),
    ] {
        let got = solve(&points, domain, WeightSigns::Any, degree).unwrap();
        let matrix = matrix(&points, domain, degree);
        assert!(matrix.nrows() > points.len());
        let expected = domain.area() / points.len() as f64;
        assert!(got.weights.iter().all(|w| (w - expected).abs() < 1e-13), "{name}: {got:?}");
        let singular = matrix.svd(false, false).singular_values;
        let ratio = got.condition * singular.min() / singular.max();
        assert!((1.0 - 1e-3..1.0 + 1e-6).contains(&ratio), "{name}: {}", got.condition);
        for degree in [beyond, 100 * beyond] {
            let error = solve(&points, domain, WeightSigns::Any, degree).unwrap_err();
            assert!(matches!(error, QuadratureError::TooFewPoints { .. }), "{name}: {error}");
        }
        let nonnegative = solve(&points, domain, WeightSigns::Nonnegative, degree).unwrap();
        assert_eq!(nonnegative.weights, got.weights, "{name}");
    }
}

/// 500 random points to degree 15: the residual is that of rounding.
#[test]
fn five_hundred_random_points_are_exact_to_degree_15() {
    let points = white(500, Domain::Sphere, 11);
    let got = solve(&points, Domain::Sphere, WeightSigns::Any, 15).unwrap();
    assert!(got.residual < 1e-13, "{:e}", got.residual);
    assert_eq!((got.degree, got.exact_degree), (15, 15));
    let sum: f64 = got.weights.iter().sum();
    assert!((sum / (4.0 * PI) - 1.0).abs() < 1e-13, "{sum}");
}

/// Solves `min |A x - b|` for `x >= 0` by the active-set method of Lawson and Hanson 1974 (chapter
/// 23), and returns x.
fn nnls(a: &DMatrix<f64>, b: &DVector<f64>) -> DVector<f64> {
    let n = a.ncols();
    let mut x = DVector::<f64>::zeros(n);
    let mut passive = Vec::<usize>::new();
    loop {
        let slope = a.transpose() * (b - a * &x);
        let next =
            (0..n).filter(|k| !passive.contains(k)).max_by(|&i, &j| slope[i].total_cmp(&slope[j]));
        let Some(next) = next.filter(|&k| slope[k] > 1e-11 * b.norm()) else { return x };
        passive.push(next);
        loop {
            let columns = DMatrix::from_fn(a.nrows(), passive.len(), |i, j| a[(i, passive[j])]);
            let z = columns.svd(true, true).solve(b, 1e-14).unwrap();
            if z.iter().all(|z| *z > 0.0) {
                x.fill(0.0);
                passive.iter().zip(&z).for_each(|(&k, z)| x[k] = *z);
                break;
            }
            let crossing = |(&k, z): (&usize, &f64)| (*z <= 0.0).then(|| x[k] / (x[k] - z));
            let step = passive.iter().zip(&z).filter_map(crossing).fold(1.0, f64::min);
            passive.iter().zip(&z).for_each(|(&k, z)| x[k] += step * (z - x[k]));
            passive.retain(|&k| x[k] > 1e-14);
        }
    }
}

/// The least-norm problem with signs, as a least-distance problem that NNLS solves (Lawson and
/// Hanson 1974, section 23.4): with `r = E u - f` for the u of NNLS, E the transposed constraints with their
/// right-hand sides as last row and f = (0, ..., 0, 1), the solution is `-r_j/r_(n+1)`.
fn nonnegative_by_definition(matrix: &DMatrix<f64>, b: &DVector<f64>) -> Option<DVector<f64>> {
    let (m, n) = matrix.shape();
    // w >= 0, B w >= b, -B w >= -b.
    let e = DMatrix::from_fn(n + 1, n + 2 * m, |i, j| match (i == n, j.checked_sub(n)) {
        (false, None) => f64::from(i == j),
        (true, None) => 0.0,
        (false, Some(j)) if j < m => matrix[(j, i)],
        (false, Some(j)) => -matrix[(j - m, i)],
        (true, Some(j)) if j < m => b[j],
        (true, Some(j)) => -b[j - m],
    });
    let mut f = DVector::zeros(n + 1);
    f[n] = 1.0;
    let r = &e * nnls(&e, &f) - f;
    (r.norm() > 1e-7).then(|| DVector::from_fn(n, |k, _| -r[k] / r[n]))
}

/// At the largest degree with nonnegative weights, where the signs matter.
#[test]
fn nonnegative_weights_match_the_least_distance_problem() {
    for (name, points, domain) in [
        ("spread", spread(40), Domain::Sphere),
        ("random", white(80, Domain::Sphere, 3), Domain::Sphere),
        ("half", white(60, Domain::Hemisphere, 4), Domain::Hemisphere),
    ] {
        let problem = QuadratureProblem::new(&points, domain, WeightSigns::Nonnegative).unwrap();
        let got = problem.solve_largest(usize::MAX, &mut proceed).unwrap();
        assert!(got.degree >= 2, "{name}: {}", got.degree);
        assert!(got.weights.iter().all(|w| *w >= 0.0), "{name}");
        assert!(got.residual < 1e-13, "{name}: {:e}", got.residual);
        let any = solve(&points, domain, WeightSigns::Any, got.degree).unwrap();
        let is_negative = any.weights.iter().any(|w| *w < 0.0);
        assert_eq!(is_negative, name != "spread", "{name}");
        let matrix = matrix(&points, domain, got.degree);
        let b = right_hand_side(matrix.nrows(), domain);
        let exact = nonnegative_by_definition(&matrix, &b).expect(name);
        for (w, e) in got.weights.iter().zip(&exact) {
            assert!((w - e).abs() < 1e-7, "{name}: {w}, not {e}");
        }
    }
}

/// Where the definition has no solution, that is proven rather than guessed.
#[test]
fn degrees_without_nonnegative_weights_are_recognized() {
    let points = white(60, Domain::Sphere, 3);
    let problem =
        QuadratureProblem::new(&points, Domain::Sphere, WeightSigns::Nonnegative).unwrap();
    let largest = problem.solve_largest(usize::MAX, &mut proceed).unwrap();
    assert!(largest.degree >= 3, "{}", largest.degree);
    for degree in [largest.degree, largest.degree + 1] {
        let matrix = matrix(&points, Domain::Sphere, degree);
        let b = right_hand_side(matrix.nrows(), Domain::Sphere);
        let exists = (&matrix * nnls(&matrix, &b) - &b).norm() < 1e-9;
        assert_eq!(exists, degree == largest.degree, "degree {degree}");
    }
    let error = problem.solve(largest.degree + 1, &mut proceed).unwrap_err();
    assert_eq!(error, QuadratureError::NoNonnegative { degree: largest.degree + 1 });
}

#[test]
fn the_largest_degree_is_one_that_converges() {
    let points = white(200, Domain::Sphere, 12);
    let problem = QuadratureProblem::new(&points, Domain::Sphere, WeightSigns::Any).unwrap();
    assert_eq!(problem.largest_possible_degree(), 13);
    let largest = problem.solve_largest(usize::MAX, &mut proceed).unwrap();
    assert!((11..=13).contains(&largest.degree), "{}", largest.degree);
    assert_eq!(problem.solve(largest.degree, &mut proceed).unwrap(), largest);
    let error = problem.solve(14, &mut proceed).unwrap_err();
    assert!(
        error.to_string().contains("the largest degree for points in general is 13"),
        "{error}"
    );
    // Points on a cap of 20 degrees: only low degrees converge.
    let cap: Vec<DVec3> = points.iter().map(|p| (p * 0.2 + DVec3::Z).normalize()).collect();
    let problem = QuadratureProblem::new(&cap, Domain::Sphere, WeightSigns::Any).unwrap();
    let error = problem.solve(10, &mut proceed).unwrap_err();
    assert!(matches!(error, QuadratureError::NotConverged { .. }), "{error}");
    let largest = problem.solve_largest(9, &mut proceed).unwrap();
    assert!((1..9).contains(&largest.degree), "{}", largest.degree);
    assert!(largest.residual < 1e-11);
}

#[test]
fn antipodes_are_one_point_of_the_hemisphere() {
    let points = [DVec3::X, -DVec3::X, DVec3::Y, DVec3::new(-0.0, -1.0, -0.0), DVec3::Z, DVec3::Z];
    let count =
        |domain| QuadratureProblem::new(&points, domain, WeightSigns::Any).unwrap().n_distinct();
    assert_eq!((count(Domain::Sphere), count(Domain::Hemisphere)), (5, 3));
    let none = QuadratureProblem::new(&[], Domain::Sphere, WeightSigns::Any);
    assert_eq!(none.err(), Some(QuadratureError::NoPoints));
    // Two points on each of three axes are the octahedron to even degrees.
    assert_eq!(exact_degree(&points, &[1.0; 6], Domain::Hemisphere, 4), Ok(2));
    assert_eq!(exact_degree(&points, &[1.0; 6], Domain::Sphere, 4), Ok(0));
}

#[test]
fn the_work_stops_at_once() {
    let points = white(300, Domain::Sphere, 2);
    for signs in [WeightSigns::Any, WeightSigns::Nonnegative] {
        let problem = QuadratureProblem::new(&points, Domain::Sphere, signs).unwrap();
        let mut left = 7;
        let mut watch = || {
            left -= 1;
            if left > 0 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        };
        assert_eq!(problem.solve_largest(usize::MAX, &mut watch), Err(QuadratureError::Stopped));
        assert_eq!(left, 0);
    }
}

/// Enough points for the fast transform, whose coefficients of order 0 have an imaginary part of
/// rounding.
#[test]
fn many_points_converge_with_the_fast_transform() {
    // Displaced by about half the distance of neighbours.
    let noise = white(1500, Domain::Sphere, 4);
    let points: Vec<DVec3> =
        spread(1500).iter().zip(&noise).map(|(p, v)| (p + 0.04 * v).normalize()).collect();
    let got = solve(&points, Domain::Sphere, WeightSigns::Any, 26).unwrap();
    assert!(got.residual < 1e-13, "{:e}", got.residual);
    assert_eq!(got.exact_degree, 26);
    let matrix = matrix(&points, Domain::Sphere, 26);
    let eigenvalues = (&matrix * matrix.transpose()).symmetric_eigenvalues();
    let condition = (eigenvalues.max() / eigenvalues.min()).sqrt();
    let ratio = got.condition / condition;
    assert!(condition > 1.5 && (1.0 - 1e-3..1.0 + 1e-6).contains(&ratio), "{condition}: {ratio}");
    let apart = spread(3000);
    let got = solve(&apart, Domain::Sphere, WeightSigns::Nonnegative, 40).unwrap();
    assert!(got.residual < 1e-13 && got.weights.iter().all(|w| *w >= 0.0), "{:e}", got.residual);
}
