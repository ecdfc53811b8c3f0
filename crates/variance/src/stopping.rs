use sphvar_samplers::Realizations;

use crate::{Error, Integrand, Measurement, measurement::estimates};

/// How precisely a variance is to be measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Precision {
    /// The relative standard error of the variance that is small enough.
    pub relative: f64,
    /// The number of trials at which measuring stops however large the error is.
    pub most: u64,
}

/// Measures a variance until it is precise: `start` trials (at least 4), then twice as many in all and twice
/// again, until the relative error ([`Measurement::relative_error`]) is at most `target.relative` or the trials are
/// `target.most`.
///
/// Trials are those of [`measure`](crate::measure), so a run that stops at n trials is `measure` with n. Looking only
/// where the number of trials has doubled keeps it from stopping at the first lucky moment. `done` is
/// called after each trial, `expect` with the number of trials in all by which it will probably be
/// over, before the first one and after every doubling.
///
/// # Errors
///
/// [`Error::Spectrum`] with the sampler's error if a realization cannot be made.
pub fn measure_until(
    ensemble: &Realizations<'_>,
    integrand: &dyn Integrand,
    start: u64,
    target: Precision,
    expect: &dyn Fn(u64),
    done: &(dyn Fn() + Sync),
) -> Result<Measurement, Error> {
    let most = target.most.max(4);
    let mut total = start.clamp(4, most);
    let mut from = 0;
    let mut measurement = Measurement::default();
    expect(total);
    loop {
        measurement.extend(estimates(ensemble, integrand, from..total, done)?);
        // A precision that is not a number is never reached.
        // Equal estimates have no error, but may be those of an integrand that no trial saw.
        let precise = measurement.variance() > 0.0
            && measurement.relative_error().relative() <= target.relative;
        if precise || total >= most {
            return Ok(measurement);
        }
        from = total;
        total = total.saturating_mul(2).min(most);
        expect(stages(total, measurement.trials_for(target.relative), most));
    }
}

/// The number of trials, of `total` doubled again and again, that is at least `needed`.
fn stages(mut total: u64, needed: u64, most: u64) -> u64 {
    while total < needed.min(most) {
        total = total.saturating_mul(2).min(most);
    }
    total
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use sphvar_samplers::{Domain, Pattern, Purpose, Realizations, Streams};

    use super::{Precision, measure_until, stages};
    use crate::{ClampedCosine, measure};

    #[test]
    fn a_precision_is_reached_by_doubling() {
        let sampler = Pattern::WhiteNoise.build(4, Domain::Sphere).unwrap();
        let sets = Realizations::rotated(&*sampler, Streams::new(0, Purpose::Trial, 0));
        let expected = RefCell::new(Vec::new());
        let until = |relative, most| {
            let target = Precision { relative, most };
            let expect = |n| expected.borrow_mut().push(n);
            measure_until(&sets, &ClampedCosine, 100, target, &expect, &|| ()).unwrap()
        };
        let got = until(0.05, 100_000);
        let trials = got.estimates().len();
        assert!(got.relative_stderr() <= 0.05, "{}", got.relative_stderr());
        // Near-normal estimates: 2/0.05^2 = 800 trials, and no doubling before was enough.
        assert!([400, 800, 1600].contains(&trials), "{trials}");
        assert_eq!(expected.borrow().last(), Some(&(trials as u64)));
        assert_eq!(got, measure(&sets, &ClampedCosine, trials as u64, &|| ()).unwrap());
        // The cap holds, and nothing satisfies NaN.
        assert_eq!(until(0.001, 250).estimates().len(), 250);
        assert_eq!(until(f64::NAN, 250).estimates().len(), 250);
        assert_eq!(until(0.05, 0).estimates().len(), 4);
    }

    #[test]
    fn stages_do_not_overflow() {
        assert_eq!(stages(1000, 3500, 1_000_000), 4000);
        assert_eq!(stages(1000, 3500, 3000), 3000);
        assert_eq!(stages(1 << 63, u64::MAX, u64::MAX), u64::MAX);
    }
}
