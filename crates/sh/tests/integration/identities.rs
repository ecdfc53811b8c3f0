//! Identities of the harmonics, consistency of the evaluation methods, and extreme inputs.

use core::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;
use num_complex::Complex;
use proptest::prelude::*;
use sphvar_sh::{
    Colatitude, Error, GaussLegendre, LegendrePlan, MAX_DEGREE, Recurrence, lambda, lambda_scaled,
    legendre_p, real_ylm, real_ylm_at, sectoral, ylm, ylm_at,
};

/// Returns the stated error of a value of order one.
fn stated_error(l: usize) -> f64 {
    4.0 * f64::EPSILON * (l as f64 + 1.0)
}

fn orders(l: usize) -> std::ops::RangeInclusive<i64> {
    let l = i64::try_from(l).unwrap();
    -l..=l
}

fn direction() -> impl Strategy<Value = DVec3> {
    let z = prop_oneof![-1.0..=1.0_f64, Just(0.0), Just(1.0), Just(-1.0), 1.0 - 1e-9..1.0_f64];
    (z, 0.0..TAU).prop_map(|(z, phi)| {
        let s = ((1.0 - z) * (1.0 + z)).sqrt();
        DVec3::new(s * phi.cos(), s * phi.sin(), z).normalize()
    })
}

fn colatitude() -> impl Strategy<Value = f64> {
    let tiny = (-300.0..-1.0_f64).prop_map(|e| 10_f64.powf(e));
    prop_oneof![
        0.0..=PI,
        tiny,
        (-15.0..-1.0_f64).prop_map(|e| PI - 10_f64.powf(e)),
        Just(FRAC_PI_2)
    ]
}

#[test]
fn orthonormal_in_colatitude_by_exact_quadrature() {
    const LMAX: usize = 64;
    let plan = LegendrePlan::new(LMAX).unwrap();
    let index = plan.index();
    // Products of two functions of equal m are polynomials of degree <= 128 in x: 65 nodes are
    // exact.
    let rule = GaussLegendre::new(LMAX + 1).unwrap();
    let columns: Vec<_> = rule
        .nodes()
        .iter()
        .map(|&x| {
            plan.eval(Colatitude::from_direction(DVec3::new(
                ((1.0 - x) * (1.0 + x)).sqrt(),
                0.0,
                x,
            )))
        })
        .collect();
    for m in 0..=LMAX {
        for l in m..=LMAX {
            for k in m..=l {
                let (a, b) = (index.at(l, m), index.at(k, m));
                let sum: f64 =
                    columns.iter().zip(rule.weights()).map(|(v, w)| w * v[a] * v[b]).sum();
                let expected = if l == k { 1.0 } else { 0.0 };
                // 65 values of order one, each with an error of at most stated_error(64) = 6e-14,
                // typically a tenth of it.
                assert!(
                    (TAU * sum - expected).abs() < 1e-13,
                    "l = {l}, k = {k}, m = {m}: {}",
                    TAU * sum
                );
            }
        }
    }
}

#[test]
fn complex_and_real_harmonics_are_orthonormal_on_the_sphere() {
    const LMAX: usize = 5;
    const LONGITUDES: u32 = 12; // more than 2 LMAX: exact in phi
    let rule = GaussLegendre::new(LMAX + 1).unwrap();
    let pairs: Vec<_> = (0..=LMAX).flat_map(|l| orders(l).map(move |m| (l, m))).collect();
    for (i, &(l, m)) in pairs.iter().enumerate() {
        for (j, &(k, n)) in pairs.iter().enumerate() {
            let (mut complex, mut real) = (Complex::ZERO, 0.0);
            for (&x, w) in rule.nodes().iter().zip(rule.weights()) {
                for step in 0..LONGITUDES {
                    let (theta, phi) =
                        (x.acos(), TAU * (f64::from(step) + 0.3) / f64::from(LONGITUDES));
                    let weight = w * TAU / f64::from(LONGITUDES);
                    complex += ylm(l, m, theta, phi).unwrap()
                        * ylm(k, n, theta, phi).unwrap().conj()
                        * weight;
                    real += real_ylm(l, m, theta, phi).unwrap()
                        * real_ylm(k, n, theta, phi).unwrap()
                        * weight;
                }
            }
            let expected = if i == j { 1.0 } else { 0.0 };
            // 72 terms of total size 1, each with an error of a few stated_error(5).
            let bound = 4.0 * stated_error(LMAX);
            assert!(
                (complex - expected).norm() < bound,
                "l = {l}, m = {m}, k = {k}, n = {n}: {complex}"
            );
            assert!((real - expected).abs() < bound, "l = {l}, m = {m}, k = {k}, n = {n}: {real}");
        }
    }
}

