//! The provenance of a result: the data needed to reproduce it.

use std::borrow::Cow;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::message;
use crate::session::Session;

/// The data that make a result reproducible.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(crate) struct Provenance {
    /// The command line as a shell takes it, without the number of threads and the log, on which results do not
    /// depend.
    pub(crate) command: String,
    /// The version of sphvar.
    pub(crate) version: Cow<'static, str>,
    /// The seed of all random streams.
    pub(crate) seed: u64,
}

impl Provenance {
    /// Returns the provenance of this run.
    pub(crate) fn new(session: &Session, seed: u64) -> Self {
        // A line break would end the comment in which the command is written.
        let words = session.words().iter().map(|word| quoted(&message::escape(word)));
        Self::of(format!("sphvar {}", without_run_options(words).join(" ")), seed)
    }

    /// Returns the provenance of a canonical command of this run.
    pub(crate) fn of(command: String, seed: u64) -> Self {
        Self { command, version: env!("CARGO_PKG_VERSION").into(), seed }
    }

    /// Returns the provenance of a JSON document that has one under `provenance`.
    pub(crate) fn of_document(json: &[u8]) -> Option<Self> {
        #[derive(Deserialize)]
        struct Document {
            provenance: Provenance,
        }
        serde_json::from_slice::<Document>(json).ok().map(|document| document.provenance)
    }

    /// Returns whether both runs write the same bytes to files: their commands differ at most in
    /// flags of the terminal output.
    pub(crate) fn is_same_run(&self, other: &Self) -> bool {
        let words = |run: &Self| -> Vec<String> {
            let is_shown = |word: &&str| !["--json", "--quiet", "--force"].contains(word);
            run.command.split(' ').filter(is_shown).map(str::to_owned).collect()
        };
        (&self.version, self.seed) == (&other.version, other.seed) && words(self) == words(other)
    }

    /// Returns one line for the heads of files and the feet of figures.
    pub(crate) fn line(&self) -> String {
        format!("{} (sphvar {}, seed {})", self.command, self.version, self.seed)
    }
}

/// Returns a word as a shell takes it, in single quotes unless it has only characters that mean nothing to a shell.
pub(crate) fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "_@%+=:,./-".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// Returns the words of a command line without `-j`, `--threads` and `--log` and their values.
fn without_run_options(mut words: impl Iterator<Item = String>) -> Vec<String> {
    let mut kept = Vec::new();
    while let Some(word) = words.next() {
        if ["-j", "--threads", "--log"].contains(&&*word) {
            words.next();
        } else if !["-j", "--threads=", "--log="].iter().any(|option| word.starts_with(option)) {
            kept.push(word);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn words_are_quoted_for_a_shell() {
        for (word, text) in [
            ("cap:degrees=60", "cap:degrees=60"),
            ("-n", "-n"),
            ("16..1024", "16..1024"),
            ("", "''"),
            ("a * b", "'a * b'"),
            ("env:file=\"a,b.exr\"", "'env:file=\"a,b.exr\"'"),
            ("it's", "'it'\\''s'"),
            ("$HOME", "'$HOME'"),
        ] {
            assert_eq!(quoted(word), text);
        }
    }
}
