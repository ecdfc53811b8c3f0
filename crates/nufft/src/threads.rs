use std::sync::{Mutex, PoisonError};

use rayon::prelude::{IntoParallelRefMutIterator, ParallelIterator};

/// Which threads a transform of one set may use. Results do not depend on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Threads {
    /// The caller's thread, for callers that divide many sets among threads.
    #[default]
    Caller,
    /// All threads of the current rayon pool.
    Pool,
}

impl Threads {
    /// Returns the number of threads.
    #[must_use]
    pub fn count(self) -> usize {
        match self {
            Self::Caller => 1,
            Self::Pool => rayon::current_num_threads().max(1),
        }
    }

    /// Calls `work` in the current pool, so that its parallel parts do not each enter it.
    pub fn enter<R: Send>(self, work: impl FnOnce() -> R + Send) -> R {
        match self {
            Self::Caller => work(),
            Self::Pool => rayon::scope(|_| work()),
        }
    }

    /// Resizes `states` to one for each thread.
    pub fn resize<S: Default>(self, states: &mut Vec<S>) {
        states.resize_with(self.count(), S::default);
    }
}

/// Calls `work` once with every item and any of `states`, in one thread per state. Each takes the
/// next item when it is idle, so that items should be numerous, and first the expensive ones.
///
/// With one state all items are processed in order by the caller's thread.
pub fn share<S: Send, I: Iterator<Item: Send> + Send>(
    states: &mut [S],
    items: I,
    work: impl Fn(&mut S, I::Item) + Sync,
) {
    if let [state] = states {
        return items.for_each(|item| work(state, item));
    }
    let items = Mutex::new(items.fuse());
    states.par_iter_mut().for_each(|state| {
        loop {
            let item = items.lock().unwrap_or_else(PoisonError::into_inner).next();
            let Some(item) = item else { break };
            work(state, item);
        }
    });
}

/// Iterates over the next items of several iterators together, until one ends.
pub fn zip_all<const N: usize, I: Iterator<Item: Default>>(
    mut iterators: [I; N],
) -> impl Iterator<Item = [I::Item; N]> {
    std::iter::from_fn(move || {
        let next = iterators.each_mut().map(Iterator::next);
        next.iter().all(Option::is_some).then(|| next.map(Option::unwrap_or_default))
    })
}