#[test]
fn closed_forms_fix_the_signs() {
    let (theta, phi) = (0.8_f64, 2.3_f64);
    let dir = DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
    let DVec3 { x, y, z } = dir;
    let root = |a: f64| (a / PI).sqrt();
    let complex = [
        (0, 0, Complex::new(root(0.25), 0.0)),
        (1, 0, Complex::new(root(0.75) * z, 0.0)),
        (1, 1, Complex::new(x, y) * -root(0.375)),
        (1, -1, Complex::new(x, -y) * root(0.375)),
        (2, 1, Complex::new(x, y) * z * -root(1.875)),
        (2, 2, Complex::new(x, y).powi(2) * root(0.46875)),
        (2, -2, Complex::new(x, -y).powi(2) * root(0.46875)),
    ];
    for (l, m, exact) in complex {
        for got in [ylm(l, m, theta, phi).unwrap(), ylm_at(l, m, dir).unwrap()] {
            assert!(
                (got - exact).norm() < stated_error(l),
                "l = {l}, m = {m}: {got} against {exact}"
            );
        }
    }
    let real = [
        (1, -1, -root(0.75) * y),
        (1, 0, root(0.75) * z),
        (1, 1, -root(0.75) * x),
        (2, -2, root(3.75) * x * y),
        (2, -1, -root(3.75) * y * z),
        (2, 2, root(0.9375) * (x * x - y * y)),
    ];
    for (l, m, exact) in real {
        for got in [real_ylm(l, m, theta, phi).unwrap(), real_ylm_at(l, m, dir).unwrap()] {
            assert!(
                (got - exact).abs() < stated_error(l),
                "l = {l}, m = {m}: {got} against {exact}"
            );
        }
    }
}

#[test]
fn addition_theorem_at_high_degree() {
    for l in [1000, 5000] {
        for theta in [1e-9, 1e-3, 0.7, FRAC_PI_2, 3.1] {
            let c = Colatitude::from_theta(theta).unwrap();
            let sum: f64 =
                (0..=l).map(|m| if m == 0 { 1.0 } else { 2.0 } * lambda(l, m, c).powi(2)).sum();
            let expected = (2.0 * l as f64 + 1.0) / (4.0 * PI);
            // Errors of the terms add up relative to the sum; a square doubles them.
            assert!(
                (sum / expected - 1.0).abs() < 2.0 * stated_error(l),
                "l = {l}, theta = {theta}: {sum}"
            );
        }
    }
}

