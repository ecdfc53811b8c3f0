use std::collections::BTreeSet;

use sphvar_samplers::{Progress, SamplerFamily};

use crate::predictor::ROUNDING;
use crate::space::IntegrationSpace;
use crate::{
    CurvePredictor, Error, PredictedCurve, PredictedVariance, Prediction, PredictionBudget, RateFit,
};

/// The number of points that a pattern needs for a variance.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum RequiredPoints {
    /// The predicted variance is at most the requested one at `n_points` and at every larger number
    /// tried.
    Predicted {
        /// The number of points.
        n_points: usize,
        /// The largest number tried that does not suffice; `None` if the smallest valid count does.
        too_few: Option<usize>,
    },
    /// Predictions for that number of points are too expensive: it is extrapolated by the
    /// power law through the last insufficient numbers.
    Extrapolated {
        /// The number of points.
        n_points: usize,
        /// The power law.
        fit: RateFit,
    },
    /// No number of points up to the maximum suffices.
    OutOfReach,
}

impl RequiredPoints {
    /// Returns the number of points, if any suffices.
    #[must_use]
    pub fn n_points(&self) -> Option<usize> {
        match *self {
            Self::Predicted { n_points, .. } | Self::Extrapolated { n_points, .. } => {
                Some(n_points)
            }
            Self::OutOfReach => None,
        }
    }
}

/// Returns the smallest number of points, at most `max_points`, with which `curve`'s pattern has a
/// predicted variance of at most `variance`. Predictions made on the way are added to the curve.
/// Work is ticked as in [`PredictorOn::predict`](crate::PredictorOn::predict).
///
/// The valid counts nearest to 1, 2, 4, 8, ... are tried until one suffices and the next one does
/// too. A random pattern does not need the next one if the first suffices clearly, by a factor of 1.5, and a
/// coarse prediction of the next one, with a 64th of the predictor's work, is not affordable. A pattern that is
/// not random needs two more that suffice, since its variance may rise again. Numbers beyond the first are predicted less precisely where that is decisive. Points of the curve that are
/// [preliminary](PredictedCurve::into_preliminary) are used where they are decisive. Numbers are tried only while they are affordable, and only if they are not ruled out by
/// energy that is spread over many degrees beyond 4 sqrt(N), where random patterns have at least
/// half of white noise's power ([`Predictor::broad_variance`](crate::Predictor::broad_variance)). The interval between the last
/// insufficient number and the next one is refined by interpolation in log N and log Var: to the
/// exact number where the predictions of a random pattern are exact, otherwise to 2 %. Counts that
/// were not tried are unknown; a lattice may have a larger variance at one of them. A variance that
/// exceeds the requested one by rounding only, relative 1e-12, suffices.
///
/// # Errors
///
/// Returns [`Error::Parameter`] for a variance that is not positive and finite, and the errors of
/// [`CurvePredictor::predict_at`] if the pattern cannot be built with any of the numbers tried.
///
/// # Examples
///
/// ```
/// use sphvar_integrands::ClampedCosine;
/// use sphvar_samplers::{Domain, Pattern};
/// use sphvar_variance::{PredictionBudget, PredictedCurve, Predictor, required_points};
///
/// // White noise on the hemisphere has the variance (2 pi int f^2 - (int f)^2)/N = pi^2/(3 N).
/// let mut predictor =
///     Predictor::new(&ClampedCosine, Domain::Hemisphere, 0, PredictionBudget::DEFAULT)?;
/// let mut curve = PredictedCurve::new(Pattern::WhiteNoise);
/// let variance = (0.01 * std::f64::consts::PI).powi(2);
/// let needed = required_points(&mut predictor, &mut curve, variance, 100_000, &())?;
/// assert_eq!(needed.n_points(), Some(3334));
/// # Ok::<(), sphvar_variance::Error>(())
/// ```
pub fn required_points<F: Clone, C: CurvePredictor<F> + ?Sized>(
    predictor: &mut C,
    curve: &mut PredictedCurve<F, C::Point>,
    variance: f64,
    max_points: usize,
    progress: &dyn Progress,
) -> Result<RequiredPoints, Error> {
    let budget = predictor.budget();
    required_points_within(budget, predictor, curve, (variance, max_points), progress)
}

