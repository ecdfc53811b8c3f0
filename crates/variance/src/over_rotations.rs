use std::ops::Range;

use glam::{DMat3, DQuat};
use sphvar_samplers::{
    Ensemble, PointSet, Progress, Purpose, Realizations, RotationRealizations, RotationSampler,
    Sampler, Share, rotate,
};

use crate::estimates::{estimates, trial_work};
use crate::space::IntegrationSpace;
use crate::{Error, Measurement, PredictedPoint, Predictor, student_quantile};

/// The variance of a pattern over rotations of low discrepancy instead of independent ones.
///
/// The squared error of a set of directions is a function of its rotation. Its mean over SO(3), the
/// variance, is estimated from several sets of rotations (replicates), each multiplied by an
/// independent uniform rotation: every replicate has the right expectation, and their spread is the
/// error, whatever the correlation within a set.
#[derive(Clone, Debug)]
pub struct OverRotations {
    /// The prediction for uniformly rotated realizations, [`Predictor::predict`].
    pub predicted: PredictedPoint,
    /// The exact integral, if it is known; otherwise errors are deviations from the mean estimate.
    pub exact: Option<f64>,
    /// The number of rotations of a replicate.
    pub n_rotations: usize,
    /// The mean squared error of each replicate.
    pub replicates: Vec<f64>,
}

impl OverRotations {
    /// Returns the variance, the mean over the replicates; NaN without replicates.
    #[must_use]
    pub fn variance(&self) -> f64 {
        self.moments().mean()
    }

    /// Returns the standard error of the variance; NaN for a single replicate.
    #[must_use]
    pub fn stderr(&self) -> f64 {
        self.moments().mean_stderr()
    }

    /// Returns the interval of the variance at a confidence, by Student's distribution with a degree
    /// of freedom less than there are replicates; `None` for a single one.
    #[must_use]
    pub fn interval(&self, confidence: f64) -> Option<(f64, f64)> {
        let quantile =
            student_quantile(f64::midpoint(1.0, confidence), self.replicates.len() as f64 - 1.0);
        let (mean, half) = (self.variance(), quantile * self.stderr());
        half.is_finite().then(|| ((mean - half).max(0.0), mean + half))
    }

    /// Returns measured minus predicted variance in standard errors.
    #[must_use]
    pub fn z_score(&self) -> f64 {
        let prediction = self.predicted.prediction;
        (self.variance() - prediction.variance) / self.stderr().hypot(prediction.total_stderr())
    }

    fn moments(&self) -> Measurement {
        Measurement::new(self.replicates.clone())
    }
}

