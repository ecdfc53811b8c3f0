//! Compares Legendre polynomials and Gauss-Legendre rules with 25-digit values.

use proptest::prelude::*;
use sphvar_sh::{Error, GaussLegendre, legendre_p, legendre_p_into};

/// Returns the rows of numbers of a table in `tests/data`.
fn rows(table: &str) -> impl Iterator<Item = [&str; 3]> {
    table.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_digit() || c == '-')).map(
        |line| {
            let fields: Vec<_> = line.split(',').collect();
            fields.try_into().unwrap()
        },
    )
}

#[test]
fn polynomials_against_the_table() {
    let mut count = 0;
    for [l, x, exact] in rows(include_str!("../data/legendre_p.csv")) {
        let (l, x, exact): (usize, f64, f64) =
            (l.parse().unwrap(), x.parse().unwrap(), exact.parse().unwrap());
        let got = legendre_p(l, x).unwrap();
        let below = legendre_p(l.saturating_sub(1), x).unwrap();
        let bound = 4.0 * f64::EPSILON * (l as f64 + 1.0) * exact.abs().max(below.abs());
        assert!(
            (got - exact).abs() <= bound,
            "l = {l}, x = {x:?}: {got} against {exact}, bound {bound:e}"
        );
        count += 1;
    }
    assert_eq!(count, 86, "the table is complete");
}

#[test]
#[expect(clippy::float_cmp, reason = "an untouched buffer")]
fn arguments_out_of_range_are_errors() {
    for x in [f64::NAN, 1.0_f64.next_up(), (-1.0_f64).next_down(), f64::INFINITY, f64::NEG_INFINITY]
    {
        assert!(matches!(legendre_p(3, x), Err(Error::Argument { .. })), "x = {x}");
        let mut out = [7.0; 3];
        assert!(matches!(legendre_p_into(x, &mut out), Err(Error::Argument { .. })), "x = {x}");
        assert_eq!(out, [7.0; 3], "x = {x}");
    }
    assert_eq!(legendre_p_into(0.5, &mut []), Ok(()));
}

#[test]
fn rules_against_the_table() {
    let mut rule = GaussLegendre::new(1).unwrap();
    let (mut count, mut from_top) = (0, 0);
    for [n, node, weight] in rows(include_str!("../data/gauss_legendre.csv")) {
        let (n, node, weight): (usize, f64, f64) =
            (n.parse().unwrap(), node.parse().unwrap(), weight.parse().unwrap());
        if n != rule.nodes().len() {
            rule = GaussLegendre::new(n).unwrap();
            from_top = 0;
        }
        // The table is in descending order, from the largest node to the middle one.
        let (upper, lower) = (n - 1 - from_top, from_top);
        for (k, sign) in [(upper, 1.0), (lower, -1.0)] {
            let (x, w) = (rule.nodes()[k], rule.weights()[k]);
            assert!((x - sign * node).abs() <= 1e-15, "n = {n}, k = {k}: node {x} against {node}");
            assert!((w - weight).abs() <= 1e-15, "n = {n}, k = {k}: weight {w} against {weight}");
            // A weight of order 1/n is also accurate relative to itself.
            assert!(
                (w / weight - 1.0).abs() <= 8.0 * f64::EPSILON,
                "n = {n}, k = {k}: weight {w} against {weight}"
            );
        }
        from_top += 1;
        count += 1;
    }
    assert_eq!(count, 612, "the table is complete");
}

#[test]
fn invalid_rules_are_errors() {
    for n in [0, GaussLegendre::MAX_NODES + 1, usize::MAX] {
        assert_eq!(
            GaussLegendre::new(n),
            Err(Error::NodeCount { n, max: GaussLegendre::MAX_NODES })
        );
    }
}

proptest! {
    #[test]
    #[expect(clippy::float_cmp, reason = "the same operations")]
    fn all_degrees_at_once_are_bit_identical(x in -1.0..=1.0_f64, n in 0..300_usize) {
        let mut out = vec![f64::NAN; n];
        legendre_p_into(x, &mut out).unwrap();
        for (l, value) in out.into_iter().enumerate() {
            prop_assert_eq!(value, legendre_p(l, x).unwrap(), "l = {}, x = {}", l, x);
        }
    }

    #[test]
    fn rules_are_exact_for_polynomials(n in 1..200_usize, a in -3.0..3.0_f64, length in 0.0..5.0_f64) {
        let rule = GaussLegendre::new(n).unwrap();
        prop_assert!(rule.nodes().is_sorted() && rule.weights().iter().all(|&w| w > 0.0), "n = {n}");
        // P_k integrates to 0 for 1 <= k <= 2n - 1, and P_n^2 to 2/(2n + 1) takes one more node.
        for k in [0, 1, n, 2 * n - 1] {
            let integral = rule.integrate(-1.0, 1.0, |x| legendre_p(k, x).unwrap());
            let exact = if k == 0 { 2.0 } else { 0.0 };
            let bound = 8.0 * f64::EPSILON * (k as f64 + 2.0);
            prop_assert!((integral - exact).abs() <= bound, "n = {n}, k = {k}: {integral}");
        }
        let b = a + length;
        let linear = rule.integrate(a, b, |x| 2.0 * x + 1.0);
        let exact = (b - a) * (b + a + 1.0);
        // n terms of size up to 7 times the length.
        let bound = 8.0 * f64::EPSILON * (n as f64 + 4.0) * (length + f64::EPSILON);
        prop_assert!((linear - exact).abs() <= bound, "n = {n}, a = {a}, b = {b}: {linear} against {exact}");
        let reversed = rule.integrate(b, a, |x| 2.0 * x + 1.0);
        prop_assert!((reversed + linear).abs() <= bound, "n = {n}, a = {a}, b = {b}: {reversed} against {linear}");
    }
}
