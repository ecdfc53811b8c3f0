//! Coverage of intervals and false-alarm rates of warnings, from simulated estimates and variances.

use std::f64::consts::PI;

use glam::DVec3;
use proptest::prelude::{Just, any, prop_assert, prop_oneof, proptest};
use rand::{Rng, RngExt};
use rand_distr::{Distribution, Exp1, StandardNormal, StudentT};
use sphvar_integrands::{Cap, Circle, Integrand, SampledFunction, Shape};
use sphvar_samplers::{Pattern, Purpose, Streams};
use sphvar_variance::{
    Comparison, Domain, Measurement, PredictionBudget, Predictor, RateFit, Spectrum, Trials,
    VariancePoint, fit_rate, predict,
};

const SEED: u64 = 3;
/// The tolerance of a measured share in standard errors: exceeded by chance for 6e-7 of seeds.
const SIGMAS: f64 = 5.0;

/// Returns the fraction of `reps` measurements with `trials` estimates each whose 95 % interval
/// contains the true variance.
fn coverage(trials: usize, reps: u64, variance: f64, draw: impl Fn(&mut dyn Rng) -> f64) -> f64 {
    let streams = Streams::new(SEED, Purpose::Resample, trials);
    let held = (0..reps).filter(|&i| {
        let mut rng = streams.realization(i);
        let measured = Measurement::new((0..trials).map(|_| draw(&mut rng)).collect());
        measured
            .variance_interval(0.95)
            .is_some_and(|(low, high)| low <= variance && variance <= high)
    });
    held.count() as f64 / reps as f64
}

fn normal(rng: &mut dyn Rng) -> f64 {
    StandardNormal.sample(rng)
}

/// The coverage is 95 % for normal estimates and for a biased coin of probability one in six, and
/// higher for a fair coin: its variance is nearly the largest possible for two values, so it is
/// never far off. With few trials the coverage is lower for heavy tails, because the trials have
/// not sampled the tail: for exponential estimates and Student's with 5 degrees of freedom it is 91
/// to 92 % at 100 trials (88 to 90 % with the fourth moment instead of the jackknife) and 94 % at
/// 1000.
#[test]
fn variance_intervals_have_the_stated_coverage() {
    const REPS: u64 = 1000;
    let margin = |share: f64| SIGMAS * (share * (1.0 - share) / REPS as f64).sqrt();
    let t5 = StudentT::new(5.0).unwrap();
    for (trials, heavy) in [(100, 0.91), (1000, 0.935)] {
        let within = |name, got: f64, low: f64, high: f64| {
            let range = low - margin(low)..=high + margin(0.95);
            assert!(range.contains(&got), "{name}, {trials} trials: {got}, expected {range:?}");
        };
        within("normal", coverage(trials, REPS, 1.0, normal), 0.945, 0.95);
        let sixth = |rng: &mut dyn Rng| f64::from(u8::from(normal(rng) > 1.0));
        let p = 0.158_655_253_931_457;
        within("coin", coverage(trials, REPS, p * (1.0 - p), sixth), 0.94, 0.96);
        let coin = |rng: &mut dyn Rng| f64::from(u8::from(normal(rng) > 0.0));
        within("fair coin", coverage(trials, REPS, 0.25, coin), 0.99, 1.0);
        within("exponential", coverage(trials, REPS, 1.0, |rng| Exp1.sample(rng)), heavy, 0.95);
        within("Student", coverage(trials, REPS, 5.0 / 3.0, |rng| t5.sample(rng)), heavy, 0.95);
    }
}

/// Draws from a difficult distribution.
fn difficult(kind: u8, rng: &mut dyn Rng) -> f64 {
    let x = normal(rng);
    match kind {
        // Two values with probabilities about one half and one in a hundred, and few values with
        // ties.
        0 => f64::from(u8::from(x > 0.0)),
        1 => f64::from(u8::from(x > 2.326)),
        2 => x.round(),
        // Heavy tails: no variance, no mean, and lobes that are mostly far below their peak.
        3 => 1.0 / x,
        4 => (5.0 * x).exp(),
        5 => (-50.0 * x.abs()).exp(),
        // A spike on an offset, and nearly constant values.
        6 => 1e8 + f64::from(u8::from(x > 3.0)),
        _ => 1.0 + 1e-15 * x,
    }
}

proptest! {
    /// For any estimates, an interval is finite and contains the measured variance. Scaling the
    /// estimates within range does not change this.
    #[test]
    fn intervals_contain_the_measured_value(
        kind in 0_u8..8,
        log_trials in 1.4_f64..9.2,
        exponent in prop_oneof![Just(0), Just(-140), Just(140)],
        confidence in prop_oneof![Just(0.05), Just(0.95), Just(0.999_999)],
        outlier in any::<bool>(),
        seed in any::<u64>(),
    ) {
        let mut rng = Streams::new(seed, Purpose::Resample, 0).realization(0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "4 to 10^4")]
        let trials = log_trials.exp() as usize;
        let scale = 10f64.powi(exponent);
        let mut estimates: Vec<f64> = (0..trials).map(|_| scale * difficult(kind, &mut rng)).collect();
        if outlier {
            estimates[0] = 1e6 * scale;
        }
        let measured = Measurement::new(estimates);
        let variance = measured.variance();
        if let Some((low, high)) = measured.variance_interval(confidence) {
            prop_assert!(low >= 0.0 && low <= variance && variance <= high, "{low} {variance} {high}");
            prop_assert!(high.is_finite() && high > 0.0, "{low} {variance} {high}");
            prop_assert!(measured.relative_error().is_known());
        }
    }
}

