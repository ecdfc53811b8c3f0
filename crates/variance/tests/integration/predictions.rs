//! Predictions and their stated errors.

use rand::RngExt;
use sphvar_integrands::{Cap, Energy, Integrand, Rotated, Sum};
use sphvar_samplers::{Domain, Pattern, Purpose, Realizations, Streams};
use sphvar_sh::ByParity;
use sphvar_spectrum::{Resolution, Spectrum, accumulate, estimate};
use sphvar_variance::{Prediction, PredictionAccumulator, PredictionBudget, Predictor, predict};

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
        let (low, high) = Prediction { tail_error: 0.0, ..got }.interval(0.95);
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

/// A prediction from energies with independent noise varies by its standard error, whichever part
/// of the energy the spectrum covers, and a spectrum with errors adds its own.
#[test]
fn errors_of_energies_are_those_of_noise() {
    const REPS: usize = 2000;
    let (lmax, rest) = (20, ByParity { even: 0.02, odd: 0.03 });
    let energies: Vec<f64> = (0..=lmax).map(|l| 1.0 / (1 + l * l) as f64).collect();
    let errors: Vec<f64> = (0..=lmax).map(|l| 0.1 / (2 + l) as f64).collect();
    let mut centred_errors = rest.map(|e| e * e);
    (1..=lmax).for_each(|l| *centred_errors.of_mut(l) += errors[l].powi(2));
    let centred_errors = centred_errors.map(f64::sqrt);
    let energy = |noise: &mut dyn FnMut() -> f64| {
        let noisy: Vec<f64> = energies.iter().zip(&errors).map(|(e, s)| e + s * noise()).collect();
        let mut centred = rest.map(|r| 1.0 + r * noise());
        (1..=lmax).for_each(|l| *centred.of_mut(l) += noisy[l]);
        Energy::new(Domain::Sphere, noisy, centred)
    };
    for last in [3, 20, 40] {
        let spectrum = exact(100, last, |omega| omega * omega / (1.0 + omega * omega));
        let stated =
            predict(&spectrum, &energy(&mut || 0.0).with_stderr(errors.clone(), centred_errors));
        assert_eq!((stated.stderr, stated.dof), (stated.energy_stderr, f64::INFINITY));
        let mut rng = Streams::new(SEED, Purpose::Trial, 0).realization(last as u64);
        let mut noise = || {
            // A sum of twelve uniform numbers has variance 1.
            (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0
        };
        let square: f64 = (0..REPS)
            .map(|_| predict(&spectrum, &energy(&mut noise)).variance - stated.variance)
            .map(|deviation| deviation * deviation)
            .sum();
        let measured = (square / REPS as f64).sqrt();
        // The relative error of a standard deviation is 1/sqrt(2 REPS) = 1.6 %: six of them are
        // exceeded for 2e-9 of seeds.
        assert!((stated.stderr / measured - 1.0).abs() < 0.1, "{last}: {stated:?}, {measured}");
    }
}

/// Realizations and mean spectrum give the same error of energies; it adds to that of the spectrum
/// with the degrees of freedom of Welch and Satterthwaite, and exact energies add nothing.
#[test]
fn errors_of_spectra_and_energies_are_added() {
    let sampler = Pattern::Jittered.build(192, Domain::Sphere).unwrap();
    let sets = Realizations::rotated(&*sampler, Streams::new(SEED, Purpose::Pattern, 0));
    let energy = cap60(60);
    let relative = |energy: &Energy, share: f64| {
        energy.clone().with_estimates(&[energy.of_multiple(f64::sqrt(1.0 + share))])
    };
    let spectrum = estimate(&sets, 60, 200, &()).unwrap();
    let accumulated = |energy: &Energy| {
        let empty = PredictionAccumulator::new(energy, 192, 60);
        accumulate(&sets, Resolution::new(60, 192), 0..200, &empty, &()).unwrap().finish()
    };
    let exact = accumulated(&energy);
    assert_eq!(accumulated(&relative(&energy, 0.0)), exact);
    for share in [1e-3, 0.1] {
        let (energy, bare) = (relative(&energy, share), &energy);
        let (a, b) = (predict(&spectrum, &energy), accumulated(&energy));
        // Sums of 200 numbers in another order.
        assert!((a.energy_stderr / b.energy_stderr - 1.0).abs() < 1e-12, "{a:?}, {b:?}");
        assert!((b.stderr / exact.stderr.hypot(b.energy_stderr) - 1.0).abs() < 1e-14, "{b:?}");
        let dof = 199.0 * (b.stderr / exact.stderr).powi(4);
        assert!((b.dof / dof - 1.0).abs() < 1e-12, "{b:?}, {dof}");
        assert!(predict(&spectrum, bare).energy_stderr == 0.0);
        // A total that is wrong by a share moves the variance of white noise by that share.
        let white = predict(&Spectrum::exact(Domain::Sphere, 192, vec![1.0; 61]), &energy);
        assert!((white.energy_stderr / (share * white.variance) - 1.0).abs() < 1e-10, "{white:?}");
    }
}

/// A cap whose energies are estimated to degree 40, of which another estimate is 1 % larger.
struct Estimated(Cap);

impl Integrand for Estimated {
    fn eval(&self, dir: glam::DVec3) -> f64 {
        self.0.eval(dir)
    }

    fn energy(&self, domain: Domain, lmax: usize) -> Result<Energy, sphvar_integrands::Error> {
        let energy = self.0.energy(domain, lmax.min(40))?;
        let larger = energy.of_multiple(1.01_f64.sqrt());
        Ok(energy.with_estimates(&[larger]))
    }
}

/// Every route of a prediction carries the errors, without more realizations than for exact
/// energies, and ends where energies end; so do rotations and multiples of the integrand.
#[test]
fn every_prediction_carries_the_errors_of_energies() {
    let budget = PredictionBudget::DEFAULT;
    let estimated = || Estimated(Cap::from_degrees(60.0).unwrap());
    let rotated = Rotated::new(estimated(), glam::DQuat::from_rotation_x(1.0)).unwrap();
    let multiple = Sum::default().plus(-3.0, rotated).unwrap();
    for n in [48, 192, 972] {
        for pattern in [Pattern::WhiteNoise, Pattern::Jittered, Pattern::FIBONACCI] {
            let sampler = pattern.build(n, Domain::Sphere).unwrap();
            let point = |integrand: &dyn Integrand| {
                let mut predictor = Predictor::new(integrand, Domain::Sphere, SEED, budget);
                predictor.as_mut().unwrap().predict(&*sampler, &()).unwrap()
            };
            let (exact, got) = (point(&Cap::from_degrees(60.0).unwrap()), point(&estimated()));
            let Prediction { variance, stderr, energy_stderr, .. } = got.prediction;
            // The power of these patterns is below 2, and the tail's is 1.
            assert!(energy_stderr > 0.0 && stderr >= energy_stderr, "{pattern} {n}: {got:?}");
            assert!(got.spectrum.realizations() <= exact.spectrum.realizations(), "{pattern} {n}");
            if pattern == Pattern::WhiteNoise {
                assert!((energy_stderr / (0.01 * variance) - 1.0).abs() < 1e-10, "{n}: {got:?}");
            }
            let off = (variance - exact.prediction.variance).abs();
            assert!(off <= 3.0 * stderr + got.prediction.tail_error, "{pattern} {n}: {got:?}");
            let nine = point(&multiple).prediction;
            assert!((nine.variance / (9.0 * variance) - 1.0).abs() < 1e-12, "{pattern} {n}");
            assert!((nine.stderr / (9.0 * stderr) - 1.0).abs() < 1e-9, "{pattern} {n}");
        }
    }
    // Several terms are an error, not energies without errors.
    let two = multiple.plus(1.0, Cap::from_degrees(20.0).unwrap()).unwrap();
    assert!(two.energy(Domain::Sphere, 8).is_err());
}