/// Returns [`required_points`] for a variance and a maximum number of points, from predictions
/// within another budget than the predictor's: the number of points is then known to about the
/// relative precision of `budget`. Numbers of points are affordable whose predictions take at most 16 times
/// the work of `budget` and no more than that of the predictor's budget: a rough answer exists wherever a
/// precise one does, a coarse one (rough twice) where a prediction takes at most a quarter of the predictor's
/// budget.
///
/// # Errors
///
/// Returns the errors of [`required_points`].
pub fn required_points_within<F: Clone, C: CurvePredictor<F> + ?Sized>(
    budget: PredictionBudget,
    predictor: &mut C,
    curve: &mut PredictedCurve<F, C::Point>,
    (variance, max_points): (f64, usize),
    progress: &dyn Progress,
) -> Result<RequiredPoints, Error> {
    if !(variance > 0.0 && variance.is_finite()) {
        let (name, range) = ("the requested variance", "positive and finite");
        return Err(Error::Parameter { name, range, got: variance });
    }
    let variance = variance * (1.0 + ROUNDING);
    let rough = BTreeSet::new();
    let mut search = Search { predictor, curve, budget, variance, progress, rough };
    let climb = search.climb(max_points)?;
    let required = match climb.enough {
        Some(enough) => search.predicted(climb.too_few, enough)?,
        None if climb.is_cut_short => search.extrapolate(climb.too_few, max_points)?,
        None => RequiredPoints::OutOfReach,
    };
    search.mark_rough();
    Ok(required)
}

/// Returns whether predictions show that a pattern needs more than `max_points` points for a variance:
/// [`required_points_within`] a budget would find none. It takes one prediction, of `max_points`, for a random
/// pattern, whose variance falls with the number of points, otherwise also one of half as many points, instead
/// of one for each power of 2; they are added to the curve.
///
/// Returns false where this is not clear: the variance of a pattern that is not random does not exceed the
/// requested one clearly, or the variance is unknown because its prediction is not affordable or the pattern does
/// not support that number.
///
/// # Errors
///
/// Returns the errors of the integrand's energies, and errors of closures that generate sets.
pub fn needs_more_points<F: Clone, C: CurvePredictor<F> + ?Sized>(
    budget: PredictionBudget,
    predictor: &mut C,
    curve: &mut PredictedCurve<F, C::Point>,
    (variance, max_points): (f64, usize),
    progress: &dyn Progress,
) -> Result<bool, Error> {
    let pattern = curve.pattern().clone();
    let variance = variance * (1.0 + ROUNDING);
    let rough = BTreeSet::new();
    let mut search = Search { predictor, curve, budget, variance, progress, rough };
    let max = search.predictor.nearest_count(&pattern, max_points);
    let is_random = search.predictor.is_random_at(&pattern, max);
    let counts = if is_random { &[max_points][..] } else { &[max_points, max_points / 2] };
    let mut is_enough = false;
    for n in counts {
        let n = search.predictor.nearest_count(&pattern, *n);
        is_enough = n > max_points || search.may_suffice(n)?;
        if is_enough {
            break;
        }
    }
    search.mark_rough();
    Ok(!is_enough)
}

/// A rough prediction that is an estimate decides only if its variance differs from the requested one
/// by more than this factor, and by more than this number of standard errors.
const FACTOR: f64 = 1.5;
const ERRORS: f64 = 4.0;
/// The same number where the spectrum is exact and the energy beyond it the only error, which
/// [`Prediction::tail_error`] rather overestimates: it is that of the worst window of degrees.
const TAIL_ERRORS: f64 = 2.0;

/// Returns the budget that decides whether the predictions of a budget are affordable: even the fewest
/// realizations may take more than the work of a small budget.
pub(crate) fn affordable(budget: PredictionBudget, max: PredictionBudget) -> PredictionBudget {
    const MAX_FACTOR: f64 = 16.0;
    PredictionBudget { work: (MAX_FACTOR * budget.work).min(max.work), ..budget }
}

