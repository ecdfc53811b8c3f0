//! Least-squares fits, compared with dense linear algebra.

use std::f64::consts::PI;
use std::ops::ControlFlow;

use glam::DVec3;
use nalgebra::{DMatrix, DVector};
use sphvar_sh::{Alm, Domain};
use sphvar_sht::{ExactTransform, ExactWorkspace, Fit, FitError, LeastSquares};

use crate::points::Lcg;
use crate::quadrature::{hostile, matrix, proceed, white};

/// Returns independent normal numbers (Box and Muller 1958).
pub(crate) fn normal(n: usize, random: &mut Lcg) -> Vec<f64> {
    let mut number =
        || (-2.0 * (1.0 - random.uniform()).ln()).sqrt() * (2.0 * PI * random.uniform()).cos();
    (0..n).map(|_| number()).collect()
}

/// Weights over three orders of magnitude, every seventh 0 where points are not rare.
pub(crate) fn mixed_weights(n: usize) -> Vec<f64> {
    let weight = |k: usize| [0.02, 0.2, 2.0, 20.0][k % 4];
    (0..n).map(|k| if k % 7 == 6 { 0.0 } else { weight(k) }).collect()
}

pub(crate) fn values_at(alm: &Alm, points: &[DVec3]) -> Vec<f64> {
    let mut values = vec![0.0; points.len()];
    let transform = ExactTransform::new(alm.lmax()).unwrap();
    transform.synthesis_into(alm, points, &mut ExactWorkspace::default(), &mut values);
    values
}

/// The definition: the weighted matrix with the rows of the ridge.
struct Dense {
    rows: DMatrix<f64>,
    coefficients: DVector<f64>,
    residual_rms: f64,
    freedom: f64,
    /// C by degree.
    covariances: Vec<DMatrix<f64>>,
}

impl Dense {
    fn new(
        points: &[DVec3],
        values: &[f64],
        weights: &[f64],
        (domain, lmax): (Domain, usize),
        ridge: f64,
    ) -> Self {
        let harmonics = matrix(points, domain, lmax);
        let (n, p) = (points.len(), harmonics.nrows());
        let rows = DMatrix::from_fn(n + p, p, |k, i| match k.checked_sub(n) {
            None => weights[k].sqrt() * harmonics[(i, k)],
            Some(j) => {
                if i == j {
                    ridge.sqrt()
                } else {
                    0.0
                }
            }
        });
        let right =
            DVector::from_fn(n + p, |k, _| if k < n { weights[k].sqrt() * values[k] } else { 0.0 });
        let qr = rows.clone().qr();
        let coefficients = qr.r().solve_upper_triangular(&(qr.q().transpose() * &right)).unwrap();
        let residuals = rows.rows(0, n) * &coefficients - right.rows(0, n);
        let inverse = (rows.transpose() * &rows).try_inverse().unwrap();
        let covariance = &inverse - ridge * &inverse * &inverse;
        let used = weights.iter().filter(|w| **w > 0.0).count();
        let freedom = (used - p) as f64 + ridge * ridge * (&inverse * &inverse).trace();
        let mut first = 0;
        let covariances = (0..=lmax).map(|l| {
            let orders = if domain.has_degree(l) { 2 * l + 1 } else { 0 };
            first += orders;
            covariance.view((first - orders, first - orders), (orders, orders)).into_owned()
        });
        let covariances = covariances.collect();
        let residual_rms = residuals.norm() / weights.iter().sum::<f64>().sqrt();
        Self { rows, coefficients, residual_rms, freedom, covariances }
    }

    fn condition(&self) -> f64 {
        let singular = self.rows.singular_values();
        singular.max() / singular.min()
    }
}

#[test]
fn fits_match_dense_least_squares() {
    let directions = white(60, Domain::Sphere, 99);
    for (name, points, domain, lmax) in hostile() {
        let mut random = Lcg::new(3);
        let values: Vec<f64> = normal(points.len(), &mut random).iter().map(|e| 5.0 + e).collect();
        let mixed = mixed_weights(points.len());
        for (weights, ridge) in
            [(None, 0.0), (None, 3.0), (Some(&mixed), 0.0), (Some(&mixed), 1e-2)]
        {
            let equal = vec![1.0; points.len()];
            let all = weights.unwrap_or(&equal);
            let mut problem = LeastSquares::new(&points, &values, domain).unwrap();
            if let Some(weights) = weights {
                problem = problem.with_weights(weights).unwrap();
            }
            let problem = problem.with_ridge(ridge).unwrap();
            let fit = problem.solve(lmax, &mut proceed).unwrap();
            let dense = Dense::new(&points, &values, all, (domain, lmax), ridge);
            let condition = dense.condition();
            let name = format!("{name}, ridge {ridge}, weights {}", weights.is_some());
            let expected = matrix(&directions, domain, lmax).transpose() * &dense.coefficients;
            let got = values_at(&fit.alm, &directions);
            let tolerance = 2e-11 * condition.powi(2) * expected.amax();
            for (got, expected) in got.iter().zip(&expected) {
                assert!((got - expected).abs() < tolerance, "{name}: {got}, not {expected}");
            }
            // Lanczos approximates from within.
            let ratio = fit.condition / condition;
            assert!((0.95..1.0 + 1e-6).contains(&ratio), "{name}: {ratio}");
            assert!((fit.residual_rms - dense.residual_rms).abs() < 1e-10, "{name}");
            let error = (fit.degrees_of_freedom - dense.freedom).abs();
            assert!(error < 1e-6, "{name}: {}, not {}", fit.degrees_of_freedom, dense.freedom);
            check_energies(&name, &fit, &dense, all);
        }
    }
}