/// Every value is finite and, up to rounding, within the bound of the addition theorem.
#[test]
#[expect(clippy::float_cmp, reason = "exact values")]
fn hostile_colatitudes() {
    let thetas = [
        0.0,
        5e-324,
        1e-300,
        1e-160,
        1e-15,
        FRAC_PI_2,
        FRAC_PI_2.next_up(),
        PI - 1e-15,
        PI.next_down(),
        PI,
    ];
    let pairs = [
        (0, 0),
        (1, 0),
        (1, 1),
        (2, 1),
        (300, 299),
        (20000, 0),
        (20000, 1),
        (20000, 10000),
        (20000, 19999),
    ];
    for theta in thetas {
        let c = Colatitude::from_theta(theta).unwrap();
        for (l, m) in pairs.into_iter().chain([(20000, 20000)]) {
            let value = lambda(l, m, c);
            let limit = ((2.0 * l as f64 + 1.0) / (4.0 * PI)).sqrt() * (1.0 + stated_error(l));
            assert!(value.abs() <= limit, "l = {l}, m = {m}, theta = {theta:e}: {value}");
            let exponent = lambda_scaled(l, m, c);
            assert!(
                m == 0 || theta == 0.0 || exponent.mantissa != 0.0,
                "l = {l}, m = {m}, theta = {theta:e}"
            );
            if theta == 0.0 && m > 0 {
                assert_eq!(value, 0.0, "l = {l}, m = {m}");
            }
            if m == 0 && (theta <= 1e-15 || theta >= PI - 1e-15) {
                let sign = if theta > 1.0 && l % 2 == 1 { -1.0 } else { 1.0 };
                let exact = sign * ((2.0 * l as f64 + 1.0) / (4.0 * PI)).sqrt();
                assert!(
                    (value - exact).abs() <= stated_error(l) * limit,
                    "l = {l}, theta = {theta:e}: {value}"
                );
            }
        }
    }
    let equator = Colatitude::from_theta(FRAC_PI_2).unwrap();
    assert_eq!(lambda(20000, 20000, equator), sectoral(20000), "sin = 1");
}

#[test]
fn longitude_is_irrelevant_at_the_poles() {
    for z in [
        DVec3::Z,
        DVec3::NEG_Z,
        DVec3::new(-0.0, 0.0, 1.0),
        DVec3::new(0.0, -0.0, -1.0),
        DVec3::new(5e-324, 0.0, 1.0),
    ] {
        for (l, m) in [(0, 0), (3, 0), (3, 1), (3, -1), (40, -40), (40, 39)] {
            let (y, r) = (ylm_at(l, m, z).unwrap(), real_ylm_at(l, m, z).unwrap());
            let exact = if m == 0 {
                z.z.powi(i32::try_from(l).unwrap()) * ((2.0 * l as f64 + 1.0) / (4.0 * PI)).sqrt()
            } else {
                0.0
            };
            assert!((y - exact).norm() <= stated_error(l), "l = {l}, m = {m}, {z}: {y}");
            assert!((r - exact).abs() <= stated_error(l), "l = {l}, m = {m}, {z}: {r}");
        }
    }
}

#[test]
fn invalid_input_is_an_error() {
    let nan = f64::NAN;
    assert!(matches!(ylm(3, 1, nan, 0.0), Err(Error::Colatitude { .. })));
    assert!(matches!(ylm(3, 1, -0.1, 0.0), Err(Error::Colatitude { .. })));
    for phi in [nan, f64::INFINITY] {
        assert!(matches!(ylm(3, 0, 1.0, phi), Err(Error::Longitude { .. })), "phi = {phi}");
        assert!(matches!(real_ylm(3, 0, 1.0, phi), Err(Error::Longitude { .. })), "phi = {phi}");
    }
    assert!(matches!(ylm(3, 2, 1.0, f64::MAX), Err(Error::Longitude { .. })));
    for m in [4, -4, i64::MIN, i64::MAX] {
        assert_eq!(ylm(3, m, 1.0, 0.0), Err(Error::Order { l: 3, m }));
        assert_eq!(real_ylm_at(3, m, DVec3::X), Err(Error::Order { l: 3, m }));
    }
    assert!(matches!(ylm(usize::MAX, 0, 1.0, 0.0), Err(Error::DegreeTooLarge { .. })));
    assert!(matches!(real_ylm(MAX_DEGREE + 1, 0, 1.0, 0.0), Err(Error::DegreeTooLarge { .. })));
    for dir in
        [DVec3::ZERO, DVec3::NAN, DVec3::splat(1.0), DVec3::INFINITY, DVec3::new(nan, 0.0, 1.0)]
    {
        assert!(matches!(ylm_at(2, 1, dir), Err(Error::Direction { .. })), "{dir}");
        assert!(matches!(real_ylm_at(2, 1, dir), Err(Error::Direction { .. })), "{dir}");
    }
    assert!(matches!(LegendrePlan::new(usize::MAX), Err(Error::DegreeTooLarge { .. })));
    // A large finite longitude is a valid angle.
    let y = ylm(7, 5, 1.0, 1e300).unwrap();
    let amplitude = lambda(7, 5, Colatitude::from_theta(1.0).unwrap()).abs();
    assert!((y.norm() / amplitude - 1.0).abs() < 8.0 * f64::EPSILON, "{y}");
}

