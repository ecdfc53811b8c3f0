use std::ops::Range;

use glam::DVec3;
use rayon::prelude::{IndexedParallelIterator, ParallelIterator, ParallelSliceMut};
use sphvar_samplers::{Domain, Ensemble, Point, PointSet, Progress, Realizations, Sampler};

use crate::space::IntegrationSpace;
use crate::{Error, Measurement};
use sphvar_integrands::{Integrand, VectorIntegrand};

/// Returns estimates of the integral of `integrand` from `trials` realizations of an ensemble,
/// computed in parallel. Each trial gives the estimate `area sum_k w_k f(s_k)/sum_k w_k`. Ticks
/// [`trial_work`] for each.
///
/// # Errors
///
/// Returns [`Error::Spectrum`] with the sampler's error if a realization cannot be generated or
/// `progress` stops the work, and the errors of [`Integrand::eval_into`].
pub fn measure(
    ensemble: &Realizations<'_>,
    integrand: &dyn Integrand,
    trials: u64,
    progress: &dyn Progress,
) -> Result<Measurement, Error> {
    let domain = ensemble.sampler().domain();
    Ok(Measurement::new(estimates(domain, ensemble, integrand, 0..trials, progress)?))
}

/// Returns estimates of the integrals of all components of `integrand` from the same realizations:
/// those of [`measure`] for each component.
///
/// # Errors
///
/// Those of [`measure`].
///
/// # Examples
///
/// ```
/// use sphvar_integrands::{Cap, HarmonicProjection};
/// use sphvar_samplers::{Domain, Pattern, Purpose, Realizations, Streams};
/// use sphvar_variance::{Measurement, measure_components};
///
/// let cap = Cap::from_degrees(60.0)?;
/// let probe = HarmonicProjection::new(&cap, 2)?;
/// let jittered = Pattern::Jittered.build(48, Domain::Sphere)?;
/// let sets = Realizations::rotated(&*jittered, Streams::new(0, Purpose::Trial, 0));
/// let coefficients = measure_components(&sets, &probe, 100, &())?;
/// assert_eq!(coefficients.len(), 9);
/// // The mean squared error of the irradiance, integrated over all normals.
/// let irradiance = Measurement::of_vector(&coefficients, probe.irradiance().weights());
/// assert!(irradiance.variance() > 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn measure_components(
    ensemble: &Realizations<'_>,
    integrand: &dyn VectorIntegrand,
    trials: u64,
    progress: &dyn Progress,
) -> Result<Vec<Measurement>, Error> {
    let mut shared = SharedTrials::new(ensemble, integrand, progress);
    (0..integrand.components())
        .map(|c| Ok(Measurement::new(shared.estimates(c, 0..trials)?)))
        .collect()
}

/// Trials of a vector integrand whose components are read one by one, each to a number of trials of
/// its own.
pub(crate) struct SharedTrials<'a> {
    ensemble: &'a Realizations<'a>,
    integrand: &'a dyn VectorIntegrand,
    progress: &'a dyn Progress,
    /// The estimates of all components, trial by trial.
    rows: Vec<f64>,
}

impl<'a> SharedTrials<'a> {
    pub(crate) fn new(
        ensemble: &'a Realizations<'a>,
        integrand: &'a dyn VectorIntegrand,
        progress: &'a dyn Progress,
    ) -> Self {
        Self { ensemble, integrand, progress, rows: Vec::new() }
    }

    /// Returns the number of trials so far.
    pub(crate) fn known(&self) -> u64 {
        (self.rows.len() / self.integrand.components().max(1)) as u64
    }

    /// Returns the estimates of one component, which do not depend on those of others.
    pub(crate) fn estimates(
        &mut self,
        component: usize,
        trials: Range<u64>,
    ) -> Result<Vec<f64>, Error> {
        let width = self.integrand.components().max(1);
        let known = self.known();
        if known < trials.end {
            let more = known..trials.end;
            let new = shared_estimates(self.ensemble, self.integrand, more, self.progress)?;
            self.rows.extend(new);
        }
        let all = self.rows.chunks_exact(width).map(|row| row[component]);
        let [start, end] =
            [trials.start, trials.end].map(|n| usize::try_from(n).unwrap_or(usize::MAX));
        Ok(all.take(end).skip(start).collect())
    }
}

