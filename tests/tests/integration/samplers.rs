//! A test of the `Sampler` contract for every pattern and both domains.

use std::sync::LazyLock;

use glam::DVec3;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use rayon::{ThreadPool, ThreadPoolBuilder};
use sphvar_samplers::{
    DiskMode, Domain, Error, Pattern, PointSet, PoissonDiskParameters, Purpose, Realizations,
    Sampler, Streams,
};

const SEED: u64 = 2;
const DOMAINS: [Domain; 2] = [Domain::Sphere, Domain::Hemisphere];
/// Inexpensive patterns are tested with every number of points up to this one.
const MAX_REQUESTED: usize = 200;
/// The numbers of points with which optimized patterns are tested.
const FEW_REQUESTED: [usize; 8] = [0, 1, 2, 3, 5, 12, 48, 100];
/// Realizations per number of points.
const REALIZATIONS: u64 = 3;
/// The norm of a result is accurate to a few roundings; `length` itself takes three.
const NORM_TOLERANCE: f64 = 1e-15;
static ONE_THREAD: LazyLock<ThreadPool> = LazyLock::new(|| pool(1));
/// More threads than realizations, so that their order is unpredictable.
static SEVERAL_THREADS: LazyLock<ThreadPool> = LazyLock::new(|| pool(4));

fn pool(threads: usize) -> ThreadPool {
    ThreadPoolBuilder::new().num_threads(threads).build().unwrap()
}

fn streams(n: usize) -> Streams {
    Streams::new(SEED, Purpose::Pattern, n)
}

fn is_expensive(pattern: &Pattern) -> bool {
    matches!(
        pattern,
        Pattern::Ccvt { .. }
            | Pattern::Step { .. }
            | Pattern::Blue { .. }
            | Pattern::Profile { .. }
            | Pattern::BestCandidate { .. }
            | Pattern::Leja { .. }
            | Pattern::Lloyd { .. }
            | Pattern::Riesz { .. }
            | Pattern::Dpp
    )
}

/// Returns whether `n` points are too few for the prescribed spectrum: the angle of two points
/// cannot give two degrees the powers of a profile. One point has the requested power 1.
fn is_infeasible(pattern: &Pattern, n: usize) -> bool {
    n == 2 && matches!(pattern, Pattern::Profile { .. })
}

/// Returns whether every realization has the requested number of points.
fn has_exact_count(pattern: &Pattern) -> bool {
    !matches!(
        pattern,
        Pattern::PoissonDisk(PoissonDiskParameters { mode: DiskMode::Saturated, .. })
    )
}

/// Checks the errors of all numbers of points up to [`MAX_REQUESTED`], or of a few for expensive
/// patterns, and the realizations of the valid numbers: of the first 40, and then of every
/// `step`-th.
fn check(pattern: &Pattern, domain: Domain, step: usize) {
    let all: Vec<usize> =
        if is_expensive(pattern) { FEW_REQUESTED.into() } else { (0..=MAX_REQUESTED).collect() };
    let valid: Vec<usize> =
        all.iter().copied().filter(|&n| pattern.build(n, domain).is_ok()).collect();
    assert!(
        !valid.is_empty(),
        "{pattern} {domain:?} has no number of points up to {MAX_REQUESTED}"
    );
    for requested in all {
        match pattern.build(requested, domain) {
            Ok(sampler) => {
                let rank = valid.partition_point(|&n| n < requested);
                if rank < 40 || rank % step == 0 {
                    check_sampler(pattern, domain, requested, &*sampler);
                }
            }
            Err(error) => check_error(pattern, domain, requested, &valid, &error),
        }
    }
}

/// The error names the nearest valid number.
fn check_error(
    pattern: &Pattern,
    domain: Domain,
    requested: usize,
    valid: &[usize],
    error: &Error,
) {
    if requested == 0 {
        assert_eq!(*error, Error::NoPoints { pattern: pattern.to_string() });
        return;
    }
    let Error::InvalidCount { nearest, requested: named, .. } = *error else {
        panic!("{pattern} {domain:?} N = {requested}: {error}");
    };
    assert_eq!(named, requested, "{pattern} {domain:?}");
    assert_eq!(
        pattern.nearest_count(requested, domain),
        nearest,
        "{pattern} {domain:?} N = {requested}"
    );
    assert!(pattern.build(nearest, domain).is_ok(), "{pattern} {domain:?} N = {nearest} rejected");
    let best = valid.iter().map(|n| n.abs_diff(requested)).min();
    assert!(
        Some(nearest.abs_diff(requested)) <= best,
        "{pattern} {domain:?}: {nearest} is not the nearest to {requested}"
    );
    let message = error.to_string();
    for part in [requested.to_string(), nearest.to_string(), pattern.name().to_owned()] {
        assert!(message.contains(&part), "{part} is missing in: {message}");
    }
}

/// A realization by its bits, or the error.
type Outcome = Result<Vec<[u64; 3]>, Error>;

