//! The samplers of the command line.

mod direction_sampler;
mod pattern_files;
mod predicted;
mod sampler_name;

use std::path::Path;

use sphvar_grammar::quote;
use sphvar_samplers::{
    Domain, Error, Pattern, RotationGroup, RotationPattern, SamplerFamily, Space, Square,
    SquarePattern,
};
use sphvar_variance::WarpedPattern;

use crate::error::CliError;
use crate::flags::missing_count;
use crate::memory::check_points;
use crate::session::Session;
use crate::spec::Spec;

pub(crate) use self::direction_sampler::{
    DirectionSampler, UNPREDICTED, build_warped, check_square_pattern, parse_sampler,
    parse_samplers,
};
pub(crate) use self::pattern_files::PatternFiles;
pub(crate) use self::predicted::{BandsOf, PredictedPattern, SamplerRef, n_effective};
pub(crate) use self::sampler_name::SamplerName;

/// The name of all patterns together, for subcommands that accept several.
pub(crate) const ALL: &str = "all";

/// The patterns of the sphere, or those of the unit square.
pub(crate) trait PatternKind: SamplerFamily<Self::Space> + Sized {
    type Space: Space;

    /// The message for a text with `warp=` where a pattern of this kind is required.
    const WARPS_REJECTED: &str;

    /// Returns every built-in pattern.
    fn all() -> Vec<Self>;

    /// Reads a text with the files that it names.
    fn parse(text: &str, files: &PatternFiles<'_>) -> Result<Self, Error>;

    /// Returns the name in tables.
    fn label(&self) -> String;

    /// Has the label show the whole path of a file.
    fn use_long_label(&mut self);

    /// Returns the number of points of a single file.
    fn own_count(&self) -> Option<usize>;

    /// Returns the number of points where none is requested.
    fn default_count(&self, _space: Self::Space) -> Option<usize> {
        self.own_count()
    }

    /// Returns what takes other numbers of points than this pattern.
    fn with_other_counts(&self) -> Option<&'static str> {
        None
    }

    /// Returns whether the points are the user's own.
    fn is_file(&self) -> bool;

    /// Returns the number of the random streams that all prefixes of a sequence share; `None` for
    /// files and for patterns that are not sequences.
    fn sequence_group(&self) -> Option<usize>;

    /// Returns whether the first points of a set are a set of the pattern; the points of a file are a
    /// sequence in its order.
    fn is_sequence(&self) -> bool {
        self.is_file() || self.sequence_group().is_some()
    }

    /// Returns whether a pattern has the name.
    fn is_name(name: &str) -> bool;

    /// Returns the error for the name of a pattern of the other kind.
    fn other_kind(name: &str) -> Option<String>;
}

impl PatternKind for Pattern {
    type Space = Domain;

    const WARPS_REJECTED: &str = "warp= samples directions of a density, which are not homogeneous and have no angular \
        spectrum; variance, compare, choose, progressive, sample, render and lights support it. --square is for the \
        pattern of the unit square itself, without warp=";

    fn all() -> Vec<Self> {
        Self::ALL.to_vec()
    }

    fn parse(text: &str, files: &PatternFiles<'_>) -> Result<Self, Error> {
        Self::parse(text, files)
    }

    fn label(&self) -> String {
        self.label()
    }

    fn use_long_label(&mut self) {
        if let Self::PointFile(file) = self {
            file.has_long_label = true;
        }
    }

    fn own_count(&self) -> Option<usize> {
        self.own_count()
    }

    fn default_count(&self, domain: Domain) -> Option<usize> {
        self.default_count(domain)
    }

    fn is_file(&self) -> bool {
        matches!(self, Self::PointFile(_))
    }

    fn sequence_group(&self) -> Option<usize> {
        self.sequence_group()
    }

    fn is_name(name: &str) -> bool {
        Self::known().any(|pattern| pattern.name() == name)
    }