/// Compares the noise of every degree and the errors of energies with those of the dense covariance.
fn check_energies(name: &str, fit: &Fit, dense: &Dense, weights: &[f64]) {
    let Some(variance) = fit.noise_variance else {
        assert!(fit.degrees_of_freedom < 1e-9, "{name}");
        assert!(fit.energies.iter().all(|e| e.noise.is_none() && e.stderr.is_none()), "{name}");
        return;
    };
    let sum_w: f64 = weights.iter().sum();
    let exact = dense.residual_rms.powi(2) * sum_w / fit.degrees_of_freedom;
    assert!((variance / exact - 1.0).abs() < 1e-6, "{name}: {variance}, not {exact}");
    let mut first = 0;
    for (l, (energy, c)) in fit.energies.iter().zip(&dense.covariances).enumerate() {
        let (noise, stderr) = (energy.noise.unwrap(), energy.stderr.unwrap());
        let mean = variance * c.trace();
        assert!((noise - mean).abs() <= 1e-6 * mean, "{name}, degree {l}: {noise}, not {mean}");
        let difference = energy.fitted - noise;
        let rounding = 1e-14 * (energy.fitted + noise);
        assert!((energy.corrected.unwrap() - difference).abs() <= rounding, "{name}");
        let f = dense.coefficients.rows(first, c.nrows());
        first += c.nrows();
        let square = variance * (c * c).trace();
        let of_function = 4.0 * variance * (f.dot(&(c * f)) - square).max(0.0);
        let of_variance = 2.0 * mean * mean / fit.degrees_of_freedom;
        let expected = (of_function + 2.0 * variance * square + of_variance).sqrt();
        let error = (stderr - expected).abs();
        assert!(error <= 1e-5 * expected, "{name}, degree {l}: {stderr}, not {expected}");
    }
}

#[test]
fn a_fit_to_degree_20_of_uneven_points_matches_dense_least_squares() {
    let towards_pole = |p: &DVec3| (*p + 0.3 * DVec3::Z).normalize();
    let points: Vec<DVec3> = white(1500, Domain::Sphere, 12).iter().map(towards_pole).collect();
    let values = normal(points.len(), &mut Lcg::new(13));
    let weights: Vec<f64> = (0..points.len()).map(|k| [0.5, 1.0, 2.0][k % 3]).collect();
    let problem = LeastSquares::new(&points, &values, Domain::Sphere).unwrap();
    let fit = problem.with_weights(&weights).unwrap().solve(20, &mut proceed).unwrap();
    let dense = Dense::new(&points, &values, &weights, (Domain::Sphere, 20), 0.0);
    check_energies("degree 20", &fit, &dense, &weights);
}

#[test]
fn scales_of_values_and_weights_do_not_matter() {
    let points = white(200, Domain::Sphere, 4);
    let values = normal(200, &mut Lcg::new(8));
    let fit = |value: f64, weight: f64| {
        let values: Vec<f64> = values.iter().map(|y| value * y).collect();
        let problem = LeastSquares::new(&points, &values, Domain::Sphere).unwrap();
        let problem = problem.with_weights(&vec![weight; 200]).unwrap();
        problem.with_ridge(3.0 * weight).unwrap().solve(7, &mut proceed).unwrap()
    };
    let unit = fit(1.0, 1.0);
    for (value, weight) in [(1e140, 1.0), (1e-140, 1.0), (1.0, 1e300), (1.0, 1e-300), (1e6, 1e-9)] {
        let got = fit(value, weight);
        for (got, unit) in got.alm.values().iter().zip(unit.alm.values()) {
            assert!((got / value - unit).norm() < 1e-12, "{value:e}, {weight:e}");
        }
        assert!((got.residual_rms / value / unit.residual_rms - 1.0).abs() < 1e-13);
        let variance = |fit: &Fit| fit.noise_variance.unwrap();
        let ratio = variance(&got) / value / value / weight / variance(&unit);
        assert!((ratio - 1.0).abs() < 1e-12, "{value:e}, {weight:e}: {ratio}");
    }
    // Squares beyond this range overflow or underflow.
    for value in [1e200, 1e-200] {
        let error = LeastSquares::new(&points, &[value; 200], Domain::Sphere).unwrap_err();
        assert_eq!(error, FitError::Magnitude { got: value });
    }
    // A fit of zeros is 0.
    let zeros = LeastSquares::new(&points, &[0.0; 200], Domain::Sphere).unwrap();
    let zero = zeros.solve(7, &mut proceed).unwrap();
    assert_eq!((zero.residual_rms, zero.noise_variance), (0.0, Some(0.0)));
    assert!(zero.alm.values().iter().all(|a| a.norm() == 0.0));
}

