use std::fmt;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use sphvar_integrands::{LargestRatio, PulledBack, SquareIntegrand};
use sphvar_samplers::{Progress, Purpose, Square, SquareSampler};

use super::{
    WarpedComparison, WarpedEstimates, WarpedExperiment, WarpedPattern, WarpedPoint, strategy_group,
};
use crate::estimates::estimates;
use crate::{
    CurvePredictor, Error, Experiment, Prediction, PredictionBudget, SpectrumOptions,
    SquarePredictor, Trials,
};

/// Predicts and measures the variance of integrating one function of direction with warped patterns
/// of the same warps.
///
/// Of a single warp, predictions and trials are those of [`SquarePredictor`] for the
/// [`PulledBack`]. Of several, the variance is the sum of those of the strategies, which have
/// independent sets; each prediction has the precision and the work of the budget.
///
/// # Examples
///
/// ```
/// use sphvar_integrands::{
///     ClampedCosine, Domain, NoFiles, PulledBack, Tolerance,
/// };
/// use sphvar_variance::{PredictionBudget, Trials, WarpedPattern, WarpedPredictor};
///
/// let pattern: WarpedPattern = "jittered-square:warp=cylinder".parse()?;
/// let (domain, tolerance) = (Domain::Hemisphere, Tolerance::default());
/// let strategies = pattern.warp.strategies(domain, &NoFiles)?;
/// let pulled_back =
///     PulledBack::of_strategies(&ClampedCosine, domain, &strategies, pattern.heuristic, tolerance)?;
/// let mut predictor = WarpedPredictor::new(&pulled_back, 0, PredictionBudget::DEFAULT)?;
/// let compared = predictor.compare(&pattern, 64, Trials::new(400), &())?;
/// assert!(compared.comparison.z_score().abs() < 4.0);
/// // White noise has the variance pi^2/(3 N). 2 pi u jumps where shifts wrap around, in one of 8
/// // columns of strata.
/// let reduction = 3.29 / 64.0 / compared.comparison.prediction.variance;
/// assert!((3.5..4.5).contains(&reduction), "{reduction}");
/// # Ok::<(), sphvar_variance::Error>(())
/// ```
pub struct WarpedPredictor<'a> {
    strategies: Vec<(&'a PulledBack<'a>, SquarePredictor<'a>)>,
    integral: Option<f64>,
}

impl fmt::Debug for WarpedPredictor<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.strategies.iter().map(|(_, predictor)| predictor)).finish()
    }
}

