//! Predictions with one density.

use sphvar_integrands::Domain;
use sphvar_variance::{
    Candidate, CurvePredictor, Goal, PredictionBudget, SpectrumOptions, SquarePredictor, Trials,
    WarpedPredictor,
};

use super::{integrand, pulled_back, warped};

const BUDGET: PredictionBudget = PredictionBudget::DEFAULT;

/// With one density everything is that of the square, bit-identical.
#[test]
fn one_density_is_the_square_of_the_quotient() {
    let function = integrand("vmf:kappa=3 @ 50/20");
    for (text, n) in [
        ("white-square:warp=cosine", 20),
        ("jittered-square:warp=cylinder", 64),
        ("sobol:warp=cylinder", 24),
        ("fibonacci-lattice:warp=\"vmf:kappa=1\"", 55),
        ("latin-hypercube:warp=octahedral", 1),
    ] {
        let pattern = warped(text);
        let domain = if text.contains("cosine") { Domain::Hemisphere } else { Domain::Sphere };
        let functions = pulled_back(&*function, domain, &pattern);
        let options = SpectrumOptions { realizations: Some(20), ..SpectrumOptions::default() };
        let mut square =
            SquarePredictor::new(&functions[0], 7, BUDGET).unwrap().with_options(options);
        let sampler = pattern.pattern.build(n).unwrap();
        let expected = square.compare(&*sampler, Trials::new(50), &()).unwrap();
        let mut predictor =
            WarpedPredictor::new(&functions, 7, BUDGET).unwrap().with_options(options);
        let point = predictor.predict(&pattern, n, &()).unwrap();
        assert_eq!(point.strategies, [square.predict(&*sampler, &()).unwrap()], "{text}");
        assert_eq!(point.prediction, expected.prediction, "{text}");
        let got = predictor.compare(&pattern, n, Trials::new(50), &()).unwrap().comparison;
        assert_eq!(got.measurement, expected.measurement, "{text}");
        assert_eq!(format!("{got:?}"), format!("{expected:?}"), "{text}");
        let works = [predictor.work(&pattern, n).unwrap(), square.work(&*sampler).unwrap()];
        assert_eq!(works[0].to_bits(), works[1].to_bits(), "{text}");
    }
}

/// A density proportional to the integrand leaves rounding only, with any pattern: below 1e-25 of
/// the square of the integral.
#[test]
fn densities_equal_to_the_integrand_have_no_variance() {
    for (text, warp, domain) in [
        ("cosine", "cosine", Domain::Hemisphere),
        ("vmf:kappa=50 @ 40/10", "vmf:kappa=50 @ 40/10", Domain::Sphere),
        ("cap:degrees=180", "cylinder", Domain::Sphere),
        ("env:a.exr", "env:a.exr", Domain::Sphere),
        ("env:a.exr * cosine", "env:a.exr * cosine", Domain::Hemisphere),
    ] {
        let function = integrand(text);
        for pattern in ["white-square", "jittered-square", "sobol"] {
            let pattern = warped(&format!("{pattern}:warp=\"{warp}\""));
            let functions = pulled_back(&*function, domain, &pattern);
            let mut predictor = WarpedPredictor::new(&functions, 0, BUDGET).unwrap();
            let got = predictor.compare(&pattern, 16, Trials::new(50), &()).unwrap().comparison;
            let mean = got.measurement.mean();
            let limit = 1e-25 * mean * mean;
            assert!(got.prediction.variance < limit, "{pattern}, {text}: {:?}", got.prediction);
            assert!(got.measurement.variance() < limit, "{pattern}, {text}: {got:?}");
            assert!(
                (predictor.integral().unwrap() / mean - 1.0).abs() < 1e-12,
                "{pattern}, {text}"
            );
        }
    }
}

/// Curves, ranks and required numbers of points are those of the pattern of the square.
#[test]
fn ranks_are_those_of_the_square() {
    let function = integrand("cosine");
    let patterns = ["white-square:warp=cylinder", "jittered-square:warp=cylinder"].map(warped);
    let functions = pulled_back(&*function, Domain::Hemisphere, &patterns[0]);
    let mut predictor = WarpedPredictor::new(&functions, 0, BUDGET).unwrap();
    let mut square = SquarePredictor::new(&functions[0], 0, BUDGET).unwrap();
    let variance = (0.01 * std::f64::consts::PI).powi(2);
    for goal in [Goal::Points(100), Goal::Variance { variance, max_points: 100_000 }] {
        let got = Candidate::ranked(patterns.clone(), goal, &mut predictor, &()).unwrap();
        let expected = Candidate::ranked(patterns.clone(), goal, &mut square, &()).unwrap();
        for (got, expected) in got.iter().zip(&expected) {
            assert_eq!(got.curve.pattern(), expected.curve.pattern());
            assert_eq!(got.n_points, expected.n_points);
            assert_eq!(got.variance, expected.variance);
        }
        assert_eq!(got[0].curve.pattern(), &patterns[1]);
    }
    // G = 2 pi u has the variance pi^2/3: N = 3333.3 with white noise.
    let goal = Goal::Variance { variance, max_points: 100_000 };
    let white = Candidate::new(patterns[0].clone(), goal, &mut predictor, &()).unwrap();
    assert_eq!(white.n_points, Some(3334));
    assert!(predictor.is_affordable_at(&patterns[0], 1 << 30, BUDGET).unwrap());
}
