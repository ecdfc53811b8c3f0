//! The hemisphere with antipodes identified, and the visible halves of sphere sets.

use std::f64::consts::PI;

use glam::DVec3;
use sphvar_integrands::{
    Cap, ClampedCosine, Integrand, VisibleHalfEstimator, VisibleHalfIntegrand,
};
use sphvar_samplers::{Domain, Pattern, Purpose, Realizations, Streams, uniform_rotation};
use sphvar_spectrum::{Moments, Resolution, Spectrum, SpectrumAccumulator, accumulate, estimate};
use sphvar_tests::{Family, PointList, ReferenceSpectrum, chi2_interval, exact_jitter_spectrum};
use sphvar_variance::{CutAxis, Measurement, measure, measure_visible_half, predict};

const SEED: u64 = 6;
/// The probability that a family of comparisons fails by chance (nominal).
const ALPHA: f64 = 1e-4;

fn hemisphere_spectrum(pattern: Pattern, n: usize, lmax: usize, realizations: u64) -> Spectrum {
    let sampler = pattern.build(n, Domain::Hemisphere).unwrap();
    let ensemble = Realizations::rotated(&*sampler, Streams::new(SEED, Purpose::Pattern, n));
    estimate(&ensemble, lmax, realizations, &()).unwrap()
}

/// The largest z, and chi-square within the interval that is left with probability ALPHA.
fn assert_agrees(got: &Spectrum, expected: &[f64], name: &'static str) {
    let mut family = Family::new(name);
    for (l, power, stderr) in got.rows().skip(1) {
        assert_eq!(l % 2, 0, "{name}: only even degrees exist");
        family.compare(power, expected[l], stderr, || format!("l = {l}"));
    }
    family.assert_null(ALPHA);
    let dof = family.scores().len();
    let chi2 = family.scores().iter().map(|z| z * z).sum::<f64>() / dof as f64;
    let (low, high) = chi2_interval(dof, ALPHA);
    assert!((low..=high).contains(&chi2), "{name}: chi2/dof = {chi2}, {dof} degrees");
}

/// One sample for each antipodal pair of cells: the spectrum of sphere jitter at the same nside.
#[test]
fn stratified_antipodal_pairs_have_the_spectrum_of_sphere_jitter() {
    let reference = ReferenceSpectrum::load("jitter_exact_972");
    let got = hemisphere_spectrum(Pattern::Jittered, 6 * 81, reference.lmax(), 300);
    assert_agrees(&got, reference.power(), "N_H = 486");
    for nside in [1_u32, 2, 4] {
        let n = 6 * (nside * nside) as usize;
        let got = hemisphere_spectrum(Pattern::Jittered, n, 40, 2000);
        assert_agrees(&got, &exact_jitter_spectrum(nside, 40), "N_H = 6, 24 or 96");
    }
}

#[test]
fn white_noise_is_1() {
    let got = hemisphere_spectrum(Pattern::WhiteNoise, 100, 60, 1000);
    assert_agrees(&got, &[1.0; 61], "white noise on the hemisphere");
    // Odd degrees do not exist and read 0.
    assert!(got.power().iter().skip(1).step_by(2).all(|p| *p == 0.0), "{:?}", got.power());
}

/// White noise and the double cap of 60 degrees: `(2 pi int f^2 - (int f)^2)/N = pi^2/N`, from the
/// energies exactly and from measurement.
#[test]
fn the_double_cap_with_white_noise() {
    const N: usize = 64;
    const TRIALS: u64 = 20_000;
    let cap = Cap::from_degrees(60.0).unwrap();
    assert!((cap.exact(Domain::Hemisphere).unwrap() - PI).abs() < 1e-14);
    let energy = cap.energy(Domain::Hemisphere, 500).unwrap();
    let with_power_1 = Domain::Hemisphere.variance_factor(N) * energy.beyond(0);
    let expected = PI * PI / N as f64;
    // Four roundings.
    assert!((with_power_1 / expected - 1.0).abs() < 1e-14, "{with_power_1}, expected {expected}");
    // Energies are four times those of the cap, even degrees only.
    let sphere = cap.energy(Domain::Sphere, 500).unwrap();
    for (l, (h, s)) in energy.per_band().iter().zip(sphere.per_band()).enumerate() {
        let copies = if l % 2 == 0 { 4.0 } else { 0.0 };
        assert!((h - copies * s).abs() <= 1e-15, "l = {l}: {h}, {copies} times {s}");
    }
    let sampler = Pattern::WhiteNoise.build(N, Domain::Hemisphere).unwrap();
    let streams = Streams::new(SEED, Purpose::Trial, N);
    let got = measure(&Realizations::rotated(&*sampler, streams), &cap, TRIALS, &()).unwrap();
    // False alarm: ALPHA.
    let mut family = Family::new("double cap, white noise");
    family.compare(got.variance(), expected, got.variance_stderr(), || "variance".into());
    family.compare(got.mean(), PI, got.mean_stderr(), || "mean".into());
    family.assert_null(ALPHA);
}

