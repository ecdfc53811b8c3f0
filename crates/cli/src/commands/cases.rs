//! Samplers at numbers of points, which `variance` and `compare` run.

use sphvar_samplers::{Domain, Pattern};
use sphvar_variance::{AdaptedPattern, IntegrationSpace, Trials, WarpedPattern};

use super::rows::Effort;
use crate::error::CliError;
use crate::flags::missing_count;
use crate::memory::check_points;
use crate::patterns::{self, DirectionSampler, PredictedPattern, SamplerRef};

/// One pattern at one number of points.
pub(super) struct Case<P: PredictedPattern = Pattern> {
    pub(super) pattern: P,
    /// The requested number of points.
    pub(super) requested: usize,
    sampler: Box<P::Sampler>,
}

impl<P: PredictedPattern> Case<P> {
    /// Returns the pattern with `requested` points, or with the nearest valid count.
    pub(super) fn new(
        pattern: P,
        requested: usize,
        space: P::Space,
        nearest: bool,
    ) -> Result<Self, CliError> {
        let sampler = patterns::build(&pattern, requested, space, nearest)?;
        Ok(Self { pattern, requested, sampler })
    }

    /// Returns every pattern at every number of points, each case once. A single file has one case,
    /// at its own number; without numbers, a design of given degree has one too.
    pub(super) fn all(
        patterns: &[P],
        counts: &[usize],
        space: P::Space,
        nearest: bool,
    ) -> Result<Vec<Self>, CliError> {
        let mut cases: Vec<Self> = Vec::new();
        for pattern in patterns {
            let fixed = if counts.is_empty() {
                Some(pattern.default_count(space).ok_or_else(missing_count)?)
            } else {
                pattern.own_count()
            };
            let counts = fixed.as_ref().map_or(counts, std::slice::from_ref);
            for &n in counts {
                let case = Self::new(pattern.clone(), n, space, nearest)?;
                let same = |c: &Self| c.pattern == *pattern && c.n_points() == case.n_points();
                if !cases.iter().any(same) {
                    cases.push(case);
                }
            }
        }
        Ok(cases)
    }

    pub(super) fn sampler(&self) -> SamplerRef<'_, P> {
        P::Space::sampler(&self.sampler)
    }

    pub(super) fn n_points(&self) -> usize {
        P::Space::n_points(self.sampler())
    }

    /// Returns the pattern with its parameters and its number of points, which no other case has.
    pub(super) fn name(&self) -> String {
        format!("{} N = {}", self.pattern, self.n_points())
    }
}

/// One warped pattern at one number of points.
pub(super) struct WarpedCase {
    pub(super) pattern: WarpedPattern,
    /// The requested number of points.
    pub(super) requested: usize,
    /// The number of points of all strategies.
    pub(super) n_points: usize,
}

impl WarpedCase {
    /// Returns the pattern with `requested` points, or with the nearest valid count.
    fn new(pattern: &WarpedPattern, requested: usize, nearest: bool) -> Result<Self, CliError> {
        let (n_points, _) = patterns::build_warped(pattern, requested, nearest)?;
        Ok(Self { pattern: pattern.clone(), requested, n_points })
    }

    /// Returns the trials: the user's number or the default.
    pub(super) fn trials(&self, effort: &Effort<'_>) -> Trials {
        effort.trials_or(|| self.pattern.default_trials(self.n_points))
    }

    /// Returns the pattern with its parameters and its number of points, which no other case has.
    pub(super) fn name(&self) -> String {
        format!("{} N = {}", self.pattern, self.n_points)
    }
}

/// Tessellations for a density at one number of points.
pub(super) struct AdaptedCase {
    pub(super) pattern: AdaptedPattern,
    pub(super) n_points: usize,
}

impl AdaptedCase {
    /// Returns the tessellations at every number of points, each once.
    fn all(pattern: &AdaptedPattern, counts: &[usize]) -> Result<Vec<Self>, CliError> {
        if counts.is_empty() {
            return Err(missing_count());
        }
        let distinct = counts.iter().enumerate().filter(|(i, n)| !counts[..*i].contains(n));
        distinct
            .map(|(_, &n_points)| {
                check_points(n_points.saturating_mul(pattern.capacity))?;
                Ok(Self { pattern: pattern.clone(), n_points })
            })
            .collect()
    }

