use std::cell::OnceCell;
use std::f64::consts::PI;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::DVec3;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use sphvar_samplers::{Ensemble, PointSet, Progress, Realizations, Stopped};
use sphvar_sh::{Alm, ByParity};
use sphvar_sht::{FastTransform, Method, Transform, TransformWorkspace};

use crate::{Error, ExactSum, Spectrum, SpectrumAccumulator, tail_power};

/// The coefficients of one realization, as accumulators see them.
#[derive(Debug)]
pub struct Realization<'a> {
    index: u64,
    set: &'a PointSet,
    alm: &'a Alm,
    normalization: f64,
    tail: OnceCell<ByParity>,
}

impl<'a> Realization<'a> {
    /// From coefficients that were made with the weights of `set`.
    fn new(index: u64, set: &'a PointSet, alm: &'a Alm) -> Self {
        let squares =
            if set.weights.is_empty() { set.len() as f64 } else { sum_of_squares(&set.weights) };
        let normalization = if squares > 0.0 { 4.0 * PI / squares } else { 0.0 };
        Self { index, set, alm, normalization, tail: OnceCell::new() }
    }

    /// Its number in the ensemble.
    #[must_use]
    pub fn index(&self) -> u64 {
        self.index
    }

    /// `S_lm = sum_k w_k conj Y_lm(s_k)`, the weights scaled by a power of two so that the largest is in [1/2, 1);
    /// equal weights are 1.
    #[must_use]
    pub fn alm(&self) -> &Alm {
        self.alm
    }

    /// Returns [`PointSet::n_effective`] of the points: N of equal weights.
    #[must_use]
    pub fn n_effective(&self) -> f64 {
        self.set.n_effective()
    }

    /// The factor that makes the power of white noise 1: `4 pi / sum_k w_k^2`, which is 4 pi/N
    /// for unit weights; 0 for a set without weight.
    #[must_use]
    pub fn normalization(&self) -> f64 {
        self.normalization
    }

    /// The mean power of even and of odd degrees at high degrees, [`tail_power`] of the points.
    #[must_use]
    pub fn tail(&self) -> ByParity {
        *self.tail.get_or_init(|| tail_power(&self.set.points, &self.set.weights))
    }

    /// P(l) for every degree from 0.
    pub fn power(&self) -> impl Iterator<Item = f64> {
        let normalization = self.normalization;
        self.alm.power_per_degree().into_iter().map(move |p| normalization * p)
    }
}

/// What is kept of the coefficients of an ensemble.
///
/// `merge` must give the same bits as pushing the other's realizations would, whatever the order:
/// that is what makes results independent of threads.
pub trait Accumulator: Clone + Send + Sync {
    /// Takes one realization in.
    fn push(&mut self, realization: &Realization<'_>);
    /// Takes in everything that `other`, a copy of the same empty accumulator, has seen.
    fn merge(&mut self, other: &Self);
}

impl<A: Accumulator, B: Accumulator> Accumulator for (A, B) {
    fn push(&mut self, realization: &Realization<'_>) {
        self.0.push(realization);
        self.1.push(realization);
    }

    fn merge(&mut self, other: &Self) {
        self.0.merge(&other.0);
        self.1.merge(&other.1);
    }
}

impl<A: Accumulator> Accumulator for Option<A> {
    fn push(&mut self, realization: &Realization<'_>) {
        if let Some(inner) = self {
            inner.push(realization);
        }
    }

    fn merge(&mut self, other: &Self) {
        if let (Some(mine), Some(theirs)) = (self, other) {
            mine.merge(theirs);
        }
    }
}

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

/// The squares of equal weights, added up plainly, would all be rounded to one side.
fn sum_of_squares(weights: &[f64]) -> f64 {
    let mut sum = ExactSum::default();
    for w in weights {
        sum.add(w * w);
    }
    sum.value()
}

/// The mean spectrum of a sampler to degree `lmax`, over `realizations` sets; the nominal work of making and
/// transforming them is ticked.
///
/// A pattern that is not random has the same spectrum in every rotation, so one set is
/// transformed and the standard error is 0.
///
/// # Errors
///
/// [`Error::NoRealizations`] for none, [`Error::Transform`] if `lmax` is out of range, [`Error::Sampler`] if a set cannot
/// be made or `progress` ends the work.
pub fn estimate(
    ensemble: &Realizations<'_>,
    lmax: usize,
    realizations: u64,
    progress: &dyn Progress,
) -> Result<Spectrum, Error> {
    let sampler = ensemble.sampler();
    let count = if sampler.is_random() { realizations } else { realizations.min(1) };
    let empty = SpectrumAccumulator::new(sampler.domain(), sampler.n_points(), lmax);
    let resolution = Resolution::new(lmax, sampler.n_points());
    let spectrum = accumulate(ensemble, resolution, 0..count, &empty, progress)?.finish()?;
    Ok(if sampler.is_random() { spectrum } else { spectrum.into_exact() })
}

#[cfg(test)]
mod tests {
    use super::sum_of_squares;

    /// A plain sum is off by 1.7e-11 of it.
    #[test]
    fn many_equal_weights_do_not_drift() {
        const N: usize = 1_000_000;
        let got = sum_of_squares(&[0.1; N]);
        let exact = N as f64 * (0.1 * 0.1);
        assert!((got / exact - 1.0).abs() <= 2.0 * f64::EPSILON, "{got}, not {exact}");
        let plain: f64 = [0.1; N].iter().map(|w| w * w).sum();
        assert!((plain / exact - 1.0).abs() > 1e-13, "a plain sum would do: {plain}");
    }
}