struct Search<'a, F, C: CurvePredictor<F> + ?Sized> {
    predictor: &'a mut C,
    curve: &'a mut PredictedCurve<F, C::Point>,
    /// The precision of the answer.
    budget: PredictionBudget,
    variance: f64,
    progress: &'a dyn Progress,
    /// Counts whose prediction on the curve is rough.
    rough: BTreeSet<usize>,
}

/// The state of the search after trying increasing numbers.
struct Climb {
    /// The largest number that does not suffice.
    too_few: Option<usize>,
    /// The next larger number, if there is one.
    enough: Option<usize>,
    /// Whether larger numbers are allowed but not affordable.
    is_cut_short: bool,
}

impl<F: Clone, C: CurvePredictor<F> + ?Sized> Search<'_, F, C> {
    fn climb(&mut self, max_points: usize) -> Result<Climb, Error> {
        let pattern = self.curve.pattern().clone();
        let mut climb = Climb { too_few: None, enough: None, is_cut_short: false };
        let mut rejection = None;
        // The numbers beyond the first one that suffices.
        let mut further = 0;
        let candidate_counts =
            candidate_counts(&|n| self.predictor.nearest_count(&pattern, n), max_points);
        // The lower bound falls with N: if it rules out the largest number, it rules out all.
        if let Some(&max) = candidate_counts.last()
            && self.predictor.is_ruled_out(&pattern, max, self.variance)?
        {
            return Ok(climb);
        }
        for n in candidate_counts {
            let is_random = self.predictor.is_random_at(&pattern, n);
            if self.predictor.is_ruled_out(&pattern, n, self.variance)? {
                climb.too_few = Some(n);
                continue;
            }
            // A random pattern needs the next number only for its rate.
            if is_random
                && climb.enough.is_some_and(|enough| self.is_clear(enough))
                && !self.is_inexpensive(n).unwrap_or(false)
            {
                break;
            }
            match self.is_affordable(n) {
                Ok(true) => {}
                Ok(false) => {
                    climb.is_cut_short = true;
                    break;
                }
                // The prediction itself returns this error.
                Err(_) => {}
            }
            let rough = self.budget.rough();
            let first = if climb.enough.is_some() { rough.rough() } else { rough };
            match self.suffices_by(n, first) {
                Ok(true) if climb.enough.is_some() => further += 1,
                Ok(true) => (climb.enough, further) = (Some(n), 0),
                Ok(false) => climb = Climb { too_few: Some(n), enough: None, ..climb },
                Err(error) => {
                    ignore_unsupported_count(&error)?;
                    // The variance at this number is unknown; a smaller number that suffices still
                    // does.
                    if climb.enough.is_none() {
                        climb.too_few = Some(n);
                    }
                    rejection = Some(error);
                }
            }
            if climb.enough.is_some() && further >= if is_random { 1 } else { 2 } {
                break;
            }
        }
        match rejection {
            Some(error) if self.curve.points().is_empty() => Err(error),
            _ => Ok(climb),
        }
    }

    /// Returns the answer from a number that suffices and the largest one that does not.
    fn predicted(
        &mut self,
        too_few: Option<usize>,
        enough: usize,
    ) -> Result<RequiredPoints, Error> {
        let n_points = match too_few {
            Some(too_few) => self.refine(too_few, enough)?,
            None => enough,
        };
        self.predict_precisely(n_points)?;
        self.predict_for_rate(n_points)?;
        let tried = self.curve.points().iter().rev().map(C::Point::n_points);
        let too_few = tried.filter(|&n| n < n_points).find(|&n| !self.suffices_at(n));
        Ok(RequiredPoints::Predicted { n_points, too_few })
    }

    /// Returns the smallest number found to suffice between one that does not and one that does.
    fn refine(&mut self, mut too_few: usize, mut enough: usize) -> Result<usize, Error> {
        let pattern = self.curve.pattern().clone();
        let is_lattice = !self.predictor.is_random_at(&pattern, enough);
        let mut halve = false;
        loop {
            // Lattices with neighbouring counts differ by more than this.
            let is_exact = !is_lattice
                && [too_few, enough]
                    .iter()
                    .all(|&n| self.curve.at(n).is_none_or(|p| p.prediction().stderr == 0.0));
            // The share of points is at most that of the variance: 2 % for the default budget.
            if !is_exact && enough as f64 <= (1.0 + self.budget.relative) * too_few as f64 {
                return Ok(enough);
            }
            let mut wanted = self.between(too_few, enough, halve);
            if !is_exact {
                let [low, high] = self.limits(too_few, enough);
                wanted = wanted.min(high).max(low);
            }
            let valid = |n: usize| self.predictor.nearest_count(&pattern, n);
            let Some(n) = count_between(&valid, too_few, enough, wanted) else {
                return Ok(enough);
            };
            let before = enough as f64 / too_few as f64;
            match self.suffices(n) {
                Ok(true) => enough = n,
                Ok(false) => too_few = n,
                Err(error) => {
                    ignore_unsupported_count(&error)?;
                    too_few = n;
                }
            }
            // Bisect after an interpolation that hardly narrows the interval.
            halve = (enough as f64 / too_few as f64).ln() > 0.5 * before.ln();
        }
    }

    /// Returns where, between two numbers, the smallest sufficient one is expected.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a number between two numbers of points"
    )]
    fn between(&self, too_few: usize, enough: usize, halve: bool) -> usize {
        let at = |n: usize| (n as f64).ln();
        let excess = |n: usize| {
            self.curve.at(n).map_or(f64::NAN, |p| (p.prediction().variance / self.variance).ln())
        };
        let (from, to) = (excess(too_few), excess(enough));
        let share = from / (from - to);
        let share = if share.is_finite() && !halve { share.clamp(0.0, 1.0) } else { 0.5 };
        // Slightly less, so that rounding in the logarithms does not skip the exact number of a
        // power law.
        let n = (at(too_few) + share * (at(enough) - at(too_few))).exp() * (1.0 - 1e-12);
        n.ceil() as usize
    }

    /// Returns the numbers between which the next one is tried. They differ from the ends by half of the precision
    /// of the answer: nearer numbers, to which interpolation leads, would hardly narrow the interval.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "numbers near two numbers of points"
    )]
    fn limits(&self, too_few: usize, enough: usize) -> [usize; 2] {
        let factor = 1.0 + 0.5 * self.budget.relative;
        [(factor * too_few as f64) as usize, (enough as f64 / factor).ceil() as usize]
    }

    /// Returns whether a number suffices, from a rough prediction if that is decisive.
    fn suffices(&mut self, n_points: usize) -> Result<bool, Error> {
        self.suffices_by(n_points, self.budget.rough())
    }

    /// Returns whether a number suffices, from a prediction within the budget `first` if that is
    /// decisive, or else from a rough one.
    fn suffices_by(&mut self, n_points: usize, first: PredictionBudget) -> Result<bool, Error> {
        let rough = self.budget.rough();
        if self.curve.at(n_points).is_none()
            || self.curve.is_preliminary(n_points) && !self.is_clear(n_points)
        {
            self.predict_within(first, n_points)?;
            self.rough.insert(n_points);
            if first != rough && !self.is_clear(n_points) {
                self.predict_within(rough, n_points)?;
            }
        }
        if !self.is_clear(n_points) {
            self.predict_precisely(n_points)?;
        }
        Ok(self.suffices_at(n_points))
    }

    fn is_clear(&self, n_points: usize) -> bool {
        self.curve.at(n_points).is_some_and(|point| {
            let Prediction { variance, stderr, .. } = *point.prediction();
            let ratio = variance / self.variance;
            // A standard error estimated from few realizations may be too small.
            let is_far = stderr == 0.0 || !(1.0 / FACTOR..=FACTOR).contains(&ratio);
            let errors = if stderr == 0.0 { TAIL_ERRORS } else { ERRORS };
            let distance = (variance - self.variance).abs();
            is_far && distance > errors * point.prediction().total_stderr()
        })
    }

    /// Returns whether a pattern may reach the variance with a number of points: the contrary is
    /// known for one that is not random only if it is clear, because its variance with other numbers may be less.
    fn may_suffice(&mut self, n_points: usize) -> Result<bool, Error> {
        let pattern = self.curve.pattern().clone();
        if self.predictor.is_ruled_out(&pattern, n_points, self.variance)? {
            return Ok(false);
        }
        if !self.is_affordable(n_points).unwrap_or(false) {
            return Ok(true);
        }
        let suffices = match self.suffices(n_points) {
            Ok(suffices) => suffices,
            Err(error) => {
                ignore_unsupported_count(&error)?;
                return Ok(true);
            }
        };
        let is_random = self.predictor.is_random_at(&pattern, n_points);
        Ok(suffices || !is_random && !self.is_clear(n_points))
    }

    /// Replaces a rough or preliminary prediction by one with the whole budget.
    fn predict_precisely(&mut self, n_points: usize) -> Result<(), Error> {
        if self.rough.remove(&n_points) || self.curve.is_preliminary(n_points) {
            self.predict_within(self.budget, n_points)?;
        }
        Ok(())
    }

    /// Replaces preliminary predictions from which the rate at an answer follows by rough ones. The rate does not
    /// need more of numbers beyond the answer.
    fn predict_for_rate(&mut self, n_points: usize) -> Result<(), Error> {
        let near = self.curve.points().iter().map(C::Point::n_points);
        let near: Vec<usize> = near.filter(|n| (n_points / 4..n_points).contains(n)).collect();
        for n in near {
            self.predict_roughly(n)?;
        }
        Ok(())
    }

    /// Replaces a preliminary prediction by a rough one.
    fn predict_roughly(&mut self, n_points: usize) -> Result<(), Error> {
        if self.curve.is_preliminary(n_points) {
            self.predict_within(self.budget.rough(), n_points)?;
            self.rough.insert(n_points);
        }
        Ok(())
    }

    /// Marks rough predictions on the curve for later searches.
    fn mark_rough(&mut self) {
        for n in std::mem::take(&mut self.rough) {
            self.curve.mark_preliminary(n);
        }
    }

    fn predict_within(&mut self, budget: PredictionBudget, n_points: usize) -> Result<(), Error> {
        self.curve.predict_within(self.predictor, budget, n_points, self.progress)
    }

    fn suffices_at(&self, n_points: usize) -> bool {
        self.curve.at(n_points).is_some_and(|p| p.prediction().variance <= self.variance)
    }

    /// Extrapolates from the rate of the last points; if the resulting number is affordable, it is
    /// tried.
    fn extrapolate(
        &mut self,
        mut too_few: Option<usize>,
        max_points: usize,
    ) -> Result<RequiredPoints, Error> {
        const TRIES: usize = 4;
        let pattern = self.curve.pattern().clone();
        // The rate needs predictions, and numbers that were ruled out have none on the curve.
        if let Some(mut last) = too_few {
            // Numbers that were ruled out may exceed the allowed work.
            while last > 1 && !self.is_affordable_next_to(last) {
                last /= 2;
            }
            for n in [last, last / 2, last / 4] {
                let n = self.predictor.nearest_count(&pattern, n);
                if let Err(error) = self.predict_roughly(n).and_then(|()| self.suffices(n)) {
                    ignore_unsupported_count(&error)?;
                }
            }
        }
        for _ in 0..TRIES {
            let led = self.by_rate(max_points);
            match led.n_points() {
                Some(n) if self.is_affordable(n)? => {
                    if self.suffices(n)? {
                        return self.predicted(too_few, n);
                    }
                    too_few = Some(n);
                }
                _ => return Ok(led),
            }
        }
        Ok(self.by_rate(max_points))
    }

    fn is_affordable(&mut self, n_points: usize) -> Result<bool, Error> {
        let budget = affordable(self.budget, self.predictor.budget());
        self.predictor.is_affordable_at(self.curve.pattern(), n_points, budget)
    }

    /// Returns whether a prediction takes no more than the work of a coarse one.
    fn is_inexpensive(&mut self, n_points: usize) -> Result<bool, Error> {
        let budget = self.predictor.budget().rough().rough();
        self.predictor.is_affordable_at(self.curve.pattern(), n_points, budget)
    }

    /// Returns whether the valid count nearest to `n_points` can be predicted within the budget.
    fn is_affordable_next_to(&mut self, n_points: usize) -> bool {
        let next = self.predictor.nearest_count(self.curve.pattern(), n_points);
        self.is_affordable(next).unwrap_or(false)
    }

    /// Extrapolates the power law through the last points, over a factor of 8 in N.
    fn by_rate(&self, max_points: usize) -> RequiredPoints {
        let Some(last) = self.curve.points().last().map(|p| p.n_points() as f64) else {
            return RequiredPoints::OutOfReach;
        };
        let fit = self.curve.rate_within(last / 8.5, last);
        let Some(fit) = fit.filter(|fit| fit.slope < 0.0) else {
            return RequiredPoints::OutOfReach;
        };
        // All numbers tried, including the last one, were insufficient.
        let n = ((self.variance.ln() - fit.intercept) / fit.slope).exp().max(last + 1.0);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "positive and at most max_points"
        )]
        let n = if n <= max_points as f64 { n.ceil() as usize } else { usize::MAX };
        let valid = |n: usize| self.predictor.nearest_count(self.curve.pattern(), n);
        let above = count_between(&valid, n.saturating_sub(1), usize::MAX, n);
        match above.filter(|&n| n <= max_points) {
            Some(n_points) => RequiredPoints::Extrapolated { n_points, fit },
            None => RequiredPoints::OutOfReach,
        }
    }
}

