//! The samplers of one ranking while they are predicted, one after the other.

use sphvar_variance::PredictedCurve;

use super::candidate::{CLEAR, MAX_FACTOR, Precision, TimedCandidate};
use super::choosable::{Choosable, Density};
use super::question::Question;
use super::record::LeftOut;
use super::row::Row;
use super::{MAX_BUDGETS, budgets, presentation};
use crate::error::CliError;
use crate::progress::Progress;
use crate::report::number;

/// The samplers of one ranking that have been predicted so far.
pub(super) struct Contest<'a> {
    pub(super) question: Question,
    pub(super) rows: Vec<Row>,
    pub(super) left_out: Vec<LeftOut>,
    seed: u64,
    /// Whether the user named the samplers. These are kept unchanged, however far behind they are.
    is_named: bool,
    progress: &'a Progress,
    /// The minimum variance of densities that are not the integrand itself.
    min_variance: f64,
    /// The minimum number of points.
    min_points: Option<usize>,
}

impl<'a> Contest<'a> {
    pub(super) fn new(
        question: Question,
        seed: u64,
        is_named: bool,
        progress: &'a Progress,
    ) -> Self {
        Self {
            question,
            rows: Vec::new(),
            left_out: Vec::new(),
            seed,
            is_named,
            progress,
            min_variance: f64::INFINITY,
            min_points: None,
        }
    }

    /// Adds a pattern, whose variance the predictor predicts, or the reason why it is left out;
    /// `white` is the variance of white noise with a number of points. A pattern that the user did not
    /// name is predicted coarsely, and more precisely only while it may compete with the best so far.
    ///
    /// Returns the answer if there is one.
    pub(super) fn add<'p, P: Choosable>(
        &mut self,
        pattern: P,
        predictor: &mut P::Predictor<'p>,
        white: impl Fn(&P::Predictor<'p>, usize) -> f64,
    ) -> Option<TimedCandidate<P>> {
        let first = self.rows.len();
        let mut candidate = self.survey(pattern, predictor, &white)?;
        while self.may_compete(first, &candidate) {
            self.refine(first, &mut candidate, predictor, &white);
        }
        Some(candidate)
    }

    /// Returns whether a better prediction may place a candidate, whose row has an index, among those that
    /// compete with the best one. Rows whose density is the integrand are not recommended, so that they do not
    /// compete.
    pub(super) fn may_compete<P: Choosable>(
        &self,
        index: usize,
        candidate: &TimedCandidate<P>,
    ) -> bool {
        let is_known = self.rows.get(index).is_some_and(|row| row.known_to.is_some());
        !is_known && candidate.may_compete(&self.question, self.best_merit(index))
    }

    /// Adds a pattern as [`Self::add`] does, from coarse predictions unless the user named it, and with
    /// other parameters if these are better.
    pub(super) fn survey<'p, P: Choosable>(
        &mut self,
        pattern: P,
        predictor: &mut P::Predictor<'p>,
        white: impl Fn(&P::Predictor<'p>, usize) -> f64,
    ) -> Option<TimedCandidate<P>> {
        let (sampler, label) = (pattern.to_string(), pattern.label());
        if self.rows.iter().any(|row| row.record.sampler == sampler) {
            return None;
        }
        self.progress.stage(&label);
        let precision = if self.is_named { Precision::Full } else { Precision::Coarse };
        let answer = self.answer(PredictedCurve::new(pattern), predictor, precision);
        let limit = (self.min_variance, self.limit());
        let answer = answer.and_then(|candidate| match self.is_named {
            true => Ok(candidate),
            false => candidate.tuned(&self.question, predictor, limit, self.seed),
        });
        match answer {
            Ok(candidate) => {
                let row = self.row(&candidate, predictor, white);
                self.progress.line(&presentation::line(&row.record));
                self.rows.push(row);
                if let (Some(pattern), Some(n)) =
                    (&candidate.unaffordable, candidate.answer.n_points)
                {
                    let reason = too_expensive(budgets(pattern.nominal_work(n)));
                    self.leave_out(pattern.to_string(), pattern.label(), reason);
                }
                Some(candidate)
            }
            Err(error) => {
                self.leave_out(sampler, label, error.to_string());
                None
            }
        }
    }

