//! Predictions on the unit square against sums over pairs of points, which have no tail.

use rand::RngExt;
use sphvar_integrands::{Exponential, SquareIntegrand, Wave};
use sphvar_samplers::{
    PointSet, PointSets, Purpose, Square, SquarePattern, SquareSampler, Streams,
};
use sphvar_variance::{Error, PredictionBudget, SpectrumOptions, SquarePredictor, Trials};

const A: f64 = 1.5;
const B: f64 = -0.7;

/// Returns the periodic autocorrelation `int e^{a x} e^{a (x + d mod 1)} dx` over [0, 1].
fn autocorrelation(a: f64, d: f64) -> f64 {
    let d = d.rem_euclid(1.0);
    let integral =
        |low: f64, high: f64| ((2.0 * a * high).exp() - (2.0 * a * low).exp()) / (2.0 * a);
    (a * d).exp() * integral(0.0, 1.0 - d) + (a * (d - 1.0)).exp() * integral(1.0 - d, 1.0)
}

/// Returns the variance of the weighted mean of `exp(A u + B v)` over uniform shifts of a set.
fn variance_of_pairs(set: &PointSet<[f64; 2]>) -> f64 {
    let weight = |i: usize| set.weights.get(i).copied().unwrap_or(1.0);
    let (mut sum, mut total) = (0.0, 0.0);
    for (i, p) in set.points.iter().enumerate() {
        total += weight(i);
        for (j, q) in set.points.iter().enumerate() {
            let both = autocorrelation(A, p[0] - q[0]) * autocorrelation(B, p[1] - q[1]);
            sum += weight(i) * weight(j) * both;
        }
    }
    let mean = (A.exp() - 1.0) / A * (B.exp() - 1.0) / B;
    sum / (total * total) - mean * mean
}

fn sampler(sets: Vec<PointSet<[f64; 2]>>) -> PointSets<Square> {
    PointSets::new(sets, Square).unwrap()
}

fn sets() -> Vec<(&'static str, PointSet<[f64; 2]>)> {
    let mut rng = Streams::new(5, Purpose::Pattern, 0).realization(0);
    let mut random = |n: usize| (0..n).map(|_| rng.random()).collect::<Vec<[f64; 2]>>();
    let grid = |rows: u32, columns: u32| {
        let point =
            |i: u32, j: u32| [f64::from(i) / f64::from(rows), f64::from(j) / f64::from(columns)];
        (0..rows).flat_map(|i| (0..columns).map(move |j| point(i, j))).collect::<Vec<_>>()
    };
    let weights =
        |n: usize, size: f64| (0..n).map(|i| size * (1.0 + 0.3 * (i as f64).sin())).collect();
    let signed =
        PointSet { points: random(20), weights: (0..20).map(|i| [1.0, -0.4][i % 2]).collect() };
    let large = PointSet { points: random(20), weights: weights(20, 1e150) };
    let mut repeated = random(10);
    repeated.extend(repeated.clone());
    let on_a_line = random(16).into_iter().map(|[u, _]| [u, 0.25]).collect();
    vec![
        ("one point", PointSet::new(random(1))),
        ("random points", PointSet::new(random(50))),
        ("weights of both signs", signed),
        ("large weights", large),
        ("repeated points", PointSet::new(repeated)),
        ("points on a line", PointSet::new(on_a_line)),
        ("a square grid", PointSet::new(grid(8, 8))),
        ("a grid of two rows", PointSet::new(grid(2, 32))),
    ]
}

/// The error is within that of the tail, and below 1 % of the variance.
#[test]
fn predictions_of_given_sets_are_the_sums_over_pairs() {
    let function = Exponential::new([A, B]).unwrap();
    for (name, set) in sets() {
        let exact = variance_of_pairs(&set);
        let mut predictor = SquarePredictor::new(&function, 0, PredictionBudget::DEFAULT).unwrap();
        let sampler = sampler(vec![set]);
        let got = predictor.predict(&sampler, &()).unwrap().prediction;
        let error = (got.variance - exact).abs();
        assert!(error <= got.tail_error + 1e-9 * exact, "{name}: {got:?}, exact {exact}");
        assert!(error <= 0.01 * exact && got.stderr == 0.0, "{name}: {got:?}, exact {exact}");
    }
}

