//! Predictions on sphere and hemisphere against spectra of single prefixes.

use glam::DVec3;
use sphvar_integrands::{Cap, EnvironmentMap, Harmonic, Integrand, VonMisesFisher};
use sphvar_samplers::{Domain, Pattern, PointSet, PointSets};
use sphvar_variance::{
    Error, PredictionBudget, Predictor, ProgressivePredictor, Randomized, SpectrumOptions,
};

use super::{given, hostile, sequence, white};

const N: usize = 96;

fn predictor(integrand: &dyn Integrand, domain: Domain) -> Predictor<'_> {
    let options = SpectrumOptions { lmax: Some(150), ..SpectrumOptions::default() };
    let budget = PredictionBudget::DEFAULT;
    Predictor::new(integrand, domain, 5, budget).unwrap().with_options(options)
}

fn all(n: usize) -> Vec<usize> {
    (1..=n).collect()
}

fn environment() -> EnvironmentMap {
    let texel = |k: usize| 1.0 + (k * k % 17) as f64 + if k == 40 { 300.0 } else { 0.0 };
    EnvironmentMap::new(16, 8, (0..128).map(texel).collect()).unwrap()
}

/// With the same degree the sums over pairs are those of the spectrum, of smooth functions and of
/// functions with jumps, of distinct points and of hostile ones, and so is the tail.
#[test]
fn prefixes_have_the_variances_of_their_spectra() {
    let (cap, lobe) = (Cap::from_degrees(60.0).unwrap(), VonMisesFisher::new(10.0).unwrap());
    let (harmonic, map) = (Harmonic::new(4, 2).unwrap(), environment());
    let integrands: [(&str, &dyn Integrand); 4] =
        [("cap", &cap), ("lobe", &lobe), ("Y_42", &harmonic), ("map", &map)];
    for domain in [Domain::Sphere, Domain::Hemisphere] {
        for (kind, set) in [("distinct", white(N, domain)), ("hostile", hostile(N, domain))] {
            for (name, integrand) in integrands {
                let sampler = given(&set, N, domain);
                let mut prefixes = ProgressivePredictor::new(predictor(integrand, domain));
                let curve = prefixes.predict(&sampler, 0, &all(N), &()).unwrap();
                assert_eq!((curve.points.len(), curve.realizations), (N, 1));
                let mut single = predictor(integrand, domain);
                for n in [1, 2, 3, 5, 12, 31, 64, N] {
                    let got = curve.points[n - 1].prediction;
                    let point = single.predict(&given(&set, n, domain), &()).unwrap();
                    let expected = point.prediction;
                    let case = format!("{name}, {kind}, {domain}, {n}: {got:?}, {expected:?}");
                    let close = |a: f64, b: f64| {
                        (a - b).abs() <= 1e-9 * b.abs().max(1e-9 * single.white_variance(n))
                    };
                    assert!(close(got.variance, expected.variance), "{case}");
                    assert!(close(got.tail, expected.tail), "{case}");
                    assert!(got.stderr <= got.energy_stderr && got.dof == f64::INFINITY, "{case}");
                    // Between powers of two the errors are those of a neighbour.
                    if n.is_power_of_two() || n == N {
                        let off = (got.tail_error - expected.tail_error).abs();
                        assert!(off <= 1e-9 * expected.variance, "{case}");
                    }
                }
            }
        }
    }
}

