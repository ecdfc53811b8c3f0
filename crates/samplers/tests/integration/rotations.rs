//! Patterns of rotations: texts, sets and what defines each.

use std::collections::HashSet;

use glam::{DQuat, DVec3};
use sphvar_samplers::{
    Error, Purpose, RotationPattern, RotationRealizations, RotationSet, Streams, euler_zyz,
};

fn pattern(text: &str) -> RotationPattern {
    text.parse().unwrap()
}

fn set(text: &str, n: usize) -> RotationSet {
    let sampler = pattern(text).build(n).unwrap();
    sampler.sample(&mut Streams::new(0, Purpose::Pattern, 7).realization(0)).unwrap()
}

/// Patterns with all values of their choices.
const TEXTS: [&str; 8] = [
    "uniform",
    "super-fibonacci",
    "sukharev",
    "sukharev:spacing=equidistant",
    "sukharev:weights=cell",
    "sukharev:spacing=equidistant,weights=cell",
    "healpix-hopf",
    "healpix-hopf:order=layered",
];

#[test]
fn texts_and_facts() {
    for default in RotationPattern::ALL {
        assert_eq!(default.to_string(), default.name());
        assert!(TEXTS.contains(&default.name()), "{default}");
    }
    for text in TEXTS {
        let pattern = pattern(text);
        assert_eq!(pattern.to_string(), text);
        for requested in [1, 48, 600] {
            let n = pattern.nearest_count(requested);
            let sampler = pattern.build(n).unwrap();
            let groups: HashSet<usize> =
                TEXTS.iter().map(|text| self::pattern(text).stream_group(n)).collect();
            assert_eq!(groups.len(), TEXTS.len());
            assert_eq!(sampler.stream_group(), pattern.stream_group(n));
            let [first, second] = [0, 1].map(|i| {
                sampler.sample(&mut Streams::new(0, Purpose::Pattern, 7).realization(i)).unwrap()
            });
            assert_eq!(first.len(), n);
            assert!(first.points.iter().all(|q| (q.length() - 1.0).abs() < 1e-15));
            assert_eq!(first != second, sampler.is_random(), "{text}");
            assert_eq!(first.weights.is_empty(), !text.contains("weights=cell"), "{text}");
        }
        let (n, more) = (pattern.nearest_count(100), pattern.nearest_count(3000));
        let (small, large) = (set(text, n), set(text, more));
        let begins =
            large.points.starts_with(&small.points) && large.weights.starts_with(&small.weights);
        assert_eq!(pattern.facts().is_extensible, begins, "{text}");
        assert_eq!(pattern.build(0).unwrap_err(), Error::NoPoints { pattern: text.to_owned() });
        for n in [usize::MAX, 1 << 40, 72 * 400 * 400 * 400] {
            assert!(pattern.build(n).is_err(), "{text} {n}");
        }
    }
    let error = "super-fib".parse::<RotationPattern>().unwrap_err().to_string();
    assert!(error.contains("valid: uniform, super-fibonacci, sukharev, healpix-hopf"), "{error}");
    let error = pattern("healpix-hopf").build(73).unwrap_err().to_string();
    assert!(error.contains("N must be 72 nside^3 (72, 576, 1944, ...)"), "{error}");
}

/// Realization i is a uniform rotation times that of the ensemble without rotation; prefixes keep it.
#[test]
fn realizations_are_rotated_from_the_left() {
    let sampler = pattern("sukharev:weights=cell").build(50).unwrap();
    let fewer = pattern("sukharev:weights=cell").build(20).unwrap();
    let streams = Streams::new(3, Purpose::Pattern, 0);
    let ensemble = RotationRealizations::rotated(&*sampler, streams);
    let plain = RotationRealizations::unrotated(&*sampler, streams).realize(4).unwrap();
    let rotated = ensemble.realize(4).unwrap();
    let rotation = ensemble.rotation(4);
    for (p, q) in plain.points.iter().zip(&rotated.points) {
        assert!((rotation * *p).dot(*q) > 1.0 - 1e-15);
    }
    assert_eq!(plain.weights, rotated.weights);
    let prefix = RotationRealizations::rotated(&*fewer, streams).realize(4).unwrap();
    assert!(rotated.points.starts_with(&prefix.points));
    assert_ne!(rotated.points, ensemble.realize(5).unwrap().points);
}

