//! The densities to which patterns of the square are mapped, for one function of direction.

use sphvar_integrands::{
    Domain, Expression, Heuristic, Integrand, PulledBack, Strategy, Tolerance, WarpExpression,
};
use sphvar_samplers::SquarePattern;
use sphvar_variance::{PredictionBudget, WarpedPattern, WarpedPredictor, best_shares};

use super::candidate::EXPENSIVE;
use super::choosable::{Choosable, Density, square_patterns};
use super::contest::Contest;
use super::importance::Importance;
use super::row::Row;
use crate::error::CliError;
use crate::integrands::strategies_of;
use crate::progress::Progress;
use crate::session::Session;

/// The patterns of the square that are ranked with every density, inexpensive ones of different kinds.
const FIRST: [&str; 3] = ["sobol", "r2", "jittered-square"];
/// The number of densities, those of the best rows, that are ranked with all inexpensive
/// patterns of the square.
const BEST_DENSITIES: usize = 2;
/// The number of points for which shares are found if the user gives none.
const TYPICAL_POINTS: usize = 1024;
/// The values from which the variance is predicted while shares are searched, for each of 19 pairs
/// of shares.
const SEARCH: Tolerance =
    Tolerance { relative: 1e-2, min_evaluations: 1 << 14, max_evaluations: 1 << 16 };

/// A function of direction with the settings of its ranking.
#[derive(Clone, Copy)]
pub(super) struct WarpedIntegral<'a> {
    pub(super) function: &'a dyn Integrand,
    /// The integrand, if its parts are known.
    pub(super) integrand: Option<&'a Expression>,
    pub(super) domain: Domain,
    pub(super) seed: u64,
    pub(super) session: &'a Session,
}

/// A function pulled back by one or several densities.
struct Pulled<'a> {
    warp: WarpExpression,
    heuristic: Heuristic,
    has_long_label: bool,
    strategies: Vec<Strategy>,
    functions: Vec<PulledBack<'a>>,
}

impl<'a> WarpedIntegral<'a> {
    /// Adds the patterns that the user names, those of several densities also with the best shares;
    /// `white` is the variance of independent uniform
    /// directions.
    pub(super) fn add_named(
        &self,
        contest: &mut Contest<'_>,
        named: Vec<WarpedPattern>,
        progress: &Progress,
        white: &dyn Fn(usize) -> f64,
    ) -> Result<(), CliError> {
        let mut groups: Vec<Vec<WarpedPattern>> = Vec::new();
        for pattern in named {
            let same = |group: &&mut Vec<WarpedPattern>| {
                let WarpedPattern { warp, heuristic, .. } = &group[0];
                (warp, *heuristic) == (&pattern.warp, pattern.heuristic)
            };
            match groups.iter_mut().find(same) {
                Some(group) => group.push(pattern),
                None => groups.push(vec![pattern]),
            }
        }
        let warps: Vec<&WarpExpression> = groups.iter().map(|group| &group[0].warp).collect();
        let strategies = strategies_of(&warps, self.domain, self.session)?;
        for (patterns, strategies) in groups.into_iter().zip(strategies) {
            let share = patterns.len() as f64;
            let first = patterns[0].clone();
            match self.pulled_back(&first, strategies.clone()) {
                Ok(pulled) => {
                    let own: Vec<_> = patterns.iter().map(|p| p.pattern.clone()).collect();
                    pulled.add(self, contest, patterns, white)?;
                    if first.n_strategies() > 1
                        && let Ok(best) = self.with_best_shares(contest, &first, strategies)
                    {
                        let patterns = own.into_iter().map(|p| best.pattern(p)).collect();
                        best.add(self, contest, patterns, white)?;
                    }
                }
                Err(reason) => {
                    for pattern in patterns {
                        contest.leave_out(pattern.to_string(), pattern.label(), reason.clone());
                    }
                }
            }
            progress.advance(share)?;
        }
        Ok(())
    }