/// Returns the estimates of all components of a vector integrand, trial by trial.
pub(crate) fn shared_estimates(
    ensemble: &Realizations<'_>,
    integrand: &dyn VectorIntegrand,
    trials: Range<u64>,
    progress: &dyn Progress,
) -> Result<Vec<f64>, Error> {
    let width = integrand.components().max(1);
    let eval = |dirs: &[DVec3], values: &mut [f64]| integrand.eval_into(dirs, values);
    let area = ensemble.sampler().domain().area();
    rows(area, ensemble, (width, &eval), trials, progress)
}

/// Returns the nominal work of one trial: generating a set and evaluating the integrand at its
/// points.
#[must_use]
pub fn trial_work(sampler: &dyn Sampler) -> f64 {
    trial_work_of::<Domain>(sampler)
}

/// Returns [`trial_work`] for a sampler of any space.
pub(crate) fn trial_work_of<S: IntegrationSpace>(sampler: S::SamplerRef<'_>) -> f64 {
    S::nominal_work(sampler) + evaluation_work(S::n_points(sampler))
}

/// Returns the nominal work of evaluating an integrand, 40 ns per value.
pub(crate) fn evaluation_work(n_points: usize) -> f64 {
    n_points as f64 * 2.0 / 3.0
}

/// Returns the estimates of the given trials, in their order, so that results do not depend on
/// threads.
pub(crate) fn estimates<S: IntegrationSpace>(
    space: S,
    ensemble: &dyn Ensemble<S::Point>,
    integrand: S::Integrand<'_>,
    trials: Range<u64>,
    progress: &dyn Progress,
) -> Result<Vec<f64>, Error> {
    let eval = |points: &[S::Point], values: &mut [f64]| S::eval_into(integrand, points, values);
    rows(space.area(), ensemble, (1, &eval), trials, progress)
}

/// An integrand as a vector of one component.
pub(crate) struct Single<'a>(pub(crate) &'a dyn Integrand);

impl VectorIntegrand for Single<'_> {
    fn components(&self) -> usize {
        1
    }

    fn eval_into(
        &self,
        dirs: &[DVec3],
        values: &mut [f64],
    ) -> Result<(), sphvar_integrands::Error> {
        self.0.eval_into(dirs, values)
    }
}

/// The buffers of one thread.
#[derive(Default)]
struct Buffers<P> {
    set: PointSet<P>,
    values: Vec<f64>,
    of_component: Vec<f64>,
}

/// The number of trials between which memory is allocated.
const BLOCK: usize = 1 << 16;

/// Writes the values of all components at points, point by point.
type Eval<'a, P> = dyn Fn(&[P], &mut [f64]) -> Result<(), sphvar_integrands::Error> + Sync + 'a;

/// Returns the estimates of all components, trial by trial, over a space of an area. `eval` has the
/// number of components.
fn rows<P: Point>(
    area: f64,
    ensemble: &dyn Ensemble<P>,
    (width, eval): (usize, &Eval<'_, P>),
    trials: Range<u64>,
    progress: &dyn Progress,
) -> Result<Vec<f64>, Error> {
    let trial = |buffers: &mut Buffers<P>, (index, row): (u64, &mut [f64])| -> Result<(), Error> {
        let Buffers { set, values, of_component } = buffers;
        ensemble.realize_into(index, set, progress).map_err(sphvar_spectrum::Error::from)?;
        values.clear();
        values.resize(set.len() * width, 0.0);
        eval(&set.points, values)?;
        progress.tick(evaluation_work(set.len()))?;
        for (c, estimate) in row.iter_mut().enumerate() {
            of_component.clear();
            of_component.extend(values.iter().skip(c).step_by(width));
            *estimate = area * set.mean(of_component);
        }
        Ok(())
    };
    let (mut all, mut next) = (Vec::new(), trials.start);
    while next < trials.end && width > 0 {
        let count = usize::try_from(trials.end - next).map_or(BLOCK, |rest| rest.min(BLOCK));
        let known = all.len();
        all.resize(known + count * width, 0.0);
        let rows = all[known..].par_chunks_exact_mut(width).enumerate();
        rows.map(|(i, row)| (next + i as u64, row)).try_for_each_init(Buffers::default, trial)?;
        next += count as u64;
    }
    Ok(all)
}
