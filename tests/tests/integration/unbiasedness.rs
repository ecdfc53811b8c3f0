//! Every pattern integrates every harmonic of degree 1 to 4 or 8 without bias.
//!
//! The unit of replication is the realization: the points of a stratified set depend on each other.

use std::f64::consts::PI;

use sphvar_samplers::{Domain, Pattern, Purpose, Realizations, Streams};
use sphvar_sh::legendre_p;
use sphvar_spectrum::{
    Accumulator, CoefficientSamples, Moments, Realization, Resolution, accumulate,
};
use sphvar_tests::Family;
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

const SEED: u64 = 3;
const LMAX: usize = 8;
const REALIZATIONS: u64 = 4000;
const SIZE: (usize, u64) = (LMAX, REALIZATIONS);
/// The same for expensive patterns.
const LMAX_OF_ALL: usize = 4;
const POINTS_OF_ALL: usize = 48;
const REALIZATIONS_OF_ALL: u64 = 100;
/// The false-alarm probability of a family (nominal: means of 4000 bounded numbers are normal up to
/// some per cent in the far tail).
const ALPHA: f64 = 1e-4;
/// Coefficients that are 0 for every realization are 0 to this times N.
const ROUNDING: f64 = 1e-12;

/// Mean and spread of the real and imaginary part of every coefficient.
#[derive(Clone)]
struct CoefficientMoments(Vec<[Moments; 2]>);

impl Accumulator for CoefficientMoments {
    fn push(&mut self, realization: &Realization<'_>) {
        for (moments, a) in self.0.iter_mut().zip(realization.alm().values()) {
            moments[0].push(a.re);
            moments[1].push(a.im);
        }
    }

    fn merge(&mut self, other: &Self) {
        for (mine, theirs) in self.0.iter_mut().zip(&other.0) {
            for (a, b) in mine.iter_mut().zip(theirs) {
                a.merge(b);
            }
        }
    }
}

/// Returns the mean of `Y_lm` over the domain: 0 on the sphere for l >= 1. On the hemisphere odd
/// zonal ones are left, `int_0^1 P_l dz = (P_{l-1}(0) - P_{l+1}(0))/(2l+1)`.
fn mean_of_harmonic(domain: Domain, l: usize, m: usize) -> f64 {
    if domain == Domain::Sphere || m > 0 {
        return 0.0;
    }
    let p = |l: usize| legendre_p(l, 0.0).unwrap();
    ((2 * l + 1) as f64 / (4.0 * PI)).sqrt() * (p(l - 1) - p(l + 1)) / (2 * l + 1) as f64
}

/// Returns the normal deviate with the same probability as Student's t for `count` numbers, because
/// the standard error estimated from few numbers is itself uncertain.
fn normal_score(t: f64, count: u64) -> f64 {
    let tail = StudentsT::new(0.0, 1.0, count as f64 - 1.0).unwrap().cdf(-t.abs());
    -Normal::standard().inverse_cdf(tail) * t.signum()
}

fn add_to(
    family: &mut Family,
    ensemble: &Realizations<'_>,
    (lmax, realizations): (usize, u64),
    label: &str,
) {
    let sampler = ensemble.sampler();
    let domain = sampler.domain();
    let empty = CoefficientMoments(vec![Default::default(); (lmax + 1) * (lmax + 2) / 2]);
    let samples = CoefficientSamples::new(lmax, lmax);
    let (got, last) = accumulate(
        ensemble,
        Resolution::new(lmax, sampler.n_points()),
        0..realizations,
        &(empty, samples),
        &(),
    )
    .unwrap();
    assert_eq!(last.finish().len() as u64, realizations, "{label}");
    let index = sphvar_sh::LmIndex::new(lmax).unwrap();
    // The number of points, or the sum of their weights.
    let n = got.0[index.at(0, 0)][0].mean() * (4.0 * PI).sqrt();
    for (l, m) in index.iter().filter(|lm| lm.0 >= 1) {
        for (part, name) in [(0, "Re"), (1, "Im")] {
            let moments = &got.0[index.at(l, m)][part];
            let expected = if part == 0 { n * mean_of_harmonic(domain, l, m) } else { 0.0 };
            let (mean, stderr) = (moments.mean(), moments.standard_error());
            if stderr < ROUNDING * n {
                // Im S_l0, and odd degrees of sets that hold the antipode of each point.
                assert!(
                    (mean - expected).abs() < ROUNDING * n,
                    "{label}: {name} S_{l},{m} = {mean:e} in every realization"
                );
            } else {
                let z = normal_score((mean - expected) / stderr, realizations);
                family.compare(z, 0.0, 1.0, || {
                    format!("{label}, {name} S_{l},{m} = {mean:e}, expected {expected:e}")
                });
            }
        }
    }
}

