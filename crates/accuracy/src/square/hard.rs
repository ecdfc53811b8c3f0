use num_complex::Complex as Rounded;
use sphvar_nufft::{CircleTransform, Error, TorusCoefficients, TorusTransform};

use super::EPSILONS;
use super::definition::{Definition, value_at};
use super::input::{difference, points};
use crate::reference::DoubleDouble;
use crate::transforms::Complex;
use crate::{Errors, HardCase};

/// The reason of all bounds.
const REASON: &str =
    "errors are divided by epsilon times the sum of the absolute weights or coefficients";

/// Returns the hard cases of this area.
pub(crate) fn hard_cases() -> Vec<HardCase> {
    let case = |name, what, measure| HardCase { name, what, bound: 1.0, reason: REASON, measure };
    vec![
        case(
            "one_point_on_the_square",
            "coefficients of N = 1 point to kmax 30, along an axis to 1000, and values of a function at it, for every \
             epsilon; errors relative to the documented bounds",
            one_point,
        ),
        case(
            "coordinates_at_0_and_1_minus_an_ulp",
            "coefficients and values at points whose coordinates are 0, the smallest positive number, 1/2 and \
             1 - 2^-53, for every epsilon; errors relative to the documented bounds",
            edges,
        ),
        case(
            "million_equal_points_on_the_square",
            "coefficients of 10^6 equal points to kmax 8, and along an axis, for the coarsest and the finest accuracy on \
             grids of f32 and of f64; errors relative to the documented bounds",
            million_equal_points,
        ),
        case(
            "regular_grid_at_its_multiples",
            "coefficients of 32 x 32 points to kmax 64, which are 1024 at multiples of 32 and else 0, for every \
             epsilon; errors relative to the documented bounds",
            regular_grid,
        ),
        case(
            "kmax_0_on_the_square",
            "the sum of weights as the only coefficient, and a constant function, for every epsilon; errors relative \
             to the documented bounds",
            kmax_0,
        ),
        case(
            "weights_of_any_sign_and_scale_on_the_square",
            "coefficients of points with weights of both signs from 1e-300 to 1e300, for every epsilon; errors \
             relative to the documented bounds",
            any_weights,
        ),
    ]
}

/// Adds the errors of all transforms of a few points, relative to epsilon times the sum of weights
/// or coefficients, at every frequency up to kmax and along the axis to `axis_max`.
fn push_all(
    errors: &mut Errors,
    points: &[[f64; 2]],
    weights: Option<&[f64]>,
    kmax: i32,
    axis_max: usize,
) {
    let definition = Definition::new(points, weights);
    let half_plane = (-kmax..=kmax).flat_map(|k1| (0..=kmax).map(move |k2| [k1, k2]));
    let exact: Vec<Complex> = half_plane.map(|[k1, k2]| definition.coefficient(k1, k2)).collect();
    let sum: f64 = weights.map_or(points.len() as f64, |w| w.iter().map(|w| w.abs()).sum());
    let coordinates: Vec<f64> = points.iter().map(|p| p[0]).collect();
    let on_axis: Vec<(usize, Complex)> = (0..=axis_max)
        .step_by((axis_max / 20).max(1))
        .filter_map(|k| Some((k, definition.coefficient(i32::try_from(k).ok()?, 0))))
        .collect();
    let size = usize::try_from(kmax).unwrap_or_default();
    let series = random_series(size);
    let values: Vec<DoubleDouble> =
        points.iter().take(8).map(|p| value_at(*p, size, series.values())).collect();
    let of_series: f64 = 2.0 * series.values().iter().map(|c| c.norm()).sum::<f64>();
    for epsilon in EPSILONS {
        let measured = || -> Result<_, Error> {
            let plan = TorusTransform::new(size, epsilon)?;
            let on_axis =
                CircleTransform::new(axis_max, epsilon)?.adjoint(&coordinates, weights)?;
            Ok((plan.adjoint(points, weights)?, on_axis, plan.evaluate(&series, points)?))
        };
        let Ok((fast, fast_on_axis, fast_values)) = measured() else {
            errors.push(f64::NAN, || format!("an error for epsilon = {epsilon:e}"));
            continue;
        };
        let mut push = |got: Rounded<f64>, exact: Complex, sum: f64, what: &str| {
            errors.push(difference(got, exact) / sum / epsilon, || {
                format!("{what}, epsilon = {epsilon:e}")
            });
        };
        for (got, exact) in fast.values().iter().zip(&exact) {
            push(*got, *exact, sum, "coefficients");
        }
        for (k, exact) in &on_axis {
            push(fast_on_axis[*k], *exact, sum, "coefficients of a coordinate");
        }
        for (got, exact) in fast_values.iter().zip(&values) {
            let exact = Complex { re: *exact, im: DoubleDouble::ZERO };
            push(Rounded::new(*got, 0.0), exact, of_series, "values");
        }
    }
}