/// Of a function that is not periodic, much of a lattice's variance is on the axes, at multiples of
/// N. The error is within that of the tail, which is at most a tenth of the variance.
#[test]
fn tails_of_lattices_are_bounded_on_the_axes() {
    let function = Exponential::new([A, B]).unwrap();
    for (pattern, n_points) in [
        (SquarePattern::FibonacciLattice, 55),
        (SquarePattern::FibonacciLattice, 377),
        (SquarePattern::HAMMERSLEY, 100),
        (SquarePattern::R2, 200),
        (SquarePattern::HALTON, 333),
        (SquarePattern::RegularSquare, 361),
    ] {
        let name = format!("{pattern} with N = {n_points}");
        let lattice = pattern.build(n_points).unwrap();
        let mut rng = Streams::new(0, Purpose::Pattern, 0).realization(0);
        let exact = variance_of_pairs(&lattice.sample(&mut rng).unwrap());
        let mut predictor = SquarePredictor::new(&function, 0, PredictionBudget::DEFAULT).unwrap();
        let got = predictor.predict(&*lattice, &()).unwrap().prediction;
        let error = (got.variance - exact).abs();
        assert!(error <= got.tail_error + 1e-9 * exact, "{name}: {got:?}, exact {exact}");
        assert!(got.tail_error <= 0.1 * exact, "{name}: {got:?}, exact {exact}");
    }
}

/// Several sets have the mean of their variances.
#[test]
fn predictions_of_several_sets_are_their_mean() {
    let function = Exponential::new([A, B]).unwrap();
    let all: Vec<PointSet<[f64; 2]>> = sets().into_iter().take(2).map(|named| named.1).collect();
    let exact = all.iter().map(variance_of_pairs).sum::<f64>() / 2.0;
    let mut predictor = SquarePredictor::new(&function, 0, PredictionBudget::DEFAULT).unwrap();
    let got = predictor.predict(&sampler(all), &()).unwrap().prediction;
    assert!((got.variance / exact - 1.0).abs() < 0.01, "{got:?}, exact {exact}");
}

/// The same spectrum with another kmax leaves more to the tail, which its error states.
#[test]
fn a_low_largest_frequency_has_a_larger_tail_error() {
    let function = Exponential::new([A, B]).unwrap();
    let jittered = SquarePattern::JitteredSquare.build(256).unwrap();
    let predict = |kmax: Option<usize>| {
        let options = SpectrumOptions { lmax: kmax, ..SpectrumOptions::default() };
        let predictor = SquarePredictor::new(&function, 0, PredictionBudget::DEFAULT).unwrap();
        predictor.with_options(options).predict(&*jittered, &()).unwrap().prediction
    };
    let (natural, low) = (predict(None), predict(Some(4)));
    assert!(low.tail > natural.tail && low.tail_error > natural.tail_error, "{low:?}, {natural:?}");
    let difference = (low.variance - natural.variance).abs();
    assert!(difference <= low.tail_error + natural.tail_error, "{low:?}, {natural:?}");
}

/// Independent points have the variance of the function over N, whatever their number.
#[test]
fn white_noise_has_the_variance_of_the_function() {
    let function = Exponential::new([A, B]).unwrap();
    let one = variance_of_pairs(&PointSet::new(vec![[0.0, 0.0]]));
    for n in [1, 2, 1000, 30_000] {
        let white = SquarePattern::WhiteSquare.build(n).unwrap();
        let mut predictor = SquarePredictor::new(&function, 0, PredictionBudget::DEFAULT).unwrap();
        let got = predictor.predict(&*white, &()).unwrap().prediction;
        assert!((got.variance * n as f64 / one - 1.0).abs() < 1e-12, "{n}: {got:?}");
    }
}

/// Weights of sum 0 estimate nothing; the estimates of the trials are those of the definition.
#[test]
fn invalid_sets_are_errors_and_trials_are_shifted() {
    let wave = Wave::new([2, -1]).unwrap();
    let mut predictor = SquarePredictor::new(&wave, 3, PredictionBudget::DEFAULT).unwrap();
    let none = PointSet { points: vec![[0.1, 0.2], [0.3, 0.4]], weights: vec![1.0, -1.0] };
    let error = predictor.predict(&sampler(vec![none]), &()).unwrap_err();
    assert!(
        matches!(error, Error::Spectrum(_)) && error.to_string().contains("sum is 0"),
        "{error}"
    );
    let pair = sampler(vec![PointSet::new(vec![[0.1, 0.2], [0.35, 0.2]])]);
    let compared = predictor.compare(&pair, Trials::new(500), &()).unwrap();
    // Half a turn of the wave apart, so every estimate is 0.
    assert!(compared.measurement.estimates().iter().all(|e| e.abs() < 1e-14));
    assert!(compared.prediction.variance <= 0.0 && !compared.has_too_few_hits());
    let one = sampler(vec![PointSet::new(vec![[0.1, 0.2]])]);
    let compared = predictor.compare(&one, Trials::new(2000), &()).unwrap();
    // The cosine of a uniform angle: five standard errors.
    assert!((compared.prediction.variance - 0.5).abs() < 1e-12);
    assert!(compared.z_score().abs() < 5.0, "{}", compared.z_score());
    assert_eq!(wave.band_limit(), Some(3));
    assert_eq!(pair.n_points(), 2);
}