/// After a uniform rotation, on the smallest valid sets and on larger ones.
#[test]
fn every_rotated_pattern_is_unbiased() {
    let mut family = Family::new("mean of S_lm, rotated");
    for pattern in Pattern::ELEMENTARY {
        for domain in [Domain::Sphere, Domain::Hemisphere] {
            for requested in [1, 100] {
                let n = pattern.nearest_count(requested, domain);
                let sampler = pattern.build(n, domain).unwrap();
                let streams = Streams::new(SEED, Purpose::Pattern, n);
                let label = format!("{pattern} {domain:?} N = {n}");
                add_to(&mut family, &Realizations::rotated(&*sampler, streams), SIZE, &label);
            }
        }
    }
    family.assert_null(ALPHA);
}

/// The same for every pattern with default parameters. Steps have no power at these degrees, so
/// their comparison tests rounding.
#[test]
#[ignore = "statistics"]
fn every_rotated_pattern_of_all_is_unbiased() {
    let mut family = Family::new("mean of S_lm, rotated, every pattern");
    for pattern in Pattern::ALL {
        for domain in [Domain::Sphere, Domain::Hemisphere] {
            let n = pattern.nearest_count(POINTS_OF_ALL, domain);
            let sampler = pattern.build(n, domain).unwrap();
            let streams = Streams::new(SEED, Purpose::Pattern, n);
            let label = format!("{pattern} {domain:?} N = {n}");
            let ensemble = Realizations::rotated(&*sampler, streams);
            add_to(&mut family, &ensemble, (LMAX_OF_ALL, REALIZATIONS_OF_ALL), &label);
        }
    }
    // 2 (l+1) numbers a degree, for every pattern on two domains.
    assert!(family.scores().len() > 400, "{} comparisons", family.scores().len());
    family.assert_null(ALPHA);
}

/// Independent and stratified points are unbiased without rotation, because of equal areas.
#[test]
fn random_patterns_are_unbiased_without_rotation() {
    let mut family = Family::new("mean of S_lm, unrotated");
    for pattern in [Pattern::WhiteNoise, Pattern::Jittered] {
        for domain in [Domain::Sphere, Domain::Hemisphere] {
            // The upper representative of each antipodal pair of cells is used, so it is uniform on
            // the hemisphere as well.
            let n = pattern.nearest_count(48, domain);
            let sampler = pattern.build(n, domain).unwrap();
            assert!(sampler.is_random(), "{pattern}");
            let streams = Streams::new(SEED, Purpose::Trial, n);
            let label = format!("{pattern} {domain:?} N = {n}");
            add_to(&mut family, &Realizations::unrotated(&*sampler, streams), SIZE, &label);
        }
    }
    family.assert_null(ALPHA);
}

/// The test can fail: a fixed set that is not rotated has coefficients other than 0.
#[test]
#[should_panic(expected = "in every realization")]
fn a_fixed_set_without_rotation_is_biased() {
    let sampler = Pattern::FIBONACCI.build(20, Domain::Sphere).unwrap();
    let streams = Streams::new(SEED, Purpose::Pattern, 20);
    add_to(&mut Family::new("biased"), &Realizations::unrotated(&*sampler, streams), SIZE, "fixed");
}
