//! The densities to which patterns of the square are mapped, for one function of direction.

use sphvar_integrands::{
    Domain, Expression, Heuristic, Integrand, PulledBack, Strategy, Tolerance, WarpExpression,
};
use sphvar_samplers::SquarePattern;
use sphvar_variance::{PredictionBudget, WarpedPattern, WarpedPredictor, best_shares};

use super::choosable::square_patterns;
use super::contest::Contest;
use super::importance::Importance;
use crate::error::CliError;
use crate::integrands::strategies_of;
use crate::progress::Progress;

/// The patterns of the square that are ranked with every density, inexpensive ones of different kinds.
const FIRST: [&str; 3] = ["sobol", "r2", "jittered-square"];
/// The number of densities, those of the best rows, that are ranked with all patterns of the square.
const BEST_DENSITIES: usize = 2;
/// The number of points for which shares are found if the user gives none.
const TYPICAL_POINTS: usize = 1024;
/// The values from which the variance is predicted while shares are searched, about a tenth of a
/// second for each of some eight pairs of densities.
const SEARCH: Tolerance =
    Tolerance { relative: 1e-2, min_evaluations: 1 << 14, max_evaluations: 1 << 16 };

/// A function of direction with the settings of its ranking.
#[derive(Clone, Copy)]
pub(super) struct WarpedIntegral<'a> {
    pub(super) function: &'a dyn Integrand,
    pub(super) domain: Domain,
    pub(super) seed: u64,
    pub(super) quiet: bool,
}

/// A function pulled back by one or several densities.
struct Pulled<'a> {
    warp: WarpExpression,
    heuristic: Heuristic,
    strategies: Vec<Strategy>,
    functions: Vec<PulledBack<'a>>,
}

impl<'a> WarpedIntegral<'a> {
    /// Adds the patterns that the user names; `white` is the variance of independent uniform
    /// directions.
    pub(super) fn add_named(
        &self,
        contest: &mut Contest<'_>,
        named: Vec<WarpedPattern>,
        progress: &Progress,
        white: &dyn Fn(usize) -> f64,
    ) -> Result<(), CliError> {
        let mut pending = named;
        while let Some(first) = pending.first().cloned() {
            let same = |p: &WarpedPattern| (&p.warp, p.heuristic) == (&first.warp, first.heuristic);
            let (patterns, others) = pending.into_iter().partition(same);
            pending = others;
            let patterns: Vec<WarpedPattern> = patterns;
            let share = patterns.len() as f64;
            match self.pulled_back(&first)? {
                Ok(pulled) => pulled.add(self, contest, patterns, white)?,
                Err(reason) => {
                    for pattern in patterns {
                        contest.leave_out(pattern.to_string(), pattern.label(), reason.clone());
                    }
                }
            }
            progress.advance(share);
        }
        Ok(())
    }

    /// Adds patterns with the densities that are proposed for an integrand: three with each, and all
    /// patterns of the square with the two densities that are best with those. Several densities have
    /// the best shares.
    pub(super) fn add_proposed(
        &self,
        contest: &mut Contest<'_>,
        integrand: &Expression,
        progress: &Progress,
        white: &dyn Fn(usize) -> f64,
    ) -> Result<(), CliError> {
        let first: Vec<SquarePattern> = FIRST.iter().filter_map(|name| name.parse().ok()).collect();
        let mut pulled_back = Vec::new();
        for warp in WarpExpression::proposed(integrand, self.domain) {
            let pattern =
                WarpedPattern { pattern: first[0].clone(), warp, heuristic: Heuristic::default() };
            progress.stage(&pattern.label());
            match self.with_best_shares(contest, pattern.clone()) {
                Ok(pulled) => {
                    let start = contest.rows.len();
                    let patterns = first.iter().map(|p| pulled.pattern(p.clone())).collect();
                    pulled.add(self, contest, patterns, white)?;
                    let own = contest.rows[start..].iter().filter(|row| row.known_to.is_none());
                    let merit = own.map(|row| row.merit).min_by(f64::total_cmp);
                    pulled_back.extend(merit.map(|merit| (merit, pulled)));
                }
                Err(reason) => {
                    contest.leave_out(pattern.to_string(), pattern.label(), reason);
                }
            }
            progress.advance(1.0);
        }
        pulled_back.sort_by(|a, b| a.0.total_cmp(&b.0));
        let within_reach = pulled_back.iter().filter(|(merit, _)| merit.is_finite());
        for (_, pulled) in within_reach.take(BEST_DENSITIES) {
            let patterns = square_patterns().into_iter().map(|p| pulled.pattern(p)).collect();
            pulled.add(self, contest, patterns, white)?;
        }
        Ok(())
    }

