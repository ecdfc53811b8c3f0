use sphvar_samplers::{Domain, Pattern};

use sphvar_integrands::Cap;

use super::{candidate_counts, needs_more_points, required_points, valid_between};
use crate::{PredictedCurve, PredictionBudget, Predictor};

#[test]
fn valid_counts_in_an_interval_are_found() {
    for domain in [Domain::Sphere, Domain::Hemisphere] {
        let valid: Vec<usize> =
            (1..400).filter(|&n| Pattern::Healpix.nearest_count(n, domain) == n).collect();
        for low in 0..200 {
            for high in low..low + 90 {
                let inside = valid.iter().filter(|&&n| low < n && n < high);
                for wanted in [low, (low + high) / 2, high] {
                    let got = valid_between(&Pattern::Healpix, domain, low, high, wanted);
                    assert_eq!(got.is_some(), inside.clone().count() > 0, "{low} {high}");
                    assert!(got.is_none_or(|n| valid.contains(&n) && low < n && n < high));
                }
            }
        }
    }
    let top = valid_between(&Pattern::Healpix, Domain::Sphere, 0, usize::MAX, 1 << 40);
    assert!(top.is_some_and(|n| n % 12 == 0));
}

#[test]
fn candidate_counts_are_valid_and_end_with_the_maximum() {
    let counts = |pattern: Pattern, max_points: usize| {
        candidate_counts(&|n| pattern.nearest_count(n, Domain::Sphere), max_points)
    };
    assert_eq!(counts(Pattern::Jittered, 11), []);
    assert_eq!(counts(Pattern::Jittered, 12), [12]);
    assert_eq!(counts(Pattern::Jittered, 200), [12, 48, 108, 192]);
    assert_eq!(counts(Pattern::WhiteNoise, 0), []);
    assert_eq!(counts(Pattern::WhiteNoise, 9), [1, 2, 4, 8, 9]);
    let all = counts(Pattern::Healpix, usize::MAX);
    assert!(all.windows(2).all(|pair| pair[0] < pair[1]), "{all:?}");
}

/// White noise has the relative variance (4 pi/A - 1)/N for a cap of area A: 3/N for 60 degrees, 1/N for 90.
#[test]
fn an_error_that_is_met_exactly_needs_no_point_more() {
    for (degrees, share) in [(60.0, 3), (90.0, 1)] {
        let cap = Cap::from_degrees(degrees).unwrap();
        let mut predictor =
            Predictor::new(&cap, Domain::Sphere, 0, PredictionBudget::DEFAULT).unwrap();
        let integral = 2.0 * std::f64::consts::PI * (1.0 - degrees.to_radians().cos());
        for root in [1, 2, 3, 5, 7, 10, 13, 20, 25, 31, 50, 73] {
            // With share root^2 points the relative error is 1/root.
            let n_points = share * root * root;
            let variance = (integral / root as f64).powi(2);
            for off in [1.0 - 1e-15, 1.0, 1.0 + 1e-15] {
                let mut curve = PredictedCurve::new(Pattern::WhiteNoise);
                let got = required_points(&mut predictor, &mut curve, off * variance, 100_000, &());
                assert_eq!(got.unwrap().n_points(), Some(n_points), "{degrees} {root} {off}");
                let white = predictor.white_points(off * variance) - n_points as f64;
                assert!(white.abs() < 0.5, "{degrees} {root} {off}: {white}");
            }
            let more = predictor.white_points((1.0 - 1e-6 / n_points as f64) * variance);
            assert!((more - n_points as f64 - 1.0).abs() < 0.5, "{degrees} {root}: {more}");
        }
    }
}

/// Random patterns, lattices, and one whose smallest valid count exceeds some of the limits.
#[test]
fn more_points_are_needed_where_the_search_finds_none() {
    let cap = Cap::from_degrees(60.0).unwrap();
    let budget = PredictionBudget::DEFAULT.rough().rough();
    let mut predictor = Predictor::new(&cap, Domain::Sphere, 0, PredictionBudget::DEFAULT).unwrap();
    for pattern in [Pattern::WhiteNoise, Pattern::Jittered, Pattern::Healpix, Pattern::FIBONACCI] {
        let mut answers = Vec::new();
        for variance in [3.0, 0.3, 0.03, 1e-4] {
            for max_points in [0, 5, 40, 300] {
                let range = (variance, max_points);
                let mut curve = PredictedCurve::new(pattern.clone());
                let more = needs_more_points(budget, &mut predictor, &mut curve, range, &());
                let mut curve = PredictedCurve::new(pattern.clone());
                let required =
                    required_points(&mut predictor, &mut curve, variance, max_points, &());
                let found = required.ok().and_then(|required| required.n_points());
                let more = more.unwrap();
                assert!(!more || found.is_none(), "{pattern} {range:?}: {found:?}");
                answers.push(more);
            }
        }
        assert!(answers.contains(&true) && answers.contains(&false), "{pattern}: {answers:?}");
    }
}
