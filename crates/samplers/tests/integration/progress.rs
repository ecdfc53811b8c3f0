//! Progress of single realizations: it does not change results, adds up to the nominal work, and
//! can stop it.

use std::sync::Mutex;

use glam::DVec3;
use sphvar_samplers::{
    Domain, Error, Pattern, PointSet, Progress, Purpose, Realizations, Sampler, SquarePattern,
    SquareRealizations, Stopped, Streams,
};

const DOMAINS: [Domain; 2] = [Domain::Sphere, Domain::Hemisphere];

fn rng(index: u64) -> impl rand::Rng {
    Streams::new(5, Purpose::Pattern, 1).realization(index)
}

/// Adds up the work that is ticked, and stops at a tick.
struct Ticks {
    /// Their number and sum.
    seen: Mutex<(usize, f64)>,
    stop_at: usize,
}

impl Ticks {
    fn new(stop_at: usize) -> Self {
        Self { seen: Mutex::new((0, 0.0)), stop_at }
    }

    fn seen(&self) -> (usize, f64) {
        *self.seen.lock().unwrap()
    }
}

impl Progress for Ticks {
    fn tick(&self, work: f64) -> Result<(), Stopped> {
        assert!(work >= 0.0, "{work} units");
        let mut seen = self.seen.lock().unwrap();
        seen.0 += 1;
        seen.1 += work;
        if seen.0 == self.stop_at { Err(Stopped) } else { Ok(()) }
    }
}

/// The patterns whose realizations are made in steps.
const ITERATIVE: [&str; 10] = [
    "ccvt",
    "step",
    "blue",
    "leja",
    "lloyd",
    "riesz",
    "best-candidate",
    "poisson-disk",
    "poisson-disk:placement=decreasing",
    "dpp",
];

/// Returns the sampler of the valid count nearest to 500, or to 100 for expensive sets.
fn near_500(pattern: &Pattern, domain: Domain) -> Box<dyn Sampler> {
    let requested = if pattern.nominal_work(500) > 1e5 { 100 } else { 500 };
    pattern.build(pattern.nearest_count(requested, domain), domain).unwrap()
}

#[test]
fn progress_does_not_change_the_points_and_adds_up_to_the_work() {
    for pattern in Pattern::ALL {
        for domain in DOMAINS {
            let case = format!("{pattern}, {domain}");
            let sampler = near_500(&pattern, domain);
            let expected = sampler.sample(&mut rng(1)).unwrap();
            let mut set = PointSet { points: vec![DVec3::NAN; 7], weights: vec![2.0; 7] };
            let ticks = Ticks::new(usize::MAX);
            sampler.sample_watched(&mut rng(1), &mut set, &ticks).unwrap();
            assert_eq!(set, expected, "{case}");
            assert!(ticks.seen().0 > 0, "{case}: the progress is not ticked");

            let streams = Streams::new(5, Purpose::Pattern, 1);
            let work = sampler.nominal_work();
            for ensemble in [
                Realizations::rotated(&*sampler, streams),
                Realizations::unrotated(&*sampler, streams),
            ] {
                let ticks = Ticks::new(usize::MAX);
                ensemble.realize_into(1, &mut set, &ticks).unwrap();
                assert_eq!(set, ensemble.realize(1).unwrap(), "{case}");
                let (_, ticked) = ticks.seen();
                assert!((ticked - work).abs() <= 1e-9 * work, "{case}: {ticked} of {work} units");
            }
        }
    }
}

#[test]
fn progress_of_the_square_adds_up_to_the_work() {
    for pattern in SquarePattern::ALL {
        let sampler = pattern.build(pattern.nearest_count(500)).unwrap();
        let streams = Streams::new(5, Purpose::Pattern, 1);
        let mut set = PointSet::default();
        for ensemble in [
            SquareRealizations::shifted(&*sampler, streams),
            SquareRealizations::unshifted(&*sampler, streams),
        ] {
            let ticks = Ticks::new(usize::MAX);
            ensemble.realize_into(1, &mut set, &ticks).unwrap();
            assert_eq!(set, ensemble.realize(1).unwrap(), "{pattern}");
            let (_, ticked) = ticks.seen();
            let work = sampler.nominal_work();
            assert!((ticked - work).abs() <= 1e-9 * work, "{pattern}: {ticked} of {work} units");
            let stopped = ensemble.realize_into(1, &mut set, &Ticks::new(1));
            assert_eq!(stopped, Err(Error::Stopped(Stopped)), "{pattern}");
        }
    }
    // Within a realization: between points, for pmj02 between the digits of all points, and between
    // the steps of iterative patterns.
    let named = |name: &str| name.parse::<SquarePattern>().unwrap();
    for (pattern, n, tick) in [
        (SquarePattern::Pmj02, 500, 20),
        (SquarePattern::SOBOL, 150_000, 3),
        (SquarePattern::LatinHypercube, 150_000, 3),
        (named("poisson-disk-square"), 200, 3),
        (named("ccvt-square"), 200, 10),
        (named("step-square"), 200, 20),
        (named("blue-square"), 200, 20),
        (named("profile-square"), 200, 5),
    ] {
        let (mut set, ticks) = (PointSet::default(), Ticks::new(tick));
        let stopped = pattern.build(n).unwrap().sample_watched(&mut rng(1), &mut set, &ticks);
        assert_eq!((stopped, ticks.seen().0), (Err(Error::Stopped(Stopped)), tick), "{pattern}");
    }
}

#[test]
fn iterative_patterns_stop_on_request() {
    for name in ITERATIVE {
        let pattern = name.parse::<Pattern>().unwrap();
        for domain in DOMAINS {
            let sampler = near_500(&pattern, domain);
            let mut set = PointSet::default();
            let ticks = Ticks::new(3);
            let stopped = sampler.sample_watched(&mut rng(1), &mut set, &ticks);
            assert_eq!(stopped, Err(Error::Stopped(Stopped)), "{pattern}, {domain}");
            assert_eq!(ticks.seen().0, 3, "{pattern}, {domain}: more work after the end");
            let ensemble = Realizations::rotated(&*sampler, Streams::new(5, Purpose::Pattern, 1));
            let stopped = ensemble.realize_into(1, &mut set, &Ticks::new(3));
            assert_eq!(stopped, Err(Error::Stopped(Stopped)), "{pattern}, {domain}");
        }
    }
}