/// For lobes of which only the peak counts, and any share of trials that hit it, at most 7 % of
/// intervals miss the true variance, relative to all trials including those without an interval;
/// with 50 or more peaks, 95 % of the trials have an interval. The lobe is `e^-u` for u uniform on
/// (0, range): variance `1/(2 range) - 1/range^2`, and `1000/range` trials of 1000 within `u < 1`.
#[test]
fn intervals_of_rare_peaks_cover_or_are_absent() {
    const REPS: u64 = 400;
    for (case, peaks) in [0.05, 0.3, 1.0, 3.0, 10.0, 60.0].into_iter().enumerate() {
        let range: f64 = 1000.0 / peaks;
        let variance = 0.5 / range - range.powi(-2);
        let (mut missed, mut absent) = (0, 0);
        for i in 0..REPS {
            let mut rng = Streams::new(SEED, Purpose::Trial, case).realization(i);
            let lobe = |u: f64| (-range * u).exp();
            let estimates = (0..1000).map(|_| lobe(rng.random::<f64>())).collect();
            match Measurement::new(estimates).variance_interval(0.95) {
                None => absent += 1,
                Some((low, high)) => missed += i32::from(!(low <= variance && variance <= high)),
            }
        }
        // Five standard errors of 5 % are 5.4 %.
        assert!(f64::from(missed) <= 0.07 * REPS as f64, "{peaks}: {missed} of {REPS} miss");
        assert!(peaks < 50.0 || absent == 0, "{peaks}: {absent} of {REPS} absent");
        assert!(peaks > 0.1 || f64::from(absent) > 0.95 * REPS as f64, "{peaks}: {absent}");
    }
}

/// A cap of the size of the sun with white noise and with lattices: too few trials hit it for an
/// interval, a score or a verdict, whatever the difference from the prediction. The same holds for
/// the complement, a cap of 179 degrees. If all trials agree there is an upper limit, never (0, 0).
#[test]
fn caps_missed_by_all_trials_have_a_limit_and_no_verdict() {
    for (degrees, n, trials) in [(0.27, 100, 1000), (179.0, 2, 2000), (179.9, 10, 100)] {
        for pattern in [Pattern::WhiteNoise, Pattern::FIBONACCI] {
            let cap = Cap::from_degrees(degrees).unwrap();
            let (p, q) = (
                0.5 * (1.0 - degrees.to_radians().cos()),
                (0.5 * degrees.to_radians()).cos().powi(2),
            );
            // Below half a point the points are well separated and the counts are nearly Poisson
            // distributed.
            let truth = (4.0 * PI).powi(2) * p * q / n as f64;
            let (mut missed, mut agreed) = (0, 0);
            for seed in 0..40 {
                let got = comparison(&pattern, n, &cap, trials, seed);
                let measured = got.measurement.variance();
                match got.measured_interval(0.95) {
                    None => assert!(got.has_too_few_hits(), "{degrees} {pattern} {seed}"),
                    Some((low, high)) => {
                        assert!(low <= measured && measured <= high && high > 0.0);
                        missed += i32::from(!(low <= truth && truth <= high));
                    }
                }
                agreed += i32::from(measured == 0.0);
                if measured == 0.0 {
                    assert!(
                        got.has_too_few_hits() && got.z_score().is_nan() && got.bias().is_none()
                    );
                    assert!(got.ratio().0.is_nan() && got.measured_point().stderr.is_infinite());
                }
            }
            // 5 % of 40 are 2; 8 exceed four standard errors.
            assert!(missed <= 8, "{degrees} {pattern}: {missed}");
            assert!(agreed > 5, "{degrees} {pattern}: {agreed} agree");
        }
    }
}

/// White noise on a probe whose variance comes from one texel in 1e5: the sample appears well
/// behaved, but the moments of the integrand show that it is not.
#[test]
fn moments_reveal_variance_that_no_trial_hits() {
    let spike = |d: DVec3| 2.0 + d.z + if d.z > 1.0 - 2e-5 { 1e5 } else { 0.0 };
    let edge = Circle { axis: DVec3::Z, angle: (1.0f64 - 2e-5).acos() };
    let probe =
        SampledFunction::with_shape(spike, Shape::smooth(1).zonal(DVec3::Z).with_edge(edge));
    // p = 1e-5 of the sphere: kurtosis 1/p.
    let kurtosis = probe.kurtosis(Domain::Sphere).unwrap();
    assert!((kurtosis * 1e-5 - 1.0).abs() < 1e-3, "{kurtosis}");
    for pattern in [Pattern::WhiteNoise, Pattern::FIBONACCI] {
        let got = comparison(&pattern, 48, &probe, 20, 1);
        assert!(got.has_too_few_hits() && got.z_score().is_nan() && got.bias().is_none());
        assert!(got.measured_interval(0.95).is_none() && got.is_prediction_more_precise());
        // The sample alone does not show the rare texel.
        assert!(got.measurement.variance_interval(0.95).is_some(), "{pattern}");
    }
}