    /// Adds patterns with the densities that are proposed for an integrand: three with each, and all
    /// inexpensive patterns of the square with the two densities that are best with those. Several densities have
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
        let warps = WarpExpression::proposed(integrand, self.domain);
        let is_same =
            |a: &WarpExpression, b: &WarpExpression| a != b && a.shortened() == b.shortened();
        let has_long_label = warps.iter().any(|a| warps.iter().any(|b| is_same(a, b)));
        let all = self.strategies(&warps);
        for (warp, strategies) in warps.into_iter().zip(all) {
            let (pattern, heuristic) = (first[0].clone(), Heuristic::default());
            let pattern = WarpedPattern { pattern, warp, heuristic, has_long_label };
            progress.stage(&pattern.label());
            let is_reached = |row: &Row| row.density == Density::Uniform && row.variance.is_some();
            if pattern.density() == Density::Uniform && !contest.rows.iter().any(is_reached) {
                let reason = "no pattern of uniform directions is within reach".to_owned();
                contest.leave_out(pattern.to_string(), pattern.label(), reason);
                continue;
            }
            let pulled = strategies.and_then(|s| self.with_best_shares(contest, &pattern, s));
            match pulled {
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
            progress.advance(1.0)?;
        }
        pulled_back.sort_by(|a, b| a.0.total_cmp(&b.0));
        let within_reach = pulled_back.iter().filter(|(merit, _)| merit.is_finite());
        let typical = contest.question.points().unwrap_or(TYPICAL_POINTS);
        let is_inexpensive =
            |p: &SquarePattern| p.nominal_work(typical) < EXPENSIVE * typical as f64;
        for (_, pulled) in within_reach.take(BEST_DENSITIES) {
            let patterns = square_patterns().into_iter().filter(is_inexpensive);
            let patterns = patterns.map(|p| pulled.pattern(p)).collect();
            pulled.add(self, contest, patterns, white)?;
        }
        Ok(())
    }

    /// Returns the function pulled back by the densities of a pattern or, for several, by those with
    /// the best shares.
    fn with_best_shares(
        &self,
        contest: &Contest<'_>,
        pattern: &WarpedPattern,
        strategies: Vec<Strategy>,
    ) -> Result<Pulled<'a>, String> {
        if pattern.n_strategies() == 1 {
            return self.pulled_back(pattern, strategies);
        }
        let n = contest.question.points().unwrap_or(TYPICAL_POINTS);
        let mut variance = |pattern: &WarpedPattern| {
            let strategies = with_shares(&strategies, pattern);
            let functions = self.functions(&strategies, pattern.heuristic, SEARCH)?;
            let budget = PredictionBudget::DEFAULT.rough();
            let mut predictor =
                WarpedPredictor::new(&functions, self.seed, budget)?.without_spectra();
            let point = predictor.predict(pattern, pattern.nearest_count(n), &())?;
            Ok(point.prediction.variance)
        };
        let (best, _) = best_shares(pattern, &mut variance).map_err(|e| e.to_string())?;
        self.pulled_back(&best, with_shares(&strategies, &best))
    }

    /// Returns the function pulled back by the densities of a pattern, or the reason why it cannot be.
    fn pulled_back(
        &self,
        pattern: &WarpedPattern,
        strategies: Vec<Strategy>,
    ) -> Result<Pulled<'a>, String> {
        let functions = self.functions(&strategies, pattern.heuristic, PulledBack::TOLERANCE);
        let functions = functions.map_err(|error| error.to_string())?;
        let WarpedPattern { warp, heuristic, has_long_label, .. } = pattern.clone();
        Ok(Pulled { warp, heuristic, has_long_label, strategies, functions })
    }

    /// Returns the densities of warps, or the reason why one is not available.
    fn strategies(&self, warps: &[WarpExpression]) -> Vec<Result<Vec<Strategy>, String>> {
        let all: Vec<&WarpExpression> = warps.iter().collect();
        if let Ok(all) = strategies_of(&all, self.domain, self.session) {
            return all.into_iter().map(Ok).collect();
        }
        let of_one = |warp| {
            let one = strategies_of(&[warp], self.domain, &self.session.muted());
            one.map(|mut one| one.remove(0)).map_err(|error| error.to_string())
        };
        warps.iter().map(of_one).collect()
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
        WarpedPattern {
            pattern,
            warp: self.warp.clone(),
            heuristic: self.heuristic,
            has_long_label: self.has_long_label,
        }
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
                .without_spectra()
                .with_integral(integral.function.exact(integral.domain));
        let is_of_integrand = integral.integrand.is_some_and(|f| self.warp.is_density_of(f));
        let mut predictor = Importance { predictor, strategies: &self.strategies, is_of_integrand };
        for pattern in patterns {
            contest.add(pattern, &mut predictor, |_, n| white(n));
        }
        Ok(())
    }
}
