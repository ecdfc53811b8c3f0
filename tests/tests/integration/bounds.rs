//! The bounds of the thesis on spectra that are known exactly or recorded with their errors.

use sphvar_bounds::{
    Bound, BoundVerdict, Criterion, Domain, Family, IntegrandClass, MeasuredSpectrum, Profile,
    Side, Spectrum, thesis_bounds, trigamma,
};
use sphvar_integrands::Energy;
use sphvar_samplers::{CcvtParameters, MassPoints, Pattern, Purpose, Realizations, Streams};
use sphvar_sh::ByParity;
use sphvar_spectrum::{Resolution, estimate};
use sphvar_tests::{ReferenceSpectrum, exact_jitter_spectrum};
use sphvar_variance::predict;

const SEED: u64 = 5;

/// The probability that a recorded spectrum refutes a valid bound.
const ALPHA: f64 = 1e-3;

fn checked(power: &[f64], stderr: &[f64], n: usize, bound: Bound) -> (bool, usize, f64) {
    let spectrum = MeasuredSpectrum::new(n, Domain::Sphere, power, stderr).unwrap();
    let verdict = bound.check(&spectrum, 1.0 - ALPHA).unwrap();
    (verdict.holds, verdict.worst_degree, verdict.worst_ratio)
}

/// Both bounds of jitter hold on exact spectra; the lower one is tightest at omega = 0.77 with
/// ratios of 1.289 (N = 972) and 1.271 (3888). Degree 0 is not used.
#[test]
fn the_bounds_of_jitter_hold() {
    let bounds = thesis_bounds()[2];
    assert_eq!(bounds.sampler, "jittered");
    for (nside, lmax, tightest) in [(9_u32, 124, 1.289), (18, 150, 1.271)] {
        let n = 12 * (nside * nside) as usize;
        let power = exact_jitter_spectrum(nside, lmax);
        let zero = vec![0.0; power.len()];
        let (upper, at, ratio) = checked(&power, &zero, n, Bound::upper(bounds.upper));
        assert!(upper, "N = {n}: upper bound broken at l = {at}, ratio {ratio}");
        let (lower, at, ratio) = checked(&power, &zero, n, Bound::lower(bounds.lower));
        assert!(lower, "N = {n}: lower bound broken at l = {at}, ratio {ratio}");
        let (l, smallest) = (1..=lmax)
            .map(|l| (l, power[l] / bounds.lower.power(l, n)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap();
        let omega = l as f64 / (n as f64).sqrt();
        assert!((smallest - tightest).abs() < 1e-3, "N = {n}: {smallest}, recorded {tightest}");
        assert!((omega - 0.77).abs() < 0.02, "N = {n}: tightest at omega {omega}");
    }
}

/// Dart throwing, recorded with errors: both constant bounds of Poisson disk patterns hold, the
/// lower one of 0.055 as well as 1/20; the peak is 1.71 near omega = 2. False alarm: ALPHA for each
/// bound that lies on the spectrum, less as these do not.
#[test]
fn the_bounds_of_poisson_disk_hold_on_the_recorded_spectrum() {
    let reference = ReferenceSpectrum::load("pd_fixed_1024");
    let (mut power, mut stderr) = (reference.power().to_vec(), reference.stderr().to_vec());
    // The file has no degree 0; the bounds do not use it.
    (power[0], stderr[0]) = (1024.0, 0.0);
    let bounds = thesis_bounds()[1];
    assert_eq!(bounds.sampler, "poisson-disk");
    let twentieth = Profile::constant(0.05).unwrap();
    for bound in [Bound::upper(bounds.upper), Bound::lower(bounds.lower), Bound::lower(twentieth)] {
        let (holds, at, ratio) = checked(&power, &stderr, 1024, bound);
        assert!(holds, "{bound:?} broken at l = {at}, ratio {ratio}");
    }
    // Too tight bounds are refuted, from both sides.
    for bound in [
        Bound::upper(Profile::constant(1.6).unwrap()),
        Bound::lower(Profile::constant(0.065).unwrap()),
    ] {
        let (holds, ..) = checked(&power, &stderr, 1024, bound);
        assert!(!holds, "{bound:?} was not refuted");
    }
    let (l, peak) =
        (1..power.len()).map(|l| (l, power[l])).max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
    let omega = l as f64 / 32.0;
    assert!((peak - 1.71).abs() < 0.03, "peak {peak} at omega {omega}");
    // The mean distance belongs to omega = sqrt(pi) = 1.77, hexagons to 1.905, not to 1.
    assert!((1.76..=2.04).contains(&omega), "peak {peak} at omega {omega}");
}

/// Returns the mean spectrum of a sampler to 4 sqrt(N), or to `lmax`.
fn sampled(pattern: &Pattern, n: usize, lmax: Option<usize>, realizations: u64) -> Spectrum {
    let sampler = pattern.build(n, Domain::Sphere).unwrap();
    let group = pattern.stream_group(n);
    let sets = Realizations::rotated(&*sampler, Streams::new(SEED, Purpose::Pattern, group));
    let lmax = lmax.unwrap_or_else(|| Resolution::natural_degree(n));
    estimate(&sets, lmax, realizations, &()).unwrap()
}

fn ccvt(capacity: usize, mass: MassPoints, n: usize, lmax: Option<usize>, sets: u64) -> Spectrum {
    sampled(&Pattern::Ccvt(CcvtParameters { capacity, mass }), n, lmax, sets)
}

fn verdict(spectrum: &Spectrum, bound: Bound) -> BoundVerdict {
    let spectrum = MeasuredSpectrum::from_spectrum(spectrum).unwrap();
    bound.check(&spectrum, 1.0 - ALPHA).unwrap()
}

/// White noise lies between 0.7 and 1.3, which the data prove: 1000 realizations. The lowest degree
/// has an error of 2.6 % of the mean, the quantile for all degrees is 4.2, so the limits leave the
/// bounds only if the mean is off by seven of them.
#[test]
fn the_bounds_of_white_noise_hold() {
    let spectrum = sampled(&Pattern::WhiteNoise, 256, None, 1000);
    let known = thesis_bounds()[0];
    assert_eq!(known.sampler, "white-noise");
    for bound in [Bound::upper(known.upper), Bound::lower(known.lower)] {
        let verdict = verdict(&spectrum, bound);
        assert!(verdict.holds && verdict.proved, "{bound:?}: {verdict:?}");
    }
}

/// Tessellations of white mass points keep the floor 1/m, and the upper bound is 40 l^2/N at low
/// degrees: broken at l = 1 once N > 40 m, and there only. m = 64 with N = 1024 keeps both bounds;
/// N = 4096 breaks the upper one at l = 1 with a ratio of 1.6 = (1/64)/(40/4096); the next degree
/// has 0.5. 140 sets: the error at l = 1 is 7 %, so that the excess is 5.5(10) standard errors, of
/// which 3.5 refute.
#[test]
#[ignore = "statistics"]
fn the_upper_bound_of_ccvt_is_broken_by_the_floor() {
    let known = thesis_bounds()[3];
    assert_eq!(known.sampler, "ccvt");
    let (upper, lower) = (Bound::upper(known.upper), Bound::lower(known.lower));
    let small = ccvt(64, MassPoints::White, 1024, None, 24);
    for bound in [upper, lower] {
        let verdict = verdict(&small, bound);
        assert!(verdict.holds, "{bound:?}: {verdict:?}");
    }
    let large = ccvt(64, MassPoints::White, 4096, Some(4), 140);
    let verdict = verdict(&large, upper);
    assert!(!verdict.holds && verdict.worst_degree == 1, "{verdict:?}");
    assert!((1.2..2.0).contains(&verdict.worst_ratio), "{verdict:?}");
    for l in 2..=4 {
        let ratio = large.power()[l] / known.upper.power(l, 4096);
        assert!(ratio < 0.7, "l = {l}: {ratio}");
    }
}

/// Tessellations of lattice mass have P ~ l^4, far below the lower bound: a ratio of 3e-4 at l = 1,
/// and nothing above 1 up to omega = 0.7.
#[test]
fn the_lower_bound_of_ccvt_is_broken_by_ideal_mass() {
    let lower = thesis_bounds()[3].lower;
    let ideal = ccvt(64, MassPoints::Fibonacci, 1024, None, 16);
    let verdict = verdict(&ideal, Bound::lower(lower));
    assert!(!verdict.holds, "{verdict:?}");
    let ratio = |l: usize| ideal.power()[l] / lower.power(l, 1024);
    assert!((1e-4..1e-3).contains(&ratio(1)), "ratio at l = 1: {}", ratio(1));
    for l in 1..=22 {
        assert!(ratio(l) < 1.0, "ratio at l = {l}: {}", ratio(l));
    }
}

/// The peak grows with the capacity: m = 1024 with N = 256 reaches 2.54(11) in the recorded sets,
/// above the bound of 2.
#[test]
#[ignore = "statistics"]
fn the_upper_bound_of_ccvt_is_broken_by_the_peak() {
    let upper = thesis_bounds()[3].upper;
    let spectrum = ccvt(1024, MassPoints::White, 256, None, 24);
    let verdict = verdict(&spectrum, Bound::upper(upper));
    let omega = verdict.extreme_degree as f64 / 16.0;
    assert!((1.1..1.5).contains(&verdict.extreme_ratio), "{verdict:?}");
    assert!((1.7..2.0).contains(&omega), "{verdict:?}");
}

/// Predictions from fits of a profile's own spectrum match the closed forms: the sum over degrees
/// and a tail of power 1, where the profile has gamma.
#[test]
fn spectra_of_profiles_predict_the_closed_forms() {
    let (n, lmax) = (1024, 4000);
    for domain in [Domain::Sphere, Domain::Hemisphere] {
        let step = domain.degree_step();
        let class = IntegrandClass::power_law(2.0, 2.0).unwrap();
        let energies: Vec<f64> =
            (0..=lmax).map(|l| if l % step == 0 { class.energy(l) } else { 0.0 }).collect();
        // The tail: 2 sum l^-2 over the degrees beyond lmax.
        let beyond = 2.0 / (step * step) as f64 * trigamma((lmax / step + 1) as f64);
        // The profiles have one mean power beyond, so that it does not matter how parities share
        // the tail.
        let mut centred = ByParity { even: beyond, odd: 0.0 };
        for (l, e) in energies.iter().enumerate().skip(1) {
            *centred.of_mut(l) += e;
        }
        let energy = Energy::new(domain, energies.clone(), centred);
        for profile in [
            Profile::quadratic(0.75, 1.0).unwrap(),
            Profile::polynomial(3.5, 1.5, 1.25).unwrap(),
            Profile::step(0.9, 1.0).unwrap(),
            Profile::linear(2.0, 0.5).unwrap().with_offset(0.25).unwrap(),
        ] {
            let predicted = predict(&profile.spectrum(n, domain, lmax), &energy);
            let exact = class.variance(&profile, n, domain);
            let tail = (1.0 - profile.supremum()) * predicted.tail;
            // The tail is the difference of sums of 4000 terms of the size of the whole.
            let rounding = 1e-12 * predicted.variance;
            let off = (predicted.variance - exact - tail).abs();
            assert!(
                off <= rounding,
                "{profile:?} {domain:?}: {predicted:?}, {exact:e}, off {off:e}"
            );
        }
    }
}

/// The exact spectrum of jitter: its tightest profiles are sharper than those of the thesis, and
/// the largest quadratic below it comes with the exponent of the rate that jitter has.
#[test]
fn fits_of_jitter_are_tighter_than_the_thesis() {
    let n = 972;
    let spectrum = Spectrum::exact(Domain::Sphere, n, exact_jitter_spectrum(9, 124));
    let measured = MeasuredSpectrum::from_spectrum(&spectrum).unwrap();
    let class = IntegrandClass::power_law(1.0, 2.0).unwrap();
    let known = thesis_bounds()[2];
    for (side, thesis) in [(Side::Upper, known.upper), (Side::Lower, known.lower)] {
        let fit =
            Bound::tightest(side, Family::Quadratic, &measured, Criterion::default()).unwrap();
        let (found, recorded) = (
            class.variance(&fit.bound.profile, n, Domain::Sphere),
            class.variance(&thesis, n, Domain::Sphere),
        );
        let tighter = if side == Side::Upper { found < recorded } else { found > recorded };
        assert!(tighter, "{fit:?}: {found:e}, thesis {recorded:e}");
        assert_eq!(class.rate(&fit.bound.profile, Domain::Sphere).to_string(), "N^-1.5");
    }
}
