//! The accuracy of the double-double arithmetic, by identities and against the table.

use std::f64::consts::{FRAC_PI_2, PI};

use sphvar_accuracy::reference::{AcuteAngle, DoubleDouble, LegendreTable, lambda};

fn dd(x: f64) -> DoubleDouble {
    DoubleDouble::from(x)
}

#[track_caller]
fn assert_near(got: DoubleDouble, exact: DoubleDouble, relative: f64, name: &str) {
    let error = ((got - exact) / exact).value().abs();
    // Written so that NaN fails.
    assert!(error <= relative, "{name}: {error:e}");
}

#[test]
fn identities_of_the_arithmetic() {
    let (s, c) = dd(2.5).sin_cos();
    // Several operations of 16 UNIT^2 = 2e-31 each.
    let eight = 1.6e-30;
    assert_near(s * s + c * c, DoubleDouble::ONE, eight, "sine and cosine");
    assert_near((s * c) / (s * c), DoubleDouble::ONE, eight, "quotient");
    assert_near((s * s).sqrt() / s, DoubleDouble::ONE, eight, "root");
    assert_near(s.power(10) / s.power(7), s * s * s, 2.0 * eight, "power");
    let product = DoubleDouble::parse("1.5e-4000").unwrap()
        * DoubleDouble::parse("6666666666666666666666666666.66e3972").unwrap();
    // The second factor is truncated after 30 digits; the powers of ten take 4000 factors.
    assert_near(product, DoubleDouble::ONE, 4000.0 * 2e-31, "decimal");
    let cancelled = (dd(1.0) + dd(1e-20)) - dd(1.0);
    // 1 + 1e-20 holds 1e-20 to 106 bits of 1: 1e-32.
    assert_near(cancelled, dd(1e-20), 1.3e-12, "difference");
}

#[test]
fn limits_of_the_range() {
    for x in [5e-324, -5e-324, f64::MIN_POSITIVE, f64::MAX, f64::MIN, 1.0, -0.75, 0.0, 2.5e-310] {
        assert_eq!(dd(x).value().to_bits(), x.to_bits(), "{x:e}");
    }
    assert!(dd(f64::NAN).value().is_nan());
    assert!((dd(f64::NAN) + dd(1.0)).value().is_nan());
    assert!((dd(1e300) + dd(f64::NAN) * dd(1e-300)).value().is_nan());
    assert!(dd(-1.0).sqrt().value().is_nan());
    assert!(dd(f64::INFINITY).value().is_infinite());
    let tiny = dd(1e-300).power(20000);
    assert_eq!(tiny.value().to_bits(), 0);
    assert_near(
        tiny * dd(1e300).power(20000),
        (dd(1e-300) * dd(1e300)).power(20000),
        8e-27,
        "range",
    );
    for wrong in [
        "",
        ".",
        "1e",
        "x",
        "1.2.3",
        ".-5",
        ".+5",
        "1e99999999999999999999",
        "1234567890123456789012345678901",
    ] {
        assert!(DoubleDouble::parse(wrong).is_none(), "{wrong:?}");
    }
    assert!(dd(1.0) < dd(1.0) + dd(1e-31));
    assert!(dd(-2.0) < dd(1e-300).power(1000));
}

#[test]
fn angles() {
    for angle in [1e-300, 1e-9, 0.3, 1.0, FRAC_PI_2, 2.0, 3.0, 3.2, 6.0, -2.5, -1e-20] {
        let (s, c) = dd(angle).sin_cos();
        let expected = if angle > PI {
            dd(angle) - (DoubleDouble::pi() + DoubleDouble::pi())
        } else {
            dd(angle)
        };
        // A reduction by 2 pi preserves 106 bits of 2 pi.
        assert_near(DoubleDouble::atan2(s, c), expected, 4e-31, &format!("angle {angle:e}"));
    }
    // Addition theorem with a reduced angle; the reduction loses 1e-32 times the angle.
    let (s, c) = dd(1000.0).sin_cos();
    let (s2, _) = dd(2000.0).sin_cos();
    assert_near(dd(2.0) * s * c, s2, 1e-28, "doubled angle");
    // Near pi the supplement keeps all digits: sin(pi - x) = sin x.
    for theta in [PI, PI.next_down(), 3.0, 1.6] {
        let north = DoubleDouble::supplement(theta).sin_cos().0;
        let own = dd(theta).sin_cos().0;
        let difference = (north - own).value().abs();
        assert!(difference < 1e-30, "theta = {theta}: {difference:e}");
    }
    // The first 20 digits of sin(PI), which are those of pi - PI, from Abramowitz and Stegun, table
    // 1.1.
    let lack = DoubleDouble::parse("1.2246467991473531772e-16").unwrap();
    assert_near(DoubleDouble::supplement(PI), lack, 1e-19, "pi");
}

/// Rows agree to the 25 digits of the table, relative to the value itself; in the oscillating
/// region, relative to the amplitude.
#[test]
fn recurrence_against_the_table() {
    let mut rows = 0;
    for row in LegendreTable::rows() {
        let angle = AcuteAngle::from_theta(row.theta);
        let error = lambda(row.l as u64, row.m as u64, angle).error(row.value).abs();
        assert!(error < 6e-25, "{row:?}: {error:e}");
        rows += 1;
    }
    assert_eq!(rows, 263, "the table is complete");
}

/// At the zero of `lambda_31 = -sqrt(21/(64 pi)) sin (5 cos^2 - 1)` the slope is
/// `10 sqrt(21/(64 pi)) cos sin^2`.
#[test]
fn the_amplitude_at_a_zero_follows_from_the_slope() {
    let (sin, cos) = (0.8_f64.sqrt(), 0.2_f64.sqrt());
    let at_zero = lambda(3, 1, AcuteAngle::from_direction([sin, 0.0, cos]));
    let slope = 10.0 * (21.0 / (64.0 * PI)).sqrt() * cos * sin * sin;
    // Sine and cosine are rounded, and the slope is the product of five numbers.
    let rounding = 8.0 * f64::EPSILON;
    assert!(at_zero.value.value().abs() < rounding, "{at_zero:?}");
    assert_near(at_zero.amplitude, dd(slope / 3.5), rounding, "amplitude");
    let at_pole = lambda(7, 0, AcuteAngle::from_theta(0.0));
    assert_near(at_pole.amplitude, at_pole.value, 0.0, "amplitude at the pole");
    assert!(lambda(2, 3, AcuteAngle::from_theta(1.0)).error(DoubleDouble::ONE).is_nan());
}

#[test]
fn both_angles_of_a_direction_agree() {
    for theta in [1e-300, 1e-20, 1e-3, 0.7, 1.5, 2.0, 3.1] {
        let a = AcuteAngle::from_theta(theta);
        // Not a unit vector: only the ratio matters.
        let b = AcuteAngle::from_direction([0.6 * theta.sin(), -0.8 * theta.sin(), theta.cos()]);
        // Sine and cosine are rounded to f64, the sine also multiplied.
        let bound = 4.0 * f64::EPSILON / theta.cos().abs();
        assert_near(b.sin, a.sin, bound, &format!("sine at {theta:e}"));
        assert_near(b.versine, a.versine, 2.0 * bound, &format!("versine at {theta:e}"));
        assert_eq!(a.south, b.south);
    }
}
