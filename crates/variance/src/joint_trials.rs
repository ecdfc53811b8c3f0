use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use sphvar_integrands::VectorIntegrand;
use sphvar_samplers::{Progress, Purpose, Sampler, Stopped};

use crate::estimates::{SharedTrials, shared_estimates};
use crate::predictor::{predict_from_sums, predict_together, sums_together};
use crate::{
    Comparison, Error, Experiment, Measurement, PredictedPoint, Prediction, PredictionBudget,
    PredictionSums, Predictor, Trials,
};

/// Predicts and measures several variances for the same point sets: one for each component of a
/// [`VectorIntegrand`], and mean squared errors of vectors of components.
///
/// Spectra and trials are shared, and every result is the one that its [`Predictor`] alone gives.
///
/// # Examples
///
/// ```
/// use sphvar_integrands::{Cap, HarmonicProjection};
/// use sphvar_samplers::{Domain, Pattern};
/// use sphvar_variance::{JointTrials, PredictionBudget, Predictor, Trials};
///
/// let cap = Cap::from_degrees(60.0)?;
/// let probe = HarmonicProjection::new(&cap, 1)?;
/// let (f_00, irradiance) = (probe.coefficient(0, 0)?, probe.irradiance());
/// let predictor = |f| Predictor::new(f, Domain::Sphere, 0, PredictionBudget::DEFAULT);
/// let mut joint = JointTrials::new(&probe)
///     .with_component(0, predictor(&f_00)?)
///     .with_vector(0..4, irradiance.weights(), predictor(&irradiance)?);
/// let jittered = Pattern::Jittered.build(48, Domain::Sphere)?;
/// for compared in joint.compare(&*jittered, Trials::new(400), &())? {
///     assert!(compared.z_score().abs() < 4.0);
/// }
/// # Ok::<(), sphvar_variance::Error>(())
/// ```
#[derive(Debug)]
pub struct JointTrials<'a> {
    integrand: Shared<'a>,
    parts: Vec<Part<'a>>,
}

/// The integrand, without a `Debug` form of its own.
struct Shared<'a>(&'a dyn VectorIntegrand);

impl std::fmt::Debug for Shared<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} components", self.0.components())
    }
}

/// One of the variances.
#[derive(Debug)]
struct Part<'a> {
    predictor: Predictor<'a>,
    components: Range<usize>,
    /// The factors of the components of a vector; `None` for a single component.
    weights: Option<Vec<f64>>,
}

impl<'a> JointTrials<'a> {
    /// Returns no variances yet, of the components of an integrand.
    #[must_use]
    pub fn new(integrand: &'a dyn VectorIntegrand) -> Self {
        Self { integrand: Shared(integrand), parts: Vec::new() }
    }

    /// Adds the variance of a component, predicted by `predictor`.
    ///
    /// All predictors must have the same seed, domain, budget and options.
    #[must_use]
    pub fn with_component(mut self, component: usize, predictor: Predictor<'a>) -> Self {
        let components = component..component + 1;
        self.parts.push(Part { predictor, components, weights: None });
        self
    }

    /// Adds the mean squared error of consecutive components with factors `weights`,
    /// `sum_c (a_c s_c)^2`, predicted by `predictor`.
    #[must_use]
    pub fn with_vector(
        mut self,
        components: Range<usize>,
        weights: &[f64],
        predictor: Predictor<'a>,
    ) -> Self {
        self.parts.push(Part { predictor, components, weights: Some(weights.to_vec()) });
        self
    }

