//! The grammar of samplers, integrands and profiles in arguments.

use std::ffi::OsString;

use clap::builder::{MapValueParser, OsStringValueParser, TypedValueParser};
pub(crate) use sphvar_grammar::Spec;

use crate::error::CliError;

/// Returns a parser of arguments with specifications, whose file names may contain any bytes: parts
/// that are not UTF-8 become quoted values with `\xHH`.
pub(crate) fn argument() -> MapValueParser<OsStringValueParser, fn(OsString) -> String> {
    OsStringValueParser::new().map(|argument| sphvar_grammar::argument_text(&argument))
}

/// Returns the message `unknown WHAT "name"`, with the most similar of the `known` names, if any,
/// and all of them.
pub(crate) fn unknown_name(what: &str, name: &str, known: &[&str]) -> CliError {
    sphvar_grammar::Error::unknown_name(what, name, known).into()
}
