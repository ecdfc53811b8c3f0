use std::ops::Range;

use sphvar_samplers::{Progress, Realizations};

use crate::{Error, Measurement, estimates::estimates, trial_work};
use sphvar_integrands::Integrand;

/// The precision to which a variance is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Precision {
    /// The requested relative standard error of the variance.
    pub relative: f64,
    /// The maximum number of trials, whatever the error.
    pub max_trials: u64,
}

impl Precision {
    /// The minimum number of trials: the error of the variance needs at least four.
    pub const MIN_TRIALS: u64 = 4;

    /// Checks that the precision is positive and finite, and that `start` and `max_trials` are valid.
    fn check(self, start: u64) -> Result<(), Error> {
        let relative = self.relative;
        if !(relative > 0.0 && relative.is_finite()) {
            let name = "the relative precision of a variance";
            return Err(Error::Parameter { name, range: "positive and finite", got: relative });
        }
        let trials = [
            ("the number of trials", "at least 4", start, start >= Self::MIN_TRIALS),
            (
                "the largest number of trials",
                "at least the first",
                self.max_trials,
                self.max_trials >= start,
            ),
        ];
        match trials.into_iter().find(|row| !row.3) {
            Some((name, range, got, _)) => Err(Error::Parameter { name, range, got: got as f64 }),
            None => Ok(()),
        }
    }
}

/// Returns a variance measured to a requested precision.
///
/// Runs `start` trials (at least 4) and doubles the total number until the relative error
/// ([`Measurement::relative_error`]) is at most `target.relative` or the number of trials is
/// `target.max_trials`.
///
/// The trials are those of [`measure`](crate::measure), so a run that stops after n trials equals
/// `measure` with n. Checking the error only after each doubling keeps the run from stopping at a
/// lucky fluctuation. `progress` expects the work of `start` trials; after every doubling it is
/// told the probable additional work.
///
/// # Errors
///
/// Returns [`Error::Parameter`] unless the precision is positive and finite, `start` is at least 4
/// and `target.max_trials` is at least `start`, and the errors of [`measure`](crate::measure).
pub fn measure_until(
    ensemble: &Realizations<'_>,
    integrand: &dyn Integrand,
    start: u64,
    target: Precision,
    progress: &dyn Progress,
) -> Result<Measurement, Error> {
    let domain = ensemble.sampler().domain();
    let mut source = |trials| estimates(domain, ensemble, integrand, trials, progress);
    until(&mut source, trial_work(ensemble.sampler()), start, target, progress)
}

/// Returns [`measure_until`] for estimates of the given trials from `source`, each of nominal work
/// `work`.
pub(crate) fn until(
    source: &mut dyn FnMut(Range<u64>) -> Result<Vec<f64>, Error>,
    work: f64,
    start: u64,
    target: Precision,
    progress: &dyn Progress,
) -> Result<Measurement, Error> {
    target.check(start)?;
    let (mut total, max_trials) = (start, target.max_trials);
    let mut from = 0;
    let mut measurement = Measurement::default();
    let mut expected = start;
    loop {
        measurement.extend(source(from..total)?);
        // Equal estimates have a measured error of 0, but no trial may have hit the integrand.
        let precise = measurement.variance() > 0.0
            && measurement.relative_error().relative() <= target.relative;
        if precise || total >= max_trials {
            return Ok(measurement);
        }
        from = total;
        total = total.saturating_mul(2).min(max_trials);
        let probable = doubled_total(total, measurement.trials_for(target.relative), max_trials);
        progress.expect(work * (probable as f64 - expected as f64));
        expected = probable;
    }
}

/// Returns the first number of trials, on doubling `total`, that is at least `needed`.
fn doubled_total(mut total: u64, needed: u64, max_trials: u64) -> u64 {
    while total < needed.min(max_trials) {
        total = total.saturating_mul(2).min(max_trials);
    }
    total
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use sphvar_samplers::{Domain, Pattern, Progress, Purpose, Realizations, Stopped, Streams};

    use super::{Precision, doubled_total, measure_until};
    use crate::{measure, trial_work};
    use sphvar_integrands::ClampedCosine;

    /// The number of trials announced to the progress.
    struct Announced(Mutex<f64>);

    impl Progress for Announced {
        fn tick(&self, _: f64) -> Result<(), Stopped> {
            Ok(())
        }

        fn expect(&self, work: f64) {
            let sampler = Pattern::WhiteNoise.build(4, Domain::Sphere).unwrap();
            *self.0.lock().unwrap() += work / trial_work(&*sampler);
        }
    }

    #[test]
    fn a_precision_is_reached_by_doubling() {
        let sampler = Pattern::WhiteNoise.build(4, Domain::Sphere).unwrap();
        let sets = Realizations::rotated(&*sampler, Streams::new(0, Purpose::Trial, 0));
        // In units of a trial; 100 are announced at the start.
        let announced = Announced(Mutex::new(100.0));
        let until = |relative, max_trials| {
            let target = Precision { relative, max_trials };
            measure_until(&sets, &ClampedCosine, 100, target, &announced).unwrap()
        };
        let got = until(0.05, 100_000);
        let trials = got.estimates().len();
        assert!(got.relative_stderr() <= 0.05, "{}", got.relative_stderr());
        // Near-normal estimates need 2/0.05^2 = 800 trials; no earlier doubling suffices.
        assert!([400, 800, 1600].contains(&trials), "{trials}");
        assert!((*announced.0.lock().unwrap() - trials as f64).abs() < 1e-9);
        assert_eq!(got, measure(&sets, &ClampedCosine, trials as u64, &()).unwrap());
        // The maximum number of trials holds.
        assert_eq!(until(0.001, 250).estimates().len(), 250);
    }

    /// Invalid values are rejected rather than replaced; both ends of the ranges are accepted.
    #[test]
    fn precisions_and_trials_outside_their_range_are_rejected() {
        let sampler = Pattern::WhiteNoise.build(4, Domain::Sphere).unwrap();
        let sets = Realizations::rotated(&*sampler, Streams::new(0, Purpose::Trial, 0));
        let until = |relative, start, max_trials| {
            let target = Precision { relative, max_trials };
            measure_until(&sets, &ClampedCosine, start, target, &())
        };
        for relative in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -0.1] {
            let error = until(relative, 100, 200).unwrap_err().to_string();
            let expected = ["relative precision", "positive and finite", &relative.to_string()];
            assert!(expected.iter().all(|part| error.contains(part)), "{error}");
        }
        for (start, max_trials) in [(0, 9), (3, 9), (10, 9), (4, 0)] {
            let error = until(0.1, start, max_trials).unwrap_err().to_string();
            assert!(error.contains("trials"), "{start} {max_trials}: {error}");
        }
        for relative in [f64::MIN_POSITIVE, f64::MAX] {
            assert_eq!(until(relative, 4, 4).unwrap().estimates().len(), 4);
        }
    }

    #[test]
    fn doubling_does_not_overflow() {
        assert_eq!(doubled_total(1000, 3500, 1_000_000), 4000);
        assert_eq!(doubled_total(1000, 3500, 3000), 3000);
        assert_eq!(doubled_total(1 << 63, u64::MAX, u64::MAX), u64::MAX);
    }
}
