use crate::ParameterKind;

/// Errors of a text in the grammar, with the place, the reason and the valid values.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The name before the colon is missing.
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
        /// The position in the text, counted from 1.
        character: usize,
        /// The error and the valid form.
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
    /// A value that is a text of another grammar is malformed.
    #[error("{text}: {key}: {reason}")]
    OfText {
        /// The whole text.
        text: String,
        /// The key of the parameter.
        key: &'static str,
        /// The error.
        reason: String,
    },
    /// A required parameter is missing.
    #[error("{text}: the parameter {key} is missing")]
    Missing {
        /// The whole text.
        text: String,
        /// The key of the parameter.
        key: String,
    },
    /// A file name is missing.
    #[error("{text}: the file is missing: {name}:FILE")]
    NoFile {
        /// The whole text.
        text: String,
        /// The name before the colon.
        name: String,
    },
    /// An unexpected bare value.
    #[error("{text}: unexpected value \"{value}\"; valid parameters: {}", list(valid))]
    UnexpectedValue {
        /// The whole text.
        text: String,
        /// The value.
        value: String,
        /// The valid parameters.
        valid: Vec<String>,
    },
    /// An unknown parameter.
    #[error("{text}: unknown parameter \"{key}\"{}; valid: {}", hint(key, valid), list(valid))]
    UnknownParameter {
        /// The whole text.
        text: String,
        /// The key.
        key: String,
        /// The valid parameters, each optionally followed by a blank and its values.
        valid: Vec<String>,
    },
    /// An unknown name.
    #[error("unknown {what} \"{name}\"{}; valid: {}", hint(name, valid), list(valid))]
    UnknownName {
        /// The kind of name, such as `sampler`.
        what: String,
        /// The name.
        name: String,
        /// The valid names.
        valid: Vec<String>,
    },
}

impl Error {
    /// Returns the error of an unknown `name` of kind `what`, such as `sampler`, with the `valid`
    /// names.
    pub fn unknown_name(what: impl Into<String>, name: &str, valid: &[&str]) -> Self {
        let valid = valid.iter().map(|&name| name.to_owned()).collect();
        Self::UnknownName { what: what.into(), name: name.to_owned(), valid }
    }
}

fn list(valid: &[String]) -> String {
    if valid.is_empty() { "none".to_owned() } else { valid.join(", ") }
}

/// Returns ` (did you mean "NAME"?)` for the nearest valid name, if it is close enough.
fn hint(name: &str, valid: &[String]) -> String {
    let nearest = valid
        .iter()
        .map(|known| known.split(' ').next().unwrap_or_default())
        .map(|known| (strsim::damerau_levenshtein(name, known), known))
        .min()
        // A name with half of its letters wrong is not a typing error.
        .filter(|(distance, known)| 2 * distance <= known.len().max(name.len()));
    nearest.map_or(String::new(), |(_, known)| format!(" (did you mean \"{known}\"?)"))
}
