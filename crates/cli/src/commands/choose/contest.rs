//! The samplers of one ranking while they are predicted, one after the other.

use super::candidate::{MAX_FACTOR, TimedCandidate};
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
    /// `white` is the variance of white noise with a number of points.
    ///
    /// Returns the answer if there is one.
    pub(super) fn add<'p, P: Choosable>(
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
        match self.answer(pattern, predictor) {
            Ok(candidate) => {
                let white = |n: usize| white(predictor, n);
                let row = Row::new(&candidate, &self.question, predictor, &white);
                if let (Some((variance, _)), None) = (row.variance, row.known_to) {
                    self.min_variance = self.min_variance.min(variance);
                }
                if row.record.basis == "predicted" {
                    self.min_points = row.record.n.into_iter().chain(self.min_points).min();
                }
                self.progress.line(&presentation::line(&row.record));
                self.rows.push(row);
                Some(candidate)
            }
            Err(error) => {
                self.leave_out(sampler, label, error.to_string());
                None
            }
        }
    }

    /// Returns the variance of the best uniform sampler over that of the best one, if it is above
    /// [`MAX_FACTOR`] and samplers with a requested number of points are ranked by default: expensive
    /// patterns are then not considered.
    pub(super) fn lead_of_densities(&self) -> Option<f64> {
        let is_open = !self.is_named && self.question.points().is_some();
        let uniform = self.rows.iter().filter(|row| row.density == Density::Uniform);
        let variances = uniform.filter_map(|row| row.variance).map(|variance| variance.0);
        let ratio = variances.min_by(f64::total_cmp)? / self.min_variance;
        (is_open && ratio > MAX_FACTOR as f64).then_some(ratio)
    }

    /// Leaves out a sampler for a reason.
    pub(super) fn leave_out(&mut self, sampler: String, label: String, reason: String) {
        self.left_out.push(LeftOut { sampler, label, reason });
    }

    /// Returns the answer of a pattern with its own parameters or, unless it is named, better ones.
    fn answer<P: Choosable>(
        &self,
        pattern: P,
        predictor: &mut P::Predictor<'_>,
    ) -> Result<TimedCandidate<P>, CliError> {
        let question = &self.question;
        let budgets = question.points().map_or(0.0, |n| budgets(pattern.nominal_work(n)));
        if !self.is_named && budgets > MAX_BUDGETS {
            return Err(CliError::Failed(format!(
                "a prediction costs {} times the work budget; name the sampler to include it",
                number::count(budgets)
            )));
        }
        let limit =
            self.min_points.filter(|_| !self.is_named && question.cost_per_sample.is_none());
        let candidate = TimedCandidate::new(pattern, limit, question, predictor, self.seed)?;
        match self.is_named {
            true => Ok(candidate),
            false => candidate.tuned(question, predictor, self.min_variance, self.seed),
        }
    }
}
