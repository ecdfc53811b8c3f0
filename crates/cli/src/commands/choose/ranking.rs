//! The candidates for one integral, best first.

use sphvar_integrands::Integrand;
use sphvar_variance::{PredictionBudget, Predictor, predict};

use super::args::ChooseArgs;
use super::candidate::{self, TimedCandidate};
use super::question::Question;
use super::record::{CoefficientRecord, LeftOut};
use super::{MAX_BUDGETS, budgets, considered, presentation, share};
use crate::error::CliError;
use crate::global::Global;
use crate::integrands::{Integral, check_domain};
use crate::memory::check_memory;
use crate::patterns::parse_patterns;
use crate::progress::Progress;
use crate::report::number;

/// The number of points at which patterns are ordered by cost if the user gives none.
const TYPICAL_POINTS: usize = 1024;
/// The minimum memory of a point of a transformed set, in bytes.
const BYTES_PER_POINT: f64 = 24.0;

/// The candidates for one integral, best first.
pub(super) struct Ranking<'a> {
    pub(super) question: Question,
    pub(super) predictor: Predictor<'a>,
    pub(super) candidates: Vec<TimedCandidate>,
    pub(super) left_out: Vec<LeftOut>,
    /// The coefficients that an irradiance follows from.
    coefficients: Vec<Coefficient<'a>>,
}

/// A coefficient of a projection.
struct Coefficient<'a> {
    l: usize,
    m: i64,
    exact: Option<f64>,
    predictor: Predictor<'a>,
}

impl<'a> Ranking<'a> {
    pub(super) fn new(
        args: &ChooseArgs,
        global: &Global,
        integral: &'a Integral<'_>,
        coefficients: &'a [Integral<'_>],
        announce: &'a dyn Fn(usize),
    ) -> Result<Self, CliError> {
        let (integrand, domain) = (integral.integrand, args.domain.domain());
        check_domain(integrand, domain)?;
        let named = args.samplers.list();
        let mut patterns = match &named {
            Some(list) => parse_patterns(list, global.quiet)?,
            None => considered(),
        };
        let of = |function: &'a dyn Integrand| {
            Predictor::new(function, domain, global.seed, PredictionBudget::DEFAULT)
                .map_err(CliError::usage)
        };
        let mut predictor = of(&*integrand.function)?.on_energies(announce);
        let question = Question::new(args, integral, predictor.energy())?;
        if let Some(n) = args.count.count {
            check_memory(&format!("-n {n}"), BYTES_PER_POINT * n as f64)?;
        }

        let typical = args.count.count.unwrap_or(TYPICAL_POINTS);
        // Inexpensive patterns come first. The order depends on nominal work rather than on time,
        // and so is the same on every machine.
        patterns.sort_by(|a, b| a.nominal_work(typical).total_cmp(&b.nominal_work(typical)));
        patterns.dedup();
        let shares: Vec<f64> = patterns.iter().map(|p| share(p, typical, domain)).collect();
        let progress = Progress::new(shares.iter().sum(), global.quiet);
        let (mut candidates, mut left_out) = (Vec::<TimedCandidate>::new(), Vec::new());
        let (mut best, mut min_points) = (f64::INFINITY, None);
        for (pattern, share) in patterns.into_iter().zip(shares) {
            if candidates.iter().any(|c| *c.answer.curve.pattern() == pattern) {
                continue;
            }
            progress.stage(&pattern.label());
            let budgets = args.count.count.map_or(0.0, |n| budgets(&pattern, n));
            if named.is_none() && budgets > MAX_BUDGETS {
                left_out.push(LeftOut {
                    sampler: pattern.to_string(),
                    label: pattern.label(),
                    reason: format!(
                        "a prediction costs {} times the work budget; name the sampler to include it",
                        number::count(budgets)
                    ),
                });
            } else {
                // A pattern that the user names is kept unchanged, however far behind it is.
                let is_named = named.is_some();
                let limit = min_points.filter(|_| !is_named && args.cost_per_sample.is_none());
                let (label, name) = (pattern.label(), pattern.to_string());
                let candidate =
                    TimedCandidate::new(pattern, limit, &question, &mut predictor, global.seed)
                        .and_then(|c| match is_named {
                            true => Ok(c),
                            false => c.tuned(&question, &mut predictor, best, global.seed),
                        });
                match candidate {
                    Ok(candidate) => {
                        best = best.min(candidate.answer.variance.map_or(f64::INFINITY, |v| v.0));
                        if candidate.basis() == "predicted" {
                            min_points =
                                candidate.answer.n_points.into_iter().chain(min_points).min();
                        }
                        progress.line(&presentation::line(&candidate, &question, &predictor));
                        candidates.push(candidate);
                    }
                    Err(error) => {
                        let reason = error.to_string();
                        left_out.push(LeftOut { sampler: name, label, reason });
                    }
                }
            }
            progress.advance(share);
        }
        drop(progress);
        if candidates.is_empty() {
            let reasons: Vec<String> =
                left_out.iter().map(|l| format!("{}: {}", l.label, l.reason)).collect();
            return Err(CliError::Failed(reasons.join("; ")));
        }
        candidate::rank(&mut candidates, &question);
        let coefficient = |integral: &'a Integral<'_>| {
            let (l, m) = integral.order.unwrap_or_default();
            let function = &*integral.integrand.function;
            let exact = function.exact(domain);
            Ok(Coefficient { l, m, exact, predictor: of(function)? })
        };
        let coefficients =
            coefficients.iter().map(coefficient).collect::<Result<Vec<_>, CliError>>()?;
        Ok(Self { question, predictor, candidates, left_out, coefficients })
    }

    /// Returns the errors of the coefficients with the number of points of a candidate, from the
    /// spectrum by which the irradiance is predicted.
    pub(super) fn coefficients(
        &mut self,
        candidate: usize,
    ) -> Result<Option<Vec<CoefficientRecord>>, CliError> {
        let answer = &self.candidates[candidate].answer;
        let Some(point) = answer.n_points.and_then(|n| answer.curve.at(n)) else {
            return Ok(None);
        };
        if self.coefficients.is_empty() {
            return Ok(None);
        }
        let mut records = Vec::new();
        for Coefficient { l, m, exact, predictor } in &mut self.coefficients {
            let energy = predictor.energy_to(point.spectrum.lmax())?;
            let variance = predict(&point.spectrum, energy).variance;
            let variance = if variance <= predictor.rounding() { 0.0 } else { variance };
            records.push(CoefficientRecord {
                l: *l,
                m: *m,
                exact: *exact,
                variance,
                error: variance.sqrt(),
            });
        }
        Ok(Some(records))
    }
}