/// Scores of white noise with known moments: mean 0, variance 1, whatever the kurtosis; 400 seeds.
#[test]
fn scores_with_known_moments_are_standard() {
    const SEEDS: u64 = 400;
    for (degrees, n) in [(60.0, 1), (10.0, 4), (3.0, 48)] {
        let cap = Cap::from_degrees(degrees).unwrap();
        let scores: Vec<f64> = (0..SEEDS)
            .map(|seed| comparison(&Pattern::WhiteNoise, n, &cap, 400, seed))
            .map(|c| c.z_score())
            .filter(|z| z.is_finite())
            .collect();
        let count = scores.len() as f64;
        assert!(count > 0.95 * SEEDS as f64, "{degrees}: {count}");
        let mean = scores.iter().sum::<f64>() / count;
        let square = scores.iter().map(|z| z * z).sum::<f64>() / count;
        // Five standard errors of a mean, and of a mean square of kurtosis up to 6.
        assert!(mean.abs() < 5.0 / count.sqrt(), "{degrees}: mean {mean}");
        assert!((square - 1.0).abs() < 5.0 * (5.0 / count).sqrt(), "{degrees}: square {square}");
    }
}

fn comparison(
    pattern: &Pattern,
    n: usize,
    integrand: &dyn Integrand,
    trials: u64,
    seed: u64,
) -> Comparison {
    let sampler = pattern.build(n, Domain::Sphere).unwrap();
    let energy = integrand.energy(Domain::Sphere, 8).unwrap();
    let spectrum = Spectrum::exact(Domain::Sphere, n, vec![1.0; 9]);
    let prediction = predict(&spectrum, &energy);
    let predictor =
        Predictor::new(integrand, Domain::Sphere, seed, PredictionBudget::DEFAULT).unwrap();
    predictor.measure(prediction, &*sampler, Trials::new(trials), &()).unwrap()
}

/// The curvature of power laws with errors of 2 %, known or estimated from the scatter, is
/// significant as often as the level states, here 1 % to obtain a sufficient count.
#[test]
fn power_laws_are_rarely_reported_as_curved() {
    const REPS: u64 = 10_000;
    for known in [true, false] {
        let streams = Streams::new(SEED, Purpose::Resample, usize::from(known));
        let alarms = (0..REPS).filter(|&i| {
            let mut rng = streams.realization(i);
            let points: Vec<VariancePoint> = [12.0, 48.0, 108.0, 192.0, 768.0, 3072.0]
                .iter()
                .map(|&n: &f64| {
                    let variance = n.powf(-1.5) * (0.02 * normal(&mut rng)).exp();
                    VariancePoint {
                        n_points: n,
                        variance,
                        stderr: if known { 0.02 * variance } else { 0.0 },
                    }
                })
                .collect();
            let fit = fit_rate(&points).unwrap();
            assert_eq!(
                fit.is_pre_asymptotic(),
                fit.slope_change_p < RateFit::FALSE_ALARM,
                "{fit:?}"
            );
            fit.slope_change_p < 0.01
        });
        let share = alarms.count() as f64 / REPS as f64;
        // Binomial: 0.1 % is one standard error.
        assert!((share - 0.01).abs() < SIGMAS * 0.001, "known errors {known}: {share}");
    }
}

/// Recorded variances of the cap of 60 degrees with errors of 1 %: Poisson disk patterns change
/// from N^-1.2 to N^-1 and have measured exponents of -1.08 to -1.14; jittered sampling has N^-1.5
/// from the start.
#[test]
fn poisson_disk_rates_are_pre_asymptotic() {
    let fit = |variances: [f64; 4]| {
        let points: Vec<VariancePoint> = [192.0, 768.0, 3072.0, 12288.0]
            .into_iter()
            .zip(variances)
            .map(|(n_points, variance)| VariancePoint {
                n_points,
                variance,
                stderr: 0.01 * variance,
            })
            .collect();
        fit_rate(&points).unwrap()
    };
    let disks = fit([1.594e-2, 3.07e-3, 6.75e-4, 1.67e-4]);
    assert!((-1.14..-1.08).contains(&disks.slope), "{disks:?}");
    assert!(disks.is_pre_asymptotic() && disks.slope_change > 0.1, "{disks:?}");
    let jitter = fit([1.544e-2, 1.934e-3, 2.420e-4, 3.026e-5]);
    assert!((jitter.slope + 1.5).abs() < 0.01, "{jitter:?}");
    assert!(!jitter.is_pre_asymptotic(), "{jitter:?}");
}