/// Ignores errors for counts that the pattern does not support, and returns any other error.
pub(crate) fn ignore_unsupported_count(error: &Error) -> Result<(), Error> {
    use sphvar_samplers::Error::{Given, Stopped};
    match error {
        Error::Spectrum(sphvar_spectrum::Error::Sampler(Given { .. } | Stopped(_))) => {
            Err(error.clone())
        }
        Error::Spectrum(sphvar_spectrum::Error::Sampler(_)) => Ok(()),
        other => Err(other.clone()),
    }
}

/// Returns the valid counts nearest to 1, 2, 4, ..., and the largest valid count, none beyond
/// `max_points`.
fn candidate_counts(valid: &dyn Fn(usize) -> usize, max_points: usize) -> Vec<usize> {
    let powers = (0..usize::BITS).map(|k| 1_usize << k).take_while(|&n| n < max_points);
    let mut candidate_counts: Vec<usize> = powers.map(valid).collect();
    candidate_counts.extend(largest_count_to(valid, max_points));
    candidate_counts.retain(|&n| n <= max_points);
    candidate_counts.dedup();
    candidate_counts
}

/// Returns the largest valid count of at most `max_points`, or `None` if there is none.
pub(crate) fn largest_count_to(valid: &dyn Fn(usize) -> usize, max_points: usize) -> Option<usize> {
    count_between(valid, 0, max_points.saturating_add(1), max_points)
}

