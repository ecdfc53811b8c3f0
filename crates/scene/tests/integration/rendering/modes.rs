//! Guarantees of the direction modes: directions above the surface, no bias, and the variance of
//! white noise.

use glam::DVec3;
use sphvar_samplers::{Domain, Pattern, PointSet};
use sphvar_scene::{DirectionMode, DirectionPlan, Error, Estimator, Integral};

use super::spot::{Spot, covered_share, horizontal, mean_and_error};

const SEED: u64 = 2;
/// More than twenty comparisons at |z| < 4.5; one fails by chance for 1.5e-4 of seeds.
const Z: f64 = 4.5;
const AMBIENT: Integral<'static> =
    Integral::AmbientOcclusion { max_distance: f64::INFINITY, cosine: false };

/// Returns a ceiling to one side, and the open fraction of the hemisphere beneath it.
fn sheltered() -> (Spot, f64) {
    let (x, y, z) = ([-0.3, 2.2], [0.1, 1.9], 0.8);
    (Spot::with(vec![horizontal(x, y, z)]), 1.0 - covered_share(x, y, z))
}

fn plan(pattern: &Pattern, requested: usize, mode: DirectionMode) -> DirectionPlan {
    let n = DirectionPlan::nearest_count(pattern, requested, mode);
    DirectionPlan::new(pattern.clone(), n, mode, SEED).unwrap()
}

#[test]
fn directions_are_unit_vectors_above_the_surface() {
    let normals = [DVec3::Z, -DVec3::Z, DVec3::Y, DVec3::new(-0.6, 0.0, 0.8)];
    let mut directions = PointSet::default();
    for pattern in [Pattern::WhiteNoise, Pattern::Jittered, Pattern::Healpix, Pattern::FIBONACCI] {
        for mode in DirectionMode::ALL {
            for requested in [1, 50] {
                let plan = plan(&pattern, requested, mode);
                let sets = plan.prepare(3).unwrap();
                for (index, &normal) in normals.iter().enumerate() {
                    sets.directions_into(normal, index as u64, &mut directions).unwrap();
                    let dirs = &directions.points;
                    // The entries of a rotation and the sum of three products round by a few
                    // EPSILON.
                    let unit = |d: &DVec3| (d.length() - 1.0).abs() < 8.0 * f64::EPSILON;
                    let above = |d: &DVec3| normal.dot(*d) > -8.0 * f64::EPSILON;
                    assert!(dirs.iter().all(|d| unit(d) && above(d)), "{pattern} {mode} {normal}");
                    if mode.domain() == Domain::Hemisphere {
                        assert_eq!(dirs.len(), plan.n_points(), "{pattern} {mode} {normal}");
                    } else {
                        assert!(dirs.len() <= 2 * plan.n_points(), "{pattern} {mode} {normal}");
                    }
                }
            }
        }
    }
}

/// For a set with the same rotation, the visible halves above a surface and below it add up to the
/// whole set: each direction in its plane is in one of them. HEALPix has pixel centres on the
/// equator.
#[test]
fn halves_of_a_sphere_set_add_up_to_it() {
    let (mut above, mut below) = (PointSet::default(), PointSet::default());
    let mut n_in_plane = 0;
    for (pattern, n) in [(Pattern::FIBONACCI, 100), (Pattern::Healpix, 96)] {
        for mode in [DirectionMode::Shared, DirectionMode::Rotated] {
            let sets = plan(&pattern, n, mode).prepare(0).unwrap();
            for normal in [DVec3::new(0.36, -0.48, 0.8), DVec3::X, DVec3::Y, DVec3::Z] {
                for index in 0..20 {
                    sets.directions_into(normal, index, &mut above).unwrap();
                    sets.directions_into(-normal, index, &mut below).unwrap();
                    assert_eq!(above.len() + below.len(), 2 * n, "{pattern} {mode} {normal}");
                    n_in_plane += above.points.iter().filter(|d| normal.dot(**d) == 0.0).count();
                }
            }
        }
    }
    assert!(n_in_plane > 0, "no direction is in a plane, so nothing was tested");
}

