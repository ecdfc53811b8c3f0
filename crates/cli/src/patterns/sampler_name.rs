//! The names of samplers in results.

use super::PatternKind;

/// How results name a sampler.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct SamplerName {
    /// The sampler with its parameters, as every command accepts it.
    pub(crate) text: String,
    /// The name in tables and charts.
    pub(crate) label: String,
    /// Whether the points are the user's own.
    pub(crate) is_file: bool,
}

impl SamplerName {
    pub(crate) fn of<P: PatternKind>(pattern: &P) -> Self {
        Self { text: pattern.to_string(), label: pattern.label(), is_file: pattern.is_file() }
    }
}
