use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::DVec3;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use sphvar_samplers::{Ensemble, PointSet, Progress, Stopped};
use sphvar_sh::{Alm, Domain};
use sphvar_sht::{FastTransform, Method, Transform, TransformWorkspace};

use crate::workspaces::Stock;
use crate::{Accumulator, Error, Realization, SpectralBands, Workspaces};

/// Maximum degree and method of a spectrum estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resolution {
    /// The maximum degree, inclusive.
    pub lmax: usize,
    /// The number of points of a set, exact or approximate; determines the choice of
    /// [`Method::Auto`].
    pub n_points: usize,
    /// The transform method.
    pub method: Method,
    /// The relative accuracy of coefficients computed by the fast method, in [1e-13, 1e-1].
    pub epsilon: f64,
}

impl Resolution {
    /// The default accuracy. The absolute error of the power, where the pattern has none, is the
    /// square of it: 1e-24.
    pub const EPSILON: f64 = 1e-12;

    /// The minimum of [`Self::epsilon`].
    pub const MIN_EPSILON: f64 = FastTransform::MIN_EPSILON;

    /// The maximum of [`Self::epsilon`].
    pub const MAX_EPSILON: f64 = FastTransform::MAX_EPSILON;

    /// Returns the degree at which the spectrum of a random pattern has converged to its limit:
    /// 4 sqrt(N), at least 32.
    #[must_use]
    pub fn natural_degree(n_points: usize) -> usize {
        (4 * n_points.isqrt()).max(32)
    }

    /// Returns the memory in bytes that [`accumulate`] needs for `sets` sets on `threads` threads,
    /// excluding the accumulators.
    #[must_use]
    pub fn bytes(&self, sets: u64, threads: usize) -> f64 {
        let together = sets.clamp(1, BATCH);
        let busy = sets.div_ceil(BATCH).clamp(1, threads.max(1) as u64);
        busy as f64 * self.method.bytes(self.n_points, self.lmax, together)
    }

    /// Returns the resolution for degree `lmax` and sets of `n_points`, with the less expensive
    /// method and the default accuracy.
    #[must_use]
    pub fn new(lmax: usize, n_points: usize) -> Self {
        Self { lmax, n_points, method: Method::Auto, epsilon: Self::EPSILON }
    }
}

/// Number of sets that a thread transforms together; they share one Legendre recurrence.
const BATCH: u64 = 4;

/// Transforms the sets with the given indices and accumulates them into a copy of `empty`, in
/// parallel over the sets. Ticks `progress` with the nominal work of sampling and transforming.
///
/// # Errors
///
/// [`Error::Sampler`] if a set cannot be generated or `progress` stops the work;
/// [`Error::Transform`] if the degree exceeds the limit of the transform or the accuracy is out of
/// range.
pub fn accumulate<A: Accumulator>(
    sets: &dyn Ensemble,
    resolution: Resolution,
    indices: Range<u64>,
    empty: &A,
    progress: &dyn Progress,
) -> Result<A, Error> {
    accumulate_with(&Workspaces::default(), sets, resolution, indices, empty, progress)
}

/// Returns the result of [`accumulate`], with buffers that are kept for other calls.
///
/// # Errors
///
/// The errors of [`accumulate`].
pub fn accumulate_with<A: Accumulator>(
    workspaces: &Workspaces,
    sets: &dyn Ensemble,
    resolution: Resolution,
    indices: Range<u64>,
    empty: &A,
    progress: &dyn Progress,
) -> Result<A, Error> {
    let Resolution { lmax, n_points, method, epsilon } = resolution;
    let transform = Transform::new(method, lmax, n_points, epsilon)?;
    let transform = OnSphere { transform, resolution };
    accumulate_by(&transform, &workspaces.sphere, sets, indices, empty, progress)
}

/// The transform of directions with its cost.
struct OnSphere {
    transform: Transform,
    resolution: Resolution,
}

impl SetTransform for OnSphere {
    type Bands = Domain;
    type Workspace = TransformWorkspace;

    fn zeros(&self) -> Result<Alm, Error> {
        Ok(Alm::zeros(self.resolution.lmax)?)
    }

    fn prepare(&self, workspace: &mut TransformWorkspace, is_lone: bool) {
        workspace.set_parallel(is_lone);
    }

    fn run(
        &self,
        sets: &[PointSet],
        workspace: &mut TransformWorkspace,
        alms: &mut [Alm],
    ) -> Result<(), Error> {
        let inputs: Vec<(&[DVec3], Option<&[f64]>)> =
            sets.iter().map(|set| (&*set.points, given_weights(set))).collect();
        self.transform.adjoint_batch_into(&inputs, workspace, alms);
        Ok(())
    }