    fn other_kind(name: &str) -> Option<String> {
        if RotationPattern::is_name(name) {
            return Some(format!("{name} is a pattern of rotations, for the command rotations"));
        }
        SquarePattern::is_name(name).then(|| {
            format!(
                "{name} is a pattern of the unit square, for the option --square of sample, spectrum, quality, \
                 variance, compare, choose and progressive"
            )
        })
    }
}

impl PatternKind for SquarePattern {
    type Space = Square;

    const WARPS_REJECTED: &str = "with --square, patterns are those of the unit square itself: omit warp=, or omit --square \
        for directions of its density";

    fn all() -> Vec<Self> {
        Self::ALL.to_vec()
    }

    fn parse(text: &str, files: &PatternFiles<'_>) -> Result<Self, Error> {
        Self::parse(text, files)
    }

    fn label(&self) -> String {
        self.label()
    }

    fn use_long_label(&mut self) {
        if let Self::PointFile(file) = self {
            file.has_long_label = true;
        }
    }

    fn own_count(&self) -> Option<usize> {
        self.own_count()
    }

    fn is_file(&self) -> bool {
        matches!(self, Self::PointFile(_))
    }

    fn sequence_group(&self) -> Option<usize> {
        self.sequence_group()
    }

    fn is_name(name: &str) -> bool {
        Self::known().any(|pattern| pattern.name() == name)
    }

    fn other_kind(name: &str) -> Option<String> {
        Pattern::is_name(name).then(|| {
            let known: Vec<&str> = Self::ALL.iter().map(Self::name).collect();
            let known = known.join(", ");
            format!("{name} is a pattern of the sphere; with --square the patterns are {known}")
        })
    }
}

impl PatternKind for RotationPattern {
    type Space = RotationGroup;

    const WARPS_REJECTED: &str = "warp= is for patterns of the unit square";

    fn all() -> Vec<Self> {
        Self::ALL.to_vec()
    }

    fn parse(text: &str, files: &PatternFiles<'_>) -> Result<Self, Error> {
        Self::parse(text, files)
    }

    fn label(&self) -> String {
        self.to_string()
    }

    fn use_long_label(&mut self) {}

    fn own_count(&self) -> Option<usize> {
        None
    }

    fn with_other_counts(&self) -> Option<&'static str> {
        matches!(self, Self::HealpixHopf(_)).then_some("order=layered takes any number")
    }

    fn is_file(&self) -> bool {
        false
    }

    fn sequence_group(&self) -> Option<usize> {
        self.sequence_group()
    }

    fn is_name(name: &str) -> bool {
        Self::known().any(|pattern| pattern.name() == name)
    }

    fn other_kind(name: &str) -> Option<String> {
        (Pattern::is_name(name) || SquarePattern::is_name(name)).then(|| {
            let known: Vec<&str> = Self::ALL.iter().map(Self::name).collect();
            format!("{name} is no pattern of rotations; those are {}", known.join(", "))
        })
    }
}

/// Returns the patterns of a list such as `jittered,white-noise`, or of `all`. Reports remarks on
/// files.
pub(crate) fn parse_patterns<P: PatternKind>(
    text: &str,
    session: &Session,
) -> Result<Vec<P>, CliError> {
    let mut patterns = Vec::new();
    for spec in Spec::parse_list(text)? {
        if spec.text == ALL {
            patterns.extend(P::all());
        } else {
            patterns.push(parse_pattern(&spec.text, session)?);
        }
    }
    with_distinct_labels(&mut patterns, SamplerName::of, P::use_long_label);
    Ok(patterns)
}

/// Returns the pattern of one name. Reports remarks on files.
pub(crate) fn parse_pattern<P: PatternKind>(text: &str, session: &Session) -> Result<P, CliError> {
    if WarpedPattern::is_warped(text) {
        return Err(CliError::Usage(format!("{text}: {}", P::WARPS_REJECTED)));
    }
    P::parse(text, &PatternFiles { session }).map_err(|error| error_of_pattern::<P>(text, error))
}

