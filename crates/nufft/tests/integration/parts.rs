//! The stages between points and grid, and their arithmetic.

use std::f64::consts::PI;
use std::num::NonZeroUsize;

use gauss_quad::GaussLegendre;
use num_complex::Complex;
use sphvar_nufft::Error;
use sphvar_nufft::parts::{
    Window, add_with_rests, good_size, interpolate, magnitude, magnitude_of, magnitude_of_complex,
    resize, sum_of_sizes,
};

#[test]
fn a_polynomial_is_its_own_interpolant() {
    // Rounding of sums of eight numbers below 5, times coefficients of T_7, which are below
    // 120.
    let coefficients = interpolate(|t| 3.0 * t.powi(5) - t.powi(2) + 0.25, 7);
    for (got, expected) in coefficients.iter().zip([0.0, 0.0, 3.0, 0.0, 0.0, -1.0, 0.0, 0.25]) {
        assert!((got - expected).abs() < 8.0 * 5.0 * 120.0 * f64::EPSILON, "{coefficients:?}");
    }
}

#[test]
fn sizes_are_smooth_and_near() {
    for min in 4..3000_u32 {
        for slack in [1.0, 1.04, 1.15] {
            let n = good_size(f64::from(min), slack);
            assert!(n >= min as usize && n.is_multiple_of(4), "{min}: {n}");
            let smooth = [2, 3, 5, 7].into_iter().fold(n, |mut rest, p| {
                while rest.is_multiple_of(p) {
                    rest /= p;
                }
                rest
            });
            assert_eq!(smooth, 1, "{min}: {n}");
            // From 16 on, smooth multiples of 4 differ by less than a fifth.
            assert!(n as f64 <= 1.2 * f64::from(min) + 12.0, "{min}: {n}");
        }
    }
}

#[test]
fn the_rest_accumulates_rounding_errors() {
    let (mut sums, mut rests) = ([1.0, 0.0], [0.0; 2]);
    for _ in 0..1000 {
        add_with_rests(&mut sums, &mut rests, &[2f64.powi(-60), 0.5]);
    }
    let bits = |numbers: [f64; 2]| numbers.map(f64::to_bits);
    assert_eq!(bits(sums), bits([1.0, 500.0]), "{sums:?}");
    assert_eq!(bits(rests), bits([1000.0 * 2f64.powi(-60), 0.0]), "{rests:?}");
}

#[test]
fn a_failed_allocation_is_an_error() {
    let mut values = vec![1_u16; 3];
    resize(&mut values, 5).unwrap();
    assert_eq!(values, [1, 1, 1, 0, 0]);
    let error = resize(&mut values, usize::MAX).unwrap_err();
    assert_eq!(error, Error::OutOfMemory { len: usize::MAX, bytes_each: 2 });
    assert_eq!(values.len(), 5);
}

#[test]
fn lists_have_the_same_magnitude_and_their_sum() {
    let numbers: Vec<f64> = (0..100).map(|i| f64::from((i * 37) % 101) - 50.0).collect();
    for n in 0..=100 {
        let some = &numbers[..n];
        let expected = magnitude(some.iter().copied());
        assert_eq!(magnitude_of(some).to_bits(), expected.to_bits(), "{n}");
        let complex: Vec<_> = some.iter().map(|x| Complex::new(0.5, *x)).collect();
        let expected = magnitude(some.iter().copied().chain((n > 0).then_some(0.5)));
        assert_eq!(magnitude_of_complex(&complex).to_bits(), expected.to_bits(), "{n}");
        // Integers, whose sums are exact.
        let sum = some.iter().fold(0.0, |sum: f64, x| sum + x.abs());
        assert_eq!(sum_of_sizes(some).to_bits(), sum.to_bits(), "{n}");
    }
}

#[test]
fn it_is_the_largest_power_of_two_up_to_the_maximum() {
    for (numbers, expected) in [
        (vec![], 1.0),
        (vec![0.0, -0.0], 1.0),
        (vec![-3.0, 2.0], 2.0),
        (vec![0.75], 0.5),
        (vec![5e-324], f64::MIN_POSITIVE),
        (vec![f64::MAX], 2f64.powi(1023)),
        (vec![f64::INFINITY, 3.0], 1.0),
        (vec![f64::NAN, 3.0], 2.0),
    ] {
        let got = magnitude(numbers.iter().copied());
        assert!(got.to_bits() == f64::to_bits(expected), "{numbers:?}: {got:e}");
    }
}

#[test]
fn polynomials_approximate_the_window() {
    for (epsilon, oversampling) in [(1e-3, 1.25), (1e-5, 1.5), (1e-9, 2.0), (1e-13, 2.0)] {
        let window = Window::new(epsilon, oversampling);
        let table = window.table::<f64>();
        for k in 0..1000 {
            let t = f64::from(k) / 499.5 - 1.0;
            let pair = [t, -t];
            let [values, mirrored]: [Vec<f64>; 2] = match table.padded() {
                8 => table.evaluate::<8, 4, true>(pair).map(Vec::from),
                12 => table.evaluate::<12, 6, true>(pair).map(Vec::from),
                16 => table.evaluate::<16, 8, true>(pair).map(Vec::from),
                other => panic!("width {other}"),
            };
            let (width, pad) = (window.width(), table.pad());
            for (i, v) in values.iter().enumerate() {
                let x = 0.5 * (width as f64 - 1.0 + t) - (i as f64 - pad as f64);
                let is_inside = (pad..pad + width).contains(&i);
                let expected = if is_inside { window.value(x) } else { 0.0 };
                let off = (v - expected).abs();
                assert!(off < 0.1 * epsilon + 1e-14, "t = {t}, cell {i}: {v} and {expected}");
            }
            for (v, m) in values.iter().zip(mirrored.iter().rev()) {
                assert!((v - m).abs() < 0.2 * epsilon + 1e-14, "the window is even");
            }
        }
    }
}

/// Reference: a Gauss rule with more nodes, each cosine by itself. The orders end where those of a
/// transform with this oversampling do.
#[test]
fn transforms_of_windows_are_those_of_their_values() {
    const CELLS: usize = 1000;
    let rule = GaussLegendre::new(NonZeroUsize::MIN.saturating_add(200));
    for (epsilon, oversampling, last) in
        [(1e-1, 2.0, 250), (1e-5, 1.25, 400), (1e-9, 1.5, 333), (1e-13, 1.55, 322)]
    {
        let window = Window::new(epsilon, oversampling);
        let half = 0.5 * window.width() as f64;
        let transform = window.transform(CELLS, last);
        for m in [0, 1, 31, 32, 33, 63, 100, last - 1, last] {
            let node = |(x, w): &(f64, f64)| {
                let (s, c) = (0.5 * PI * x).sin_cos();
                let phase = 2.0 * PI * m as f64 / CELLS as f64 * half * s;
                w * window.value(half * s) * phase.cos() * half * c
            };
            let expected = 0.5 * PI * rule.iter().map(node).sum::<f64>();
            let error = (transform[m] - expected).abs();
            // The nodes and weights of both rules are rounded too.
            let tolerance = 20.0 * f64::EPSILON + 1e-6 * epsilon;
            assert!(
                error < tolerance * transform[0],
                "{epsilon:e}, order {m}: {}, {expected}",
                transform[m]
            );
        }
    }
}
