//! Spectra of the patterns compared with spectra from independent programs.

use std::f64::consts::PI;

use sphvar_samplers::{
    Domain, EqualAreaParameters, Pattern, Placement, Purpose, Realizations, Streams,
};
use sphvar_spectrum::{ExactSpectrum, Spectrum, estimate};
use sphvar_tests::{
    Family, ReferenceSpectrum, chi2_false_alarm, chi2_interval, exact_jitter_spectrum,
};

const SEED: u64 = 0;
/// The probability that a family of comparisons fails by chance (nominal).
const ALPHA: f64 = 1e-4;
const REALIZATIONS: u64 = 300;
/// The window for chi-square per degree of freedom of a comparison of two correct spectra.
const CHI2_WINDOW: (f64, f64) = (0.8, 1.2);

fn spectrum(pattern: &Pattern, n: usize, lmax: usize, realizations: u64) -> Spectrum {
    let sampler = pattern.build(n, Domain::Sphere).unwrap();
    let ensemble = Realizations::rotated(&*sampler, Streams::new(SEED, Purpose::Pattern, n));
    estimate(&ensemble, lmax, realizations, &()).unwrap()
}

/// Chi-square per degree of freedom over the degrees 1 to lmax, and the family of z-scores.
fn compare(got: &Spectrum, expected: &[f64], name: &'static str) -> (f64, Family) {
    let mut family = Family::new(name);
    for (l, power, stderr) in got.rows().skip(1) {
        family.compare(power, expected[l], stderr, || format!("l = {l}"));
    }
    let chi2: f64 = family.scores().iter().map(|z| z * z).sum();
    (chi2 / family.scores().len() as f64, family)
}

/// False alarms, were the seed not fixed: 5.0 % of seeds for the 190 degrees and 11 % for the 126,
/// since chi-square per degree of freedom spreads by sqrt(2/dof); the window is two of these at 190
/// degrees. ALPHA for the largest deviation.
#[test]
#[ignore = "statistics"]
fn jitter_has_its_recorded_spectrum() {
    for (n, lmax, name, false_alarm) in
        [(3888, 190, "jitter_exact_3888", 0.050), (972, 126, "jitter_exact_972", 0.106)]
    {
        let reference = ReferenceSpectrum::load(name);
        assert!(reference.stderr()[1..].iter().all(|e| *e == 0.0), "{name} must be exact");
        let got = spectrum(&Pattern::Jittered, n, lmax, REALIZATIONS);
        let (chi2, family) = compare(&got, reference.power(), name);
        let (low, high) = CHI2_WINDOW;
        assert!((low..=high).contains(&chi2), "{name}: chi2/dof = {chi2}");
        family.assert_null(ALPHA);
        let alarm = chi2_false_alarm(lmax, low, high);
        assert!((alarm - false_alarm).abs() < 0.01, "{name}: false-alarm rate {alarm}, not stated");
    }
}

/// The standard error is correct too: sd of one realization's P(l) is sqrt(2/(2l+1)) P(l) for an
/// isotropic ensemble of many independent points. False alarm: ALPHA and what the 5 % allowance
/// leaves.
#[test]
fn the_spread_of_white_noise_is_that_of_its_orders() {
    const N: usize = 256;
    const LMAX: usize = 64;
    const WHITE: u64 = 1000;
    let got = spectrum(&Pattern::WhiteNoise, N, LMAX, WHITE);
    let (chi2, family) = compare(&got, &[1.0; LMAX + 1], "white noise");
    family.assert_null(ALPHA);
    let (low, high) = chi2_interval(LMAX, ALPHA);
    assert!((low..=high).contains(&chi2), "chi2/dof = {chi2} outside {low} to {high}");
    let mut spread = Family::new("spread of white noise");
    for (l, _, stderr) in got.rows().skip(1) {
        let sd = stderr * (WHITE as f64).sqrt();
        let expected = (2.0 / (2.0 * l as f64 + 1.0)).sqrt();
        // The relative error of a standard deviation: sqrt((kurtosis - 1)/(4 R)), the kurtosis of
        // chi-square with 2l+1 degrees of freedom being 3 + 12/(2l+1).
        let relative = ((2.0 + 12.0 / (2.0 * l as f64 + 1.0)) / (4.0 * WHITE as f64)).sqrt();
        spread.compare(sd, expected, expected * relative, || format!("l = {l}"));
    }
    spread.assert_null(ALPHA);
}