#[test]
fn rotated_sets_are_unbiased() {
    let (spot, exact) = sheltered();
    let patterns = [
        Pattern::WhiteNoise,
        Pattern::Jittered,
        Pattern::Healpix,
        Pattern::FIBONACCI,
        "poisson-disk".parse::<Pattern>().unwrap(),
        "step".parse::<Pattern>().unwrap(),
    ];
    for pattern in &patterns {
        for mode in [DirectionMode::Rotated, DirectionMode::Antipodal] {
            let sets = plan(pattern, 24, mode).prepare(0).unwrap();
            let image = spot.render(&AMBIENT, Estimator::Unbiased, &sets, 48);
            let (mean, error) = mean_and_error(&image.values);
            assert!(
                error > 0.0 && (mean - exact).abs() < Z * error,
                "{pattern} {mode}: {mean} +- {error}, {exact}"
            );
        }
    }
    for pattern in &patterns[..4] {
        let sets = plan(pattern, 24, DirectionMode::Fresh).prepare(0).unwrap();
        let image = spot.render(&AMBIENT, Estimator::Unbiased, &sets, 48);
        let (mean, error) = mean_and_error(&image.values);
        assert!(
            error > 0.0 && (mean - exact).abs() < Z * error,
            "{pattern} fresh: {mean} +- {error}, {exact}"
        );
    }
}

/// With one set for all pixels the unit of replication is the render, and the set must be random.
/// Spun sets are unbiased because their patterns are.
#[test]
fn unrotated_sets_are_unbiased_over_renders() {
    let (spot, exact) = sheltered();
    for pattern in [Pattern::WhiteNoise, Pattern::Jittered] {
        for mode in [DirectionMode::Shared, DirectionMode::Spun] {
            let plan = plan(&pattern, 24, mode);
            let value = |number| {
                let sets = plan.prepare(number).unwrap();
                spot.render(&AMBIENT, Estimator::Unbiased, &sets, 1).values[0]
            };
            let values: Vec<f64> = (0..1500).map(value).collect();
            let (mean, error) = mean_and_error(&values);
            assert!(
                (mean - exact).abs() < Z * error,
                "{pattern} {mode}: {mean} +- {error}, {exact}"
            );
        }
    }
}

/// The variances for N directions of the hemisphere, for the sum over half of 2N directions of the
/// sphere, and for their mean: `p(1-p)/N`, `p(1-p/2)/N`, and for binomial n, which is 0 with
/// probability `q = 2^-2N` and then gives 0, `p(1-p) E(1/n; n > 0) + p^2 q(1-q)`. For three
/// directions the first and the last differ by 20 %.
#[test]
fn white_noise_has_the_exact_variances() {
    let (spot, p) = sheltered();
    let n = 3;
    let chance = |k: u64| {
        let choose = (0..k).fold(1.0, |c, i| c * (2 * n - i) as f64 / (i + 1) as f64);
        choose * 0.5f64.powi(2 * i32::try_from(n).unwrap())
    };
    let inverse: f64 = (1..=2 * n).map(|k| chance(k) / k as f64).sum();
    let none = chance(0);
    let of_halves = p * (1.0 - p) * inverse + p * p * none * (1.0 - none);
    let cases = [
        (DirectionMode::Fresh, Estimator::Ratio, p, p * (1.0 - p) / n as f64),
        (DirectionMode::Rotated, Estimator::Unbiased, p, p * (1.0 - 0.5 * p) / n as f64),
        (DirectionMode::Rotated, Estimator::Ratio, p * (1.0 - none), of_halves),
    ];
    const SIDE: usize = 256;
    for (mode, estimator, p, expected) in cases {
        let plan = plan(&Pattern::WhiteNoise, 3, mode).with_sets(SIDE * SIDE).unwrap();
        let sets = plan.prepare(0).unwrap();
        let image = spot.render(&AMBIENT, estimator, &sets, SIDE);
        let (mean, error) = mean_and_error(&image.values);
        assert!((mean - p).abs() < Z * error, "{mode} {estimator:?}: {mean} +- {error}, exact {p}");
        let count = (SIDE * SIDE) as f64;
        let variance = error * error * count;
        // sqrt(2/65536) = 0.6 % as for normal numbers, and as much again for sets of a table that
        // are used more than once: 5 % in all.
        let tolerance = Z * expected * 2.0 * (2.0 / count).sqrt();
        assert!(
            (variance - expected).abs() < tolerance,
            "{mode} {estimator:?}: {variance}, {expected}"
        );
    }
}