/// Prediction and measurement of every pattern on the hemisphere. False alarm: ALPHA for the
/// family.
#[test]
fn measured_variances_are_the_predicted_ones() {
    const LMAX: usize = 120;
    const SETS: u64 = 300;
    const TRIALS: u64 = 3000;
    let cap = Cap::from_degrees(60.0).unwrap();
    let energy = cap.energy(Domain::Hemisphere, LMAX).unwrap();
    let mut family = Family::new("double cap");
    for pattern in Pattern::ELEMENTARY {
        for requested in [24, 192] {
            let n = pattern.nearest_count(requested, Domain::Hemisphere);
            let sampler = pattern.build(n, Domain::Hemisphere).unwrap();
            let sets = Realizations::rotated(&*sampler, Streams::new(SEED, Purpose::Pattern, n));
            let predicted = predict(&estimate(&sets, LMAX, SETS, &()).unwrap(), &energy);
            let trials = Realizations::rotated(&*sampler, Streams::new(SEED, Purpose::Trial, n));
            let got = measure(&trials, &cap, TRIALS, &()).unwrap();
            let stderr = got.variance_stderr().hypot(predicted.stderr);
            family.compare(got.variance(), predicted.variance, stderr, || format!("{pattern} {n}"));
        }
    }
    family.assert_null(ALPHA);
}

/// Returns the points with z > 0 of a rotated realization of sphere jitter.
fn visible_half(m: usize, index: u64) -> Vec<DVec3> {
    let sampler = Pattern::Jittered.build(m, Domain::Sphere).unwrap();
    let streams = Streams::new(SEED, Purpose::Resample, m);
    let mut points = Realizations::rotated(&*sampler, streams).realize(index).unwrap().points;
    points.retain(|p| p.z > 0.0);
    points
}

/// The number of visible points is random: mean M/2, variance `(M/4 pi) sum_{l odd} E_90(l) P(l)`,
/// for jitter 0.30 sqrt(M).
#[test]
fn half_a_sphere_set_has_a_random_number_of_points() {
    const REALIZATIONS: u64 = 4000;
    let mut family = Family::new("number of points kept");
    for nside in [2_u32, 4, 8] {
        let m = 12 * (nside * nside) as usize;
        let lmax = 16 * nside as usize;
        let energy = Cap::from_degrees(90.0).unwrap().energy(Domain::Sphere, lmax).unwrap();
        let spectrum = exact_jitter_spectrum(nside, lmax);
        let known: f64 = energy.per_band().iter().zip(&spectrum).skip(1).map(|(e, p)| e * p).sum();
        let expected = m as f64 / (4.0 * PI) * (known + energy.beyond(lmax));
        let mut count = Moments::default();
        for i in 0..REALIZATIONS {
            count.push(visible_half(m, i).len() as f64);
        }
        family.compare(count.mean(), 0.5 * m as f64, count.standard_error(), || {
            format!("mean, M = {m}")
        });
        // Close to normal: the variance's relative error is sqrt(2/R).
        let stderr = expected * (2.0 / REALIZATIONS as f64).sqrt();
        family.compare(count.variance(), expected, stderr, || format!("variance, M = {m}"));
        let coefficient = expected / (m as f64).sqrt();
        assert!((coefficient - 0.30).abs() < 0.003, "M = {m}: variance {coefficient} sqrt(M)");
    }
    family.assert_null(ALPHA);
}

/// Treated as an antipodal pattern, the visible half has far more power at low degrees than a
/// stratified antipodal pattern.
#[test]
fn half_a_sphere_set_is_not_stratified() {
    const REALIZATIONS: u64 = 3000;
    for (nside, recorded) in [(2_u32, 0.203), (4, 0.075), (8, 0.0313)] {
        let m = 12 * (nside * nside) as usize;
        let empty = SpectrumAccumulator::new(Domain::Hemisphere, m / 2, 2);
        let sets = PointList(|i| visible_half(m, i));
        let got = accumulate(&sets, Resolution::new(2, 100), 0..REALIZATIONS, &empty, &())
            .unwrap()
            .finish()
            .unwrap();
        let stratified = exact_jitter_spectrum(nside, 2)[2];
        let (power, stderr) = (got.power()[2], got.stderr()[2]);
        // Recorded with errors of 2.5 %; six standard errors of both.
        let off = (power - recorded).abs() / stderr.hypot(0.03 * recorded);
        assert!(off < 6.0, "M = {m}: P(2) = {power}, recorded {recorded}");
        assert!(power > 1.4 * stratified, "M = {m}: {power}, stratified {stratified}");
    }
}