/// Returns coefficients of modulus 1.
fn random_series(kmax: usize) -> TorusCoefficients {
    let mut series = TorusCoefficients::zeros(kmax).expect("a low frequency");
    let len = series.values().len();
    for (c, [phase, _]) in series.values_mut().iter_mut().zip(points(len)) {
        *c = Rounded::from_polar(1.0, std::f64::consts::TAU * phase);
    }
    series
}

fn one_point() -> Errors {
    let mut errors = Errors::default();
    push_all(&mut errors, &[[0.754877666, 0.3]], None, 30, 1000);
    push_all(&mut errors, &[[0.1, 1.0 - f64::EPSILON / 2.0]], Some(&[-3.0]), 30, 1000);
    errors
}

fn edges() -> Errors {
    let edges = [0.0, 5e-324, 0.5, 1.0 - f64::EPSILON / 2.0];
    let points: Vec<[f64; 2]> = edges.iter().flat_map(|&u| edges.map(|v| [u, v])).collect();
    let mut errors = Errors::default();
    push_all(&mut errors, &points, None, 12, 1000);
    errors
}

fn million_equal_points() -> Errors {
    const KMAX: i32 = 8;
    const N: f64 = 1e6;
    let point = [0.1, 0.7];
    let points = vec![point; 1_000_000];
    let coordinates = vec![point[0]; points.len()];
    let one = Definition::new(&[point], Some(&[N]));
    let mut errors = Errors::default();
    for epsilon in [1e-1, 5e-6, 4e-6, 1e-13] {
        let fast = TorusTransform::new(8, epsilon).and_then(|plan| plan.adjoint(&points, None));
        let on_axis = CircleTransform::new(8, epsilon).and_then(|c| c.adjoint(&coordinates, None));
        for k1 in -KMAX..=KMAX {
            for k2 in 0..=KMAX {
                let got = fast.as_ref().ok().and_then(|c| c.get(k1, k2));
                let got = got.unwrap_or(Rounded::new(f64::NAN, 0.0));
                let error = difference(got, one.coefficient(k1, k2)) / N / epsilon;
                errors.push(error, || format!("({k1}, {k2}), epsilon = {epsilon:e}"));
            }
        }
        for (k, got) in (0..).zip(on_axis.iter().flatten()) {
            let error = difference(*got, one.coefficient(k, 0)) / N / epsilon;
            errors.push(error, || format!("{k} on the axis, epsilon = {epsilon:e}"));
        }
        errors.push_length(on_axis.map_or(0, |c| c.len()), 9);
    }
    errors
}

fn regular_grid() -> Errors {
    const SIDE: i32 = 32;
    let coordinate = |i: i32| f64::from(i) / f64::from(SIDE);
    let points: Vec<[f64; 2]> =
        (0..SIDE * SIDE).map(|j| [coordinate(j % SIDE), coordinate(j / SIDE)]).collect();
    let n = points.len() as f64;
    let mut errors = Errors::default();
    for epsilon in EPSILONS {
        let fast = TorusTransform::new(64, epsilon).and_then(|plan| plan.adjoint(&points, None));
        for k1 in -2 * SIDE..=2 * SIDE {
            for k2 in 0..=2 * SIDE {
                let got = fast.as_ref().ok().and_then(|c| c.get(k1, k2));
                let got = got.unwrap_or(Rounded::new(f64::NAN, 0.0));
                let exact = if k1 % SIDE == 0 && k2 % SIDE == 0 { n } else { 0.0 };
                errors.push((got - exact).norm() / n / epsilon, || {
                    format!("({k1}, {k2}), epsilon = {epsilon:e}")
                });
            }
        }
    }
    errors
}

fn kmax_0() -> Errors {
    let mut errors = Errors::default();
    push_all(&mut errors, &points(50), None, 0, 0);
    push_all(&mut errors, &points(50), Some(&weights_of_all_sizes(50)), 0, 0);
    errors
}

fn any_weights() -> Errors {
    let mut errors = Errors::default();
    push_all(&mut errors, &points(61), Some(&weights_of_all_sizes(61)), 9, 200);
    // The largest one alone, which rounding of the others must not hide.
    push_all(&mut errors, &points(2), Some(&[1e300, -1e300]), 9, 200);
    push_all(&mut errors, &points(2), Some(&[1e-300, -1e-300]), 9, 200);
    errors
}

/// Returns weights of alternating sign from 1e-300 to 1e300.
fn weights_of_all_sizes(n: i32) -> Vec<f64> {
    let weight = |j: i32| 10f64.powi(600 * j / (n - 1) - 300) * if j % 2 == 0 { 1.0 } else { -1.0 };
    (0..n).map(weight).collect()
}