/// Returns the error of a text that names no pattern of this kind.
fn error_of_pattern<P: PatternKind>(text: &str, error: Error) -> CliError {
    match error {
        Error::File(source) => CliError::of_resolver(&source),
        Error::Given { .. } => CliError::File(error.to_string()),
        other if Path::new(text).is_file() => {
            CliError::Usage(format!("{other}; a file is a sampler as file:{}", quote(text)))
        }
        other => {
            let name = text.split(':').next().unwrap_or_default();
            let of_other_kind = P::other_kind(name).filter(|_| !P::is_name(name));
            of_other_kind.map_or_else(|| CliError::usage(other), CliError::Usage)
        }
    }
}

/// Gives files of the same name labels with their paths.
fn with_distinct_labels<T>(
    samplers: &mut [T],
    name: impl Fn(&T) -> SamplerName,
    use_long_label: impl Fn(&mut T),
) {
    let names: Vec<SamplerName> = samplers.iter().map(name).collect();
    for (sampler, name) in samplers.iter_mut().zip(&names) {
        if names.iter().any(|other| other.label == name.label && other.text != name.text) {
            use_long_label(sampler);
        }
    }
}

/// Returns the sampler of `n` points or, if `nearest`, of the nearest valid count; for a single
/// file, the sampler of its own number of points.
pub(crate) fn build<P: PatternKind<Space = S>, S: Space>(
    pattern: &P,
    n: usize,
    space: S,
    nearest: bool,
) -> Result<Box<S::Sampler>, CliError> {
    Ok(build_counted(pattern, n, space, nearest)?.1)
}

/// Returns the number of points and the sampler of [`build`].
fn build_counted<P: PatternKind<Space = S>, S: Space>(
    pattern: &P,
    n: usize,
    space: S,
    nearest: bool,
) -> Result<(usize, Box<S::Sampler>), CliError> {
    let nearest = nearest || pattern.own_count().is_some();
    let n = if nearest && n > 0 { pattern.nearest_count(n, space) } else { n };
    let sampler = pattern.build(n, space).map_err(|error| match error {
        Error::InvalidCount { .. } => {
            let other = pattern.with_other_counts().map(|other| format!("; {other}"));
            CliError::Usage(format!("{error} (use --nearest){}", other.unwrap_or_default()))
        }
        Error::Given { .. } => CliError::File(error.to_string()),
        _ => CliError::usage(error),
    })?;
    check_points(n)?;
    Ok((n, sampler))
}

/// Returns the pattern that a text names, and its sampler as [`nearest_sampler`] does.
pub(crate) fn sampler_of<P: PatternKind<Space = S>, S: Space>(
    text: &str,
    n: Option<usize>,
    space: S,
    nearest: bool,
    session: &Session,
) -> Result<(P, Box<S::Sampler>), CliError> {
    let pattern = parse_pattern(text, session)?;
    let sampler = nearest_sampler(&pattern, n, space, nearest, session)?;
    Ok((pattern, sampler))
}

/// Returns the sampler of `n` points or of the nearest valid count if `nearest`. A single file
/// and a design of given degree need no `n`. Reports a remark if the number of points differs from
/// `n`.
pub(crate) fn nearest_sampler<P: PatternKind<Space = S>, S: Space>(
    pattern: &P,
    n: Option<usize>,
    space: S,
    nearest: bool,
    session: &Session,
) -> Result<Box<S::Sampler>, CliError> {
    let n = n.or(pattern.default_count(space)).ok_or_else(missing_count)?;
    let (got, sampler) = build_counted(pattern, n, space, nearest)?;
    if got != n {
        let label = pattern.label();
        let why = match pattern.own_count() {
            Some(_) => "as in the file".to_owned(),
            None => format!("the valid count nearest to the requested {n}"),
        };
        session.say(&format!("{label}: {got} points, {why}"));
    }
    Ok(sampler)
}
