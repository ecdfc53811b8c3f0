//! Progress, interrupts and threads.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use sphvar_integrands::{Cap, Disk};
use sphvar_samplers::{Domain, Error as SamplerError, Progress, SquarePattern, Stopped};
use sphvar_spectrum::Error as SpectrumError;
use sphvar_variance::{
    Error, PredictionBudget, Predictor, ProgressiveCurve, ProgressivePredictor, Randomized,
    SquarePredictor,
};

use super::sequence;

const N: usize = 200;

/// Stops after a number of ticks.
struct After(AtomicU64, u64);

impl Progress for After {
    fn tick(&self, _: f64) -> Result<(), Stopped> {
        if self.0.fetch_add(1, Ordering::Relaxed) < self.1 { Ok(()) } else { Err(Stopped) }
    }
}

/// Records the work and the largest part of it between two ticks.
#[derive(Default)]
struct Record(Mutex<(f64, f64)>);

impl Progress for Record {
    fn tick(&self, work: f64) -> Result<(), Stopped> {
        let mut record = self.0.lock().unwrap();
        record.0 += work;
        record.1 = record.1.max(work);
        Ok(())
    }
}

fn curve(progress: &dyn Progress) -> Result<(ProgressiveCurve, f64), Error> {
    let cap = Cap::from_degrees(60.0).unwrap();
    let budget = PredictionBudget { work: 1e5, ..PredictionBudget::DEFAULT };
    let sampler = sequence("halton", N, Domain::Sphere);
    let mut prefixes =
        ProgressivePredictor::new(Predictor::new(&cap, Domain::Sphere, 5, budget).unwrap());
    let counts: Vec<usize> = (1..=N).collect();
    let work = prefixes.work(&sampler, &counts, 50)?;
    let curve = prefixes.curve(&sampler, 9, &counts, 50, Randomized::Rotated, progress)?;
    Ok((curve, work))
}

fn square_curve(progress: &dyn Progress) -> Result<(ProgressiveCurve, f64), Error> {
    let disk = Disk::new(0.3, [0.5, 0.45]).unwrap();
    let budget = PredictionBudget { work: 1e5, ..PredictionBudget::DEFAULT };
    let sampler = "sobol".parse::<SquarePattern>().unwrap().build(N).unwrap();
    let mut prefixes = ProgressivePredictor::new(SquarePredictor::new(&disk, 5, budget).unwrap());
    let counts: Vec<usize> = (1..=N).collect();
    let work = prefixes.work(&*sampler, &counts, 50)?;
    let curve = prefixes.curve(&*sampler, 9, &counts, 50, Randomized::Rotated, progress)?;
    Ok((curve, work))
}

#[test]
fn work_is_announced_and_stops() {
    for curve in [curve, square_curve] {
        let record = Record::default();
        let (_, announced) = curve(&record).unwrap();
        let (done, largest) = *record.0.lock().unwrap();
        assert!(done <= 1.01 * announced, "{done} of {announced}");
        assert!(done >= 0.02 * announced, "{done} of {announced}");
        // A tenth of a second.
        assert!(largest < 2e6, "{largest}");
        for ticks in [0, 1, 100, 2000] {
            let stopped = Error::Spectrum(SpectrumError::Sampler(SamplerError::Stopped(Stopped)));
            assert_eq!(curve(&After(AtomicU64::new(0), ticks)).unwrap_err(), stopped, "{ticks}");
        }
    }
}

/// A list of prefixes takes no more work than all prefixes up to the last one, by whichever method.
#[test]
fn lists_take_no_more_work_than_all_prefixes() {
    let cap = Cap::from_degrees(60.0).unwrap();
    let work = |name: &str, n: usize, counts: &[usize]| {
        let budget = PredictionBudget::DEFAULT;
        let predictor = Predictor::new(&cap, Domain::Sphere, 5, budget).unwrap();
        let sampler = sequence(name, n, Domain::Sphere);
        ProgressivePredictor::new(predictor).work(&sampler, counts, 0).unwrap()
    };
    let every = |n: usize, step: usize| (step..=n).step_by(step).collect::<Vec<_>>();
    for name in ["sobol", "white-noise"] {
        for n in [64, 1024, 2048] {
            let all = work(name, n, &every(n, 1));
            for step in [n / 64, n / 32, n / 4] {
                let list = work(name, n, &every(n, step));
                assert!(list <= all, "{name}, {n}, {step}: {list} of {all}");
            }
        }
        // Single predictions of few prefixes keep their budgets.
        let single = |n: usize| {
            let budget = PredictionBudget::DEFAULT;
            let mut predictor = Predictor::new(&cap, Domain::Sphere, 5, budget).unwrap();
            predictor.work(&sequence(name, n, Domain::Sphere)).unwrap()
        };
        let (got, expected) =
            (work(name, 50_000, &[5_000, 50_000]), single(5_000) + single(50_000));
        // A prefix may take somewhat less work than a set of its own.
        assert!((0.9..=1.000_001).contains(&(got / expected)), "{name}: {got}, {expected}");
    }
}

#[test]
fn curves_do_not_depend_on_the_number_of_threads() {
    for curve in [curve, square_curve] {
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            format!("{:?}", pool.install(|| curve(&()).unwrap().0))
        };
        assert_eq!(with(1), with(3));
    }
}
