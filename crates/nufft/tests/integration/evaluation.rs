//! The transform from coefficients to values and derivatives at points.

use std::f64::consts::TAU;

use num_complex::Complex;
use sphvar_nufft::{
    TorusCoefficients, TorusTransform, TorusWorkspace, direct_evaluate, direct_gradient,
};

use crate::input::{EPSILONS, JUST_BELOW_1, Size, gradient_factors, real, uniform};

fn points() -> Vec<[f64; 2]> {
    let mut next = uniform(3);
    let corners = [0.0, -0.0, 5e-324, 0.0625, 1.0 - f64::EPSILON, JUST_BELOW_1];
    let corners = corners.iter().flat_map(|&u| corners.map(|v| [u, v]));
    let on_the_grid = (0..16).map(|j| [j % 4, j / 4].map(|i| f64::from(i) / 4.0));
    let random: Vec<[f64; 2]> = (0..30).map(|_| [next(), next()]).collect();
    corners.chain(on_the_grid).chain(random).collect()
}

/// Returns functions by name. All have conjugate coefficients at (k1, 0) and (-k1, 0).
fn functions(kmax: usize) -> Vec<(&'static str, TorusCoefficients)> {
    let mut next = uniform(17);
    let mut of = |f: &dyn Fn(usize, f64) -> f64| {
        let mut c = TorusCoefficients::zeros(kmax).unwrap();
        for (index, value) in c.values_mut().iter_mut().enumerate() {
            *value = Complex::new(f(index, 2.0 * next() - 1.0), f(index, 2.0 * next() - 1.0));
        }
        let columns = kmax + 1;
        for line in 0..=kmax {
            let mirrored = c.values()[(2 * kmax - line) * columns].conj();
            c.values_mut()[line * columns] = mirrored;
        }
        c.values_mut()[kmax * columns].im = 0.0;
        c
    };
    let corner = (2 * kmax + 1) * (kmax + 1) - 1;
    let at = |index: usize| move |i: usize, _: f64| if i == index { 1.0 } else { 0.0 };
    vec![
        ("random", of(&|_, x| x)),
        ("highest", of(&at(corner))),
        ("lowest", of(&at(kmax))),
        ("constant", of(&at(kmax * (kmax + 1)))),
        ("along u", of(&at(2 * kmax * (kmax + 1)))),
        ("zero", of(&|_, _| 0.0)),
        ("huge", of(&|_, x| x * 1e297)),
        ("tiny", of(&|_, x| x * 1e-309)),
        ("of all sizes", of(&|i, x| x * 10f64.powi(i32::try_from(i % 600).unwrap() - 300))),
    ]
}

fn check(kmax: usize, epsilons: &[f64], points: &[[f64; 2]]) {
    let mut workspace = TorusWorkspace::default();
    let (mut values, mut gradients) = (vec![0.0; points.len()], vec![[0.0; 3]; points.len()]);
    for (name, c) in functions(kmax) {
        let exact = direct_gradient(&c, points).unwrap();
        let size = Size::of_real(&c);
        for &epsilon in epsilons {
            let name = format!("{name}, kmax {kmax}");
            let plan = TorusTransform::new(kmax, epsilon).unwrap();
            plan.evaluate_into(&c, points, &mut workspace, &mut values).unwrap();
            let pairs = values.iter().zip(&exact).map(|(f, [e, ..])| (real(*f), real(*e)));
            size.assert_near(&name, epsilon, 1.0, pairs);
            plan.gradient_into(&c, points, &mut workspace, &mut gradients).unwrap();
            for (i, factor) in gradient_factors(kmax, epsilon).into_iter().enumerate() {
                let pairs = gradients.iter().zip(&exact).map(|(f, e)| (real(f[i]), real(e[i])));
                size.assert_near(&format!("{name}, part {i}"), epsilon, factor, pairs);
            }
        }
    }
}