/// Smooth functions are integrated by a lattice with a variance of 1e-5 of that of white noise and
/// less, which no sum of the kernel over pairs resolves.
#[test]
fn small_variances_keep_their_digits() {
    let n = 500;
    let lattice = Pattern::FIBONACCI.build(n, Domain::Sphere).unwrap();
    for kappa in [1.0, 10.0, 30.0] {
        let lobe = VonMisesFisher::new(kappa).unwrap();
        let new = || Predictor::new(&lobe, Domain::Sphere, 5, PredictionBudget::DEFAULT).unwrap();
        let curve = ProgressivePredictor::new(new()).predict(&*lattice, 0, &all(n), &()).unwrap();
        let (got, mut single) = (curve.points[n - 1].prediction.variance, new());
        let expected = single.predict(&*lattice, &()).unwrap().prediction.variance;
        let white = single.white_variance(n);
        assert!(expected < 1e-4 * white, "{kappa}: {expected:e}, {white:e}");
        // Coefficients have errors of some 1e-15 relative to those of white noise.
        let bound = 1e-6 * expected + 1e-14 * (expected * white).sqrt();
        assert!((got - expected).abs() <= bound, "{kappa}: {got:e}, {expected:e}");
    }
}

/// The realizations of a prefix are those of the sequence.
#[test]
fn random_sequences_have_the_mean_of_their_realizations() {
    let cap = Cap::from_degrees(60.0).unwrap();
    let options =
        SpectrumOptions { lmax: Some(100), realizations: Some(5), ..SpectrumOptions::default() };
    let new = || predictor(&cap, Domain::Sphere).with_options(options);
    let long = sequence("halton", N, Domain::Sphere);
    let curve = ProgressivePredictor::new(new()).predict(&long, 9, &all(N), &()).unwrap();
    assert_eq!(curve.realizations, 5);
    for n in [1, 2, 16, 33, N] {
        let got = curve.points[n - 1].prediction;
        let short = sequence("halton", n, Domain::Sphere);
        let expected = new().predict(&short, &()).unwrap().prediction;
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-9 * expected.variance;
        assert!(close(got.variance, expected.variance), "{n}: {got:?}, {expected:?}");
        assert!(close(got.stderr, expected.stderr), "{n}: {got:?}, {expected:?}");
        assert!((got.dof - 4.0).abs() < 1e-12, "{n}: {got:?}");
    }
}

/// Without options, realizations are added until every prefix is precise.
#[test]
fn predictions_are_as_precise_as_requested() {
    let cap = Cap::from_degrees(60.0).unwrap();
    let budget = PredictionBudget { relative: 0.05, ..PredictionBudget::DEFAULT };
    let halton = sequence("halton", 64, Domain::Sphere);
    let predictor = Predictor::new(&cap, Domain::Sphere, 5, budget).unwrap();
    let curve = ProgressivePredictor::new(predictor).predict(&halton, 9, &all(64), &()).unwrap();
    assert!(curve.realizations > 4);
    for point in &curve.points {
        let prediction = point.prediction;
        assert!(prediction.stderr <= 0.05 * prediction.variance, "{point:?}");
    }
}

#[test]
fn independent_points_have_the_variance_of_white_noise() {
    let map = environment();
    for domain in [Domain::Sphere, Domain::Hemisphere] {
        let sampler = Pattern::WhiteNoise.build(100_000, domain).unwrap();
        let single = predictor(&map, domain);
        let mut prefixes = ProgressivePredictor::new(predictor(&map, domain));
        let counts = all(100_000);
        for randomized in [Randomized::Rotated, Randomized::AsDrawn] {
            let curve = prefixes.curve(&*sampler, 0, &counts, 0, randomized, &()).unwrap();
            for point in curve.points.iter().step_by(777) {
                let expected = single.white_variance(point.n_points);
                assert!((point.prediction.variance / expected - 1.0).abs() < 1e-14);
            }
        }
    }
}

/// Few prefixes are predicted one by one, with the results of single predictions.
#[test]
fn few_prefixes_have_single_predictions() {
    let cap = Cap::from_degrees(60.0).unwrap();
    let new = || Predictor::new(&cap, Domain::Sphere, 5, PredictionBudget::DEFAULT).unwrap();
    let (counts, long) = ([300, 1000], sequence("halton", 1000, Domain::Sphere));
    let curve = ProgressivePredictor::new(new()).predict(&long, 9, &counts, &()).unwrap();
    for (point, n) in curve.points.iter().zip(counts) {
        let expected = new().predict(&sequence("halton", n, Domain::Sphere), &()).unwrap();
        assert_eq!(point.prediction, expected.prediction);
    }
}