/// Returns the value of each degree and colatitude that the visitor was called with, and checks
/// that it was called once for each, block by block.
fn visited(
    recurrence: &Recurrence,
    degrees: core::ops::RangeInclusive<usize>,
    colatitudes: &[Colatitude],
) -> Vec<Vec<f64>> {
    let mut rows = vec![Vec::new(); degrees.clone().count()];
    recurrence.for_each_block(degrees.clone(), colatitudes, |l, range, values| {
        let row = &mut rows[l - degrees.start()];
        assert_eq!(row.len(), range.start, "l = {l}");
        assert_eq!(range.len(), values.len(), "l = {l}");
        row.extend_from_slice(values);
    });
    rows
}

/// The reference is the column of each colatitude by itself.
#[test]
#[expect(clippy::float_cmp, reason = "the same operations")]
fn lists_of_colatitudes_are_bit_identical_to_single_ones() {
    let mut thetas = vec![
        0.0,
        5e-324,
        f64::MIN_POSITIVE,
        1e-300,
        1e-160,
        1e-154,
        1e-15,
        1e-8,
        1e-3,
        FRAC_PI_2.next_down(),
        FRAC_PI_2,
        FRAC_PI_2.next_up(),
        PI - 1e-15,
        PI.next_down(),
        PI,
    ];
    thetas.extend((1..85).map(|i| PI * (f64::from(i) / 85.0)));
    let colatitudes: Vec<_> =
        thetas.iter().map(|&theta| Colatitude::from_theta(theta).unwrap()).collect();
    let n = colatitudes.len();
    for (m, lmax) in [
        (0, 0),
        (0, 90),
        (1, 50),
        (7, 7),
        (15, 31),
        (16, 47),
        (300, 1000),
        (999, 1000),
        (5000, 7000),
        (20000, 20100),
        (MAX_DEGREE - 40, MAX_DEGREE),
    ] {
        let recurrence = Recurrence::new(m, lmax);
        let mut table = vec![f64::NAN; (lmax + 1 - m) * n];
        recurrence.table_into(&colatitudes, &mut table);
        let mut column = vec![f64::NAN; lmax + 1 - m];
        for (i, (&c, theta)) in colatitudes.iter().zip(&thetas).enumerate() {
            recurrence.column_into(c, &mut column);
            for (row, value) in column.iter().enumerate() {
                let got = table[row * n + i];
                assert_eq!(got, *value, "m = {m}, l = {}, theta = {theta:e}", m + row);
            }
        }
        let mut last = vec![f64::NAN; n];
        recurrence.degree_into(lmax, &colatitudes, &mut last);
        assert_eq!(last, table[(lmax - m) * n..], "m = {m}");
        // Ranges that start and end at odd and even degrees, within a span of steps and beyond it.
        for degrees in [m..=lmax, m..=m, lmax..=lmax, m + 1..=lmax, m + 18..=m + 23, m + 5..=m + 4]
        {
            if !degrees.is_empty() && *degrees.end() <= lmax {
                let rows = visited(&recurrence, degrees.clone(), &colatitudes);
                assert_eq!(rows.concat(), table[(degrees.start() - m) * n..][..rows.len() * n]);
            }
        }
    }
}

