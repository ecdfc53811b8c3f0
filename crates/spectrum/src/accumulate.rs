use std::f64::consts::PI;
use std::ops::Range;

use glam::DVec3;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use sphvar_samplers::Realizations;
use sphvar_sh::Alm;
use sphvar_sht::{ExactTransform, ExactWorkspace};

use crate::{Error, Spectrum, SpectrumAccumulator};

/// A numbered family of point sets: the realizations of a sampler, or sets that a user brings.
pub trait PointSets: Sync {
    /// Replaces `points` by set `index`, unit vectors; `weights` is filled with one weight per
    /// point or left empty for unit weights.
    fn realize_into(&self, index: u64, points: &mut Vec<DVec3>, weights: &mut Vec<f64>);
}

impl PointSets for Realizations<'_> {
    fn realize_into(&self, index: u64, points: &mut Vec<DVec3>, weights: &mut Vec<f64>) {
        weights.clear();
        Self::realize_into(self, index, points);
    }
}

/// The coefficients of one realization, as accumulators see them.
#[derive(Debug)]
pub struct Realization<'a> {
    index: u64,
    alm: &'a Alm,
    normalization: f64,
}

impl Realization<'_> {
    /// Its number in the ensemble.
    #[must_use]
    pub fn index(&self) -> u64 {
        self.index
    }

    /// `S_lm = sum_k w_k conj Y_lm(s_k)`.
    #[must_use]
    pub fn alm(&self) -> &Alm {
        self.alm
    }

    /// The factor that makes the power of white noise 1: `4 pi / sum_k w_k^2`, which is 4 pi/N
    /// for unit weights; 0 for a set without weight.
    #[must_use]
    pub fn normalization(&self) -> f64 {
        self.normalization
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

/// Transforms the sets of the given numbers to degree `lmax` and accumulates them into a copy of
/// `empty`, in parallel over the sets; `done` is called after each.
///
/// # Errors
///
/// [`Error::Transform`] if `lmax` is beyond what the transform can hold.
pub fn accumulate<A: Accumulator>(
    sets: &dyn PointSets,
    lmax: usize,
    indices: Range<u64>,
    empty: &A,
    done: &(dyn Fn() + Sync),
) -> Result<A, Error> {
    let transform = ExactTransform::new(lmax)?;
    let begin = || -> Result<Worker<A>, Error> {
        Ok(Worker {
            points: Vec::new(),
            weights: Vec::new(),
            workspace: ExactWorkspace::default(),
            alm: Alm::zeros(lmax)?,
            accumulator: empty.clone(),
        })
    };
    let step = |worker: Result<Worker<A>, Error>, index| {
        let mut worker = worker?;
        worker.take(sets, &transform, index);
        done();
        Ok(worker)
    };
    let finished = indices.into_par_iter().fold(begin, step).map(|worker| Ok(worker?.accumulator));
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
    points: Vec<DVec3>,
    weights: Vec<f64>,
    workspace: ExactWorkspace,
    alm: Alm,
    accumulator: A,
}

impl<A: Accumulator> Worker<A> {
    fn take(&mut self, sets: &dyn PointSets, transform: &ExactTransform, index: u64) {
        sets.realize_into(index, &mut self.points, &mut self.weights);
        let weights = (!self.weights.is_empty()).then_some(&*self.weights);
        transform.adjoint_into(&self.points, weights, &mut self.workspace, &mut self.alm);
        let squares = weights.map_or(self.points.len() as f64, |w| w.iter().map(|x| x * x).sum());
        let normalization = if squares > 0.0 { 4.0 * PI / squares } else { 0.0 };
        self.accumulator.push(&Realization { index, alm: &self.alm, normalization });
    }
}

/// The mean spectrum of a sampler to degree `lmax`, over `realizations` sets; `done` is called
/// after each.
///
/// A pattern that is not random has the same spectrum in every rotation, so one set is
/// transformed and the standard error is 0.
///
/// # Errors
///
/// [`Error::NoRealizations`] for none, [`Error::Transform`] if `lmax` is out of range.
pub fn estimate(
    ensemble: &Realizations<'_>,
    lmax: usize,
    realizations: u64,
    done: &(dyn Fn() + Sync),
) -> Result<Spectrum, Error> {
    let sampler = ensemble.sampler();
    let count = if sampler.is_random() { realizations } else { realizations.min(1) };
    let empty = SpectrumAccumulator::new(sampler.domain(), sampler.n_points(), lmax);
    accumulate(ensemble, lmax, 0..count, &empty, done)?.finish()
}
