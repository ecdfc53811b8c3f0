use crate::{Domain, Pattern, Stopped};

/// Why a sampler cannot be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A pattern of no points integrates nothing.
    #[error("{pattern} needs at least 1 point, got 0")]
    NoPoints {
        /// The pattern asked for.
        pattern: Pattern,
    },
    /// The pattern does not exist with this number of points.
    #[error(
        "{pattern} has no pattern of {asked} points on the {domain}: N must be {rule}; the nearest is {nearest}"
    )]
    IllegalCount {
        /// The pattern asked for.
        pattern: Pattern,
        /// Where it was to live.
        domain: Domain,
        /// The number of points asked for.
        asked: usize,
        /// The legal number of points nearest to `asked`.
        nearest: usize,
        /// The rule that legal numbers obey.
        rule: &'static str,
    },
    /// More points than the pattern's indices can count.
    #[error("{pattern} cannot have {asked} points: the most is {most}")]
    TooManyPoints {
        /// The pattern's name.
        pattern: &'static str,
        /// The number of points asked for.
        asked: usize,
        /// The largest legal number.
        most: usize,
    },
    /// No pattern is as asked for, or no realization could be completed.
    #[error("{pattern} of {n_points} points is infeasible: {reason}")]
    Infeasible {
        /// The pattern's name.
        pattern: &'static str,
        /// The number of points asked for.
        n_points: usize,
        /// What stands in the way, and what would be possible.
        reason: String,
    },
    /// A spectrum of so many degrees cannot be computed.
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
    /// The work was ended from outside.
    #[error(transparent)]
    Stopped(#[from] Stopped),
    /// A parameter outside its range.
    #[error("{name} must be {range}, got {got}")]
    Parameter {
        /// What the parameter is.
        name: &'static str,
        /// The legal values, in words.
        range: &'static str,
        /// The value given.
        got: f64,
    },
}
