use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::DVec3;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use sphvar_samplers::{Ensemble, PointSet, Progress, Stopped};
use sphvar_sh::Alm;
use sphvar_sht::{FastTransform, Method, Transform, TransformWorkspace};

use crate::{Accumulator, Error, Realization};

/// To which degree and how spectra are computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resolution {
    /// The largest degree, inclusive.
    pub lmax: usize,
    /// The number of points of a set, or about that: the choice of [`Method::Auto`] goes by it.
    pub n_points: usize,
    /// The way of transforming.
    pub method: Method,
    /// The relative accuracy of coefficients by the fast method, in [1e-13, 1e-1].
    pub epsilon: f64,
}

impl Resolution {
    /// The accuracy unless another is asked for: power comes out to its square, 1e-24, where the
    /// pattern has none.
    pub const EPSILON: f64 = 1e-12;

    /// The smallest [`Self::epsilon`].
    pub const MIN_EPSILON: f64 = FastTransform::MIN_EPSILON;

    /// The largest [`Self::epsilon`].
    pub const MAX_EPSILON: f64 = FastTransform::MAX_EPSILON;

    /// The degree by which the spectrum of a random pattern has settled, 4 sqrt(N), at least 32.
    #[must_use]
    pub fn natural_degree(n_points: usize) -> usize {
        (4 * n_points.isqrt()).max(32)
    }

    /// The bytes that [`accumulate`] takes for `sets` sets on `threads` threads, without what the
    /// accumulators keep.
    #[must_use]
    pub fn bytes(&self, sets: u64, threads: usize) -> f64 {
        let together = sets.clamp(1, BATCH);
        let busy = sets.div_ceil(BATCH).clamp(1, threads.max(1) as u64);
        busy as f64 * self.method.bytes(self.n_points, self.lmax, together)
    }

    /// Degree `lmax` for sets of `n_points`, by the cheaper method.
    #[must_use]
    pub fn new(lmax: usize, n_points: usize) -> Self {
        Self { lmax, n_points, method: Method::Auto, epsilon: Self::EPSILON }
    }
}

/// Sets that one thread transforms together: the recurrence is shared among as many.
const BATCH: u64 = 4;

/// Transforms the sets of the given numbers and accumulates them into a copy of `empty`, in
/// parallel over the sets; the nominal work of making and transforming them is ticked.
///
/// # Errors
///
/// [`Error::Sampler`] if a set cannot be made or `progress` ends the work, [`Error::Transform`] if the degree is beyond what the transform can hold, or the accuracy outside its
/// range.
pub fn accumulate<A: Accumulator>(
    sets: &dyn Ensemble,
    resolution: Resolution,
    indices: Range<u64>,
    empty: &A,
    progress: &dyn Progress,
) -> Result<A, Error> {
    let Resolution { lmax, n_points, method, epsilon } = resolution;
    let transform = Transform::new(method, lmax, n_points, epsilon)?;
    let begin = || Worker {
        sets: Vec::new(),
        workspace: TransformWorkspace::default(),
        alms: Vec::new(),
        accumulator: empty.clone(),
    };
    // What follows a stop is not even begun.
    let is_stopped = AtomicBool::new(false);
    let stop = |error: &Error| {
        let stopped = Error::from(Stopped);
        is_stopped.fetch_or(*error == stopped, Ordering::Relaxed);
    };
    let step = |worker: Result<Worker<A>, Error>, batch: u64| {
        let mut worker = worker?;
        if is_stopped.load(Ordering::Relaxed) {
            return Err(Stopped.into());
        }
        let first = indices.start + batch * BATCH;
        let batch = first..first.saturating_add(BATCH).min(indices.end);
        worker.take(sets, &transform, resolution, batch, progress).inspect_err(stop)?;
        Ok(worker)
    };
    let n_batches = indices.end.saturating_sub(indices.start).div_ceil(BATCH);
    let finished = (0..n_batches)
        .into_par_iter()
        .fold(|| Ok(begin()), step)
        .map(|worker| Ok(worker?.accumulator));
    finished.reduce(
        || Ok(empty.clone()),
        |a, b| {
            let mut a = a?;
            a.merge(&b?);
            Ok(a)
        },
    )
}

/// The buffers of one thread's share of the sets.
struct Worker<A> {
    sets: Vec<PointSet>,
    workspace: TransformWorkspace,
    alms: Vec<Alm>,
    accumulator: A,
}

impl<A: Accumulator> Worker<A> {
    fn take(
        &mut self,
        ensemble: &dyn Ensemble,
        transform: &Transform,
        resolution: Resolution,
        batch: Range<u64>,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        let mut used = 0;
        for index in batch.clone() {
            if self.alms.len() == used {
                self.sets.push(PointSet::default());
                self.alms.push(Alm::zeros(resolution.lmax)?);
            }
            ensemble.realize_into(index, &mut self.sets[used], progress)?;
            self.sets[used].normalize_weights();
            used += 1;
        }
        let (sets, alms) = (&self.sets[..used], &mut self.alms[..used]);
        let weights = |set: &PointSet| !set.weights.is_empty();
        let inputs: Vec<(&[DVec3], Option<&[f64]>)> =
            sets.iter().map(|set| (&*set.points, weights(set).then_some(&*set.weights))).collect();
        transform.adjoint_batch_into(&inputs, &mut self.workspace, alms);
        let work = resolution.method.nominal_work(resolution.n_points, resolution.lmax);
        for ((index, set), alm) in batch.zip(sets).zip(alms) {
            self.accumulator.push(&Realization::new(index, set, alm));
            progress.tick(work)?;
        }
        Ok(())
    }
}
