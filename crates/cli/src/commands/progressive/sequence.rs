//! Sequences: patterns whose prefixes are sets of the pattern.

use sphvar_samplers::{Domain, Pattern, Square, SquarePattern};
use sphvar_variance::{IntegrationSpace, WarpedPattern};

use super::prefixes::Prefixes;
use crate::error::CliError;
use crate::flags::missing_count;
use crate::patterns::{
    self, ALL, DirectionSampler, PatternKind, PredictedPattern, SamplerName, SamplerRef,
};
use crate::spec::Spec;

/// One sequence with the prefixes whose errors are computed.
pub(super) struct Sequence<P: PredictedPattern> {
    pattern: P,
    pub(super) prefixes: Prefixes,
    sampler: Box<P::Sampler>,
}

impl<P: PredictedPattern> Sequence<P> {
    /// Returns a pattern that is a sequence with the prefixes that are requested; `counts` may be
    /// empty for patterns from files.
    fn new(pattern: &P, counts: &[usize], space: P::Space) -> Result<Self, CliError> {
        let own = pattern.own_count();
        let counts = if counts.is_empty() { own.as_slice() } else { counts };
        let max = counts.iter().max().ok_or_else(missing_count)?;
        let prefixes = Prefixes::new(counts, own).ok_or_else(|| {
            let own = own.unwrap_or(0);
            CliError::Usage(format!("{pattern} has {own} points, fewer than every N of -n"))
        })?;
        let sampler = patterns::build(pattern, *max, space, false)?;
        Ok(Self { pattern: pattern.clone(), prefixes, sampler })
    }

    pub(super) fn sampler(&self) -> SamplerRef<'_, P> {
        P::Space::sampler(&self.sampler)
    }

    /// Returns the number of the random streams of all prefixes.
    pub(super) fn group(&self) -> usize {
        let of_file = || P::Space::stream_group(self.sampler());
        self.pattern.sequence_group().unwrap_or_else(of_file)
    }
}

/// A sequence of a space, or one of the square that is mapped to directions.
pub(super) enum SpaceSequence<P: PredictedPattern> {
    Own(Sequence<P>),
    Warped(Box<WarpedPattern>, Sequence<SquarePattern>),
}

impl<P: PredictedPattern> SpaceSequence<P> {
    /// Returns every distinct pattern, all of which must be sequences.
    pub(super) fn of_patterns(
        patterns: &[P],
        counts: &[usize],
        space: P::Space,
    ) -> Result<Vec<Self>, CliError> {
        let sequences = distinct(patterns).map(|pattern| Self::own(pattern, counts, space));
        sequences.collect()
    }

    fn own(pattern: &P, counts: &[usize], space: P::Space) -> Result<Self, CliError> {
        if !pattern.is_sequence() {
            let advice = format!("; --reference {pattern} compares sequences with it");
            return Err(not_a_sequence::<P>(&pattern.to_string(), space, &advice));
        }
        Sequence::new(pattern, counts, space).map(Self::Own)
    }

    pub(super) fn prefixes(&self) -> &Prefixes {
        match self {
            Self::Own(sequence) => &sequence.prefixes,
            Self::Warped(_, sequence) => &sequence.prefixes,
        }
    }

    /// Returns the name in results.
    pub(super) fn name(&self) -> SamplerName {
        match self {
            Self::Own(sequence) => SamplerName::of(&sequence.pattern),
            Self::Warped(pattern, _) => DirectionSampler::Warped((**pattern).clone()).name(),
        }
    }

    /// Returns the warped pattern, if it is one.
    pub(super) fn warped(&self) -> Option<&WarpedPattern> {
        match self {
            Self::Own(_) => None,
            Self::Warped(pattern, _) => Some(pattern),
        }
    }
}

impl SpaceSequence<Pattern> {
    /// Returns every distinct sampler of directions, all of which must be sequences.
    pub(super) fn of_directions(
        samplers: &[DirectionSampler],
        counts: &[usize],
        domain: Domain,
    ) -> Result<Vec<Self>, CliError> {
        let sequence = |sampler: &DirectionSampler| match sampler {
            DirectionSampler::Uniform(pattern) => Self::own(pattern, counts, domain),
            DirectionSampler::Warped(warped) => Self::of_warped(warped, counts),
            DirectionSampler::Adapted(adapted) => {
                Err(not_a_sequence::<Pattern>(&adapted.to_string(), domain, ""))
            }
        };
        distinct(samplers).map(sequence).collect()
    }

    fn of_warped(warped: &WarpedPattern, counts: &[usize]) -> Result<Self, CliError> {
        if !warped.pattern.is_sequence() {
            return Err(not_a_sequence::<SquarePattern>(&warped.to_string(), Square, ""));
        }
        if warped.n_strategies() > 1 {
            return Err(CliError::Usage(format!(
                "{warped} is not a sequence: the numbers of points of its {} densities are shares of N; name one \
                 density",
                warped.n_strategies()
            )));
        }
        let sequence = Sequence::new(&warped.pattern, counts, Square)?;
        Ok(Self::Warped(Box::new(warped.clone()), sequence))
    }
}

/// Returns the items without repetitions.
fn distinct<T: PartialEq>(items: &[T]) -> impl Iterator<Item = &T> {
    items.iter().enumerate().filter(|(i, item)| !items[..*i].contains(item)).map(|(_, item)| item)
}

/// Returns a list of samplers in which `all` is replaced by the built-in sequences.
pub(super) fn with_all<P: PredictedPattern>(text: &str) -> Result<String, CliError> {
    let mut names = Vec::new();
    for spec in Spec::parse_list(text)? {
        match spec.text.as_str() {
            ALL => names.extend(sequences::<P>()),
            _ => names.push(spec.text),
        }
    }
    Ok(names.join(","))
}

/// Returns the names of the built-in sequences.
fn sequences<P: PredictedPattern>() -> Vec<String> {
    let all = P::all().into_iter().filter(P::is_sequence);
    all.map(|sequence| sequence.to_string()).collect()
}

/// Returns the error for a pattern whose points depend on their number, with the patterns of its
/// space that are sequences.
fn not_a_sequence<P: PredictedPattern>(text: &str, space: P::Space, advice: &str) -> CliError {
    CliError::Usage(format!(
        "{text} is not a sequence: its points depend on N, so the first points of a set are not a set of the \
         pattern. Sequences on the {space}: {}, file:PATH{advice}",
        sequences::<P>().join(", ")
    ))
}
