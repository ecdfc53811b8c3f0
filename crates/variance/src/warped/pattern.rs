use std::fmt;

use sphvar_integrands::{Heuristic, WarpExpression};
use sphvar_samplers::{FileResolver, SamplerFamily, Square, SquarePattern, SquareSampler};

use crate::estimates::trial_work_of;
use crate::{Error, Trials, WarpedText};

/// A pattern of the unit square that is mapped to directions of one or several known densities:
/// importance sampling, as in `sobol:warp=cosine` or
/// `jittered-square:warp="0.3 * cosine + 0.7 * env:sky.exr",heuristic=power`.
///
/// It is an estimator of integrals, not a pattern of directions: sets are shifted modulo 1 before
/// they are mapped and are not rotated, and points have the weights 1/(N p). A sum of warps is
/// several strategies, each with points of its own (multiple importance sampling); their numbers
/// are the [`counts`](Self::counts). The keys `warp` and `heuristic` are those of the estimator,
/// all others those of the pattern.
///
/// # Examples
///
/// ```
/// use sphvar_samplers::FileResolver;
/// use sphvar_variance::WarpedPattern;
///
/// let text = "jittered-square:warp=\"1 * cosine + 3 * vmf:kappa=50\"";
/// assert!(WarpedPattern::is_warped(text));
/// let pattern: WarpedPattern = text.parse()?;
/// assert_eq!(pattern.to_string(), text);
/// // Squares of integers next to 25 and 75.
/// assert_eq!(pattern.counts(100), [25, 81]);
/// assert_eq!(pattern.nearest_count(100), 106);
/// # Ok::<(), sphvar_variance::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct WarpedPattern {
    /// The pattern of the square.
    pub pattern: SquarePattern,
    /// The densities to which its points are mapped, with the shares of the points.
    pub warp: WarpExpression,
    /// The weights of several strategies.
    pub heuristic: Heuristic,
    /// Whether [`label`](Self::label) has the paths of maps instead of the names of the files, because
    /// another file has the same name. Not part of the text form.
    pub has_long_label: bool,
}

/// The maximum number of steps to the next total number of points whose parts are all valid.
const MAX_STEPS: usize = 1000;

impl WarpedPattern {
    /// Returns whether a text has the key `warp`.
    #[must_use]
    pub fn is_warped(text: &str) -> bool {
        WarpedText::is_warped(text)
    }

    /// Reads `name:key=value,warp=WARP`; `files` reads the files that the pattern names, not those
    /// of the warp.
    ///
    /// # Errors
    ///
    /// Returns [`Error::Spectrum`] with the error of [`SquarePattern::parse`], [`Error::Integrand`]
    /// with that of the warp or heuristic, for a text without `warp`, and for a heuristic of a
    /// single warp, and [`Error::Unquoted`] for parameters of the warp outside its quotes.
    pub fn parse(text: &str, files: &dyn FileResolver) -> Result<Self, Error> {
        Self::read(text, &|pattern| SquarePattern::parse(pattern, files))
    }

    fn read(
        text: &str,
        pattern: &dyn Fn(&str) -> Result<SquarePattern, sphvar_samplers::Error>,
    ) -> Result<Self, Error> {
        let parts: WarpedText = text.parse()?;
        let warp: WarpExpression = parts.warp.parse()?;
        if parts.heuristic.is_some() && warp.n_strategies() == 1 {
            return Err(Error::Heuristic { text: text.to_owned() });
        }
        let pattern = pattern(&parts.pattern).map_err(|error| {
            parts.quoted(text).map_or(Error::from(error), |quoted| Error::Unquoted { quoted })
        })?;
        let heuristic = parts.heuristic.unwrap_or_default();
        Ok(Self { pattern, warp, heuristic, has_long_label: false })
    }

    /// Returns the name in tables and plots, as [`SquarePattern::label`] does.
    #[must_use]
    pub fn label(&self) -> String {
        let warp = if self.has_long_label { self.warp.clone() } else { self.warp.shortened() };
        self.text(&self.pattern.label(), &warp)
    }

    fn text(&self, pattern: &str, warp: &WarpExpression) -> String {
        let is_stated = self.heuristic != Heuristic::default() && self.n_strategies() > 1;
        let text = WarpedText {
            pattern: pattern.to_owned(),
            warp: warp.to_string(),
            heuristic: is_stated.then_some(self.heuristic),
        };
        text.to_string()
    }

    /// Returns the number of strategies, each with points of its own.
    #[must_use]
    pub fn n_strategies(&self) -> usize {
        self.warp.n_strategies()
    }

    /// Returns the number of points of each strategy at [`nearest_count`](Self::nearest_count) of
    /// `n`: the valid counts nearest to the shares, at least one point each.
    #[must_use]
    pub fn counts(&self, n: usize) -> Vec<usize> {
        let shares = self.warp.shares();
        let mut counts = self.rounded(&shares, n);
        // Totals of rounded parts may be rounded to other parts. Since the parts never decrease
        // with the total, the steps from total to total are all up or all down, to the next total
        // that stays.
        for _ in 0..MAX_STEPS {
            let next = self.rounded(&shares, total(&counts));
            if next == counts {
                break;
            }
            counts = next;
        }
        counts
    }

