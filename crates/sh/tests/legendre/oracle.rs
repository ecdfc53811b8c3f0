//! A slow second way: the three-term recurrence with `cos theta`, in double-double arithmetic.

use core::f64::consts::PI;

use proptest::prelude::*;

use crate::{double_double::DoubleDouble, reference::compare};

/// `4 pi` to 30 digits, as text so that both parts are right.
const FOUR_PI: &str = "12.5663706143591729538505735331";

fn number(x: usize) -> DoubleDouble {
    DoubleDouble::from(x as f64)
}

/// `lambda_lm(theta)`; loses a factor of about `l / sin theta` of its 31 digits.
fn lambda_three_term(l: usize, m: usize, theta: f64) -> DoubleDouble {
    let (sin, x) = DoubleDouble::sin_cos(theta);
    let mut squared = DoubleDouble::from(1.0).over(DoubleDouble::parse(FOUR_PI));
    for k in 1..=m {
        squared = (squared * number(2 * k + 1)).over(number(2 * k));
    }
    let sectoral = squared.sqrt() * sin.power(m as u64);
    let mut current = if m % 2 == 1 { -sectoral } else { sectoral };
    let mut previous = DoubleDouble::ZERO;
    let coupling = |k: usize| number(k * k - m * m).over(number(4 * k * k - 1)).sqrt();
    for k in m..l {
        let back = if k > m { coupling(k) * previous } else { DoubleDouble::ZERO };
        let next = (x * current - back).over(coupling(k + 1));
        (previous, current) = (current, next);
    }
    current
}

#[test]
fn the_oracle_itself_on_closed_forms() {
    // lambda_53 = -sqrt(385/(1024 pi)) sin^3 (9 cos^2 - 1), in f64 from the same angle.
    for theta in [0.1_f64, 1.0, 2.0, 3.0] {
        let (s, x) = theta.sin_cos();
        let exact = -(385.0 / (1024.0 * PI)).sqrt() * s.powi(3) * (9.0 * x * x - 1.0);
        let got = lambda_three_term(5, 3, theta).scaled().value();
        assert!(
            (got - exact).abs() < 8.0 * f64::EPSILON * s.powi(3),
            "theta = {theta}: {got} {exact}"
        );
    }
    // 30 digits of the double-double layer: sin^2 + cos^2 = 1, sqrt and quotient invert products.
    let (s, c) = DoubleDouble::sin_cos(2.5);
    for (name, one) in [
        ("sine and cosine", s * s + c * c),
        ("quotient", (s * c).over(s * c)),
        ("root", (s * s).sqrt().over(s)),
        (
            "decimal",
            DoubleDouble::parse("1.5e-4000")
                * DoubleDouble::parse("6666666666666666666666666666.66e3972"),
        ),
    ] {
        let rest = one - DoubleDouble::from(1.0);
        assert!(rest.hi == 0.0 || rest.exponent < -90, "{name}: {rest:?}");
    }
}

fn colatitude() -> impl Strategy<Value = f64> {
    // Below 1e-4 from a pole the oracle runs out of digits; the table covers that.
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
        prop_assert!(row.of_promise <= 1.0, "{row}");
    }
}