/// The first super-Fibonacci rotations of 8, from the published algorithm in plain arithmetic.
#[test]
fn super_fibonacci_follows_the_publication() {
    let psi = 1.533_751_168_755_204_3_f64;
    assert!((psi.powi(4) - psi - 4.0).abs() < 1e-14);
    let points = set("super-fibonacci", 8).points;
    for (i, q) in (0..).zip(&points) {
        let s = f64::from(i) + 0.5;
        let (r, big_r) = ((s / 8.0).sqrt(), (1.0 - s / 8.0).sqrt());
        let (a, b) = (std::f64::consts::TAU * s / 2f64.sqrt(), std::f64::consts::TAU * s / psi);
        let expected = [r * a.sin(), r * a.cos(), big_r * b.sin(), big_r * b.cos()];
        for (got, expected) in [q.w, q.x, q.y, q.z].into_iter().zip(expected) {
            assert!((got - expected).abs() < 1e-14, "{i}: {got} and {expected}");
        }
    }
}

/// The images of z are the HEALPix centres, each with equally spaced twists.
#[test]
fn healpix_hopf_is_a_product() {
    for nside in [1, 2, 3] {
        let points = set("healpix-hopf", 72 * nside * nside * nside).points;
        let twists = 6 * nside;
        let directions: Vec<DVec3> = points.chunks(twists).map(|set| set[0] * DVec3::Z).collect();
        for (k, direction) in directions.iter().enumerate() {
            let apart = |other: &DVec3| direction.distance(*other) > 0.1 / nside as f64;
            assert!(directions[..k].iter().all(apart), "nside {nside}");
        }
        for (fibre, direction) in points.chunks(twists).zip(&directions) {
            for (k, q) in fibre.iter().enumerate() {
                assert!((*q * DVec3::Z).distance(*direction) < 1e-15);
                let step = DQuat::from_rotation_z(std::f64::consts::TAU * k as f64 / twists as f64);
                assert!((fibre[0] * step).dot(*q).abs() > 1.0 - 1e-14);
            }
        }
    }
    // Layered: the grids of nside 1, 2 and 4, in another order.
    let all = set("healpix-hopf:order=layered", 72 + 576 + 4608).points;
    let mut rest = &all[..];
    for n in [72, 576, 4608] {
        let (layer, others) = rest.split_at(n);
        rest = others;
        let grid = set("healpix-hopf", n).points;
        for q in layer.iter().step_by(n / 72) {
            assert!(grid.iter().any(|p| p.dot(*q).abs() > 1.0 - 1e-14), "{n}: {q}");
        }
        let rounded = |q: &DQuat| euler_zyz(*q).map(|angle| format!("{angle:.6}"));
        let distinct: HashSet<[String; 3]> = layer.iter().map(rounded).collect();
        assert_eq!(distinct.len(), n);
    }
}

/// Angles of uniform rotations have the density (1 - cos w)/pi: chi-square of 20 classes of equal
/// probability, 19 degrees of freedom, exceeds 50 for 1.3e-4 of seeds.
#[test]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "from 0 to the number of classes"
)]
fn uniform_rotations_have_haar_measure() {
    const CLASSES: usize = 20;
    let n = 20_000;
    let mut counts = [0.0; CLASSES];
    for q in set("uniform", n).points {
        let angle = 2.0 * q.w.abs().min(1.0).acos();
        let below = (angle - angle.sin()) / std::f64::consts::PI;
        counts[((below * CLASSES as f64) as usize).min(CLASSES - 1)] += 1.0;
    }
    let expected = n as f64 / CLASSES as f64;
    let chi2: f64 = counts.iter().map(|c| (c - expected).powi(2) / expected).sum();
    assert!(chi2 < 50.0, "{chi2}: {counts:?}");
}
