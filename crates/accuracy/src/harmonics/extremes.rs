use std::f64::consts::PI;

use crate::reference::{AcuteAngle, DoubleDouble, LegendreColumn, lambda as exact_lambda};
use glam::DVec3;
use sphvar_sh::{Colatitude, LegendrePlan, Scaled, lambda, lambda_scaled};

use crate::{Errors, HardCase};

/// Distances from a pole in radians.
const SMALL: [f64; 7] = [1e-300, 1e-200, 1e-100, 1e-30, 1e-16, 1e-8, 1e-3];
/// Degrees tested at the distances from a pole.
const DEGREES: [usize; 6] = [1, 2, 10, 200, 2000, 20000];
/// Generic colatitudes for high degrees, in radians.
const ORDINARY: [f64; 7] = [0.03, 0.3, 0.9, 1.5, PI / 2.0, 2.2, 3.0];
/// High degrees.
const HIGH: [usize; 3] = [5000, 12345, 20000];

/// The largest degree.
const LMAX: usize = 20000;

const LEGENDRE: &str = "lambda_lm with a separate exponent; error relative to the local amplitude, in units of EPSILON (l + 1)";

const ONE_PER_STEP: &str = "the sine, accurate to half an EPSILON, enters m times, its power rounds m times and the recurrence in each of l - m steps, all by about half an EPSILON: l + 1 times EPSILON if all have the same sign";

/// Returns the hard cases of this area.
pub(crate) fn hard_cases() -> Vec<HardCase> {
    let legendre = |name, measure| HardCase {
        name,
        what: LEGENDRE,
        bound: 1.0,
        reason: ONE_PER_STEP,
        measure,
    };
    vec![
        legendre("colatitudes_down_to_1e_minus_300", near_the_north_pole),
        legendre("colatitudes_up_to_pi_minus_1e_minus_300", near_the_south_pole),
        legendre("degrees_to_20000_with_orders_near_0", || high_degrees(|_| vec![0, 1, 2, 3])),
        legendre("degrees_to_20000_with_orders_near_half", || {
            high_degrees(|l| vec![l / 2 - 1, l / 2, l / 2 + 1])
        }),
        legendre("degrees_to_20000_with_orders_near_the_degree", || {
            high_degrees(|l| vec![l - 3, l - 2, l - 1, l])
        }),
        legendre("degrees_to_20000_at_zeros_near_a_pole", zeros_near_a_pole),
        HardCase {
            name: "values_under_the_f64_range",
            what: "lambda_lm as f64; error relative to the local amplitude or to 2^-1022, in units of EPSILON (l + 1)",
            bound: 1.0,
            reason: ONE_PER_STEP,
            measure: under_the_range,
        },
        HardCase {
            name: "numbers_over_and_under_the_f64_range",
            what: "powers with a separate exponent; relative error in units of EPSILON n",
            bound: 0.5,
            reason: "n - 1 products round by half an EPSILON each",
            measure: scaled_powers,
        },
    ]
}

/// Adds the error of a value in units of EPSILON (l + 1) of its amplitude.
fn push(errors: &mut Errors, l: usize, error: f64, name: impl FnOnce() -> String) {
    errors.push(error / (f64::EPSILON * (l as f64 + 1.0)), name);
}

/// Adds the error of `lambda_lm` at a point given in the representations of both implementations.
fn compare(errors: &mut Errors, l: usize, m: usize, place: (Colatitude, AcuteAngle), name: &str) {
    let got = lambda_scaled(l, m, place.0);
    let exact = exact_lambda(l as u64, m as u64, place.1);
    push(errors, l, exact.error(number(got)), || format!("l = {l}, m = {m}, {name}"));
}

/// Returns a colatitude in `[0, PI]` in the representations of both implementations.
fn at(theta: f64) -> (Colatitude, AcuteAngle) {
    (Colatitude::from_theta(theta).expect("a colatitude"), AcuteAngle::from_theta(theta))
}

fn number(x: Scaled) -> DoubleDouble {
    DoubleDouble::scaled(x.mantissa, x.exponent)
}

/// Returns the orders for which `lambda_lm` is compared near a pole.
fn few_orders(l: usize) -> Vec<usize> {
    let mut orders = vec![0, 1, 2, l / 2, l];
    orders.retain(|&m| m <= l);
    orders.dedup();
    orders
}

fn near_the_north_pole() -> Errors {
    let mut errors = Errors::default();
    for theta in SMALL {
        let place = at(theta);
        for l in DEGREES {
            for m in few_orders(l) {
                compare(&mut errors, l, m, place, &format!("theta = {theta:e}"));
            }
        }
    }
    errors
}

/// Returns the `f64` nearest to `pi - 1e-300` is `PI`, which is 1.2e-16 from the pole; smaller
/// distances require a direction.
fn near_the_south_pole() -> Errors {
    let mut errors = Errors::default();
    for small in SMALL {
        let dir = DVec3::new(small.sin(), 0.0, -small.cos());
        let of_dir = (Colatitude::from_direction(dir), AcuteAngle::from_direction(dir.to_array()));
        let of_theta = at(PI - small);
        for l in DEGREES {
            for m in few_orders(l) {
                compare(&mut errors, l, m, of_dir, &format!("direction {small:e} from -z"));
                compare(&mut errors, l, m, of_theta, &format!("theta = pi - {small:e}, rounded"));
            }
        }
    }
    errors
}