/// Sets that are generated quickly fill a table, slow ones are few, and lattices have one.
#[test]
fn numbers_of_sets() {
    let default = |name: &str, n| DirectionPlan::default_sets(&name.parse::<Pattern>().unwrap(), n);
    assert_eq!(
        ["jittered", "white-noise", "poisson-disk"].map(|name| default(name, 16)),
        [1024; 3]
    );
    assert_eq!((default("jittered", 4096), default("jittered", 1 << 20)), (64, 4));
    assert_eq!(
        (default("riesz", 4096), default("ccvt", usize::MAX), default("sobol", 0)),
        (4, 4, 1024)
    );
    let between = default("step", 64);
    assert!((5..1024).contains(&between), "{between}");
    let of = |pattern, mode| {
        let plan = plan(&pattern, 24, mode).with_sets(5).unwrap();
        assert!(plan.clone().with_sets(0).is_err(), "a table without sets");
        (plan.has_table(), plan.n_sets(), plan.distinct_sets(3))
    };
    for mode in DirectionMode::ALL {
        let (table, sets, distinct) = match mode {
            DirectionMode::Shared | DirectionMode::Spun => (false, 1, 3),
            DirectionMode::Rotated | DirectionMode::Antipodal => (true, 5, 15),
            DirectionMode::Fresh => (false, 0, 0),
        };
        assert_eq!(of(Pattern::Jittered, mode), (table, sets, distinct), "{mode}");
        assert_eq!(of(Pattern::Healpix, mode), (false, sets.min(1), 1), "{mode}");
    }
}

#[test]
fn numbers_of_directions() {
    assert_eq!(DirectionPlan::reference(32768, 0).unwrap().n_points(), 6 * 74 * 74);
    assert_eq!(DirectionPlan::reference(1, 0).unwrap().n_points(), 6);
    assert_eq!(DirectionPlan::reference(6, 0).unwrap().n_points(), 6);
    assert_eq!(DirectionPlan::reference(7, 0).unwrap().n_points(), 24);
    DirectionPlan::reference(0, 0).unwrap_err();
    for n in [usize::MAX, usize::MAX / 4] {
        let error = DirectionPlan::reference(n, 0);
        assert!(matches!(error, Err(Error::Sampler(_))), "{n}: {error:?}");
    }
    for mode in DirectionMode::ALL {
        // The nearest count is one that a plan accepts, also for rules with an odd number of nodes on
        // the sphere.
        for pattern in Pattern::ALL {
            for requested in 0..=130 {
                let n = DirectionPlan::nearest_count(&pattern, requested, mode);
                let plan = DirectionPlan::new(pattern.clone(), n, mode, 0)
                    .unwrap_or_else(|error| panic!("{pattern} {mode} {requested}: {error}"));
                let expected = mode.set_points(n);
                assert!([expected, expected - 1].contains(&plan.set_points()), "{pattern} {mode}");
                let again = DirectionPlan::nearest_count(&pattern, n, mode);
                assert_eq!(again, n, "{pattern} {mode} {requested}");
            }
        }
        let error = DirectionPlan::new(Pattern::Jittered, 100, mode, 0).unwrap_err();
        assert!(matches!(error, Error::Sampler(_)), "{error}");
        DirectionPlan::new(Pattern::WhiteNoise, 0, mode, 0).unwrap_err();
        let plan = DirectionPlan::new(Pattern::WhiteNoise, 1, mode, 0).unwrap();
        plan.prepare((1 << 24) - 1).unwrap();
        assert!(matches!(plan.prepare(1 << 24), Err(Error::TooManyRenders { .. })));
    }
}