impl<'a> WarpedPredictor<'a> {
    /// Returns a predictor for an integrand pulled back by every warp of the patterns, in their
    /// order ([`PulledBack::of_strategies`]). All realizations use the seed.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`SquarePredictor::new`], and [`Error::Parameter`] without functions.
    pub fn new(
        pulled_back: &'a [PulledBack<'a>],
        seed: u64,
        budget: PredictionBudget,
    ) -> Result<Self, Error> {
        if pulled_back.is_empty() {
            let (name, range) = ("the number of densities", "at least 1");
            return Err(Error::Parameter { name, range, got: 0.0 });
        }
        let predictor = |(i, function): (usize, &'a PulledBack<'a>)| {
            let predictor = SquarePredictor::new(function, seed, budget)?;
            Ok::<_, Error>((function, predictor.with_group(strategy_group(i))))
        };
        let strategies =
            pulled_back.iter().enumerate().map(predictor).collect::<Result<Vec<_>, _>>()?;
        let exact = |(function, _): &(&PulledBack<'_>, _)| function.exact();
        let integral = strategies.iter().map(exact).sum();
        Ok(Self { strategies, integral })
    }

    /// Returns the predictor with the exact integral, against which means of trials are tested.
    /// Default: the sum over the strategies, if all are known.
    #[must_use]
    pub fn with_integral(self, integral: Option<f64>) -> Self {
        Self { integral: integral.or(self.integral), ..self }
    }

    /// Returns the predictor with the user's settings for spectra.
    #[must_use]
    pub fn with_options(self, options: SpectrumOptions) -> Self {
        let with = |(function, predictor): (_, SquarePredictor<'a>)| {
            (function, predictor.with_options(options))
        };
        Self { strategies: self.strategies.into_iter().map(with).collect(), ..self }
    }

    /// Returns the predictor of predictions without their spectra; see
    /// [`PredictorOn::without_spectra`](crate::PredictorOn::without_spectra).
    #[must_use]
    pub fn without_spectra(self) -> Self {
        let without = |(function, predictor): (_, SquarePredictor<'a>)| {
            (function, predictor.without_spectra())
        };
        Self { strategies: self.strategies.into_iter().map(without).collect(), ..self }
    }

    /// Returns the precision and the work of the prediction for each strategy.
    #[must_use]
    pub fn budget(&self) -> PredictionBudget {
        self.strategies[0].1.budget()
    }

    /// Returns the exact integral, if it is known.
    #[must_use]
    pub fn integral(&self) -> Option<f64> {
        self.integral
    }

    /// Returns the predictors of the strategies, in their order.
    pub fn strategies(&self) -> impl Iterator<Item = &SquarePredictor<'a>> {
        self.strategies.iter().map(|(_, predictor)| predictor)
    }

    pub(crate) fn predictors(&mut self) -> impl Iterator<Item = &mut SquarePredictor<'a>> {
        self.strategies.iter_mut().map(|(_, predictor)| predictor)
    }

    /// Returns the variance with independent points, `n_points` in all, whose numbers are the
    /// pattern's shares; in closed form.
    #[must_use]
    pub fn white_variance(&self, pattern: &WarpedPattern, n_points: usize) -> f64 {
        let shares = pattern.warp.shares();
        let of_one = |((_, predictor), share): (&(_, SquarePredictor<'_>), f64)| {
            predictor.white_variance(1) / (share * n_points as f64)
        };
        self.strategies.iter().zip(shares).map(of_one).sum()
    }

    /// Returns the predicted variance with `n_points`. Ticks at most [`Self::work`].
    ///
    /// # Errors
    ///
    /// Returns the errors of [`WarpedPattern::samplers`] and
    /// [`PredictorOn::predict`](crate::PredictorOn::predict), and [`Error::Strategies`] for a pattern
    /// with another number of warps.
    pub fn predict(
        &mut self,
        pattern: &WarpedPattern,
        n_points: usize,
        progress: &dyn Progress,
    ) -> Result<WarpedPoint, Error> {
        self.predict_at(pattern, n_points, self.budget(), progress)
    }

    /// Returns the maximum nominal work of a prediction.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::predict`] that occur without a realization.
    pub fn work(&mut self, pattern: &WarpedPattern, n_points: usize) -> Result<f64, Error> {
        let samplers = self.samplers(pattern, n_points)?;
        let each = self.strategies.iter_mut().zip(&samplers);
        each.map(|((_, predictor), sampler)| predictor.work(&**sampler)).sum()
    }

    /// Returns the predicted and the measured variance, by [`Self::predict`], which also has the
    /// spectra, and [`Self::measure`].
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::predict`] and [`Self::measure`].
    pub fn compare(
        &mut self,
        pattern: &WarpedPattern,
        n_points: usize,
        trials: Trials,
        progress: &dyn Progress,
    ) -> Result<WarpedComparison, Error> {
        let point = self.predict(pattern, n_points, progress)?;
        self.measure(&point.prediction, pattern, n_points, trials, progress)
    }

    /// Returns the comparison of a prediction with the variance measured from the same seed, on sets
    /// independent of those of the prediction. Each trial adds one estimate of every strategy, and
    /// ticks [`WarpedPattern::trial_work`].
    ///
    /// # Errors
    ///
    /// Returns the errors of [`PredictorOn::measure`](crate::PredictorOn::measure) and
    /// [`Error::Strategies`].
    pub fn measure(
        &self,
        prediction: &Prediction,
        pattern: &WarpedPattern,
        n_points: usize,
        trials: Trials,
        progress: &dyn Progress,
    ) -> Result<WarpedComparison, Error> {
        let experiment = self.experiment(pattern, n_points)?;
        let mut source = |trials| self.estimates(pattern, n_points, trials, progress);
        experiment.measure(&mut source, *prediction, trials, progress)
    }

    /// Computes the energies that [`Self::predict`] needs.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::predict`] that occur without a realization.
    pub fn prepare(&mut self, pattern: &WarpedPattern, n_points: usize) -> Result<(), Error> {
        let samplers = self.samplers(pattern, n_points)?;
        let mut each = self.strategies.iter_mut().zip(&samplers);
        each.try_for_each(|((_, predictor), sampler)| predictor.prepare(&**sampler))
    }

    /// Returns what is known of the trials with `n_points`. Its roundings are those of the energies
    /// that have been computed so far ([`Self::prepare`]).
    ///
    /// # Errors
    ///
    /// Returns the errors of [`WarpedPattern::samplers`] and [`Error::Strategies`].
    pub fn experiment(
        &self,
        pattern: &WarpedPattern,
        n_points: usize,
    ) -> Result<WarpedExperiment, Error> {
        let samplers = self.samplers(pattern, n_points)?;
        let each = self.strategies.iter().zip(&samplers);
        let experiments: Vec<Experiment> =
            each.map(|((_, predictor), sampler)| predictor.experiment(&**sampler)).collect();
        let (strategy, largest) = self.largest_contribution(&samplers);
        Ok(WarpedExperiment {
            all: Experiment::of_sum(&experiments, self.integral),
            strategy,
            n_points: experiments[strategy].n_points,
            ratio: largest.ratio,
            direction: largest.direction.to_array(),
            area: largest.area,
        })
    }

    /// Returns the estimates of the given trials of [`Self::measure`]. Ticks
    /// [`WarpedPattern::trial_work`] for each.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::measure`].
    pub fn estimates(
        &self,
        pattern: &WarpedPattern,
        n_points: usize,
        trials: Range<u64>,
        progress: &dyn Progress,
    ) -> Result<WarpedEstimates, Error> {
        let samplers = self.samplers(pattern, n_points)?;
        let (strategy, largest) = self.largest_contribution(&samplers);
        let seen = AtomicU64::new(0);
        let mut sums: Vec<f64> = Vec::new();
        for (i, ((function, predictor), sampler)) in
            self.strategies.iter().zip(&samplers).enumerate()
        {
            let sets = predictor.realizations(Purpose::Trial, &**sampler);
            let threshold = if i == strategy { 0.5 * largest.ratio } else { f64::INFINITY };
            let function = Watched { function: *function, threshold, seen: &seen };
            let own = estimates(Square, &sets, &function, trials.clone(), progress)?;
            if i == 0 {
                sums = own;
            } else {
                sums.iter_mut().zip(own).for_each(|(sum, estimate)| *sum += estimate);
            }
        }
        Ok(WarpedEstimates { estimates: sums, near_largest: seen.into_inner() })
    }

    /// Returns the samplers of the strategies, of which the pattern must have as many as the
    /// predictor.
    pub(crate) fn samplers(
        &self,
        pattern: &WarpedPattern,
        n_points: usize,
    ) -> Result<Vec<Box<dyn SquareSampler>>, Error> {
        let (expected, got) = (pattern.n_strategies(), self.strategies.len());
        if expected != got {
            return Err(Error::Strategies { pattern: pattern.to_string(), expected, got });
        }
        pattern.samplers(n_points)
    }

    /// Returns the strategy of which one point contributes most to an estimate, and its largest
    /// ratio.
    fn largest_contribution(&self, samplers: &[Box<dyn SquareSampler>]) -> (usize, LargestRatio) {
        let n_points = samplers.iter().map(|sampler| sampler.n_points() as f64);
        let all = self.strategies.iter().zip(n_points).enumerate().map(|(i, (strategy, n))| {
            let largest = strategy.0.largest_ratio();
            (i, largest, largest.ratio / n)
        });
        let first = (0, self.strategies[0].0.largest_ratio(), f64::NEG_INFINITY);
        let (i, largest, _) = all.fold(first, |max, next| if next.2 > max.2 { next } else { max });
        (i, largest)
    }
}