    /// Replaces a candidate and its row by those from predictions of the next higher precision.
    pub(super) fn refine<'p, P: Choosable>(
        &mut self,
        index: usize,
        candidate: &mut TimedCandidate<P>,
        predictor: &mut P::Predictor<'p>,
        white: impl Fn(&P::Predictor<'p>, usize) -> f64,
    ) {
        let curve = candidate.answer.curve.clone().into_preliminary();
        match self.answer(curve, predictor, candidate.precision.next()) {
            Ok(better) => *candidate = better,
            // What was predicted coarsely stays in the ranking even if it cannot be predicted better.
            Err(_) => candidate.precision = Precision::Full,
        }
        self.rows[index] = self.row(candidate, predictor, white);
    }

    fn row<'p, P: Choosable>(
        &mut self,
        candidate: &TimedCandidate<P>,
        predictor: &P::Predictor<'p>,
        white: impl Fn(&P::Predictor<'p>, usize) -> f64,
    ) -> Row {
        let row = Row::new(candidate, &self.question, predictor, &|n| white(predictor, n));
        if let (Some((variance, _)), None) = (row.variance, row.known_to) {
            self.min_variance = self.min_variance.min(variance);
        }
        if row.record.basis == "predicted" {
            self.min_points = row.record.n.into_iter().chain(self.min_points).min();
        }
        row
    }

    /// Returns a merit that the best row which may be recommended does not exceed, apart from the row of an
    /// index.
    fn best_merit(&self, without: usize) -> f64 {
        let others = self.rows.iter().enumerate().filter(|(i, row)| *i != without && row.is_sure());
        let largest = others.map(|(_, row)| {
            let share = row.variance.map_or(0.0, |(variance, stderr)| stderr / variance);
            if row.is_rough { row.merit * (1.0 + CLEAR.1 * share) } else { row.merit }
        });
        largest.fold(f64::INFINITY, f64::min)
    }

    /// Returns whether the row of a candidate needs better predictions: it may compete with the best row,
    /// or is the best one of uniform directions, which is named beside it.
    pub(super) fn needs_refinement<P: Choosable>(
        &self,
        index: usize,
        candidate: &TimedCandidate<P>,
    ) -> bool {
        let is_uniform = |row: &&Row| row.density == Density::Uniform && row.is_sure();
        let uniform = self.rows.iter().filter(is_uniform).map(|row| row.merit);
        let is_best = self
            .rows
            .get(index)
            .is_some_and(|row| row.is_sure() && row.merit <= uniform.fold(f64::INFINITY, f64::min));
        candidate.is_rough() && is_best || self.may_compete(index, candidate)
    }

    /// Returns the variance of the best pattern of the sphere over that of the best sampler, if it is
    /// above [`MAX_FACTOR`] and samplers with a requested number of points are ranked by default:
    /// expensive patterns of the sphere are then not considered.
    pub(super) fn lead_of_warped(&self) -> Option<f64> {
        let is_open = !self.is_named && self.question.points().is_some();
        let on_sphere = self.rows.iter().filter(|row| row.warp.is_none());
        let variances = on_sphere.filter_map(|row| row.variance).map(|variance| variance.0);
        let ratio = variances.min_by(f64::total_cmp)? / self.min_variance;
        (is_open && ratio > MAX_FACTOR as f64).then_some(ratio)
    }

    /// Leaves out a sampler for a reason.
    pub(super) fn leave_out(&mut self, sampler: String, label: String, reason: String) {
        self.left_out.push(LeftOut { sampler, label, reason });
    }

    /// Returns the minimum number of points by which other samplers are limited, if they are.
    fn limit(&self) -> Option<usize> {
        let is_limited = !self.is_named && self.question.cost_per_sample.is_none();
        self.min_points.filter(|_| is_limited)
    }

    /// Returns the answer of a pattern.
    fn answer<P: Choosable>(
        &self,
        curve: PredictedCurve<P, P::Point>,
        predictor: &mut P::Predictor<'_>,
        precision: Precision,
    ) -> Result<TimedCandidate<P>, CliError> {
        let question = &self.question;
        let work = |n: usize| curve.pattern().nominal_work(n);
        let budgets = question.points().map_or(0.0, |n| budgets(work(n)));
        if !self.is_named && budgets > MAX_BUDGETS {
            return Err(CliError::Failed(too_expensive(budgets)));
        }
        TimedCandidate::new(curve, self.limit(), question, predictor, precision, self.seed)
    }
}

/// Returns the reason why a sampler is left out whose prediction costs this number of budgets.
fn too_expensive(budgets: f64) -> String {
    format!(
        "a prediction costs {} times the work budget; name the sampler to include it",
        number::count(budgets)
    )
}
