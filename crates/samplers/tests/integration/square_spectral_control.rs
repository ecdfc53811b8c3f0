//! Controlled spectra of the square: the power and the distances of sets, invalid parameters, small
//! numbers of points, and the contract of samplers.

use std::f64::consts::{PI, TAU};

use sphvar_samplers::{
    Error, NoiseColour, PowerProfile, Purpose, SquareSampler, SquareSpectralControl, Streams,
};

type Point = [f64; 2];

fn sample(control: &SquareSpectralControl, realization: u64) -> Result<Vec<Point>, Error> {
    let streams = Streams::new(20_261_130, Purpose::Pattern, control.n_points());
    Ok(control.sample(&mut streams.realization(realization))?.points)
}

/// Returns the frequencies of a half plane with `low < |k|^2 <= high`.
fn frequencies(low: u64, high: u64) -> Vec<Point> {
    let last = i32::try_from(high.isqrt()).unwrap();
    let half = (-last..=last).flat_map(|k1| (0..=last).map(move |k2| (k1, k2)));
    half.filter(|&(k1, k2)| k2 > 0 || k1 > 0)
        .filter(|&(k1, k2)| {
            (low + 1..=high).contains(&u64::from((k1 * k1 + k2 * k2).unsigned_abs()))
        })
        .map(|(k1, k2)| [f64::from(k1), f64::from(k2)])
        .collect()
}

/// The definition of a power.
fn power(points: &[Point], k: Point) -> f64 {
    let terms = points.iter().map(|p| (TAU * (k[0] * p[0] + k[1] * p[1])).sin_cos());
    let (sin, cos) = terms.fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
    (sin * sin + cos * cos) / points.len() as f64
}

/// Returns the smallest toroidal distance of two points.
fn separation(points: &[Point]) -> f64 {
    let apart = |p: Point, q: Point| {
        let d = [0, 1].map(|axis| {
            let d = (p[axis] - q[axis]).abs();
            d.min(1.0 - d)
        });
        d[0].hypot(d[1])
    };
    let pairs = points.iter().enumerate();
    pairs.flat_map(|(j, &p)| points[..j].iter().map(move |&q| apart(p, q))).fold(1.0, f64::min)
}

/// The tolerance of powers is 5e-21 by the transforms of the descent; by the definition, rounding
/// leaves about N 1e-32, and the accuracy 1e-10 of the transforms up to 1e-19.
#[test]
fn steps_have_no_power_up_to_alpha_and_keep_their_distance() {
    for (n, alpha) in [(40, None), (256, None), (256, Some(0.3)), (200, Some(0.7))] {
        for control in [
            SquareSpectralControl::step(n, alpha, None).unwrap(),
            SquareSpectralControl::blue(n, alpha).unwrap(),
        ] {
            let points = sample(&control, 0).unwrap();
            let last = control.last_empty_square();
            let alpha = alpha.unwrap_or(PI.sqrt().recip());
            assert!((last as f64 - alpha * alpha * n as f64).abs() <= 1.0, "{control:?}");
            for k in frequencies(0, last) {
                let power = power(&points, k);
                assert!(power < 1e-18, "N = {n}, k = {k:?}: {power:e}");
            }
            // The frequencies beyond have power: the zeros end where they should.
            let beyond = frequencies(last, last + 8);
            let mean = beyond.iter().map(|&k| power(&points, k)).sum::<f64>() / beyond.len() as f64;
            assert!(mean > 0.01, "N = {n}: {mean} beyond");
            // Relative overlaps fall to the square root of 5e-21 N.
            let (apart, sigma) = (separation(&points), control.core_distance());
            assert!(apart > sigma * (1.0 - 1e-8), "N = {n}: {apart} against {sigma}");
            assert!(points.iter().flatten().all(|x| (0.0..1.0).contains(x)));
        }
    }
}

