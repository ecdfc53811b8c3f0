use std::collections::HashMap;

use num_complex::Complex;
use sphvar_scene::Image;
use sphvar_spectrum::{OrderPower, Spectrum};
use sphvar_variance::Measurement;

use crate::{Error, Job, PlaneSpectrum, Setting};

/// The results of jobs in one setting; jobs do not contain the seed of their sets.
#[derive(Clone, Debug)]
pub struct Results {
    setting: Setting,
    outcomes: HashMap<String, Outcome>,
}

/// The result of a complete job.
#[derive(Clone, Debug)]
pub(crate) enum Outcome {
    Spectrum(Spectrum),
    Orders(Vec<OrderPower>),
    Coefficients(Vec<Complex<f64>>),
    Trials([Measurement; 2]),
    Pictures(Vec<Image>),
    Plane(Box<PlaneSpectrum>),
}

impl Results {
    /// Returns empty results.
    #[must_use]
    pub fn new(setting: Setting) -> Self {
        Self { setting, outcomes: HashMap::new() }
    }

    /// Returns the setting of jobs and figures.
    #[must_use]
    pub fn setting(&self) -> Setting {
        self.setting
    }

    /// Returns whether the job has been run.
    #[must_use]
    pub fn contains(&self, job: &Job) -> bool {
        self.outcomes.contains_key(&job.key())
    }

    pub(crate) fn insert(&mut self, job: &Job, outcome: Outcome) {
        self.outcomes.insert(job.key(), outcome);
    }

    /// Copies the result of another job in `other` as the result of this job.
    #[cfg(test)]
    pub(crate) fn take_over(&mut self, job: &Job, other: &Self, others: &Job) {
        if let Some(outcome) = other.outcomes.get(&others.key()) {
            self.insert(job, outcome.clone());
        }
    }

    /// Returns the mean spectrum of a [`Job::Spectrum`]; for a single set, the spectrum of the set,
    /// without errors.
    ///
    /// # Errors
    ///
    /// [`Error::Missing`], as for the others.
    pub fn spectrum(&self, job: &Job) -> Result<&Spectrum, Error> {
        match self.outcomes.get(&job.key()) {
            Some(Outcome::Spectrum(spectrum)) => Ok(spectrum),
            _ => Err(missing(job)),
        }
    }

    /// Returns the mean powers of a [`Job::Orders`], by degree and then by order from 0.
    ///
    /// # Errors
    ///
    /// [`Error::Missing`].
    pub fn orders(&self, job: &Job) -> Result<&[OrderPower], Error> {
        match self.outcomes.get(&job.key()) {
            Some(Outcome::Orders(orders)) => Ok(orders),
            _ => Err(missing(job)),
        }
    }

    /// Returns the coefficients of a [`Job::Coefficient`], set by set.
    ///
    /// # Errors
    ///
    /// [`Error::Missing`].
    pub fn coefficients(&self, job: &Job) -> Result<&[Complex<f64>], Error> {
        match self.outcomes.get(&job.key()) {
            Some(Outcome::Coefficients(samples)) => Ok(samples),
            _ => Err(missing(job)),
        }
    }

    /// Returns the estimates of a [`Job::Trials`], in the order of
    /// [`TestIntegrand::ALL`](crate::TestIntegrand::ALL).
    ///
    /// # Errors
    ///
    /// [`Error::Missing`].
    pub fn trials(&self, job: &Job) -> Result<&[Measurement; 2], Error> {
        match self.outcomes.get(&job.key()) {
            Some(Outcome::Trials(measurements)) => Ok(measurements),
            _ => Err(missing(job)),
        }
    }

    /// Returns the renders of a [`Job::Pictures`].
    ///
    /// # Errors
    ///
    /// [`Error::Missing`].
    pub fn pictures(&self, job: &Job) -> Result<&[Image], Error> {
        match self.outcomes.get(&job.key()) {
            Some(Outcome::Pictures(images)) => Ok(images),
            _ => Err(missing(job)),
        }
    }

    /// Returns the mean power of a [`Job::PlaneSpectrum`].
    ///
    /// # Errors
    ///
    /// [`Error::Missing`].
    pub fn plane(&self, job: &Job) -> Result<&PlaneSpectrum, Error> {
        match self.outcomes.get(&job.key()) {
            Some(Outcome::Plane(spectrum)) => Ok(spectrum),
            _ => Err(missing(job)),
        }
    }
}

fn missing(job: &Job) -> Error {
    Error::Missing { key: job.key() }
}