/// The pixel centres are antipodally symmetric, so odd degrees vanish; even ones do not.
#[test]
fn healpix_has_its_recorded_spectrum() {
    let reference = ReferenceSpectrum::load("healpix_972");
    let got = spectrum(&Pattern::Healpix, 972, reference.lmax(), REALIZATIONS);
    assert_eq!(got.realizations(), 1, "a fixed pattern is transformed once");
    for (l, power, stderr) in got.rows().skip(1) {
        assert!(stderr == 0.0, "l = {l}: a fixed pattern has no standard error, got {stderr}");
        if l % 2 == 1 {
            assert!(power < 1e-20, "l = {l}: {power:e}");
        } else {
            digits_agree(l, power, reference.power()[l]);
        }
    }
    // The large-N constants N P(l) -> 0.309, 0.906, 0.460, 0.208; at N = 972 they are up to 2.3 %
    // off.
    for (l, constant) in [(2, 0.309), (4, 0.906), (6, 0.460), (8, 0.208)] {
        let scaled = 972.0 * got.power()[l];
        assert!((scaled / constant - 1.0).abs() < 0.025, "l = {l}: N P = {scaled}");
    }
    let fine = spectrum(&Pattern::Healpix, 12 * 64 * 64, 8, 1);
    for (l, constant) in [(2, 0.309), (4, 0.906), (6, 0.460), (8, 0.208)] {
        let scaled = 49152.0 * fine.power()[l];
        assert!((scaled / constant - 1.0).abs() < 0.003, "nside 64, l = {l}: N P = {scaled}");
    }
}

#[test]
fn fibonacci_has_its_recorded_spectrum() {
    let reference = ReferenceSpectrum::load("fib_1024");
    let got = spectrum(&Pattern::FIBONACCI, 1024, reference.lmax(), 1);
    for (l, power, _) in got.rows().skip(1) {
        digits_agree(l, power, reference.power()[l]);
    }
}

/// The files print eight digits: half a unit of the last is 5e-8 relative at most.
fn digits_agree(l: usize, power: f64, recorded: f64) {
    // Rounding of N = 1000 terms: |S| to 1e-13, P to 2 sqrt(4 pi P/N) 1e-13.
    let rounding = 2.0 * (4.0 * PI * recorded / 972.0).sqrt() * 1e-13;
    assert!(
        (power - recorded).abs() < 5.1e-8 * recorded + rounding,
        "l = {l}: {power:e}, recorded {recorded:e}"
    );
}

/// Jitter at low degrees: `<P(l)> = c_N l(l+1)/N (1 + O(l^2/N))`, with constants from 1.0117 for 12
/// points to the limit 1.118598.
#[test]
fn jitter_has_the_predicted_power_at_low_degrees() {
    let limit = 4.0 / 3.0 * 1.2_f64.ln() + 2.0 / 9.0 * 5.0_f64.ln() + 17.0 * PI * PI / 324.0;
    assert!((limit - 1.118598).abs() < 1e-6, "{limit}");
    let constants: Vec<f64> = [1_u32, 2, 3, 4, 9, 16]
        .iter()
        .map(|&nside| exact_jitter_spectrum(nside, 1)[1] * 6.0 * f64::from(nside * nside))
        .collect();
    for (c, recorded) in constants.iter().zip([1.0117, 1.0771, 1.0958, 1.1039, 1.1143, 1.1168]) {
        assert!((c - recorded).abs() < 1e-4, "c = {c}, recorded {recorded}");
    }
    assert!(constants.is_sorted() && constants[5] < limit, "{constants:?}");
    // Quadratic in sqrt(l(l+1)), not in l: the constant is the same for the next degrees.
    let spectrum = exact_jitter_spectrum(32, 8);
    let n = 12.0 * 1024.0;
    for (l, p) in spectrum.iter().enumerate().skip(1) {
        let c = n * p / (l * (l + 1)) as f64;
        let correction = (l * l) as f64 / n;
        assert!((c - 1.1179).abs() < 3e-4 + correction, "l = {l}: c = {c}");
    }
    // Cells of another shape than their neighbours, at the poles, at |z| = 2/3 and on the edges of
    // the faces, are some 1/nside of all: c_N = limit + a/nside + ..., extrapolated twice.
    let [coarse, middle, fine] = [32_u32, 64, 128]
        .map(|nside| exact_jitter_spectrum(nside, 1)[1] * 6.0 * f64::from(nside * nside));
    let (first, second) = (2.0 * middle - coarse, 2.0 * fine - middle);
    let extrapolated = second + (second - first) / 3.0;
    // The second order has a logarithm, from the sum over rings: ln(128)/128^2 = 3e-4, of which 2 %
    // are left.
    assert!((extrapolated - limit).abs() < 1e-5, "{extrapolated}, limit {limit}");
}