/// Returns the mean power in the ring of |k| rounded to `radius`, of the frequencies with `low <
/// |k|^2`.
fn ring(points: &[Point], radius: u64, low: u64) -> f64 {
    // |k| < radius + 1/2 is |k|^2 <= radius^2 + radius in integers.
    let inner = (radius * radius - radius).max(low);
    let all = frequencies(inner, radius * radius + radius);
    all.iter().map(|&k| power(points, k)).sum::<f64>() / all.len() as f64
}

#[test]
fn rings_have_the_power_of_their_target() {
    let n = 256;
    let step = SquareSpectralControl::step(n, None, None).unwrap();
    // |k| from 9.0 to 18.05; the last ring is cut.
    let points = sample(&step, 1).unwrap();
    for radius in 9..18 {
        let power = ring(&points, radius, step.last_empty_square());
        assert!((power - 1.0).abs() < 1e-5, "step, {radius}: {power}");
    }
    let profile =
        PowerProfile::Polynomial { exponent: 2.0, alpha: 0.6, gamma: 0.9, offset: 0.1, to: 1.0 };
    let points = sample(&SquareSpectralControl::profile(n, &profile).unwrap(), 0).unwrap();
    for radius in 1..16_u64 {
        let all = frequencies(radius * radius - radius, radius * radius + radius);
        let of = |k: &Point| 0.1 + 0.9 * (k[0].hypot(k[1]) / 16.0 / 0.6).powi(2).min(1.0);
        let expected = all.iter().map(of).sum::<f64>() / all.len() as f64;
        let power = ring(&points, radius, 0);
        assert!((power - expected).abs() < 1e-5, "profile, {radius}: {power}, {expected}");
    }
    let table: Vec<f64> =
        (0..14).map(|k| if k < 5 { 0.0 } else { 0.2 + 0.05 * f64::from(k) }).collect();
    let profile = PowerProfile::Table { name: "table".into(), power: table.clone().into() };
    let points = sample(&SquareSpectralControl::profile(n, &profile).unwrap(), 0).unwrap();
    for radius in 1..13 {
        let power = ring(&points, radius, 0);
        let expected = table[usize::try_from(radius).unwrap()];
        assert!((power - expected).abs() < 1e-5, "table, {radius}: {power}, {expected}");
    }
}

/// Each colour in the units of the sphere: omega = sqrt(pi) |k|/sqrt(N), 1.1 of blue noise at |k| =
/// 11 for N = 314.
#[test]
fn colours_have_their_power() {
    for colour in NoiseColour::ALL {
        let profile = PowerProfile::Colour(colour);
        let points = sample(&SquareSpectralControl::profile(314, &profile).unwrap(), 0).unwrap();
        for radius in [1, 3, 6, 9, 14, 17] {
            let all = frequencies(radius * radius - radius, radius * radius + radius);
            let of = |k: &Point| colour.power(k[0].hypot(k[1]) * (PI / 314.0).sqrt());
            let expected = all.iter().map(of).sum::<f64>() / all.len() as f64;
            let power = ring(&points, radius, 0);
            assert!((power - expected).abs() < 1e-5, "{colour}, {radius}: {power}, {expected}");
        }
    }
}

/// Few points have too few degrees of freedom for blue noise, and the errors say what helps. The
/// pair correlation is stated only where it is impossible: it is positive here.
#[test]
fn blue_noise_of_few_points_needs_more() {
    let blue = PowerProfile::Colour(NoiseColour::Blue);
    for (n, cause) in [(1, "stalled"), (3, "cannot vanish"), (7, "stalled"), (9, "stalled")] {
        let error = SquareSpectralControl::profile(n, &blue)
            .and_then(|control| sample(&control, 0))
            .unwrap_err()
            .to_string();
        assert!(error.contains(cause) && error.contains("Use more points"), "{n}: {error}");
        assert!(!error.contains("correlation"), "{n}: {error}");
    }
    for n in [2, 4, 10, 14, 26] {
        let control = SquareSpectralControl::profile(n, &blue).unwrap();
        assert!(sample(&control, 0).is_ok(), "{n}");
    }
}

