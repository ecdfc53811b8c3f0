//! The candidates for one integral, best first.

use sphvar_integrands::Integrand;
use sphvar_samplers::{Pattern, SquarePattern};
use sphvar_variance::{PredictionBudget, Predictor, SquarePredictor, predict};

use super::args::ChooseArgs;
use super::candidate::{self, TimedCandidate};
use super::choosable::{Choosable, PredictorOf};
use super::question::Question;
use super::record::{CoefficientRecord, LeftOut};
use super::{MAX_BUDGETS, budgets, presentation};
use crate::error::CliError;
use crate::global::Global;
use crate::integrands::{Integral, NamedSquareIntegrand, check_domain};
use crate::memory::check_memory;
use crate::patterns::parse_patterns;
use crate::progress::Progress;
use crate::report::number;

/// The number of points at which patterns are ordered by cost if the user gives none.
const TYPICAL_POINTS: usize = 1024;
/// The minimum memory of a point of a transformed set, in bytes.
const BYTES_PER_POINT: f64 = 24.0;

/// The candidates for one integral, best first.
pub(super) struct Ranking<'a, P: Choosable> {
    pub(super) question: Question,
    pub(super) predictor: PredictorOf<'a, P>,
    pub(super) candidates: Vec<TimedCandidate<P>>,
    pub(super) left_out: Vec<LeftOut>,
    /// For each candidate, the errors of the coefficients that an irradiance follows from.
    pub(super) coefficients: Vec<Option<Vec<CoefficientRecord>>>,
}

/// A coefficient of a projection.
struct Coefficient<'a> {
    l: usize,
    m: i64,
    exact: Option<f64>,
    predictor: Predictor<'a>,
}

impl<'a> Ranking<'a, Pattern> {
    /// Returns the candidates for an integral over the sphere or the hemisphere.
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
        let named = named.map(|list| parse_patterns(&list, global.quiet)).transpose()?;
        let of = |function: &'a dyn Integrand| {
            Predictor::new(function, domain, global.seed, PredictionBudget::DEFAULT)
                .map_err(CliError::usage)
        };
        let predictor = of(&*integrand.function)?.on_energies(announce);
        let quantity = if integral.is_irradiance() { "irradiance" } else { "integral" };
        let estimate = integrand.function.integral_estimate(domain);
        let largest = (domain.area() * predictor.energy().total()).sqrt();
        let question = Question::new(args, &integrand.name, quantity, estimate, largest)?;
        let mut ranking = Self::of_patterns(args, global, named, question, predictor)?;
        let coefficient = |integral: &'a Integral<'_>| {
            let (l, m) = integral.order.unwrap_or_default();
            let function = &*integral.integrand.function;
            let exact = function.exact(domain);
            Ok(Coefficient { l, m, exact, predictor: of(function)? })
        };
        let mut coefficients =
            coefficients.iter().map(coefficient).collect::<Result<Vec<_>, CliError>>()?;
        for (candidate, records) in ranking.candidates.iter().zip(&mut ranking.coefficients) {
            *records = coefficients_of(candidate, &mut coefficients)?;
        }
        Ok(ranking)
    }
}

impl<'a> Ranking<'a, SquarePattern> {
    /// Returns the candidates for an integral over the unit square.
    pub(super) fn on_square(
        args: &ChooseArgs,
        global: &Global,
        integrand: &'a NamedSquareIntegrand,
    ) -> Result<Self, CliError> {
        let named = args.samplers.list();
        let named = named.map(|list| parse_patterns(&list, global.quiet)).transpose()?;
        let function = &*integrand.function;
        let budget = PredictionBudget::DEFAULT;
        let predictor = SquarePredictor::new(function, global.seed, budget)
            .map_err(|e| CliError::Usage(format!("{}: {e}", integrand.name)))?;
        let largest = predictor.energy().total().sqrt();
        let estimate = function.integral_estimate();
        let question = Question::new(args, &integrand.name, "integral", estimate, largest)?;
        Self::of_patterns(args, global, named, question, predictor)
    }
}

/// Returns the errors of the coefficients with the number of points of a candidate, from the
/// spectrum by which the irradiance is predicted.
fn coefficients_of(
    candidate: &TimedCandidate<Pattern>,
    coefficients: &mut [Coefficient<'_>],
) -> Result<Option<Vec<CoefficientRecord>>, CliError> {
    let answer = &candidate.answer;
    let Some(point) = answer.n_points.and_then(|n| answer.curve.at(n)) else {
        return Ok(None);
    };
    if coefficients.is_empty() {
        return Ok(None);
    }
    let mut records = Vec::new();
    for Coefficient { l, m, exact, predictor } in coefficients {
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

impl<'a, P: Choosable> Ranking<'a, P> {
    /// Returns the candidates among `named` patterns, or all that are considered by default.
    pub(super) fn of_patterns(
        args: &ChooseArgs,
        global: &Global,
        named: Option<Vec<P>>,
        question: Question,
        mut predictor: PredictorOf<'a, P>,
    ) -> Result<Self, CliError> {
        let space = predictor.space();
        let is_named = named.is_some();
        let mut patterns = named.unwrap_or_else(P::considered);
        if let Some(n) = args.count.count {
            check_memory(&format!("-n {n}"), BYTES_PER_POINT * n as f64)?;
        }

        let typical = args.count.count.unwrap_or(TYPICAL_POINTS);
        // Inexpensive patterns come first. The order depends on nominal work rather than on time,
        // and so is the same on every machine.
        let work = |pattern: &P| P::nominal_work(pattern, typical);
        patterns.sort_by(|a, b| work(a).total_cmp(&work(b)));
        patterns.dedup();
        let shares: Vec<f64> = patterns.iter().map(|p| P::share(p, typical, space)).collect();
        let progress = Progress::new(shares.iter().sum(), global.quiet);
        let (mut candidates, mut left_out) = (Vec::<TimedCandidate<P>>::new(), Vec::new());
        let (mut best, mut min_points) = (f64::INFINITY, None);
        for (pattern, share) in patterns.into_iter().zip(shares) {
            if candidates.iter().any(|c| *c.answer.curve.pattern() == pattern) {
                continue;
            }
            progress.stage(&pattern.label());
            let budgets = args.count.count.map_or(0.0, |n| budgets(&pattern, n));
            if !is_named && budgets > MAX_BUDGETS {
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
        let coefficients = candidates.iter().map(|_| None).collect();
        Ok(Self { question, predictor, candidates, left_out, coefficients })
    }
}