impl CurvePredictor<WarpedPattern> for WarpedPredictor<'_> {
    type Point = WarpedPoint;

    fn budget(&self) -> PredictionBudget {
        self.budget()
    }

    fn nearest_count(&self, pattern: &WarpedPattern, requested: usize) -> usize {
        pattern.nearest_count(requested)
    }

    fn predict_at(
        &mut self,
        pattern: &WarpedPattern,
        n_points: usize,
        budget: PredictionBudget,
        progress: &dyn Progress,
    ) -> Result<WarpedPoint, Error> {
        let samplers = self.samplers(pattern, n_points)?;
        let each = self.strategies.iter_mut().zip(&samplers);
        let points = each.map(|((_, predictor), sampler)| {
            predictor.predict_within(budget, &**sampler, progress)
        });
        Ok(WarpedPoint::new(points.collect::<Result<_, _>>()?))
    }

    fn is_affordable_at(
        &mut self,
        pattern: &WarpedPattern,
        n_points: usize,
        budget: PredictionBudget,
    ) -> Result<bool, Error> {
        let samplers = self.samplers(pattern, n_points)?;
        for ((_, predictor), sampler) in self.strategies.iter_mut().zip(&samplers) {
            if !predictor.is_affordable_within(budget, &**sampler)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    fn is_repeated_by(
        &mut self,
        pattern: &WarpedPattern,
        point: &WarpedPoint,
        budget: PredictionBudget,
    ) -> Result<bool, Error> {
        let samplers = self.samplers(pattern, point.n_points())?;
        let each = self.strategies.iter_mut().zip(&samplers).zip(&point.strategies);
        for (((_, predictor), sampler), point) in each {
            if !predictor.repeats(budget, &**sampler, point)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    fn is_random_at(&self, pattern: &WarpedPattern, n_points: usize) -> bool {
        let samplers = self.samplers(pattern, n_points);
        samplers.is_ok_and(|samplers| samplers.iter().any(|sampler| sampler.is_random()))
    }

    /// No variance is impossible on the square.
    fn is_ruled_out(&mut self, _: &WarpedPattern, _: usize, _: f64) -> Result<bool, Error> {
        Ok(false)
    }
}

/// A function that counts the sets with a value above a threshold.
struct Watched<'a> {
    function: &'a dyn SquareIntegrand,
    threshold: f64,
    seen: &'a AtomicU64,
}

impl SquareIntegrand for Watched<'_> {
    fn eval(&self, point: [f64; 2]) -> f64 {
        self.function.eval(point)
    }

    fn eval_into(
        &self,
        points: &[[f64; 2]],
        values: &mut [f64],
    ) -> Result<(), sphvar_integrands::Error> {
        self.function.eval_into(points, values)?;
        if values.iter().any(|value| value.abs() > self.threshold) {
            self.seen.fetch_add(1, Ordering::Relaxed);
        }
        Ok(())
    }
}
