//! One checker of the `Sampler` contract, run on every pattern and both domains.

use glam::DVec3;
use sphvar_samplers::{Domain, Error, Pattern, Purpose, Realizations, Sampler, Streams};

const SEED: u64 = 2;
const DOMAINS: [Domain; 2] = [Domain::Sphere, Domain::Hemisphere];
/// Every number of points up to this one is asked for.
const MOST_ASKED: usize = 200;
/// Realizations per number of points.
const REALIZATIONS: u64 = 3;
/// The norm of a result is good to a few roundings; `length` itself takes three.
const NORM_TOLERANCE: f64 = 1e-15;

fn streams(n: usize) -> Streams {
    Streams::new(SEED, Purpose::Pattern, n)
}

/// The whole contract, for every legal number of points up to [`MOST_ASKED`].
fn check(pattern: &Pattern, domain: Domain) {
    let legal: Vec<usize> =
        (1..=MOST_ASKED).filter(|&n| pattern.build(n, domain).is_ok()).collect();
    assert!(!legal.is_empty(), "{pattern} {domain:?} has no number of points up to {MOST_ASKED}");
    for asked in 0..=MOST_ASKED {
        match pattern.build(asked, domain) {
            Ok(sampler) => check_sampler(pattern, domain, asked, &*sampler),
            Err(refusal) => check_refusal(pattern, domain, asked, &legal, &refusal),
        }
    }
}

/// A refusal names the legal number that is nearest.
fn check_refusal(
    pattern: &Pattern,
    domain: Domain,
    asked: usize,
    legal: &[usize],
    refusal: &Error,
) {
    if asked == 0 {
        assert_eq!(*refusal, Error::NoPoints { pattern: pattern.clone() });
        return;
    }
    let Error::IllegalCount { nearest, asked: named, .. } = *refusal else {
        panic!("{pattern} {domain:?} N = {asked}: {refusal}");
    };
    assert_eq!(named, asked, "{pattern} {domain:?}");
    assert_eq!(pattern.nearest_count(asked, domain), nearest, "{pattern} {domain:?} N = {asked}");
    assert!(pattern.build(nearest, domain).is_ok(), "{pattern} {domain:?} N = {nearest} refused");
    let best = legal.iter().map(|n| n.abs_diff(asked)).min();
    assert!(
        Some(nearest.abs_diff(asked)) <= best,
        "{pattern} {domain:?}: {nearest} is not the nearest to {asked}"
    );
    let message = refusal.to_string();
    for part in [asked.to_string(), nearest.to_string(), pattern.name().to_owned()] {
        assert!(message.contains(&part), "{part} is missing in: {message}");
    }
}

fn check_sampler(pattern: &Pattern, domain: Domain, n: usize, sampler: &dyn Sampler) {
    let name = format!("{pattern} {domain:?} N = {n}");
    assert_eq!((sampler.n_points(), sampler.domain()), (n, domain), "{name}");
    for ensemble in
        [Realizations::unrotated(sampler, streams(n)), Realizations::rotated(sampler, streams(n))]
    {
        let mut dirty = vec![DVec3::NAN; 3 * n + 1];
        for i in 0..REALIZATIONS {
            let points = ensemble.realize(i).unwrap();
            assert_eq!(points.len(), n, "{name}, realization {i}");
            for p in &points {
                assert!((p.length() - 1.0).abs() <= NORM_TOLERANCE, "{name}: |{p}| is not 1");
                if domain == Domain::Hemisphere {
                    // The sign bit too: a z of -0 prints a minus.
                    assert!(p.z >= 0.0 && p.z.is_sign_positive(), "{name}: {p} lies below");
                }
            }
            // What is in the buffer, and how long it is, does not matter; nor does repetition.
            ensemble.realize_into(i, &mut dirty).unwrap();
            assert_eq!(
                bits(&dirty),
                bits(&points),
                "{name}: a dirty buffer changed realization {i}"
            );
            assert_eq!(
                bits(&ensemble.realize(i).unwrap()),
                bits(&points),
                "{name}: realization {i} changed"
            );
        }
        // Rotations make even a fixed pattern's realizations differ.
        assert_ne!(
            bits(&Realizations::rotated(sampler, streams(n)).realize(0).unwrap()),
            bits(&Realizations::rotated(sampler, streams(n)).realize(1).unwrap()),
            "{name}: two rotated realizations are equal"
        );
    }
    let unrotated = Realizations::unrotated(sampler, streams(n));
    let differ = bits(&unrotated.realize(0).unwrap()) != bits(&unrotated.realize(1).unwrap());
    assert_eq!(sampler.is_random(), differ, "{name}: is_random is not what the sampler does");
}

fn bits(points: &[DVec3]) -> Vec<[u64; 3]> {
    points.iter().map(|p| p.to_array().map(f64::to_bits)).collect()
}

#[test]
fn every_sampler_keeps_its_contract() {
    for pattern in Pattern::ELEMENTARY {
        for domain in DOMAINS {
            check(&pattern, domain);
        }
    }
}

/// The smallest patterns: 1 point, or one pixel of each kind.
#[test]
fn smallest_numbers_of_points() {
    for (pattern, sphere, hemisphere) in [
        (Pattern::WhiteNoise, 1, 1),
        (Pattern::Fibonacci, 1, 1),
        (Pattern::Jittered, 12, 6),
        (Pattern::Healpix, 12, 6),
    ] {
        for (domain, smallest) in [(Domain::Sphere, sphere), (Domain::Hemisphere, hemisphere)] {
            assert_eq!(pattern.nearest_count(0, domain), smallest, "{pattern} {domain:?}");
            for n in 1..smallest {
                assert!(pattern.build(n, domain).is_err(), "{pattern} {domain:?} N = {n}");
            }
            assert!(pattern.build(smallest, domain).is_ok(), "{pattern} {domain:?} N = {smallest}");
        }
    }
}

/// 1024 and 4096 points do not exist for HEALPix: the nearest are 972 and 3888.
#[test]
fn healpix_counts_are_12_nside_squared() {
    for pattern in [Pattern::Healpix, Pattern::Jittered] {
        for (asked, nearest) in [(1024, 972), (4096, 3888), (1100, 1200), (4332, 4332)] {
            assert_eq!(pattern.nearest_count(asked, Domain::Sphere), nearest, "{pattern} {asked}");
        }
    }
}
