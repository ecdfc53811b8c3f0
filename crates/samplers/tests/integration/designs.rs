//! Spherical designs: degrees, symmetry, numbers of points without designs, threads, interrupts.

use std::f64::consts::PI;
use std::sync::atomic::{AtomicU32, Ordering};

use glam::DVec3;
use sphvar_samplers::{
    Design, Domain, Error, Pattern, PointSet, Progress, Purpose, Sampler, Stopped, Streams,
    ValidCounts, separation,
};
use sphvar_sht::ExactTransform;

fn set(design: &dyn Sampler) -> PointSet {
    design.sample(&mut Streams::new(0, Purpose::Pattern, 0).realization(0)).unwrap()
}

/// Returns the powers of the degrees from 0.
fn powers(points: &[DVec3], lmax: usize) -> Vec<f64> {
    let squares =
        ExactTransform::new(lmax).unwrap().adjoint(points, None).unwrap().energy_per_degree();
    let power =
        |(l, square): (usize, f64)| 4.0 * PI / points.len() as f64 / (2 * l + 1) as f64 * square;
    squares.into_iter().enumerate().map(power).collect()
}

/// The platonic solids, a stored set, sets that are searched with dense matrices and by transforms.
#[test]
fn designs_have_no_power_up_to_their_degree() {
    for (n, degree, is_symmetric) in [
        (2, 1, false),
        (4, 2, false),
        (6, 3, false),
        (12, 5, false),
        (23, 5, false),
        (86, 12, false),
        (150, 12, false),
        (482, 30, false),
        (2, 1, true),
        (6, 3, true),
        (12, 5, true),
        (48, 7, true),
        (90, 11, true),
    ] {
        let design = Design::new(n, Domain::Sphere, Some(degree), is_symmetric).unwrap();
        assert_eq!(design.last_empty_degree(), Some(degree));
        let points = set(&design).points;
        assert_eq!(points.len(), n);
        let largest = powers(&points, degree)[1..].iter().copied().fold(0.0, f64::max);
        assert!(largest <= 1e-20, "t = {degree}, N = {n}: {largest}");
        if is_symmetric {
            let is_paired = |p: &DVec3| points.contains(&-*p);
            assert!(points.iter().all(is_paired), "t = {degree}, N = {n}");
        }
        // The same degrees of the hemisphere.
        if is_symmetric {
            let half = Design::new(n / 2, Domain::Hemisphere, Some(degree), false).unwrap();
            assert_eq!(half.last_empty_degree(), Some(degree - 1));
            let half = set(&half).points;
            assert!(half.iter().all(|p| p.z >= 0.0));
            let powers = powers(&half, degree);
            for l in (2..degree).step_by(2) {
                assert!(powers[l] <= 1e-20, "t = {degree}, N = {n}: {}", powers[l]);
            }
        }
    }
}

/// The mean over a sphere of the von Mises-Fisher lobe of concentration 50 about a direction is
/// `sinh(50)/50`; Womersley's set of 482 points has a relative error of 1.26e-5.
#[test]
fn a_lobe_is_integrated_as_well_as_by_published_designs() {
    let design: Pattern = "design:t=30".parse().unwrap();
    let points = set(&*design.build(482, Domain::Sphere).unwrap()).points;
    assert!(separation(&points, Domain::Sphere, &()).unwrap().unwrap() * 482_f64.sqrt() >= 3.0);
    let exact = (1.0 - (-100_f64).exp()) / 100.0;
    let mut squares = 0.0;
    let directions = 2000;
    let lattice = set(&*Pattern::FIBONACCI.build(directions, Domain::Sphere).unwrap()).points;
    for axis in &lattice {
        let sum: f64 = points.iter().map(|p| (50.0 * (axis.dot(*p) - 1.0)).exp()).sum();
        squares += (sum / 482.0 / exact - 1.0).powi(2);
    }
    let error = (squares / directions as f64).sqrt();
    assert!(error <= 1.3e-5, "{error}");
}

