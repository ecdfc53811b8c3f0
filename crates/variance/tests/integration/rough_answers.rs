//! Answers from rough predictions, against those from precise ones.

use sphvar_integrands::{Cap, Harmonic, Integrand, VonMisesFisher};
use sphvar_samplers::{Domain, Pattern};
use sphvar_variance::{
    Candidate, CurvePredictor, Goal, PredictedCurve, PredictionBudget, Predictor, RequiredPoints,
    needs_more_points, required_points,
};

/// Patterns of each kind: independent, strata in closed form, lattices with a few and many degrees,
/// random ones that are inexpensive, expensive, and without power at low degrees.
const PATTERNS: [&str; 8] =
    ["white-noise", "jittered", "fibonacci", "healpix", "sobol", "poisson-disk", "lloyd", "step"];

fn integrands() -> Vec<Box<dyn Integrand>> {
    vec![
        Box::new(Cap::from_degrees(60.0).unwrap()),
        Box::new(Cap::from_degrees(5.0).unwrap()),
        Box::new(VonMisesFisher::new(20.0).unwrap()),
        // All energy at one degree, below and at the edge of the power of patterns with 48 points.
        Box::new(Harmonic::new(2, 1).unwrap()),
        Box::new(Harmonic::new(7, 0).unwrap()),
    ]
}

/// A prediction that is said to be repeated is repeated to the last bit, whatever the budgets.
#[test]
fn repeated_predictions_are_the_same() {
    let budget = |relative: f64, work: f64| PredictionBudget { relative, work };
    let budgets = [
        budget(0.5, 1.0),
        budget(0.2, 3e4),
        budget(0.06, 2e5),
        budget(0.03, 2e5),
        budget(0.03, 6e5),
    ];
    let mut repeated = 0;
    for integrand in integrands() {
        let mut predictor = Predictor::new(&*integrand, Domain::Sphere, 3, budgets[4]).unwrap();
        for name in PATTERNS {
            let pattern: Pattern = name.parse().unwrap();
            for (i, coarse) in budgets.into_iter().enumerate() {
                let point = predictor.predict_at(&pattern, 48, coarse, &()).unwrap();
                for fine in &budgets[i + 1..] {
                    if predictor.is_repeated_by(&pattern, &point, *fine).unwrap() {
                        let again = predictor.predict_at(&pattern, 48, *fine, &()).unwrap();
                        assert_eq!(again, point, "{name} {coarse:?} {fine:?}");
                        repeated += 1;
                    }
                }
            }
        }
    }
    // Closed forms and lattices to the same degree alone are more than a quarter.
    assert!(repeated > 100, "{repeated}");
}

/// Coarse answers are within their stated errors of precise ones: 5 standard errors of four or more
/// realizations, which normal errors exceed at most once in a hundred (Student's t with 3 degrees of
/// freedom: 0.015) where they are independent; the sets of the precise answer contain those of the
/// coarse one. The seed is fixed.
#[test]
fn coarse_answers_are_within_their_errors() {
    let budget = PredictionBudget { relative: 0.02, work: 1e6 };
    let coarse = budget.rough().rough();
    for integrand in integrands() {
        let mut predictor = Predictor::new(&*integrand, Domain::Sphere, 1, budget).unwrap();
        let white = predictor.white_variance(1);
        for name in PATTERNS {
            let pattern: Pattern = name.parse().unwrap();
            let goal = Goal::Points(192);
            let [rough, precise] = [coarse, budget].map(|budget| {
                let curve = PredictedCurve::new(pattern.clone());
                Candidate::with_curve_within(curve, goal, budget, &mut predictor, &()).unwrap()
            });
            assert_eq!(rough.n_points, precise.n_points, "{name}");
            let ((a, da), (b, db)) = (rough.variance.unwrap(), precise.variance.unwrap());
            // Rounding of variances that are 0.
            let limit = 5.0 * da.hypot(db) + 1e-12 * white;
            assert!((a - b).abs() <= limit, "{name}: {a} +- {da}, {b} +- {db}");
        }
    }
}

/// An answer from a curve with coarse predictions, of which some were made to rule the pattern out, is as precise as
/// one without them: its prediction is that of the budget, and the number of points differs by at most the
/// precision to which both are known, or for patterns with few valid counts not at all.
#[test]
fn preliminary_predictions_do_not_decide_precise_answers() {
    let budget = PredictionBudget { relative: 0.02, work: 2e5 };
    let coarse = budget.rough().rough();
    let mut answers = 0;
    for integrand in integrands().into_iter().step_by(2) {
        let mut predictor = Predictor::new(&*integrand, Domain::Sphere, 1, budget).unwrap();
        // Without those of which every set is optimized.
        for name in &PATTERNS[..6] {
            let pattern: Pattern = name.parse().unwrap();
            let variance = predictor.white_variance(150);
            let range = (variance, 200);
            let mut curve = PredictedCurve::new(pattern.clone());
            let alone =
                required_points(&mut predictor, &mut curve, variance, range.1, &()).unwrap();
            let mut curve = PredictedCurve::new(pattern.clone());
            let is_behind =
                needs_more_points(coarse, &mut predictor, &mut curve, range, &()).unwrap();
            assert!(!is_behind || alone.n_points().is_none(), "{name}: {alone:?}");
            for budget in [coarse, budget.rough()] {
                let goal = Goal::Variance { variance, max_points: range.1 };
                let found =
                    Candidate::with_curve_within(curve, goal, budget, &mut predictor, &()).unwrap();
                curve = found.curve.into_preliminary();
            }
            let got = required_points(&mut predictor, &mut curve, variance, range.1, &()).unwrap();
            let (RequiredPoints::Predicted { n_points, .. }, Some(expected)) =
                (got, alone.n_points())
            else {
                assert_eq!(got.n_points(), alone.n_points(), "{name}");
                continue;
            };
            let direct = predictor.predict_at(&pattern, n_points, budget, &()).unwrap();
            assert_eq!(curve.at(n_points), Some(&direct), "{name}");
            let (a, b) = (n_points as f64, expected as f64);
            // A lattice may suffice at numbers that only one of the searches tried.
            let limit = if *name == "fibonacci" { 0.1 } else { 3.0 * budget.relative };
            assert!(
                (a / b).ln().abs() <= limit || n_points.abs_diff(expected) <= 1,
                "{name}: {a} {b}"
            );
            answers += 1;
        }
    }
    assert!(answers > 8, "{answers}");
}