/// Returns the valid count of a pattern nearest to `wanted` among those above `low` and below
/// `high`, or `None` if there is none.
#[must_use]
pub fn valid_between<S: IntegrationSpace>(
    pattern: &dyn SamplerFamily<S>,
    space: S,
    low: usize,
    high: usize,
    wanted: usize,
) -> Option<usize> {
    count_between(&|n| pattern.nearest_count(n, space), low, high, wanted)
}

/// Returns [`valid_between`] for the valid counts nearest to any count, which never decrease.
pub(crate) fn count_between(
    valid: &dyn Fn(usize) -> usize,
    low: usize,
    high: usize,
    wanted: usize,
) -> Option<usize> {
    if high <= low.saturating_add(1) {
        return None;
    }
    let wanted = wanted.clamp(low + 1, high - 1);
    let (mut from, mut to) = (low + 1, high - 1);
    let near = valid(wanted);
    let found = if near >= high {
        // The largest n whose valid count is below `high`.
        while from < to {
            let middle = to - (to - from) / 2;
            if valid(middle) < high {
                from = middle;
            } else {
                to = middle - 1;
            }
        }
        valid(from)
    } else if near <= low {
        while from < to {
            let middle = from + (to - from) / 2;
            if valid(middle) > low {
                to = middle;
            } else {
                from = middle + 1;
            }
        }
        valid(from)
    } else {
        near
    };
    (low < found && found < high).then_some(found)
}

#[cfg(test)]
mod tests;