/// High degrees at generic colatitudes and at the turning point, where oscillation begins.
fn high_degrees(orders: fn(usize) -> Vec<usize>) -> Errors {
    let mut errors = Errors::default();
    for l in HIGH {
        for m in orders(l) {
            let turning = (m as f64 / (l as f64 + 0.5)).asin();
            for theta in ORDINARY.into_iter().chain([turning, 0.999 * turning, PI - turning]) {
                compare(&mut errors, l, m, at(theta), &format!("theta = {theta:?}"));
            }
        }
    }
    errors
}

/// Near a pole neighbouring degrees have nearly the same zeros, so the amplitude follows from the
/// slope only.
///
/// There `lambda_lm` is nearly proportional to the Bessel function `J_m((l + 1/2) theta)`; whole
/// columns cross its zeros.
fn zeros_near_a_pole() -> Errors {
    /// The first two zeros of `J_0`, `J_1` and `J_2`, Abramowitz and Stegun, table 9.5.
    const ZEROS: [(usize, [f64; 2]); 3] = [
        (0, [2.404825557695773, 5.520078110286311]),
        (1, [3.831705970207512, 7.015586669815619]),
        (2, [5.135622301840683, 8.417244140399864]),
    ];
    let mut errors = Errors::default();
    let plan = LegendrePlan::new(LMAX).expect("a degree in range");
    let mut column = vec![0.0; LMAX + 1];
    for (m, zeros) in ZEROS {
        let at_zeros = zeros.map(|zero| zero / (LMAX as f64 + 0.5));
        for theta in at_zeros.into_iter().chain([1e-3, 1e-2, PI - 1e-3]) {
            let (colatitude, angle) = at(theta);
            let column = &mut column[m..];
            plan.column_into(m, colatitude, column);
            let exact = LegendreColumn::new(m as u64, angle);
            for ((l, exact), &got) in (m..).zip(exact).zip(&*column) {
                push(&mut errors, l, exact.error_in_f64(got), || {
                    format!("l = {l}, m = {m}, theta = {theta:?}")
                });
            }
        }
    }
    errors
}

/// Columns that start far below the range of `f64` and rise into it, and single values at its lower
/// end.
fn under_the_range() -> Errors {
    let mut errors = Errors::default();
    let plan = LegendrePlan::new(LMAX).expect("a degree in range");
    for (m, theta) in
        [(200, 0.02), (1000, 0.3), (1900, 0.9), (1500, 2.8), (5000, 0.2), (10000, 0.5)]
    {
        let (colatitude, angle) = at(theta);
        let mut column = vec![0.0; LMAX + 1 - m];
        plan.column_into(m, colatitude, &mut column);
        let exact = LegendreColumn::new(m as u64, angle);
        for ((l, exact), got) in (m..).zip(exact).zip(column) {
            push(&mut errors, l, exact.error_in_f64(got), || {
                format!("column l = {l}, m = {m}, theta = {theta:?}")
            });
        }
    }
    // The angle whose sine has the 20000th power 1e-309.
    let high = 10.0_f64.powf(-309.0 / 20000.0).asin();
    for (l, m, theta) in [(1, 1, 1e-310), (2, 2, 1e-155), (5, 2, 3e-157), (20000, 20000, high)] {
        let (colatitude, angle) = at(theta);
        let exact = exact_lambda(l as u64, m as u64, angle);
        push(&mut errors, l, exact.error_in_f64(lambda(l, m, colatitude)), || {
            format!("single l = {l}, m = {m}, theta = {theta:e}")
        });
    }
    errors
}

fn scaled_powers() -> Errors {
    let mut errors = Errors::default();
    // Squares at both ends of the range: 2^-1074, the smallest number, and 2^-1076; 2^1023.8 and
    // 2^1024.
    let at_the_ends = [-537.0, -538.0, 511.9, 512.0].map(f64::exp2);
    for n in [1_usize, 2, 3, 100, 20000] {
        let ordinary = [1e300, 1e-300, 5e-324, f64::MAX, 1.0 + 1e-3, 0.999];
        for x in ordinary.into_iter().chain(at_the_ends) {
            let power = Scaled::new(x, 0).power(n);
            let exact = DoubleDouble::from(x).power(n as u64);
            let error = ((number(power) - exact) / exact).value();
            errors.push(error / (f64::EPSILON * n as f64), || format!("{x:e}^{n}"));
            // Values outside the range of f64, and only those, become infinite or 0.
            let (value, expected) = (power.value(), exact.value());
            let same = value.total_cmp(&expected).is_eq()
                || ((value - expected) / expected).abs() <= n as f64 * f64::EPSILON;
            errors.push(if same { 0.0 } else { f64::INFINITY }, || format!("{x:e}^{n} as f64"));
        }
    }
    errors
}
