//! Predictions and their stated errors.

use sphvar_integrands::{Cap, Energy, Integrand};
use sphvar_samplers::{Domain, Pattern, Purpose, Realizations, Streams};
use sphvar_sh::ByParity;
use sphvar_spectrum::{Resolution, Spectrum, accumulate, estimate};
use sphvar_variance::{PredictionAccumulator, predict};

const SEED: u64 = 11;

fn cap60(lmax: usize) -> Energy {
    Cap::from_degrees(60.0).unwrap().energy(Domain::Sphere, lmax).unwrap()
}

/// Returns a spectrum that is a function of omega = l/sqrt(N).
fn exact(n: usize, lmax: usize, power: impl Fn(f64) -> f64) -> Spectrum {
    let root = (n as f64).sqrt();
    Spectrum::exact(Domain::Sphere, n, (0..=lmax).map(|l| power(l as f64 / root)).collect())
}

/// White noise's power is 1 and so is that of its tail, wherever the sum is cut.
#[test]
fn white_noise_has_no_tail_error() {
    for lmax in [1, 2, 7, 40, 300] {
        let got = predict(&exact(100, lmax, |_| 1.0), &cap60(lmax));
        let textbook = 3.0 * std::f64::consts::PI.powi(2) / 100.0;
        // Sums of 300 terms.
        assert!((got.variance / textbook - 1.0).abs() < 1e-13, "lmax {lmax}: {got:?}");
        // Weights sum to 1 within 150 roundings.
        assert!(got.tail > 0.0 && got.tail_error <= 1e-13 * got.tail, "lmax {lmax}: {got:?}");
        let (low, high) = got.interval(0.95);
        assert!(high - low <= 1e-12 * textbook, "{low} to {high}");
    }
}

/// A step at omega = 1. If the sum is cut at 256 and sqrt(N) is larger, the spectrum contains
/// nothing of the pattern: the variance is all tail, and its error shows this. If it is cut well
/// above, the interval is narrow and contains the true variance.
#[test]
fn a_truncated_sum_has_a_large_tail_error() {
    const WHOLE: usize = 20_000;
    let step = |omega: f64| f64::from(u8::from(omega > 1.0));
    for n in [100_000, 400_000] {
        let truth = predict(&exact(n, WHOLE, step), &cap60(WHOLE));
        assert!(truth.tail_error < 1e-10 * truth.variance, "{truth:?}");
        let cut = predict(&exact(n, 256, step), &cap60(256));
        assert!(cut.variance > 1.2 * truth.variance, "{cut:?}, {truth:?}");
        let (low, high) = cut.interval(0.95);
        assert!(low <= truth.variance && truth.variance <= high, "{cut:?}, {truth:?}");
        assert!(cut.tail_error >= 0.999 * cut.tail, "{cut:?}");
        let enough = predict(&exact(n, 4 * n.isqrt(), step), &cap60(4 * n.isqrt()));
        assert!((enough.variance / truth.variance - 1.0).abs() < 1e-10, "{enough:?}, {truth:?}");
    }
}

/// If the power still oscillates by a tenth at the end of the spectrum, the true variance is within
/// the error of the tail.
#[test]
fn oscillations_beyond_the_spectrum_are_within_the_error() {
    let power = |omega: f64| 1.0 + (-omega / 3.0).exp() * (3.0 * omega).sin();
    let n = 2000;
    let truth = predict(&exact(n, 20_000, power), &cap60(20_000));
    for multiple in [2, 3, 4, 6, 8] {
        let lmax = multiple * n.isqrt();
        let got = predict(&exact(n, lmax, power), &cap60(lmax));
        let off = (got.variance - truth.variance).abs();
        assert!(off <= got.tail_error + truth.tail_error, "{multiple} sqrt N: {got:?}, {truth:?}");
        assert!(got.tail_error < 0.5 * got.tail, "{multiple} sqrt N: {got:?}");
    }
}

/// Without energy in the upper octave but with all of it beyond, the error is the whole tail.
#[test]
fn an_unresolved_tail_is_its_own_error() {
    let mut energies = vec![0.0; 33];
    energies[3] = 1.0;
    let got = predict(
        &exact(100, 32, |_| 0.5),
        &Energy::new(Domain::Sphere, energies, ByParity { even: 0.0, odd: 2.0 }),
    );
    assert!(got.tail > 0.0 && (got.tail_error / got.tail - 1.0).abs() < 1e-15, "{got:?}");
}

/// The predictions from realizations and from the mean spectrum agree up to the order of sums, and
/// the error of the first includes the covariance of degrees.
#[test]
fn predictions_from_realizations_and_mean_spectrum_agree() {
    let sampler = Pattern::Jittered.build(192, Domain::Sphere).unwrap();
    let sets = Realizations::rotated(&*sampler, Streams::new(SEED, Purpose::Pattern, 0));
    let energy = cap60(60);
    let spectrum = estimate(&sets, 60, 200, &()).unwrap();
    let a = predict(&spectrum, &energy);
    let empty = PredictionAccumulator::new(&energy, 192, 60);
    let b = accumulate(&sets, Resolution::new(60, 192), 0..200, &empty, &()).unwrap().finish();
    for (name, x, y) in [
        ("variance", a.variance, b.variance),
        ("tail", a.tail, b.tail),
        ("tail error", a.tail_error, b.tail_error),
        ("dof", a.dof, b.dof),
    ] {
        // Sums of 200 numbers in another order.
        assert!((x / y - 1.0).abs() < 1e-12, "{name}: {x}, {y}");
    }
    assert!((0.5..2.0).contains(&(a.stderr / b.stderr)), "{a:?}, {b:?}");
}

/// The 95 % interval from 8 sets, Student's with 7 degrees of freedom, contains the variance from
/// 4000 sets in 95 % of cases; with the normal quantile the coverage would be 91 %.
#[test]
fn prediction_intervals_have_the_stated_coverage() {
    const REPS: usize = 500;
    let sampler = Pattern::Jittered.build(48, Domain::Sphere).unwrap();
    let energy = cap60(28);
    let sets = Realizations::rotated(&*sampler, Streams::new(SEED, Purpose::Pattern, 1));
    let predict_from = |range| {
        let empty = PredictionAccumulator::new(&energy, 48, 28);
        let resolution = Resolution::new(28, 48);
        accumulate(&sets, resolution, range, &empty, &()).unwrap().finish()
    };
    let truth = predict_from(0..4000).variance;
    let held = (0..REPS).filter(|&i| {
        let first = 4000 + 8 * i as u64;
        // The reference has the same tail; its error is not tested.
        let got = predict_from(first..first + 8);
        let (low, high) = sphvar_variance::Prediction { tail_error: 0.0, ..got }.interval(0.95);
        low <= truth && truth <= high
    });
    let share = held.count() as f64 / REPS as f64;
    // Binomial, five standard errors of 1 %: exceeded by chance for 6e-7 of seeds.
    assert!((share - 0.95).abs() < 0.05, "{share}");
    for confidence in [0.0, 1.0, f64::NAN, -3.0] {
        assert!(predict_from(0..8).interval(confidence).0.is_nan(), "{confidence}");
    }
    assert!(predict_from(0..1).interval(0.95).0.is_nan());
}