#[test]
fn values_and_derivatives_meet_the_requested_accuracy() {
    for kmax in [0, 1, 2, 7, 20] {
        check(kmax, &EPSILONS, &points());
    }
}

#[test]
fn values_and_derivatives_meet_the_requested_accuracy_for_many_frequencies() {
    for kmax in [100, 255] {
        check(kmax, &[1e-1, 1e-5, 5e-6, 1e-10, 1e-13], &points()[30..40]);
    }
}

#[test]
fn no_points_have_no_values() {
    let plan = TorusTransform::new(3, 1e-3).unwrap();
    let c = TorusCoefficients::<f64>::zeros(3).unwrap();
    assert_eq!(plan.evaluate(&c, &[]), Ok(vec![]));
    assert_eq!(plan.gradient(&c, &[]), Ok(vec![]));
    assert_eq!(
        plan.evaluate_batch_into(&[], &[[0.5; 2]], &mut TorusWorkspace::default(), &mut []),
        Ok(())
    );
}

/// `cos(2 pi (3 u - 2 v) + 1)` and its derivatives.
#[test]
fn a_wave_has_its_closed_form() {
    let mut c = TorusCoefficients::zeros(4).unwrap();
    // c(-3, 2) is that of the wave with opposite phase.
    c.values_mut()[5 + 2] = Complex::from_polar(0.5, -1.0);
    let points = points();
    let fast = TorusTransform::new(4, 1e-12).unwrap().gradient(&c, &points).unwrap();
    let slow = direct_gradient(&c, &points).unwrap();
    for (j, [u, v]) in points.iter().enumerate() {
        let angle = TAU * (3.0 * u - 2.0 * v) + 1.0;
        let slope = -TAU * angle.sin();
        let expected = [angle.cos(), 3.0 * slope, -2.0 * slope];
        for i in 0..3 {
            // The angle is up to 33 and rounded by 2^-48; derivatives multiply it by 6 pi.
            assert!((slow[j][i] - expected[i]).abs() < 20.0 * 1e-14, "{slow:?}, {expected:?}");
            assert!((fast[j][i] - expected[i]).abs() < TAU * 5.0 * 1e-12, "{fast:?}");
        }
    }
}

#[test]
fn functions_of_a_batch_have_the_values_of_single_calls() {
    let (kmax, points) = (20, points());
    let functions = functions(kmax);
    let mut workspace = TorusWorkspace::default();
    for epsilon in [1e-4, 1e-10] {
        let plan = TorusTransform::new(kmax, epsilon).unwrap();
        for n in 1..=functions.len() {
            let batch: Vec<_> = functions[..n].iter().map(|(_, c)| c).collect();
            let mut values = vec![0.0; n * points.len()];
            plan.evaluate_batch_into(&batch, &points, &mut workspace, &mut values).unwrap();
            for (b, c) in batch.iter().enumerate() {
                let alone = plan.evaluate(c, &points).unwrap();
                let of_batch: Vec<f64> = values[b..].iter().step_by(n).copied().collect();
                assert_eq!(of_batch, alone, "function {b} of {n}, {epsilon:e}");
            }
        }
    }
}

#[test]
fn the_value_is_the_real_part_of_the_series() {
    // Without its conjugate, c(-1, 0) = 1 is half of cos(2 pi u).
    let mut c = TorusCoefficients::zeros(1).unwrap();
    c.values_mut()[0] = real(1.0);
    let points = [[0.0, 0.1], [0.25, 0.3], [0.5, 0.9]];
    let fast = TorusTransform::new(1, 1e-12).unwrap().evaluate(&c, &points).unwrap();
    let slow = direct_evaluate(&c, &points).unwrap();
    for ((fast, slow), expected) in fast.iter().zip(&slow).zip([1.0, 0.0, -1.0]) {
        assert!(
            (fast - expected).abs() < 1e-12 && (slow - expected).abs() < 1e-15,
            "{fast}, {slow}"
        );
    }
}