#[test]
fn colatitudes_that_are_not_a_number_affect_no_others() {
    let c = Colatitude::from_theta(1.0).unwrap();
    let mut list = vec![c; 50];
    list[3] = Colatitude::from_direction(DVec3::NAN);
    let mut values = vec![0.0; 50];
    Recurrence::new(30, 100).degree_into(100, &list, &mut values);
    let expected = lambda(100, 30, c).to_bits();
    assert!(values[3].is_nan());
    values.remove(3);
    assert!(values.iter().all(|value| value.to_bits() == expected));
}

#[test]
fn empty_lists_and_recurrences_have_no_values() {
    let c = Colatitude::from_theta(1.0).unwrap();
    let recurrence = Recurrence::new(3, 10);
    recurrence.table_into(&[], &mut []);
    recurrence.degree_into(10, &[], &mut []);
    Recurrence::new(3, 2).table_into(&[c], &mut []);
    Recurrence::default().table_into(&[c], &mut []);
    #[expect(clippy::reversed_empty_ranges, reason = "an empty range")]
    recurrence.for_each_block(5..=4, &[c], |_, _, _| panic!("called"));
}

#[test]
#[should_panic(expected = "degrees 3..=11 are not among the 8 of order 3 from 3 on")]
fn degrees_beyond_the_recurrence_panic() {
    let c = Colatitude::from_theta(1.0).unwrap();
    Recurrence::new(3, 10).for_each_block(3..=11, &[c], |_, _, _| {});
}

