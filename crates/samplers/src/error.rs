use crate::{Domain, Stopped, ValidCounts};

/// Why a sampler cannot be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A pattern of no points integrates nothing.
    #[error("{pattern} needs at least 1 point, got 0")]
    NoPoints {
        /// The requested pattern.
        pattern: String,
    },
    /// The pattern does not exist with this number of points.
    #[error(
        "{pattern} has no pattern of {asked} points on the {domain}: N must be {rule}; the nearest valid count is {nearest}"
    )]
    InvalidCount {
        /// The requested pattern.
        pattern: String,
        /// Where it was to live.
        domain: Domain,
        /// The requested number of points.
        asked: usize,
        /// The valid number of points nearest to `asked`.
        nearest: usize,
        /// The numbers that exist.
        rule: ValidCounts,
    },
    /// More points than the pattern's indices can count.
    #[error("{pattern} cannot have {asked} points; the maximum is {max}")]
    TooManyPoints {
        /// The pattern's name.
        pattern: &'static str,
        /// The requested number of points.
        asked: usize,
        /// The largest valid number.
        max: usize,
    },
    /// There is no such pattern, or no realization could be completed.
    #[error("{pattern} of {n_points} points is infeasible: {reason}")]
    Infeasible {
        /// The pattern's name.
        pattern: &'static str,
        /// The requested number of points.
        n_points: usize,
        /// What stands in the way, and what would be possible.
        reason: String,
    },
    /// A spectrum of this many degrees cannot be computed.
    #[error("a target to degree {last} cannot be computed: {reason}")]
    Degree {
        /// The last degree of the target.
        last: usize,
        /// Why.
        reason: String,
    },
    /// Invalid points or weights, given by the caller or made by a sampler of the caller's own.
    #[error("invalid point sets: {reason}")]
    Given {
        /// What is wrong.
        reason: String,
    },
    /// A text that names no pattern, or gives a parameter that does not exist or is out of range.
    #[error(transparent)]
    Grammar(#[from] sphvar_grammar::Error),
    /// A file that the text of a pattern names cannot be read.
    #[error(transparent)]
    File(#[from] sphvar_grammar::ResolveError),
    /// The work was ended from outside.
    #[error(transparent)]
    Stopped(#[from] Stopped),
    /// A parameter outside its range.
    #[error("{name} must be {range}, got {got}")]
    Parameter {
        /// What the parameter is.
        name: &'static str,
        /// The valid values, in words.
        range: &'static str,
        /// The value given.
        got: f64,
    },
}