    /// Returns the trials: the user's number or the default.
    pub(super) fn trials(&self, effort: &Effort<'_>) -> Trials {
        effort.trials_or(|| self.pattern.default_trials(self.n_points))
    }

    /// Returns the pattern with its parameters and its number of points, which no other case has.
    pub(super) fn name(&self) -> String {
        format!("{} N = {}", self.pattern, self.n_points)
    }
}

/// One sampler of directions at one number of points.
pub(super) enum DirectionCase {
    Uniform(Case),
    Warped(WarpedCase),
    Adapted(AdaptedCase),
}

impl DirectionCase {
    /// Returns every sampler at every number of points, each case once.
    pub(super) fn all(
        samplers: &[DirectionSampler],
        counts: &[usize],
        domain: Domain,
        nearest: bool,
    ) -> Result<Vec<Self>, CliError> {
        let mut cases: Vec<Self> = Vec::new();
        for (i, sampler) in samplers.iter().enumerate() {
            if samplers[..i].contains(sampler) {
                continue;
            }
            match sampler {
                DirectionSampler::Uniform(pattern) => {
                    let patterns = std::slice::from_ref(pattern);
                    let all = Case::all(patterns, counts, domain, nearest)?;
                    cases.extend(all.into_iter().map(Self::Uniform));
                }
                DirectionSampler::Warped(pattern) => {
                    cases.extend(warped(pattern, counts, nearest)?.into_iter().map(Self::Warped));
                }
                DirectionSampler::Adapted(pattern) => {
                    let all = AdaptedCase::all(pattern, counts)?;
                    cases.extend(all.into_iter().map(Self::Adapted));
                }
            }
        }
        Ok(cases)
    }

    pub(super) fn n_points(&self) -> usize {
        match self {
            Self::Uniform(case) => case.n_points(),
            Self::Warped(case) => case.n_points,
            Self::Adapted(case) => case.n_points,
        }
    }

    /// Returns the pattern of the sphere, if it is one.
    pub(super) fn uniform(&self) -> Option<&Case> {
        match self {
            Self::Uniform(case) => Some(case),
            Self::Warped(_) | Self::Adapted(_) => None,
        }
    }

    /// Returns the warped pattern, if it is one.
    pub(super) fn warped(&self) -> Option<&WarpedCase> {
        match self {
            Self::Uniform(_) | Self::Adapted(_) => None,
            Self::Warped(case) => Some(case),
        }
    }

    /// Returns the text of a sampler that is no pattern of the sphere.
    fn density(&self) -> Option<String> {
        match self {
            Self::Uniform(_) => None,
            Self::Warped(case) => Some(case.pattern.to_string()),
            Self::Adapted(case) => Some(case.pattern.to_string()),
        }
    }

    /// Returns the patterns of the sphere; an error names the option that does not apply to samplers
    /// of a density, and why.
    pub(super) fn all_uniform<'c>(
        cases: &'c [Self],
        option: &str,
        why: &str,
    ) -> Result<Vec<&'c Case>, CliError> {
        match cases.iter().find_map(Self::density) {
            None => Ok(cases.iter().filter_map(Self::uniform).collect()),
            Some(name) => Err(CliError::Usage(format!("{option} does not apply to {name}: {why}"))),
        }
    }

    /// Returns the name of the sampler and its number of points, for progress.
    pub(super) fn stage(&self) -> String {
        let label = match self {
            Self::Uniform(case) => case.pattern.label(),
            Self::Warped(case) => case.pattern.label(),
            Self::Adapted(case) => case.pattern.to_string(),
        };
        format!("{label} N = {}", self.n_points())
    }
}

/// Returns a warped pattern at every number of points, each once.
fn warped(
    pattern: &WarpedPattern,
    counts: &[usize],
    nearest: bool,
) -> Result<Vec<WarpedCase>, CliError> {
    let own = pattern.own_count();
    if own.is_none() && counts.is_empty() {
        return Err(missing_count());
    }
    let mut cases: Vec<WarpedCase> = Vec::new();
    for &n in own.as_ref().map_or(counts, std::slice::from_ref) {
        let case = WarpedCase::new(pattern, n, nearest)?;
        if !cases.iter().any(|other| other.n_points == case.n_points) {
            cases.push(case);
        }
    }
    Ok(cases)
}