proptest! {
    #[test]
    #[expect(clippy::float_cmp, reason = "the same operations")]
    fn lists_of_any_length_are_bit_identical_to_single_values(
        thetas in prop::collection::vec(colatitude(), 0..110), m in 0..2000_usize, n in 0..40_usize,
    ) {
        let list: Vec<_> = thetas.iter().map(|&t| Colatitude::from_theta(t).unwrap()).collect();
        let mut values = vec![f64::NAN; list.len()];
        Recurrence::new(m, m + n).degree_into(m + n, &list, &mut values);
        for (i, (&c, value)) in list.iter().zip(values).enumerate() {
            prop_assert_eq!(value, lambda(m + n, m, c), "theta = {:e}, at {} of {}", thetas[i], i, list.len());
        }
    }

    #[test]
    fn addition_theorem_for_two_directions(a in direction(), b in direction(), l in 0..60_usize) {
        let sum: Complex<f64> =
            orders(l).map(|m| ylm_at(l, m, a).unwrap() * ylm_at(l, m, b).unwrap().conj()).sum();
        let cos = a.dot(b).clamp(-1.0, 1.0);
        let scale = (2.0 * l as f64 + 1.0) / (4.0 * PI);
        let expected = scale * legendre_p(l, cos).unwrap();
        // The factors of a product have the stated error plus 2 EPSILON m of the longitude; the few
        // roundings of the dot product are multiplied by the slope of P_l, at most l(l + 1)/2.
        let bound = scale * (6.0 * stated_error(l) + 2.0 * f64::EPSILON * (l * (l + 1)) as f64);
        prop_assert!((sum - expected).norm() <= bound, "l = {l}, a = {a}, b = {b}: {sum} against {expected}");
        let real: f64 = orders(l).map(|m| real_ylm_at(l, m, a).unwrap() * real_ylm_at(l, m, b).unwrap()).sum();
        prop_assert!((real - expected).abs() <= bound, "l = {l}, a = {a}, b = {b}: {real} against {expected}");
    }

    #[test]
    fn norm_over_orders(a in direction(), l in 0..400_usize) {
        let c = Colatitude::from_direction(a);
        let sum: f64 = (0..=l).map(|m| if m == 0 { 1.0 } else { 2.0 } * lambda(l, m, c).powi(2)).sum();
        let expected = (2.0 * l as f64 + 1.0) / (4.0 * PI);
        prop_assert!((sum / expected - 1.0).abs() <= 2.0 * stated_error(l), "l = {l}, a = {a}: {sum}");
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "the same operations")]
    fn mirror_and_point_parity(a in direction(), l in 0..100_usize, order in 0.0..=1.0_f64) {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a number in 0..=l")]
        let m = (order * l as f64) as usize;
        let mirrored = DVec3::new(a.x, a.y, -a.z);
        let sign = if (l + m).is_multiple_of(2) { 1.0 } else { -1.0 };
        let (up, down) = (Colatitude::from_direction(a), Colatitude::from_direction(mirrored));
        if a.z != 0.0 {
            // The same operations except for the sign.
            prop_assert_eq!(lambda(l, m, up), sign * lambda(l, m, down));
        }
        let point_sign = if l.is_multiple_of(2) { 1.0 } else { -1.0 };
        let m = i64::try_from(m).unwrap();
        let (here, there) = (ylm_at(l, m, a).unwrap(), ylm_at(l, m, -a).unwrap());
        let scale = ((2.0 * l as f64 + 1.0) / (4.0 * PI)).sqrt();
        prop_assert!((here - point_sign * there).norm() <= 2.0 * stated_error(l) * scale, "l = {l}, m = {m}, a = {a}");
        prop_assert_eq!(ylm_at(l, -m, a).unwrap(), here.conj() * if m % 2 == 0 { 1.0 } else { -1.0 });
    }

    #[test]
    fn real_harmonics_are_the_parts_of_the_complex_ones(
        l in 0..200_usize, order in 0.0..=1.0_f64, theta in colatitude(), phi in -10.0..10.0_f64,
    ) {
        #[expect(clippy::cast_possible_truncation, reason = "a number in 0..=l")]
        let m = (order * l as f64) as i64;
        let y = ylm(l, m, theta, phi).unwrap();
        let root = if m == 0 { 1.0 } else { 2_f64.sqrt() };
        // Below the normal range the last place is an absolute error.
        let bound = 4.0 * f64::EPSILON * y.norm() + f64::MIN_POSITIVE * f64::EPSILON * 4.0;
        prop_assert!((real_ylm(l, m, theta, phi).unwrap() - root * y.re).abs() <= bound, "{l} {m} {theta} {phi}");
        if m > 0 {
            prop_assert!((real_ylm(l, -m, theta, phi).unwrap() - root * y.im).abs() <= bound, "{l} {m} {theta} {phi}");
        }
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "the same operations")]
    fn plan_column_recurrence_and_single_value_are_bit_identical(theta in colatitude(), lmax in 0..90_usize) {
        let c = Colatitude::from_theta(theta).unwrap();
        let plan = LegendrePlan::new(lmax).unwrap();
        let index = plan.index();
        // Filled with NaN to verify that every entry is written.
        let mut all = vec![f64::NAN; index.len()];
        plan.eval_into(c, &mut all);
        let mut recurrence = Recurrence::default();
        for m in 0..=lmax {
            let mut column = vec![f64::NAN; lmax + 1 - m];
            plan.column_into(m, c, &mut column);
            prop_assert_eq!(&column[..], &all[index.column(m)], "theta = {:e}, m = {}", theta, m);
            column.fill(f64::NAN);
            recurrence.fill(m, lmax);
            recurrence.column_into(c, &mut column);
            prop_assert_eq!(&column[..], &all[index.column(m)], "theta = {:e}, m = {}", theta, m);
            for (l, value) in (m..).zip(&column) {
                prop_assert_eq!(*value, lambda(l, m, c), "theta = {:e}, l = {}, m = {}", theta, l, m);
            }
        }
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "the same operations")]
    fn long_columns_through_the_range_of_f64(theta in colatitude(), m in 0..3000_usize) {
        let c = Colatitude::from_theta(theta).unwrap();
        let mut column = vec![f64::NAN; 3001 - m];
        LegendrePlan::new(3000).unwrap().column_into(m, c, &mut column);
        for l in [m, (m + 3000) / 2, (m + 5 * 3000) / 6, 3000] {
            prop_assert_eq!(column[l - m], lambda(l, m, c), "theta = {:e}, l = {}, m = {}", theta, l, m);
        }
    }
}
