//! The bounds of the thesis on spectra that are known exactly or recorded with their errors.

use sphvar_bounds::{Bound, Domain, MeasuredSpectrum, Profile, thesis_bounds};
use sphvar_tests::{ReferenceSpectrum, exact_jitter_spectrum};

/// The probability that a bound that stands is refuted by a recorded spectrum.
const ALPHA: f64 = 1e-3;

fn checked(power: &[f64], stderr: &[f64], n: usize, bound: Bound) -> (bool, usize, f64) {
    let spectrum = MeasuredSpectrum::new(n, Domain::Sphere, power, stderr).unwrap();
    let verdict = bound.check(&spectrum, 1.0 - ALPHA).unwrap();
    (verdict.holds, verdict.worst_degree, verdict.worst_ratio)
}

/// Both bounds of jitter hold on exact spectra; the lower one is tightest at omega = 0.77 with ratios of
/// 1.289 (N = 972) and 1.271 (3888). Degree 0 is not used.
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

/// Dart throwing, recorded with errors: both constant bounds of Poisson disk patterns hold, the lower
/// one of 0.055 as well as 1/20; the peak is 1.71 near omega = 2. False alarm: ALPHA for each bound that
/// lies on the spectrum, less as these do not.
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
    // Bounds that are too tight are refuted, from both sides.
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