    fn rounded(&self, shares: &[f64], n: usize) -> Vec<usize> {
        apportioned(shares, n).into_iter().map(|part| self.pattern.nearest_count(part)).collect()
    }

    /// Returns the valid number of points next to `requested`; never 0, and never decreasing.
    #[must_use]
    pub fn nearest_count(&self, requested: usize) -> usize {
        total(&self.counts(requested))
    }

    /// Returns the number of points of a pattern that has only one, because it is a single point
    /// file.
    #[must_use]
    pub fn own_count(&self) -> Option<usize> {
        self.pattern.own_count().map(|n| n.saturating_mul(self.n_strategies()))
    }

    /// Returns the sampler of each strategy, for `n` points together.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`SquarePattern::build`], and an error naming the next valid count if
    /// `n` is none.
    pub fn samplers(&self, n: usize) -> Result<Vec<Box<dyn SquareSampler>>, Error> {
        let counts = self.counts(n);
        if counts.len() == 1 {
            return Ok(vec![self.pattern.build(n)?]);
        }
        let nearest = total(&counts);
        if nearest != n {
            let pattern = self.to_string();
            return Err(Error::Total { pattern, requested: n, counts, nearest });
        }
        Ok(counts.into_iter().map(|n| self.pattern.build(n)).collect::<Result<_, _>>()?)
    }

    /// Returns the nominal work of one trial with `n` points, or with the next valid count.
    #[must_use]
    pub fn trial_work(&self, n: usize) -> f64 {
        let samplers = self.samplers(self.nearest_count(n));
        let of_all =
            |samplers: Vec<_>| samplers.iter().map(|s| trial_work_of::<Square>(s)).sum::<f64>();
        samplers.map_or(n as f64, of_all)
    }

    /// Returns the default number of trials with `n` points, as [`Trials::default_of`] does.
    #[must_use]
    pub fn default_trials(&self, n: usize) -> Trials {
        Trials::default_of_work(self.trial_work(n))
    }
}

fn total(counts: &[usize]) -> usize {
    counts.iter().fold(0, |sum: usize, n| sum.saturating_add(*n))
}

/// Returns whole numbers of at least 1 in proportion to shares, of sum `n` unless that is below their
/// number, by the method of Webster and Sainte-Lague. No part decreases as n grows.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a share of n is positive, and the cast saturates"
)]
fn apportioned(shares: &[f64], n: usize) -> Vec<usize> {
    if shares.len() == 1 {
        return vec![n];
    }
    let near = |share: &f64| ((share * n as f64).round() as usize).max(1);
    let mut parts: Vec<usize> = shares.iter().map(near).collect();
    // The share for each point, with half of the last or of the next one counted.
    let quotient = |parts: &[usize], i: usize, half: f64| shares[i] / (parts[i] as f64 + half);
    let by = |parts: &[usize], a: usize, b: usize, half: f64| {
        quotient(parts, a, half).total_cmp(&quotient(parts, b, half))
    };
    while total(&parts) < n {
        let next = (0..shares.len()).rev().max_by(|&a, &b| by(&parts, a, b, 0.5));
        let Some(next) = next else { break };
        parts[next] += 1;
    }
    while total(&parts) > n {
        let reducible = (0..shares.len()).rev().filter(|&i| parts[i] > 1);
        let Some(last) = reducible.min_by(|&a, &b| by(&parts, a, b, -0.5)) else { break };
        parts[last] -= 1;
    }
    parts
}

/// Reads texts whose pattern needs no file.
impl std::str::FromStr for WarpedPattern {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        Self::read(text, &|pattern| pattern.parse())
    }
}

/// Writes the form that [`WarpedPattern::parse`] reads.
impl fmt::Display for WarpedPattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&self.text(&self.pattern.to_string(), &self.warp))
    }
}

/// The sets on the square, of a pattern with a single warp.
impl SamplerFamily<Square> for WarpedPattern {
    /// # Errors
    ///
    /// Those of [`SquarePattern::build`], and [`Given`](sphvar_samplers::Error::Given) for several
    /// warps, each of which has a sampler of its own.
    fn build(
        &self,
        n_points: usize,
        _: Square,
    ) -> Result<Box<dyn SquareSampler>, sphvar_samplers::Error> {
        let strategies = self.n_strategies();
        if strategies > 1 {
            let reason = format!("{self} has {strategies} samplers, one for each warp");
            return Err(sphvar_samplers::Error::Given { reason });
        }
        self.pattern.build(n_points)
    }

    fn nearest_count(&self, requested: usize, _: Square) -> usize {
        Self::nearest_count(self, requested)
    }
}
