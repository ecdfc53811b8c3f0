//! An independent slow reference: the three-term recurrence with `cos theta`, in double-double
//! arithmetic.

use core::f64::consts::PI;

use proptest::prelude::*;

use sphvar_accuracy::reference::DoubleDouble;

use crate::reference::compare;

fn number(x: usize) -> DoubleDouble {
    DoubleDouble::from(x as f64)
}

/// Returns `lambda_lm(theta)`; loses a factor of about `l / sin theta` of its 31 digits.
fn lambda_three_term(l: usize, m: usize, theta: f64) -> DoubleDouble {
    let (sin, x) = DoubleDouble::from(theta).sin_cos();
    let mut squared = DoubleDouble::ONE / (DoubleDouble::from(4.0) * DoubleDouble::pi());
    for k in 1..=m {
        squared = squared * number(2 * k + 1) / number(2 * k);
    }
    let sectoral = squared.sqrt() * sin.power(m as u64);
    let mut current = if m % 2 == 1 { -sectoral } else { sectoral };
    let mut previous = DoubleDouble::ZERO;
    let coupling = |k: usize| (number(k * k - m * m) / number(4 * k * k - 1)).sqrt();
    for k in m..l {
        let back = if k > m { coupling(k) * previous } else { DoubleDouble::ZERO };
        let next = (x * current - back) / coupling(k + 1);
        (previous, current) = (current, next);
    }
    current
}

#[test]
fn the_oracle_matches_closed_forms() {
    // lambda_53 = -sqrt(385/(1024 pi)) sin^3 (9 cos^2 - 1), in f64 from the same angle.
    for theta in [0.1_f64, 1.0, 2.0, 3.0] {
        let (s, x) = theta.sin_cos();
        let exact = -(385.0 / (1024.0 * PI)).sqrt() * s.powi(3) * (9.0 * x * x - 1.0);
        let got = lambda_three_term(5, 3, theta).value();
        assert!(
            (got - exact).abs() < 8.0 * f64::EPSILON * s.powi(3),
            "theta = {theta}: {got} {exact}"
        );
    }
}

fn colatitude() -> impl Strategy<Value = f64> {
    // Within 1e-4 of a pole this reference has too few digits; the table covers that range.
    let near_pole = (-4.0..-1.0_f64).prop_map(|e| 10_f64.powf(e));
    prop_oneof![
        0.1..PI - 0.1,
        near_pole.clone(),
        near_pole.prop_map(|t| PI - t),
        (-12.0..-1.0_f64).prop_map(|e| 0.5 * PI + 10_f64.powf(e)),
        Just(0.5 * PI),
    ]
}

fn degree_and_order() -> impl Strategy<Value = (usize, usize)> {
    prop_oneof![0..20_usize, 0..2000_usize].prop_flat_map(|l| {
        let order = prop_oneof![0..=l, 0..=l.min(3), l.saturating_sub(3)..=l];
        (Just(l), order)
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn random_values_against_the_oracle((l, m) in degree_and_order(), theta in colatitude()) {
        let row = compare(l, m, theta, lambda_three_term(l, m, theta));
        prop_assert!(row.of_bound <= 1.0, "{row}");
    }
}
