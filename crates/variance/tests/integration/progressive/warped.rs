//! Prefixes of warped sequences.

use sphvar_integrands::{Domain, NoFiles, PulledBack, Tolerance, VonMisesFisher};
use sphvar_variance::{
    Error, PredictionBudget, ProgressiveCurve, ProgressivePredictor, Randomized, SquarePredictor,
    WarpedPattern, WarpedPredictor,
};

const COUNTS: [usize; 3] = [2, 5, 33];

fn with<T>(
    pattern: &WarpedPattern,
    f: impl FnOnce(&[PulledBack<'_>], WarpedPredictor<'_>) -> T,
) -> T {
    let lobe = VonMisesFisher::new(5.0).unwrap();
    let strategies = pattern.warp.strategies(Domain::Sphere, &NoFiles).unwrap();
    let tolerance = Tolerance::default();
    let pulled_back =
        PulledBack::of_strategies(&lobe, Domain::Sphere, &strategies, pattern.heuristic, tolerance)
            .unwrap();
    let predictor = WarpedPredictor::new(&pulled_back, 5, PredictionBudget::DEFAULT).unwrap();
    f(&pulled_back, predictor)
}

fn curve(
    predictor: &mut WarpedPredictor<'_>,
    pattern: &WarpedPattern,
    counts: &[usize],
    randomized: Randomized,
) -> Result<ProgressiveCurve, Error> {
    predictor.progressive(pattern, 7, counts, 300, randomized, &())
}

/// Sums of strategies, each with a prefix of its own sequence, against single predictions and
/// measurements: 6 scores within 4.5, 4e-5 of seeds by chance.
#[test]
fn prefixes_of_strategies_add_up() {
    for text in ["r2:warp=\"0.4 * cylinder + 0.6 * vmf:kappa=5\"", "r2:warp=cylinder"] {
        let pattern: WarpedPattern = text.parse().unwrap();
        with(&pattern, |pulled_back, mut predictor| {
            let found = curve(&mut predictor, &pattern, &COUNTS, Randomized::Rotated).unwrap();
            for point in &found.points {
                let single = predictor.predict(&pattern, point.n_points, &()).unwrap().prediction;
                let got = point.prediction;
                let bound = got.tail_error
                    + single.tail_error
                    + 3.0 * (got.energy_stderr + single.energy_stderr)
                    + 1e-9 * single.variance;
                assert!((got.variance - single.variance).abs() <= bound, "{got:?}, {single:?}");
                assert!(point.measurement.unwrap().z.abs() < 4.5, "{point:?}");
            }
            if let [alone] = pulled_back {
                let square = SquarePredictor::new(alone, 5, PredictionBudget::DEFAULT).unwrap();
                let sampler = pattern.pattern.build(33).unwrap();
                let mut prefixes = ProgressivePredictor::new(square);
                let of_square =
                    prefixes.curve(&*sampler, 7, &COUNTS, 300, Randomized::Rotated, &()).unwrap();
                assert_eq!(format!("{found:?}"), format!("{of_square:?}"));
            }
        });
    }
}

#[test]
fn only_totals_of_strategies_are_prefixes() {
    let pattern: WarpedPattern = "sobol:warp=\"cylinder + vmf:kappa=5\"".parse().unwrap();
    with(&pattern, |_, mut predictor| {
        let error = curve(&mut predictor, &pattern, &[1, 2], Randomized::Rotated).unwrap_err();
        assert!(matches!(error, Error::Total { requested: 1, nearest: 2, .. }), "{error}");
        let error = curve(&mut predictor, &pattern, &[4, 3], Randomized::Rotated).unwrap_err();
        assert!(matches!(error, Error::Parameter { .. }), "{error}");
        let single: WarpedPattern = "sobol:warp=cylinder".parse().unwrap();
        let error = curve(&mut predictor, &single, &[4], Randomized::Rotated).unwrap_err();
        assert!(matches!(error, Error::Strategies { .. }), "{error}");
        let drawn = curve(&mut predictor, &pattern, &[2, 8], Randomized::AsDrawn).unwrap();
        assert!(drawn.points.iter().all(|point| point.prediction.is_unknown()));
        let none = curve(&mut predictor, &pattern, &[], Randomized::Rotated).unwrap();
        assert!(none.points.is_empty());
    });
}
