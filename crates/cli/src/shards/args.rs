//! The flags of commands whose work can be divided.

use std::path::PathBuf;

use clap::Args;
use schemars::JsonSchema;
use serde::Serialize;

use super::{Part, Request, Tasks};
use crate::error::CliError;
use crate::files::{AtomicFile, is_stdout, set_last_output};
use crate::global::Global;
use crate::report::{Document, Provenance};

/// A finished part: `--shard I/K --save FILE --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct PartBody {
    /// The number of the part, from 1.
    part: u64,
    /// The number of all parts.
    parts: u64,
    /// The file with its results.
    file: String,
}

/// Which part of the work is done, and where it is kept.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct ShardArgs {
    /// Compute only part I of K parts of the work, for `sphvar merge`
    #[arg(long, value_name = "I/K", requires = "save")]
    pub(crate) shard: Option<Part>,
    /// Keep the work in a file, for `sphvar merge`; the same command continues interrupted work
    #[arg(long, value_name = "FILE")]
    pub(crate) save: Option<PathBuf>,
    /// If another process computes the same part, wait for its end instead of failing
    #[arg(long, requires = "save")]
    pub(crate) wait: bool,
}

impl ShardArgs {
    /// Returns the part that is computed.
    pub(crate) fn part(&self) -> Part {
        self.shard.unwrap_or(Part::WHOLE)
    }

    /// Returns the tasks of a command with these words that keeps its results.
    ///
    /// # Errors
    ///
    /// If the file cannot be written, or unfinished work of it cannot be continued.
    pub(crate) fn tasks(&self, words: &[String]) -> Result<Tasks, CliError> {
        let Some(path) = &self.save else { return Ok(Tasks::default()) };
        if is_stdout(path) {
            return Err(CliError::Usage("--save must name a file".to_owned()));
        }
        AtomicFile::check(path)?;
        let tasks = Tasks::of_part(Request::new(words, self), self.part(), path, self.wait)?;
        set_last_output(Some(path));
        Ok(tasks)
    }

    /// Reports a finished part; the whole work has reported its results.
    ///
    /// # Errors
    ///
    /// If standard output cannot be written to.
    pub(crate) fn report(&self, global: &Global) -> Result<(), CliError> {
        let (Part { part, parts }, Some(path)) = (self.part(), &self.save) else { return Ok(()) };
        if parts == 1 {
            return Ok(());
        }
        let file = path.display().to_string();
        if !global.json {
            global.session.say(&format!("part {part}/{parts} is complete: {file}"));
            return Ok(());
        }
        let provenance = Provenance::new(&global.session, global.seed);
        Document::new(&PartBody { part, parts, file }, &provenance).print(&global.session)
    }
}