impl Predictor<'_> {
    /// Returns the predicted variance of a sampler and the one measured over `replicates` sets of
    /// rotations. Realizations of random patterns differ between all rotations. Ticks
    /// [`Self::over_rotations_work`].
    ///
    /// The error is smaller than that of as many independent rotations if the squared error is a
    /// smooth function of the rotation: for integrands of few degrees and several hundred rotations a
    /// replicate. For integrands with jumps it is not.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::predict`] and of the samplers.
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_integrands::VonMisesFisher;
    /// use sphvar_samplers::{Domain, Pattern, RotationPattern};
    /// use sphvar_variance::{PredictionBudget, Predictor};
    ///
    /// let lobe = VonMisesFisher::new(4.0)?;
    /// let mut predictor = Predictor::new(&lobe, Domain::Sphere, 0, PredictionBudget::DEFAULT)?;
    /// let fibonacci = Pattern::FIBONACCI.build(20, Domain::Sphere)?;
    /// let rotations = RotationPattern::SuperFibonacci.build(256)?;
    /// let measured = predictor.over_rotations(&*fibonacci, &*rotations, 8, &())?;
    /// assert!(measured.z_score().abs() < 6.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn over_rotations(
        &mut self,
        sampler: &dyn Sampler,
        rotations: &dyn RotationSampler,
        replicates: u64,
        progress: &dyn Progress,
    ) -> Result<OverRotations, Error> {
        let share = Share::new(progress, self.work(sampler)?);
        let predicted = self.predict(sampler, &share)?;
        share.finish()?;
        let trials = 0..replicates.saturating_mul(rotations.n_points() as u64);
        let estimates = self.rotation_estimates(sampler, rotations, trials, progress)?;
        let exact = self.space().integral(self.integrand());
        self.over_rotations_of(predicted, exact, (sampler, rotations), &estimates)
    }

    /// Returns the estimates of the given trials of [`Self::over_rotations`], in their order: those of
    /// all rotations of the first replicate, then of the next. Ticks [`trial_work`] for each.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::over_rotations`].
    pub fn rotation_estimates(
        &self,
        sampler: &dyn Sampler,
        rotations: &dyn RotationSampler,
        trials: Range<u64>,
        progress: &dyn Progress,
    ) -> Result<Vec<f64>, Error> {
        let group = sampler.stream_group();
        let sets = Realizations::unrotated(sampler, self.streams(Purpose::Trial, group));
        let families = self.families(sampler, rotations);
        let (space, integrand) = (self.space(), self.integrand());
        let n = (rotations.n_points() as u64).max(1);
        let (mut all, mut next) = (Vec::new(), trials.start);
        while next < trials.end {
            let replicate = next / n;
            let first = replicate * n;
            let end = trials.end.min(first.saturating_add(n));
            let family = families.realize(replicate).map_err(sphvar_spectrum::Error::from)?;
            let rotated = RotatedSets { sets, rotations: &family.points, first };
            let own = next - first..end - first;
            all.extend(estimates(space, &rotated, integrand, own, progress)?);
            next = end;
        }
        Ok(all)
    }

    /// Returns the result of [`Self::over_rotations`] from its prediction, the exact integral if it is
    /// known, and the estimates of all trials ([`Self::rotation_estimates`]).
    ///
    /// # Errors
    ///
    /// Returns the errors of the rotations.
    pub fn over_rotations_of(
        &self,
        predicted: PredictedPoint,
        exact: Option<f64>,
        (sampler, rotations): (&dyn Sampler, &dyn RotationSampler),
        estimates: &[f64],
    ) -> Result<OverRotations, Error> {
        let families = self.families(sampler, rotations);
        let n_rotations = rotations.n_points();
        let centre = exact.unwrap_or_else(|| Measurement::new(estimates.to_vec()).mean());
        let mut replicates = Vec::new();
        for (index, values) in (0..).zip(estimates.chunks_exact(n_rotations.max(1))) {
            let family = families.realize(index).map_err(sphvar_spectrum::Error::from)?;
            let squares: Vec<f64> = values.iter().map(|x| (x - centre).powi(2)).collect();
            replicates.push(family.mean(&squares));
        }
        Ok(OverRotations { predicted, exact, n_rotations, replicates })
    }

    /// Returns the sets of rotations of the replicates.
    fn families<'r>(
        &self,
        sampler: &dyn Sampler,
        rotations: &'r dyn RotationSampler,
    ) -> RotationRealizations<'r> {
        let group = sampler.stream_group() ^ rotations.stream_group();
        RotationRealizations::rotated(rotations, self.streams(Purpose::Trial, group))
    }

    /// Returns the nominal work of [`Self::over_rotations`].
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::work`].
    pub fn over_rotations_work(
        &mut self,
        sampler: &dyn Sampler,
        n_rotations: usize,
        replicates: u64,
    ) -> Result<f64, Error> {
        let trials = replicates as f64 * n_rotations as f64;
        Ok(self.work(sampler)? + trials * trial_work(sampler))
    }
}

/// Realizations, each rotated by one of several rotations.
struct RotatedSets<'a> {
    sets: Realizations<'a>,
    rotations: &'a [DQuat],
    /// The number of the realization that the first rotation rotates.
    first: u64,
}

impl Ensemble for RotatedSets<'_> {
    fn realize_into(
        &self,
        index: u64,
        set: &mut PointSet,
        progress: &dyn Progress,
    ) -> Result<(), sphvar_samplers::Error> {
        self.sets.realize_into(self.first.wrapping_add(index), set, progress)?;
        let rotation = usize::try_from(index).ok().and_then(|at| self.rotations.get(at));
        let rotation = rotation.copied().unwrap_or(DQuat::IDENTITY);
        rotate(DMat3::from_quat(rotation), self.sets.sampler().domain(), &mut set.points);
        Ok(())
    }
}