/// Realizations 0, 1, ... on the threads of `pool`, each into a buffer created by `fill`.
fn outcomes(
    ensemble: &Realizations<'_>,
    pool: &ThreadPool,
    fill: impl Fn() -> Vec<DVec3> + Sync,
) -> Vec<Outcome> {
    let realize = |index| {
        let mut set = PointSet::new(fill());
        ensemble.realize_into(index, &mut set, &())?;
        Ok(bits(&set.points))
    };
    pool.install(|| (0..REALIZATIONS).into_par_iter().map(realize).collect())
}

fn check_sampler(pattern: &Pattern, domain: Domain, n: usize, sampler: &dyn Sampler) {
    let name = format!("{pattern} {domain:?} N = {n}");
    assert_eq!((sampler.n_points(), sampler.domain()), (n, domain), "{name}");
    for is_rotated in [false, true] {
        let ensemble = if is_rotated {
            Realizations::rotated(sampler, streams(n))
        } else {
            Realizations::unrotated(sampler, streams(n))
        };
        let first = outcomes(&ensemble, &ONE_THREAD, Vec::new);
        // Neither the content and length of the buffer nor threads or repetition matter.
        let again = outcomes(&ensemble, &SEVERAL_THREADS, || vec![DVec3::NAN; 3 * n + 1]);
        for (i, (outcome, again)) in first.iter().zip(&again).enumerate() {
            assert_eq!(outcome, again, "{name}: realization {i} changed");
            assert_eq!(outcome.is_err(), is_infeasible(pattern, n), "{name}: {outcome:?}");
            match outcome {
                Ok(points) => check_points(pattern, domain, n, points),
                Err(Error::Infeasible { n_points, reason, .. }) => assert!(
                    *n_points == n && reason.contains("Use more points"),
                    "{name}, realization {i}: {n_points} points, {reason}"
                ),
                Err(error) => panic!("{name}, realization {i}: {error}"),
            }
        }
        if let [Ok(zeroth), Ok(first), ..] = &first[..] {
            // Rotations make even a fixed pattern's realizations differ.
            let expected = is_rotated || sampler.is_random();
            assert_eq!(zeroth != first, expected, "{name}, rotated {is_rotated}: do they differ?");
        }
    }
}

fn check_points(pattern: &Pattern, domain: Domain, n: usize, points: &[[u64; 3]]) {
    let name = format!("{pattern} {domain:?} N = {n}");
    if has_exact_count(pattern) {
        assert_eq!(points.len(), n, "{name}");
    } else {
        assert!(!points.is_empty(), "{name}: no point");
    }
    for p in points.iter().map(|p| DVec3::from_array(p.map(f64::from_bits))) {
        assert!((p.length() - 1.0).abs() <= NORM_TOLERANCE, "{name}: |{p}| is not 1");
        if domain == Domain::Hemisphere {
            // The sign bit too: a z of -0 prints a minus.
            assert!(p.z >= 0.0 && p.z.is_sign_positive(), "{name}: {p} lies below");
        }
    }
}

fn bits(points: &[DVec3]) -> Vec<[u64; 3]> {
    points.iter().map(|p| p.to_array().map(f64::to_bits)).collect()
}

#[test]
fn every_sampler_keeps_its_contract() {
    for pattern in Pattern::ALL {
        for domain in DOMAINS {
            check(&pattern, domain, 9);
        }
    }
}

#[test]
#[ignore = "slow"]
fn every_sampler_keeps_its_contract_for_every_number_of_points() {
    for pattern in Pattern::ALL.into_iter().filter(|pattern| !is_expensive(pattern)) {
        for domain in DOMAINS {
            check(&pattern, domain, 1);
        }
    }
}

/// The one pattern whose number of points is random.
#[test]
#[ignore = "statistics"]
fn saturated_disks_keep_the_contract() {
    for domain in DOMAINS {
        check(
            &Pattern::PoissonDisk(PoissonDiskParameters {
                mode: DiskMode::Saturated,
                ..PoissonDiskParameters::DEFAULT
            }),
            domain,
            1,
        );
    }
}

/// One point, or one in each pixel, is never too few.
#[test]
fn the_smallest_number_of_points_works() {
    for pattern in Pattern::ALL {
        for domain in DOMAINS {
            let n = pattern.nearest_count(0, domain);
            let sampler = pattern.build(n, domain).unwrap();
            let points = Realizations::rotated(&*sampler, streams(n)).realize(0);
            assert_eq!(
                points.map(|p| p.len()),
                Ok(n),
                "{pattern} {domain:?}: {n} points, the fewest"
            );
        }
    }
}

/// The smallest patterns: 1 point, or one pixel of each kind.
#[test]
fn smallest_numbers_of_points() {
    for pattern in Pattern::ALL {
        let (sphere, hemisphere) = match pattern {
            Pattern::Jittered | Pattern::Healpix | Pattern::Icosahedral => (12, 6),
            Pattern::GaussLegendre => (2, 1),
            Pattern::DriscollHealy => (3, 2),
            Pattern::Lebedev | Pattern::CubeSphere(_) => (6, 3),
            _ => (1, 1),
        };
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
        for (requested, nearest) in [(1024, 972), (4096, 3888), (1100, 1200), (4332, 4332)] {
            assert_eq!(
                pattern.nearest_count(requested, Domain::Sphere),
                nearest,
                "{pattern} {requested}"
            );
        }
    }
}
