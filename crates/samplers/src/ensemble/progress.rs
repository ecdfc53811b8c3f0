use std::sync::Mutex;

/// The error of work that a [`Progress`] stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("stopped before the work was done")]
pub struct Stopped;

/// Receives the progress of long work and decides whether it continues.
///
/// Work is counted in nominal units ([`Sampler::nominal_work`](crate::Sampler::nominal_work)),
/// about 60 ns of one core each. A closure `Fn(f64)` is called with the completed units and never
/// stops the work; `()` ignores progress.
///
/// # Examples
///
/// ```
/// use std::sync::atomic::{AtomicBool, Ordering};
/// use sphvar_samplers::{Domain, Pattern, Progress, Purpose, Realizations, Stopped, Streams};
///
/// /// Stops the work when a flag is set, for example by Ctrl-C.
/// struct UntilRaised(AtomicBool);
///
/// impl Progress for UntilRaised {
///     fn tick(&self, _work: f64) -> Result<(), Stopped> {
///         if self.0.load(Ordering::Relaxed) { Err(Stopped) } else { Ok(()) }
///     }
/// }
///
/// let sampler = "riesz".parse::<Pattern>()?.build(64, Domain::Sphere)?;
/// let sets = Realizations::rotated(&*sampler, Streams::new(0, Purpose::Pattern, 0));
/// let mut set = Default::default();
/// sets.realize_into(0, &mut set, &UntilRaised(AtomicBool::new(false)))?;
/// assert!(sets.realize_into(1, &mut set, &UntilRaised(AtomicBool::new(true))).is_err());
/// # Ok::<(), sphvar_samplers::Error>(())
/// ```
pub trait Progress: Sync {
    /// Records `work` completed units; 0 only checks whether to continue.
    ///
    /// # Errors
    ///
    /// [`Stopped`] to stop the work; callers return it as their error.
    fn tick(&self, work: f64) -> Result<(), Stopped>;

    /// Announces `work` more units. Default: ignored.
    fn expect(&self, _work: f64) {}
}

impl<F: Fn(f64) + Sync> Progress for F {
    fn tick(&self, work: f64) -> Result<(), Stopped> {
        self(work);
        Ok(())
    }
}

impl Progress for () {
    fn tick(&self, _work: f64) -> Result<(), Stopped> {
        Ok(())
    }
}

/// Seconds per unit of nominal work on one core, to a factor of about 2. Used for time estimates
/// only; no result depends on it.
pub const SECONDS_PER_WORK: f64 = 60e-9;

/// Callback that returns whether a long loop continues.
pub(crate) type Tick<'a> = &'a dyn Fn() -> Result<(), Stopped>;

/// A share of known size of another progress: ticks are passed on up to that size, and
/// [`finish`](Self::finish) adds the rest.
pub struct Share<'a> {
    whole: &'a dyn Progress,
    left: Mutex<f64>,
}

impl std::fmt::Debug for Share<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Share").field("left", &self.left).finish_non_exhaustive()
    }
}

impl<'a> Share<'a> {
    /// Returns a part of `whole` of `work` units.
    #[must_use]
    pub fn new(whole: &'a dyn Progress, work: f64) -> Self {
        // A negative or NaN amount of work counts as 0.
        let work = if work.is_finite() { work.max(0.0) } else { 0.0 };
        Self { whole, left: Mutex::new(work) }
    }

    /// Ticks the rest of the share.
    ///
    /// # Errors
    ///
    /// [`Stopped`] if the work is to stop.
    pub fn finish(self) -> Result<(), Stopped> {
        self.tick(f64::INFINITY)
    }
}

impl Progress for Share<'_> {
    fn tick(&self, work: f64) -> Result<(), Stopped> {
        let part = {
            // The number behind a poisoned lock is still valid.
            let mut left = self.left.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            let part = work.min(*left);
            *left -= part;
            part
        };
        self.whole.tick(part)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::{Progress, Share};

    #[test]
    fn a_share_adds_up_to_its_declared_size() {
        for parts in [vec![], vec![1.0, 2.0], vec![4.0, 0.0, 9.0], vec![f64::INFINITY]] {
            let sum = Mutex::new(0.0);
            let whole = |work: f64| *sum.lock().unwrap() += work;
            let share = Share::new(&whole, 10.0);
            for part in parts {
                share.tick(part).unwrap();
            }
            share.finish().unwrap();
            let off = *sum.lock().unwrap() - 10.0;
            assert!(off.abs() <= 0.0, "{off}");
        }
    }
}
