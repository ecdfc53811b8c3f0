//! Trials of warped patterns: threads, ticks, interrupts and rare values.

use std::sync::Mutex;

use glam::DVec3;
use sphvar_integrands::Domain;
use sphvar_samplers::{Progress, Purpose, Stopped};
use sphvar_variance::{
    Precision, PredictionBudget, Trials, WarpedComparison, WarpedPredictor, WarpedRealizations,
};

use super::{Map, integrand, pulled_back, warped};

const BUDGET: PredictionBudget = PredictionBudget { relative: 0.04, work: 1e6 };
const PATTERN: &str = "sobol:warp=\"1 * cylinder + 3 * vmf:kappa=4 @ 60/0\"";

fn compared(text: &str, n: usize, trials: Trials, progress: &dyn Progress) -> WarpedComparison {
    let pattern = warped(text);
    let function = integrand("vmf:kappa=6 @ 60/0");
    let functions = pulled_back(&*function, Domain::Sphere, &pattern);
    let mut predictor = WarpedPredictor::new(&functions, 1, BUDGET).unwrap();
    let point = predictor.predict(&pattern, n, &()).unwrap();
    predictor.measure(&point.prediction, &pattern, n, trials, progress).unwrap()
}

#[test]
fn results_do_not_depend_on_threads() {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| format!("{:?}", compared(PATTERN, 40, Trials::new(100), &())))
    };
    assert_eq!(run(1), run(2));
}

/// Sums all work, and stops after some of it.
struct Counted {
    limit: f64,
    work: Mutex<(f64, f64)>,
}

impl Progress for Counted {
    fn tick(&self, work: f64) -> Result<(), Stopped> {
        let mut sums = self.work.lock().unwrap();
        sums.0 += work;
        if sums.0 > self.limit { Err(Stopped) } else { Ok(()) }
    }

    fn expect(&self, work: f64) {
        self.work.lock().unwrap().1 += work;
    }
}

#[test]
fn trials_tick_their_work_and_can_be_stopped() {
    let counted = |limit| Counted { limit, work: Mutex::default() };
    let pattern = warped(PATTERN);
    let all = counted(f64::INFINITY);
    compared(PATTERN, 40, Trials::new(50), &all);
    let (ticked, _) = *all.work.lock().unwrap();
    let expected = 50.0 * pattern.trial_work(40);
    assert!((ticked / expected - 1.0).abs() < 1e-9, "{ticked}, {expected}");
    // To a precision, the probable work of further trials is announced.
    let all = counted(f64::INFINITY);
    let until = Some(Precision { relative: 0.1, max_trials: 10_000 });
    let got = compared(PATTERN, 40, Trials { count: 50, until }, &all);
    let (ticked, announced) = *all.work.lock().unwrap();
    assert!(got.comparison.error().relative() <= 0.1);
    let trials = got.comparison.measurement.estimates().len() as f64;
    assert!((ticked / (trials * pattern.trial_work(40)) - 1.0).abs() < 1e-9, "{ticked}, {trials}");
    assert!(trials > 50.0 && announced > 0.0, "{trials}, {announced}");
    let function = integrand("cosine");
    let functions = pulled_back(&*function, Domain::Sphere, &pattern);
    let mut predictor = WarpedPredictor::new(&functions, 1, BUDGET).unwrap();
    let stopped = predictor.compare(&pattern, 40, Trials::new(50), &counted(10.0));
    assert!(stopped.unwrap_err().to_string().contains("stopped"));
    assert_eq!(pattern.default_trials(40), Trials::new(1000));
}

/// A lobe of 2e-4 of the sphere, seen by few of 200 trials: the number of trials that saw it is the
/// number of sets with a point there, and the measured variance has no error.
#[test]
fn rare_values_are_counted_and_leave_no_error() {
    let text = "white-square:warp=cylinder";
    let pattern = warped(text);
    let peak = |dir: DVec3| 1.0 + 1e4 * (2000.0 * (dir.y - 1.0)).exp();
    let functions = pulled_back(&peak, Domain::Sphere, &pattern);
    let mut predictor = WarpedPredictor::new(&functions, 0, BUDGET).unwrap();
    let (n, trials) = (4, 200);
    let got = predictor.compare(&pattern, n, Trials::new(trials), &()).unwrap();
    let largest = got.largest;
    let max = 4.0 * std::f64::consts::PI * 10_001.0;
    assert!(largest.ratio <= max * (1.0 + 1e-12) && largest.ratio > 0.5 * max, "{largest:?}");
    assert!(largest.direction.y > 0.999, "{largest:?}");
    // The area is that of the cap where the exponential exceeds half: ln(2)/2000/2 of the sphere.
    let expected = 0.5 * 2f64.ln() / 2000.0 * (n as f64 * trials as f64);
    assert!((0.3..3.0).contains(&(largest.expected_trials / expected)), "{largest:?}, {expected}");
    let strategies = pattern.warp.strategies(Domain::Sphere, &Map).unwrap();
    let samplers = pattern.samplers(n).unwrap();
    let sets =
        WarpedRealizations::new(&strategies, pattern.heuristic, &samplers, 0, Purpose::Trial);
    let has_peak = |i: &u64| {
        let set = sets.realize(*i).unwrap();
        set.points.iter().any(|dir| peak(*dir) * 4.0 * std::f64::consts::PI > 0.5 * largest.ratio)
    };
    assert_eq!(largest.trials, (0..trials).filter(has_peak).count() as u64);
    assert!(got.comparison.has_too_few_hits() && got.comparison.z_score().is_nan());
    // A function without rare values is seen by all.
    let got = compared("sobol:warp=cylinder", 64, Trials::new(20), &());
    assert_eq!(got.largest.trials, 20);
    assert!(!got.comparison.has_too_few_hits());
}