/// Estimates of a double cap about random axes from half a sphere set: `(4 pi/M) sum f` is unbiased
/// but has a larger variance due to the jump on the equator, the ratio estimate `(2 pi/n) sum f`
/// less so; stratified antipodal points are best.
#[test]
fn estimators_from_half_a_sphere_set() {
    const TRIALS: u64 = 6000;
    const NSIDE: usize = 4;
    let m = 12 * NSIDE * NSIDE;
    let pairs = Pattern::Jittered.build(m / 2, Domain::Hemisphere).unwrap();
    let streams = Streams::new(SEED, Purpose::Trial, m);
    let best = Realizations::rotated(&*pairs, streams);
    let axes = Streams::new(SEED + 1, Purpose::Trial, m);
    let mut estimates = [const { Vec::new() }; 3];
    for i in 0..TRIALS {
        let axis = uniform_rotation(&mut axes.realization(i)) * DVec3::Z;
        let sum =
            |points: &[DVec3]| points.iter().filter(|p| p.dot(axis).abs() >= 0.5).count() as f64;
        let points = visible_half(m, i);
        estimates[0].push(4.0 * PI / m as f64 * sum(&points));
        estimates[1].push(2.0 * PI / points.len() as f64 * sum(&points));
        estimates[2].push(4.0 * PI / m as f64 * sum(&best.realize(i).unwrap().points));
    }
    let [fixed, ratio, best] = estimates.map(Measurement::new);
    // False alarm: ALPHA.
    let mut family = Family::new("bias of half a set");
    family.compare(fixed.mean(), PI, fixed.mean_stderr(), || "(4 pi/M) sum f".into());
    family.compare(best.mean(), PI, best.mean_stderr(), || "stratified antipodal pairs".into());
    family.assert_null(ALPHA);
    let (a, b) = (fixed.variance() / best.variance(), ratio.variance() / best.variance());
    // Recorded 1.5 to 1.6 and 1.2 to 1.3; a ratio of variances has an error of sqrt(4/6000) = 2.6
    // %, so the margins are six of them.
    assert!((a / 1.55 - 1.0).abs() < 0.18, "unbiased over stratified: {a}");
    assert!((b / 1.25 - 1.0).abs() < 0.18, "ratio estimate over stratified: {b}");
}

/// The cut sets of the library: with a randomly rotated cut, the ratios of the test above; with the
/// cut at the equator, the variance that the formula of the sphere predicts for functions that
/// vanish below it. False alarm: ALPHA.
#[test]
fn visible_halves_are_measured_and_predicted() {
    const TRIALS: u64 = 6000;
    const M: usize = 192;
    let cap = Cap::from_degrees(60.0).unwrap();
    let sphere = Pattern::Jittered.build(M, Domain::Sphere).unwrap();
    let sets = Realizations::rotated(&*sphere, Streams::new(SEED + 2, Purpose::Trial, M));
    let pairs = Pattern::Jittered.build(M / 2, Domain::Hemisphere).unwrap();
    let pairs = Realizations::rotated(&*pairs, Streams::new(SEED + 3, Purpose::Trial, M));
    let best = measure(&pairs, &cap, TRIALS, &()).unwrap();
    let axis = CutAxis::Random(Streams::new(SEED + 2, Purpose::Resample, M));
    let got = measure_visible_half(&sets, &cap, axis, TRIALS, &()).unwrap();
    let ratio = |m: &Measurement| m.variance() / best.variance();
    let (a, b) = (ratio(&got.unbiased), ratio(&got.ratio));
    // As in the test above: six standard errors of 2.6 %.
    assert!((a / 1.55 - 1.0).abs() < 0.18, "unbiased over stratified: {a}");
    assert!((b / 1.25 - 1.0).abs() < 0.18, "ratio estimate over stratified: {b}");

    let lmax = 8 * M.isqrt();
    let spectrum = Spectrum::exact(Domain::Sphere, M, exact_jitter_spectrum(4, lmax));
    let mut family = Family::new("cut at the equator");
    let integrands: [(&str, &dyn Integrand); 2] = [("cap", &cap), ("cosine", &ClampedCosine)];
    for (name, integrand) in integrands {
        let got = measure_visible_half(&sets, integrand, CutAxis::Equator, TRIALS, &()).unwrap();
        for (estimator, got) in [
            (VisibleHalfEstimator::Unbiased, &got.unbiased),
            (VisibleHalfEstimator::Ratio, &got.ratio),
        ] {
            let cut = VisibleHalfIntegrand::new(integrand, estimator).unwrap();
            let predicted = predict(&spectrum, &cut.energy(Domain::Sphere, lmax).unwrap());
            let stderr = got.variance_stderr().hypot(predicted.total_stderr());
            // The ratio's variance is that to first order: the next order is Var n/n^2 of it, 0.2
            // %.
            let stderr = stderr.hypot(2e-3 * predicted.variance);
            let label = || format!("{name}, {estimator:?}, variance");
            family.compare(got.variance(), predicted.variance, stderr, label);
        }
        let exact = integrand.exact(Domain::Hemisphere).unwrap();
        let (mean, stderr) = (got.unbiased.mean(), got.unbiased.mean_stderr());
        family.compare(mean, exact, stderr, || format!("{name}, mean"));
    }
    family.assert_null(ALPHA);
}