/// The cube, and pairs of antipodes with fewer points than other sets of the degree, or with a higher
/// degree than other sets of the number.
#[test]
fn pairs_of_antipodes_are_taken_where_others_have_no_such_degree() {
    for (n, degree) in [(8, 3), (18, 5), (32, 7), (48, 9), (50, 9), (70, 11), (94, 13), (500, 31)] {
        for given in [Some(degree), None] {
            let design = Design::new(n, Domain::Sphere, given, false).unwrap();
            assert_eq!(design.last_empty_degree(), Some(degree), "N = {n}");
            let points = set(&design).points;
            let largest = powers(&points, degree)[1..].iter().copied().fold(0.0, f64::max);
            assert!(points.len() == n && largest <= 1e-20, "t = {degree}, N = {n}: {largest}");
        }
        let pattern: Pattern = format!("design:t={degree}").parse().unwrap();
        assert!(pattern.valid_counts(Domain::Sphere).contains(n), "t = {degree}, N = {n}");
        assert_eq!(pattern.nearest_count(n, Domain::Sphere), n);
    }
}

#[test]
fn numbers_of_points_without_designs_are_errors() {
    for (n, degree, reason) in [
        (5, 2, "no design of degree 2 is available; N must be 4 or at least 6"),
        (9, 3, "N must be 6, 8 or at least 10"),
        (1, 1, "N must be at least 2"),
        (53, 9, "N must be 48, 50, 52 or at least 54"),
        (481, 30, "N must be at least 482"),
    ] {
        let error = Design::new(n, Domain::Sphere, Some(degree), false).unwrap_err();
        let message = error.to_string();
        assert!(message.contains(reason), "{message}");
    }
    let odd = Design::new(7, Domain::Sphere, None, true).unwrap_err();
    assert!(odd.to_string().contains("an even number of points"), "{odd}");
    let pattern: Pattern = "design:t=30".parse().unwrap();
    let few = pattern.build(400, Domain::Sphere).unwrap_err();
    assert!(matches!(few, Error::InvalidCount { nearest: 482, .. }), "{few}");
    assert_eq!(pattern.default_count(Domain::Sphere), Some(482));
    let pairs: Pattern = "design:t=7,symmetric=yes".parse().unwrap();
    assert_eq!(pairs.valid_counts(Domain::Sphere), ValidCounts::AtLeast { first: 32, step: 2 });
    assert_eq!(pairs.default_count(Domain::Hemisphere), Some(16));
}

/// All numbers of points up to 60 have a design of the degree that follows from the number, and all
/// numbers of pairs up to 30.
#[test]
fn every_number_of_points_has_a_design() {
    for (domain, last) in [(Domain::Sphere, 60), (Domain::Hemisphere, 30)] {
        for n in 1..=last {
            let design = Design::new(n, domain, None, false).unwrap();
            let degree = design.last_empty_degree().unwrap();
            let powers = powers(&set(&design).points, degree);
            let of_degrees = (1..=degree).filter(|&l| domain.has_degree(l)).map(|l| powers[l]);
            let largest = of_degrees.fold(0.0, f64::max);
            assert!(largest <= 1e-20, "{domain}, t = {degree}, N = {n}: {largest}");
        }
    }
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let points = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| set(&Design::new(100, Domain::Sphere, Some(12), false).unwrap()).points)
    };
    let one = points(1);
    assert_eq!(one, points(2));
    assert_eq!(one, points(3));
}

/// Stops at the k-th tick.
struct After(AtomicU32);

impl Progress for After {
    fn tick(&self, _: f64) -> Result<(), Stopped> {
        let left = self.0.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |k| k.checked_sub(1));
        left.map(drop).map_err(|_| Stopped)
    }
}

#[test]
fn interrupts_stop_searches() {
    let design = Design::new(100, Domain::Sphere, Some(12), false).unwrap();
    for ticks in [0, 1, 10, 40, 60] {
        let mut rng = Streams::new(0, Purpose::Pattern, 0).realization(0);
        let progress = After(AtomicU32::new(ticks));
        let stopped = design.sample_watched(&mut rng, &mut PointSet::default(), &progress);
        assert_eq!(stopped, Err(Error::Stopped(Stopped)), "{ticks}");
    }
}
