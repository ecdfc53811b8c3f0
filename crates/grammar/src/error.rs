use crate::ParameterKind;

/// Errors of a text in the grammar: what is wrong, where, and what would be right.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// There is no name in front of the colon.
    #[error("\"{text}\" has no name in front of the colon")]
    NoName {
        /// The whole text.
        text: String,
    },
    /// An item after the first is a bare value.
    #[error("{text}: \"{item}\" is not key=value")]
    NotKeyValue {
        /// The whole text.
        text: String,
        /// The item.
        item: String,
    },
    /// A parameter occurs twice.
    #[error("{text}: {key} is given twice")]
    Repeated {
        /// The whole text.
        text: String,
        /// The key of the parameter.
        key: String,
    },
    /// A quoted value is malformed.
    #[error("{text}: at character {character}: {reason}")]
    Quoting {
        /// The whole text.
        text: String,
        /// The place in the text, counted from 1.
        character: usize,
        /// What is wrong and what would be right.
        reason: String,
    },
    /// A value is not a number.
    #[error("{text}: {key} must be a number, got \"{got}\"")]
    NotANumber {
        /// The whole text.
        text: String,
        /// The key of the parameter.
        key: String,
        /// The value.
        got: String,
    },
    /// A value is outside the range of its parameter.
    #[error("{text}: {key} must be {kind}, got {got}")]
    OutOfRange {
        /// The whole text.
        text: String,
        /// The key of the parameter.
        key: &'static str,
        /// The valid values.
        kind: ParameterKind,
        /// The value.
        got: String,
    },
    /// A parameter without a default is absent.
    #[error("{text}: the parameter {key} is missing")]
    Missing {
        /// The whole text.
        text: String,
        /// The key of the parameter.
        key: String,
    },
    /// A file is not named.
    #[error("{text}: the file is missing: {name}:FILE")]
    NoFile {
        /// The whole text.
        text: String,
        /// The name in front of the colon.
        name: String,
    },
    /// A bare value where none has a meaning.
    #[error("{text}: unexpected value \"{value}\"; valid parameters: {}", list(valid))]
    UnexpectedValue {
        /// The whole text.
        text: String,
        /// The value.
        value: String,
        /// The valid parameters.
        valid: Vec<String>,
    },
    /// A parameter that does not exist.
    #[error("{text}: unknown parameter \"{key}\"{}; valid: {}", hint(key, valid), list(valid))]
    UnknownParameter {
        /// The whole text.
        text: String,
        /// The key.
        key: String,
        /// The valid parameters, each perhaps with its values after a blank.
        valid: Vec<String>,
    },
    /// A name that does not exist.
    #[error("unknown {what} \"{name}\"{}; valid: {}", hint(name, valid), list(valid))]
    UnknownName {
        /// What is named, such as `sampler`.
        what: String,
        /// The name.
        name: String,
        /// The valid names.
        valid: Vec<String>,
    },
}

impl Error {
    /// Returns the error of an unknown `name` of a `what`, such as `sampler`, where `valid` exist.
    pub fn unknown_name(what: impl Into<String>, name: &str, valid: &[&str]) -> Self {
        let valid = valid.iter().map(|&name| name.to_owned()).collect();
        Self::UnknownName { what: what.into(), name: name.to_owned(), valid }
    }
}

fn list(valid: &[String]) -> String {
    if valid.is_empty() { "none".to_owned() } else { valid.join(", ") }
}

/// Returns ` (did you mean "NAME"?)` for the nearest of the valid names, if one is near.
fn hint(name: &str, valid: &[String]) -> String {
    let nearest = valid
        .iter()
        .map(|known| known.split(' ').next().unwrap_or_default())
        .map(|known| (strsim::damerau_levenshtein(name, known), known))
        .min()
        // Half of the letters wrong is no typing error.
        .filter(|(distance, known)| 2 * distance <= known.len().max(name.len()));
    nearest.map_or(String::new(), |(_, known)| format!(" (did you mean \"{known}\"?)"))
}