#[test]
fn what_is_no_prefix_is_an_error_or_unknown() {
    let cap = Cap::from_degrees(60.0).unwrap();
    let mut prefixes = ProgressivePredictor::new(predictor(&cap, Domain::Sphere));
    let sampler = given(&white(8, Domain::Sphere), 8, Domain::Sphere);
    for counts in [&[0][..], &[9], &[3, 3], &[4, 2]] {
        let error = prefixes.predict(&sampler, 0, counts, &()).unwrap_err();
        assert!(matches!(error, Error::Parameter { .. }), "{error}");
    }
    assert!(prefixes.predict(&sampler, 0, &[], &()).unwrap().points.is_empty());
    // The mean number of points is 8.
    let sets = [6, 10].map(|n| white(n, Domain::Sphere)).to_vec();
    let sampler = PointSets::new(sets, Domain::Sphere).unwrap();
    let error = prefixes.predict(&sampler, 0, &all(8), &()).unwrap_err().to_string();
    assert!(error.contains("6 points, fewer than the 8"), "{error}");
    // Two points whose weights cancel.
    let points = vec![DVec3::X, DVec3::Y, DVec3::Z];
    let set = PointSet { points, weights: vec![1.0, -1.0, 2.0] };
    let sampler = PointSets::new(vec![set], Domain::Sphere).unwrap();
    for counts in [&[1, 2, 3][..], &[2]] {
        let curve = prefixes.curve(&sampler, 0, counts, 10, Randomized::Rotated, &()).unwrap();
        for point in curve.points {
            let is_unknown = point.n_points == 2;
            assert_eq!(point.prediction.is_unknown(), is_unknown, "{point:?}");
            let measured = point.measurement.unwrap();
            assert_eq!(measured.variance.is_finite(), !is_unknown, "{measured:?}");
        }
    }
}

/// Whole sets by the sums of prefixes against the spectrum of each, within the errors of both, for
/// functions with and without a tail.
#[test]
fn whole_sets_have_the_variances_of_single_predictions() {
    let (cap, lobe) = (Cap::from_degrees(50.0).unwrap(), VonMisesFisher::new(8.0).unwrap());
    let integrands: [&dyn Integrand; 2] = [&cap, &lobe];
    for domain in [Domain::Sphere, Domain::Hemisphere] {
        for integrand in integrands {
            let new = || Predictor::new(integrand, domain, 5, PredictionBudget::DEFAULT).unwrap();
            let counts = [1, 2, 7, 18, 37, 154];
            let sets: Vec<_> =
                counts.iter().map(|&n| Pattern::FIBONACCI.build(n, domain).unwrap()).collect();
            let samplers: Vec<_> = sets.iter().map(|set| &**set).collect();
            let got = ProgressivePredictor::new(new()).predict_sets(&samplers, &()).unwrap();
            let mut single = new();
            for (sampler, got) in samplers.iter().zip(&got) {
                let expected = single.predict(*sampler, &()).unwrap().prediction;
                let got = (got.n_points, &got.prediction);
                assert_eq!(got.0, sampler.n_points());
                let error = |p: &sphvar_variance::Prediction| p.tail_error + p.energy_stderr;
                let bound = error(got.1) + error(&expected) + 1e-8 * expected.variance;
                let off = (got.1.variance - expected.variance).abs();
                assert!(off <= bound, "{domain}, {got:?}, {expected:?}");
            }
        }
    }
    let none = Predictor::new(&cap, Domain::Sphere, 5, PredictionBudget::DEFAULT).unwrap();
    assert_eq!(ProgressivePredictor::new(none).predict_sets(&[], &()).unwrap(), []);
}