/// Exact spectra against sampled ones. False alarms, were the seeds not fixed: at most ALPHA for
/// the largest deviation, 2 ALPHA for chi-square (ALPHA, and as much for its stderrs being
/// estimates) of each case.
#[test]
#[ignore = "statistics"]
fn exact_spectra_are_what_sampling_finds() {
    const MANY: u64 = 1500;
    let equal_area = Pattern::EqualArea(EqualAreaParameters { placement: Placement::Jittered });
    for (pattern, n, domain, lmax) in [
        (Pattern::Jittered, 768, Domain::Sphere, 110),
        (Pattern::Jittered, 150, Domain::Hemisphere, 100),
        (equal_area.clone(), 333, Domain::Sphere, 80),
        (equal_area, 61, Domain::Hemisphere, 60),
    ] {
        let sampler = pattern.build(n, domain).unwrap();
        let ensemble = Realizations::rotated(&*sampler, Streams::new(SEED, Purpose::Trial, n));
        let got = estimate(&ensemble, lmax, MANY, &()).unwrap();
        let exact = ExactSpectrum::of(&*sampler).unwrap().to(lmax, &()).unwrap();
        assert!(exact.is_exact() && exact.realizations() == 0);
        let (chi2, family) = compare(&got, exact.power(), "an exact spectrum");
        family.assert_null(ALPHA);
        let (low, high) = chi2_interval(family.scores().len(), ALPHA);
        assert!((low..=high).contains(&chi2), "{pattern}, N = {n}, {domain}: chi2/dof = {chi2}");
    }
}

/// A deterministic pattern has the power of any of its realizations.
#[test]
fn exact_spectra_of_fixed_patterns_are_those_of_a_rotated_set() {
    for (pattern, domain) in
        [(Pattern::Healpix, Domain::Sphere), (Pattern::FIBONACCI, Domain::Hemisphere)]
    {
        const N: usize = 768;
        let n = pattern.nearest_count(N, domain);
        let sampler = pattern.build(n, domain).unwrap();
        let ensemble = Realizations::rotated(&*sampler, Streams::new(SEED, Purpose::Pattern, n));
        let rotated = estimate(&ensemble, 150, 1, &()).unwrap();
        let exact = ExactSpectrum::of(&*sampler).unwrap().to(150, &()).unwrap();
        for (l, p, _) in rotated.rows() {
            // Coefficients of size sqrt(N P/(4 pi)) are good to some 1e-12 N/(4 pi).
            let expected = exact.power()[l];
            let tolerance = 1e-11 * (1.0 + expected.sqrt()) * expected.sqrt() + 1e-22;
            assert!((p - expected).abs() < tolerance, "{pattern}, l = {l}: {p:e}, {expected:e}");
        }
    }
}

/// The power of lattices does not converge to 1: peaks persist. (Their mean, weighted by 2l+1,
/// does: the sum rule of `identities.rs`.)
#[test]
fn lattices_have_peaks() {
    for (pattern, n, lmax, height, omega) in
        [(Pattern::Healpix, 3888, 220, 30.2, 1.764), (Pattern::FIBONACCI, 4096, 220, 7.96, 1.75)]
    {
        let got = spectrum(&pattern, n, lmax, 1);
        let (l, peak) = got
            .power()
            .iter()
            .enumerate()
            .skip(1)
            .fold((0, 0.0), |best, (l, &p)| if p > best.1 { (l, p) } else { best });
        let at = l as f64 / (n as f64).sqrt();
        assert!((peak / height - 1.0).abs() < 0.005, "{pattern}: peak {peak}, recorded {height}");
        assert!((at - omega).abs() < 0.006, "{pattern}: peak at omega {at}, recorded {omega}");
    }
}