    /// Returns the function pulled back by the densities of a pattern or, for several, by those with
    /// the best shares.
    fn with_best_shares(
        &self,
        contest: &Contest<'_>,
        pattern: WarpedPattern,
    ) -> Result<Pulled<'a>, String> {
        if pattern.n_strategies() == 1 {
            return self.pulled_back(&pattern).map_err(|e| e.to_string())?;
        }
        let n = contest.question.points().unwrap_or(TYPICAL_POINTS);
        let strategies = self.strategies(&pattern).map_err(|e| e.to_string())?;
        let mut variance = |pattern: &WarpedPattern| {
            let strategies = with_shares(&strategies, pattern);
            let functions = self.functions(&strategies, pattern.heuristic, SEARCH)?;
            let budget = PredictionBudget::DEFAULT.rough();
            let mut predictor = WarpedPredictor::new(&functions, self.seed, budget)?;
            let point = predictor.predict(pattern, pattern.nearest_count(n), &())?;
            Ok(point.prediction.variance)
        };
        let (best, _) = best_shares(&pattern, &mut variance).map_err(|e| e.to_string())?;
        let strategies = with_shares(&strategies, &best);
        let functions = self.functions(&strategies, best.heuristic, PulledBack::TOLERANCE);
        let functions = functions.map_err(|e| e.to_string())?;
        Ok(Pulled { warp: best.warp, heuristic: best.heuristic, strategies, functions })
    }

    /// Returns the function pulled back by the densities of a pattern, or the reason why it cannot be.
    fn pulled_back(&self, pattern: &WarpedPattern) -> Result<Result<Pulled<'a>, String>, CliError> {
        let strategies = self.strategies(pattern)?;
        let functions = self.functions(&strategies, pattern.heuristic, PulledBack::TOLERANCE);
        let pulled = |functions| Pulled {
            warp: pattern.warp.clone(),
            heuristic: pattern.heuristic,
            strategies,
            functions,
        };
        Ok(functions.map(pulled).map_err(|error| error.to_string()))
    }

    fn strategies(&self, pattern: &WarpedPattern) -> Result<Vec<Strategy>, CliError> {
        Ok(strategies_of(&[&pattern.warp], self.domain, self.quiet)?.remove(0))
    }

    fn functions(
        &self,
        strategies: &[Strategy],
        heuristic: Heuristic,
        tolerance: Tolerance,
    ) -> Result<Vec<PulledBack<'a>>, sphvar_integrands::Error> {
        PulledBack::of_strategies(self.function, self.domain, strategies, heuristic, tolerance)
    }
}

/// Returns strategies with the shares of a pattern.
fn with_shares(strategies: &[Strategy], pattern: &WarpedPattern) -> Vec<Strategy> {
    let shares = pattern.warp.shares();
    let with = |(strategy, share): (&Strategy, f64)| Strategy { share, ..strategy.clone() };
    strategies.iter().zip(shares).map(with).collect()
}

impl Pulled<'_> {
    fn pattern(&self, pattern: SquarePattern) -> WarpedPattern {
        WarpedPattern { pattern, warp: self.warp.clone(), heuristic: self.heuristic }
    }

    /// Adds patterns of the densities, inexpensive ones first.
    fn add(
        &self,
        integral: &WarpedIntegral<'_>,
        contest: &mut Contest<'_>,
        mut patterns: Vec<WarpedPattern>,
        white: &dyn Fn(usize) -> f64,
    ) -> Result<(), CliError> {
        let typical = contest.question.points().unwrap_or(TYPICAL_POINTS);
        let work = |p: &WarpedPattern| p.pattern.nominal_work(typical);
        patterns.sort_by(|a, b| work(a).total_cmp(&work(b)));
        let predictor =
            WarpedPredictor::new(&self.functions, integral.seed, PredictionBudget::DEFAULT)?
                .with_integral(integral.function.exact(integral.domain));
        let mut predictor = Importance { predictor, strategies: &self.strategies };
        for pattern in patterns {
            contest.add(pattern, &mut predictor, |_, n| white(n));
        }
        Ok(())
    }
}