    fn work(&self, _n_points: usize) -> f64 {
        self.resolution.method.nominal_work(self.resolution.n_points, self.resolution.lmax)
    }
}

/// Returns the weights of a set; `None` if all are equal.
pub(crate) fn given_weights<P>(set: &PointSet<P>) -> Option<&[f64]> {
    (!set.weights.is_empty()).then_some(&*set.weights)
}

/// A transform of point sets to the coefficients of bands.
pub(crate) trait SetTransform: Sync {
    /// The bands.
    type Bands: SpectralBands;
    /// Buffers that repeated transforms use.
    type Workspace: Default + Send;

    /// Returns coefficients of 0.
    fn zeros(&self) -> Result<<Self::Bands as SpectralBands>::Coefficients, Error>;

    /// Prepares buffers, which other transforms may have used, for transforms that run beside others or,
    /// if `is_lone`, one at a time, when each may use all threads.
    fn prepare(&self, workspace: &mut Self::Workspace, is_lone: bool);

    /// Replaces `out` by the coefficients of the sets.
    fn run(
        &self,
        sets: &[PointSet<<Self::Bands as SpectralBands>::Point>],
        workspace: &mut Self::Workspace,
        out: &mut [<Self::Bands as SpectralBands>::Coefficients],
    ) -> Result<(), Error>;

    /// Returns the nominal work of a set of `n_points`.
    fn work(&self, n_points: usize) -> f64;
}

/// Accumulates the sets with the given indices as [`accumulate_with`] does, by any transform.
pub(crate) fn accumulate_by<T: SetTransform, A: Accumulator<T::Bands>>(
    transform: &T,
    stock: &Stock<T::Workspace>,
    sets: &dyn Ensemble<<T::Bands as SpectralBands>::Point>,
    indices: Range<u64>,
    empty: &A,
    progress: &dyn Progress,
) -> Result<A, Error> {
    let n_batches = indices.end.saturating_sub(indices.start).div_ceil(BATCH);
    let begin = || {
        let mut workspace = stock.take();
        transform.prepare(&mut workspace, n_batches <= 1);
        let accumulator = empty.clone();
        Worker::<T, A> { sets: Vec::new(), workspace, coefficients: Vec::new(), accumulator }
    };
    // After a stop, no further batch is started.
    let is_stopped = AtomicBool::new(false);
    let stop = |error: &Error| {
        let stopped = Error::from(Stopped);
        is_stopped.fetch_or(*error == stopped, Ordering::Relaxed);
    };
    let step = |worker: Result<Worker<T, A>, Error>, batch: u64| {
        let mut worker = worker?;
        if is_stopped.load(Ordering::Relaxed) {
            return Err(Stopped.into());
        }
        let first = indices.start + batch * BATCH;
        let batch = first..first.saturating_add(BATCH).min(indices.end);
        worker.process(sets, transform, batch, progress).inspect_err(stop)?;
        Ok(worker)
    };
    let finished = (0..n_batches).into_par_iter().fold(|| Ok(begin()), step).map(|worker| {
        let Worker { workspace, accumulator, .. } = worker?;
        stock.put(workspace);
        Ok(accumulator)
    });
    let merge = |a: Result<A, Error>, b: Result<A, Error>| {
        let mut a = a?;
        a.merge(&b?);
        Ok(a)
    };
    finished.reduce_with(merge).unwrap_or_else(|| Ok(empty.clone()))
}

/// The buffers of one thread.
struct Worker<T: SetTransform, A> {
    sets: Vec<PointSet<<T::Bands as SpectralBands>::Point>>,
    workspace: T::Workspace,
    coefficients: Vec<<T::Bands as SpectralBands>::Coefficients>,
    accumulator: A,
}

impl<T: SetTransform, A: Accumulator<T::Bands>> Worker<T, A> {
    fn process(
        &mut self,
        ensemble: &dyn Ensemble<<T::Bands as SpectralBands>::Point>,
        transform: &T,
        batch: Range<u64>,
        progress: &dyn Progress,
    ) -> Result<(), Error> {
        let mut used = 0;
        for index in batch.clone() {
            if self.coefficients.len() == used {
                self.sets.push(PointSet::default());
                self.coefficients.push(transform.zeros()?);
            }
            ensemble.realize_into(index, &mut self.sets[used], progress)?;
            self.sets[used].normalize_weights();
            used += 1;
        }
        let (sets, coefficients) = (&self.sets[..used], &mut self.coefficients[..used]);
        transform.run(sets, &mut self.workspace, coefficients)?;
        for ((index, set), coefficients) in batch.zip(sets).zip(coefficients) {
            self.accumulator.push(&Realization::new(index, set, coefficients));
            progress.tick(transform.work(set.len()))?;
        }
        Ok(())
    }
}
