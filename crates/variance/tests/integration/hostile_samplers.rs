//! Samplers with wrong metadata or invalid sets.

use std::f64::consts::PI;

use glam::DVec3;
use rand::Rng;
use sphvar_integrands::Cap;
use sphvar_samplers::{Domain, Pattern, PointSet, Sampler, SetDistribution};
use sphvar_variance::{
    PredictedCurve, PredictedPoint, PredictionBudget, Predictor, required_points,
};

/// A sampler whose metadata and set are given.
#[derive(Debug)]
struct FakeSampler {
    n_points: usize,
    is_fixed: bool,
    set: PointSet,
}

impl Sampler for FakeSampler {
    fn n_points(&self) -> usize {
        self.n_points
    }

    fn domain(&self) -> Domain {
        Domain::Sphere
    }

    fn distribution(&self) -> SetDistribution<'_> {
        if self.is_fixed { SetDistribution::Fixed } else { SetDistribution::Random }
    }

    fn sample_into(
        &self,
        _: &mut dyn Rng,
        set: &mut PointSet,
    ) -> Result<(), sphvar_samplers::Error> {
        set.clone_from(&self.set);
        Ok(())
    }
}

/// The single set of a fixed pattern is validated like every realization.
#[test]
fn invalid_fixed_sets_are_errors() {
    let points = || vec![DVec3::X, DVec3::Y];
    let sets = [
        (vec![], vec![], "no points"),
        (points(), vec![1.0], "2 points and 1 weights"),
        (points(), vec![1.0, f64::NAN], "not finite"),
        (points(), vec![1.0, -1.0], "sum is 0"),
        (vec![DVec3::X, 2.0 * DVec3::Y], vec![], "not of length 1"),
    ];
    for (points, weights, expected) in sets {
        let sampler =
            FakeSampler { n_points: 2, is_fixed: true, set: PointSet { points, weights } };
        let error = predict(&sampler).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}

/// Degrees beyond the maximum are an immediate error, whatever number of points the sampler
/// reports.
#[test]
fn more_points_than_any_spectrum_can_resolve_are_errors() {
    for n_points in [1_000_000_000_000, 1 << 60, usize::MAX] {
        for is_fixed in [false, true] {
            let sampler = FakeSampler { n_points, is_fixed, set: PointSet::new(vec![DVec3::X]) };
            let error = predict(&sampler).unwrap_err().to_string();
            assert!(error.contains("largest supported degree"), "{error}");
        }
    }
    let white = Pattern::WhiteNoise.build(usize::MAX, Domain::Sphere).unwrap();
    // 3 pi^2/N.
    let expected = 3.0 * PI.powi(2) / usize::MAX as f64;
    let variance = predict(&*white).unwrap().prediction.variance;
    assert!((variance / expected - 1.0).abs() < 1e-12, "{variance}");
}

fn predict(sampler: &dyn Sampler) -> Result<PredictedPoint, sphvar_variance::Error> {
    let cap = Cap::from_degrees(60.0).unwrap();
    Predictor::new(&cap, Domain::Sphere, 0, PredictionBudget::DEFAULT)?.predict(sampler, &())
}

/// If counts too large for a prediction are ruled out without one, the rate is computed from
/// affordable counts; predictions at the large counts once took 17 GB.
#[test]
fn rates_come_from_affordable_numbers() {
    let cap = Cap::from_degrees(60.0).unwrap();
    let budget = PredictionBudget { work: 1e5, ..PredictionBudget::DEFAULT };
    let mut predictor = Predictor::new(&cap, Domain::Sphere, 0, budget).unwrap();
    let mut curve = PredictedCurve::new(Pattern::FIBONACCI);
    required_points(&mut predictor, &mut curve, 1e-11, 1_000_000_000_000, &()).unwrap();
    let largest = curve.points().last().unwrap().n_points();
    let sampler = Pattern::FIBONACCI.build(largest, Domain::Sphere).unwrap();
    assert!(predictor.is_affordable(&*sampler).unwrap(), "{largest}");
}