#[test]
fn undetermined_coefficients_are_an_error_that_states_a_ridge() {
    let random = white(400, Domain::Sphere, 6);
    let cap: Vec<DVec3> = random.iter().map(|p| (p * 0.05 + DVec3::Z).normalize()).collect();
    let ring = |k: usize| DVec3::new((k as f64).cos(), (k as f64).sin(), 0.0).normalize();
    let equator: Vec<DVec3> = (0..400).map(ring).collect();
    let values = normal(400, &mut Lcg::new(2));
    for (name, points, lmax) in [
        ("cap", &cap, 10),
        ("small cap", &cap, 5),
        ("equator", &equator, 2),
        ("ring", &equator, 12),
    ] {
        let problem = LeastSquares::new(points, &values, Domain::Sphere).unwrap();
        let error = problem.solve(lmax, &mut proceed).unwrap_err();
        let FitError::IllConditioned { condition, ridge, .. } = error else {
            panic!("{name}: {error}")
        };
        assert!(condition > 100.0, "{name}: {condition}");
        let fit = problem.with_ridge(ridge).unwrap().solve(lmax, &mut proceed).unwrap();
        assert!((5.0..40.0).contains(&fit.condition), "{name}: {}", fit.condition);
    }
}

#[test]
fn invalid_problems_are_errors() {
    let points = white(30, Domain::Sphere, 1);
    let values = vec![1.0; 30];
    fn new<'a>(points: &'a [DVec3], values: &[f64]) -> Result<LeastSquares<'a>, FitError> {
        LeastSquares::new(points, values, Domain::Sphere)
    }
    let text = |error: FitError| error.to_string();
    assert_eq!(new(&[], &[]).err(), Some(FitError::NoPoints));
    assert_eq!(
        text(new(&points, &values[1..]).unwrap_err()),
        "30 points need as many values, got 29"
    );
    for bad in [f64::NAN, f64::INFINITY] {
        let mut values = values.clone();
        values[3] = bad;
        let error = text(new(&points, &values).unwrap_err());
        assert!(error.starts_with("value 3 (0-based) must be finite"), "{error}");
        values[3] = -bad.abs();
        let error = new(&points, &vec![1.0; 30]).unwrap().with_weights(&values).unwrap_err();
        assert!(text(error).starts_with("weight 3 (0-based)"));
        assert!(new(&points, &vec![1.0; 30]).unwrap().with_ridge(bad).is_err());
    }
    let problem = new(&points, &values).unwrap();
    assert_eq!(problem.clone().with_weights(&[0.0; 30]).err(), Some(FitError::NoWeight));
    assert_eq!(problem.clone().with_ridge(-1.0).err(), Some(FitError::Ridge { got: -1.0 }));
    // 25 harmonics of degree 4 need 25 of the distinct points of positive weight.
    let mut weights = vec![1.0; 30];
    weights[24..].fill(0.0);
    let few = problem.clone().with_weights(&weights).unwrap();
    assert_eq!((problem.largest_possible_degree(), few.largest_possible_degree()), (4, 3));
    let error = text(few.solve(4, &mut proceed).unwrap_err());
    assert!(error.contains("needs 25 distinct points, one for each harmonic, got 24"), "{error}");
    assert!(error.ends_with("the largest possible degree is 3"), "{error}");
}

#[test]
fn the_work_stops_at_once() {
    let points = white(300, Domain::Sphere, 2);
    let problem = LeastSquares::new(&points, &vec![1.0; 300], Domain::Sphere).unwrap();
    for limit in [1, 20, 60] {
        let mut left = limit;
        let mut watch = || {
            left -= 1;
            if left > 0 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        };
        assert_eq!(problem.solve(11, &mut watch), Err(FitError::Stopped));
        assert_eq!(left, 0);
    }
}