/// Returns the name of the rejected parameter.
fn rejected<T: std::fmt::Debug>(result: Result<T, Error>) -> &'static str {
    match result {
        Err(Error::Parameter { name, .. }) => name,
        other => panic!("not a rejected parameter: {other:?}"),
    }
}

#[test]
fn parameters_outside_their_range_are_rejected() {
    const COUNT: &str = "the number of points";
    for alpha in [f64::NAN, f64::INFINITY, -1e-9, 0.83, 1e300] {
        assert_eq!(rejected(SquareSpectralControl::step(100, Some(alpha), None)), "alpha");
        assert_eq!(rejected(SquareSpectralControl::blue(100, Some(alpha))), "alpha");
    }
    for flat in [f64::NAN, -1.0, 8.1] {
        assert_eq!(rejected(SquareSpectralControl::step(100, None, Some(flat))), "flat");
    }
    for core in [f64::NAN, -1e-9, 0.96] {
        let step = SquareSpectralControl::step(100, None, None).unwrap();
        assert_eq!(rejected(step.with_core(core)), "core");
    }
    let quadratic = PowerProfile::QUADRATIC;
    for n in [0, 1 << 32, usize::MAX] {
        assert_eq!(rejected(SquareSpectralControl::step(n, None, None)), COUNT, "{n}");
        assert_eq!(rejected(SquareSpectralControl::profile(n, &quadratic)), COUNT, "{n}");
        assert_eq!(rejected(SquareSpectralControl::max_alpha(n)), COUNT, "{n}");
    }
    for bad in [-1e-9, f64::NAN] {
        let table = PowerProfile::Table { name: "table".into(), power: vec![0.0, 1.0, bad].into() };
        assert_eq!(rejected(SquareSpectralControl::profile(50, &table)), "a target power");
    }
}

/// 200 points have 398 degrees of freedom, which allow 386 vanishing coefficients: |k|^2 to 124 has
/// 384 frequencies, 125 has 400. 100 points allow 192 of 198.
#[test]
fn more_zeros_than_degrees_of_freedom_are_infeasible() {
    let max = SquareSpectralControl::max_alpha(200).unwrap();
    let at_most = SquareSpectralControl::step(200, Some(max), None).unwrap();
    assert_eq!(at_most.last_empty_square(), 124);
    assert_eq!([124, 125].map(|last| 2 * frequencies(0, last).len()), [384, 400]);
    let beyond = SquareSpectralControl::step(200, Some(max + 1e-5), None).unwrap_err().to_string();
    for part in ["400", "398", &max.to_string()] {
        assert!(beyond.contains(part), "{beyond}");
    }
    let zeros = PowerProfile::Table { name: "zeros".into(), power: vec![0.0; 10].into() };
    let beyond = SquareSpectralControl::profile(100, &zeros).unwrap_err().to_string();
    assert!(beyond.contains("192") && beyond.contains("198"), "{beyond}");
}

#[test]
fn few_points_have_sets_with_the_default_parameters() {
    for n in 1..=40 {
        let quadratic = PowerProfile::Polynomial {
            exponent: 2.0,
            alpha: 0.564,
            gamma: 1.0,
            offset: 0.0,
            to: 1.128,
        };
        for (name, control) in [
            ("step", SquareSpectralControl::step(n, None, None)),
            ("bare step", SquareSpectralControl::step(n, None, Some(0.0))),
            ("blue", SquareSpectralControl::blue(n, None)),
            ("profile", SquareSpectralControl::profile(n, &quadratic)),
        ] {
            let points = control.and_then(|control| sample(&control, 0));
            match points {
                Ok(points) => assert_eq!(points.len(), n, "{name} of {n}"),
                Err(error) => panic!("{name} of {n}: {error}"),
            }
        }
    }
}