    /// Returns the predictors, in the order in which they were added.
    pub fn predictors(&mut self) -> impl Iterator<Item = &mut Predictor<'a>> {
        self.parts.iter_mut().map(|part| &mut part.predictor)
    }

    /// Returns the maximum nominal work of [`Self::predict`], if all spectra have the same degree.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Predictor::work`].
    pub fn work(&mut self, sampler: &dyn Sampler) -> Result<f64, Error> {
        let mut max: f64 = 0.0;
        for predictor in self.predictors() {
            max = max.max(predictor.work(sampler)?);
        }
        Ok(max)
    }

    /// Returns the predicted variances, each that of [`Predictor::predict`].
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Predictor::predict`].
    pub fn predict(
        &mut self,
        sampler: &dyn Sampler,
        progress: &dyn Progress,
    ) -> Result<Vec<PredictedPoint>, Error> {
        let mut predictors: Vec<&mut Predictor<'_>> =
            self.parts.iter_mut().map(|part| &mut part.predictor).collect();
        let Some(budget) = predictors.first().map(|p| p.budget()) else { return Ok(Vec::new()) };
        predict_together(&mut predictors, budget, sampler, progress)
    }

    /// Returns the sums over some realizations of a sampler, from which [`Self::predict_from`] predicts
    /// variances. Of all realizations that the user chose
    /// ([`fixed_realizations`](crate::PredictorOn::fixed_realizations)), the predictions are those of
    /// [`Self::predict`].
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Predictor::predict`].
    pub fn prediction_sums(
        &mut self,
        sampler: &dyn Sampler,
        realizations: Range<u64>,
        progress: &dyn Progress,
    ) -> Result<PredictionSums, Error> {
        let mut predictors: Vec<&mut Predictor<'_>> = self.predictors().collect();
        let budget = predictors.first().map_or(PredictionBudget::DEFAULT, |p| p.budget());
        sums_together(&mut predictors, budget, sampler, realizations, progress)
    }

    /// Returns the predictions from [`Self::prediction_sums`].
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Predictor::predict`] that occur without a realization, and an error
    /// for sums of no realizations.
    pub fn predict_from(
        &mut self,
        sampler: &dyn Sampler,
        sums: &PredictionSums,
    ) -> Result<Vec<PredictedPoint>, Error> {
        let mut predictors: Vec<&mut Predictor<'_>> = self.predictors().collect();
        let budget = predictors.first().map_or(PredictionBudget::DEFAULT, |p| p.budget());
        predict_from_sums(&mut predictors, budget, sampler, sums)
    }

    /// Computes the energies that [`Self::predict`] needs for a sampler.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Predictor::prepare`].
    pub fn prepare(&mut self, sampler: &dyn Sampler) -> Result<(), Error> {
        self.predictors().try_for_each(|predictor| predictor.prepare(sampler))
    }

    /// Returns what is known of the trials with a sampler, for each variance
    /// ([`PredictorOn::experiment`](crate::PredictorOn::experiment)).
    #[must_use]
    pub fn experiments(&self, sampler: &dyn Sampler) -> Vec<Experiment> {
        self.parts.iter().map(|part| part.predictor.experiment(sampler)).collect()
    }

    /// Returns the number of components of an estimate.
    #[must_use]
    pub fn components(&self) -> usize {
        self.integrand.0.components()
    }

    /// Returns the estimates of all components from the given trials of [`Self::measure`], trial by
    /// trial. Ticks [`trial_work`](crate::trial_work) for each trial.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Predictor::measure`].
    pub fn estimates(
        &self,
        sampler: &dyn Sampler,
        trials: Range<u64>,
        progress: &dyn Progress,
    ) -> Result<Vec<f64>, Error> {
        let Some(first) = self.parts.first() else { return Ok(Vec::new()) };
        let sets = first.predictor.realizations(Purpose::Trial, sampler);
        shared_estimates(&sets, self.integrand.0, trials, progress)
    }

    /// Returns the comparisons of predictions with the variances of estimates, those of all
    /// components trial by trial ([`Self::estimates`]); `experiments` are those of
    /// [`Self::experiments`]. For a fixed number of trials, it is the result of [`Self::measure`].
    #[must_use]
    pub fn comparisons(
        &self,
        experiments: &[Experiment],
        predictions: &[Prediction],
        estimates: &[f64],
    ) -> Vec<Comparison> {
        let width = self.components().max(1);
        let of_component = |component: usize| {
            let rows = estimates.chunks_exact(width);
            Measurement::new(rows.filter_map(|row| row.get(component).copied()).collect())
        };
        let known = experiments.iter().zip(predictions);
        let compared = self.parts.iter().zip(known).map(|(part, (experiment, prediction))| {
            let measurement = match &part.weights {
                None => of_component(part.components.start),
                Some(weights) => {
                    let components: Vec<_> = part.components.clone().map(of_component).collect();
                    Measurement::of_vector(&components, weights)
                }
            };
            experiment.comparison(*prediction, measurement)
        });
        compared.collect()
    }

    /// Returns the comparisons of predictions with variances measured from the same trials. Each
    /// component has the trials of [`Predictor::measure`]; a vector has as many as the component
    /// with the most, to which its precision is at least as good.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Predictor::measure`].
    pub fn measure(
        &self,
        predictions: &[Prediction],
        sampler: &dyn Sampler,
        trials: Trials,
        progress: &dyn Progress,
    ) -> Result<Vec<Comparison>, Error> {
        self.measure_known(&self.experiments(sampler), predictions, sampler, trials, progress)
    }

    /// Returns [`Self::measure`] with what is known of the trials, [`Self::experiments`] at an earlier
    /// time.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Predictor::measure`].
    pub fn measure_known(
        &self,
        experiments: &[Experiment],
        predictions: &[Prediction],
        sampler: &dyn Sampler,
        trials: Trials,
        progress: &dyn Progress,
    ) -> Result<Vec<Comparison>, Error> {
        let Some(first) = self.parts.first() else { return Ok(Vec::new()) };
        let sets = first.predictor.realizations(Purpose::Trial, sampler);
        let mut shared = SharedTrials::new(&sets, self.integrand.0, progress);
        let work = SharedWork { progress, expected: Mutex::default() };
        let progress = if self.parts.len() > 1 { &work } else { progress };
        let mut comparisons: Vec<Option<Comparison>> = vec![None; self.parts.len()];
        // Components come first, as they determine the number of trials.
        for is_vector in [false, true] {
            let known = experiments.iter().zip(predictions);
            for (i, (part, (experiment, &prediction))) in self.parts.iter().zip(known).enumerate() {
                if part.weights.is_some() != is_vector {
                    continue;
                }
                work.begin();
                comparisons[i] = Some(match &part.weights {
                    None => {
                        let component = part.components.start;
                        let mut source = |range| shared.estimates(component, range);
                        experiment.measure(&mut source, prediction, trials, progress)?
                    }
                    Some(weights) => {
                        let all = 0..shared.known().max(trials.count);
                        let of = |c| Ok(Measurement::new(shared.estimates(c, all.clone())?));
                        let components: Result<Vec<_>, Error> =
                            part.components.clone().map(of).collect();
                        let measurement = Measurement::of_vector(&components?, weights);
                        experiment.comparison(prediction, measurement)
                    }
                });
            }
        }
        Ok(comparisons.into_iter().flatten().collect())
    }

    /// Returns [`Self::predict`] and [`Self::measure`].
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Predictor::compare`].
    pub fn compare(
        &mut self,
        sampler: &dyn Sampler,
        trials: Trials,
        progress: &dyn Progress,
    ) -> Result<Vec<Comparison>, Error> {
        let predicted = self.predict(sampler, progress)?;
        let predictions: Vec<_> = predicted.iter().map(|point| point.prediction).collect();
        self.measure(&predictions, sampler, trials, progress)
    }
}

/// The progress of trials that several variances share: the additional work that one expects counts
/// only where it exceeds that of the others.
struct SharedWork<'a> {
    progress: &'a dyn Progress,
    /// The largest additional work so far, and that of the present variance.
    expected: Mutex<(f64, f64)>,
}

impl SharedWork<'_> {
    fn begin(&self) {
        self.expected.lock().unwrap_or_else(PoisonError::into_inner).1 = 0.0;
    }
}

impl Progress for SharedWork<'_> {
    fn tick(&self, work: f64) -> Result<(), Stopped> {
        self.progress.tick(work)
    }

    fn expect(&self, work: f64) {
        let mut expected = self.expected.lock().unwrap_or_else(PoisonError::into_inner);
        expected.1 += work;
        if expected.1 > expected.0 {
            self.progress.expect(expected.1 - expected.0);
            expected.0 = expected.1;
        }
    }
}
