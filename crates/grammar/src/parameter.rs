use std::fmt;
use std::path::PathBuf;

use crate::Range;
use crate::quoted::{path_text, quote};

/// A user-visible parameter of a sampler or integrand.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Parameter {
    /// Its key.
    pub name: &'static str,
    /// Its valid values.
    pub kind: ParameterKind,
    /// Its default value.
    pub default: DefaultValue,
    /// Its meaning, without a full stop.
    pub summary: &'static str,
}

/// The valid values of a parameter; the `Display` text continues "must be".
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ParameterKind {
    /// Whole numbers.
    Integer {
        /// The minimum.
        min: i64,
        /// The maximum.
        max: i64,
    },
    /// Numbers.
    Number(Range),
    /// One of these names.
    Choice(Vec<&'static str>),
    /// Any text, such as the name of a channel.
    Word,
    /// A text of another grammar, such as "an integrand".
    Text(&'static str),
    /// A file name, which may also be the first bare value.
    File,
    /// The name of something that the program has, which may also be the first bare value.
    Name,
}

/// The default value of a parameter.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum DefaultValue {
    /// This value.
    Value(Value),
    /// No value; a description of the effect.
    Depends(&'static str),
    /// The parameter is required.
    Required,
}

/// The value of a parameter; the grammar parses its `Display` text.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Value {
    /// A whole number.
    Integer(i64),
    /// A number.
    Number(f64),
    /// One of some names.
    Choice(&'static str),
    /// Any text.
    Word(String),
    /// The name of a file.
    File(PathBuf),
}

/// Values that have names.
pub trait Choice: Copy + PartialEq + 'static {
    /// All names with their values, in display order.
    const CHOICES: &'static [(&'static str, Self)];
}

impl Choice for bool {
    const CHOICES: &'static [(&'static str, Self)] = &[("no", false), ("yes", true)];
}

impl Parameter {
    /// Returns the key, followed by the valid names in parentheses if it is a choice.
    #[must_use]
    pub fn with_values(&self) -> String {
        match &self.kind {
            ParameterKind::Choice(names) => format!("{} ({})", self.name, names.join(", ")),
            _ => self.name.to_owned(),
        }
    }
}

impl ParameterKind {
    /// Returns whether the value may stand first without its key.
    pub(crate) fn is_bare(&self) -> bool {
        matches!(self, Self::File | Self::Name)
    }
}

impl fmt::Display for ParameterKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Integer { min: i64::MIN, max: i64::MAX } => f.write_str("a whole number"),
            Self::Integer { min, max: i64::MAX } => write!(f, "a whole number from {min}"),
            Self::Integer { min, max } => write!(f, "a whole number from {min} to {max}"),
            Self::Number(range) => range.fmt(f),
            Self::Choice(names) => write!(f, "one of {}", names.join(", ")),
            Self::Word => f.write_str("a name"),
            Self::Text(what) => f.write_str(what),
            Self::File => f.write_str("the name of a file"),
            Self::Name => f.write_str("a name"),
        }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Integer(value) => value.fmt(f),
            Self::Number(value) => value.fmt(f),
            Self::Choice(name) => f.write_str(name),
            Self::Word(word) => f.write_str(&quote(word)),
            Self::File(path) => f.write_str(&path_text(path)),
        }
    }
}
