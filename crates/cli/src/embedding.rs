//! The command inside another program: the package for Python.
//!
//! A [`Session`] has the arrays that stand for files and the place of messages and progress.
//! [`Session::answer`] takes the words of the command line and returns the document of `--json`:
//! the same question has the same answer, and the same words in errors.

mod arrays;
mod fits;
mod integration;
mod parsing;
mod spectra;

use std::ffi::OsString;
use std::fmt;

pub use self::integration::Integration;
pub use self::spectra::SpectrumAnswer;
use crate::args::Command;
pub use crate::commands::healpix::{angles_of_degrees, degrees_of_angles, rounded_colatitude};
pub use crate::draws::{DrawRequest, Draws, GivenSets};
use crate::error::CliError;
pub use crate::files::RotationFormat;
pub use crate::given::PointTable;
use crate::global::Global;
use crate::message;
pub use crate::session::Session;

/// The option of documents.
const JSON: &str = "--json";

/// Why a question has no answer.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum FailureKind {
    /// The request is invalid.
    Usage,
    /// A file cannot be read or written.
    File,
    /// The memory does not suffice; none was taken.
    Memory,
    /// The caller stopped the work.
    Stopped,
    /// Valid work failed.
    Failed,
}

/// A question without an answer, in the words of the command.
#[derive(Clone, Debug)]
pub struct Failure {
    /// The kind of the failure.
    pub kind: FailureKind,
    /// What is wrong, where, and what would be right.
    pub message: String,
}

impl Failure {
    /// Returns a failure for an invalid request.
    pub(crate) fn usage(message: impl fmt::Display) -> Self {
        Self { kind: FailureKind::Usage, message: message::clean(&message.to_string()) }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Failure {}

impl Failure {
    /// Returns the failure of a run; the content of an array is invalid as an argument is.
    pub(crate) fn of_run(error: CliError, session: &Session) -> Self {
        let is_of_array =
            matches!(&error, CliError::File(message) if session.given.is_about(message));
        let failure = Self::from(error);
        if is_of_array { Self { kind: FailureKind::Usage, ..failure } } else { failure }
    }
}

impl From<CliError> for Failure {
    fn from(error: CliError) -> Self {
        let kind = match error {
            CliError::Usage(_) => FailureKind::Usage,
            CliError::File(_) => FailureKind::File,
            CliError::Memory(_) => FailureKind::Memory,
            CliError::Stopped(_) => FailureKind::Stopped,
            CliError::Failed(_)
            | CliError::NotDone
            | CliError::PlanFailed
            | CliError::ClosedPipe => FailureKind::Failed,
        };
        Self { kind, message: message::clean(&error.to_string()) }
    }
}

/// Returns a failure if `bytes`, a lower bound of the memory of `what`, exceed the available memory.
///
/// # Errors
///
/// A failure of the kind [`FailureKind::Memory`].
pub fn check_memory(what: &str, bytes: f64) -> Result<(), Failure> {
    Ok(crate::memory::check_memory(what, bytes)?)
}

/// Runs the command with the words after its name and returns its exit status.
#[must_use]
pub fn run_command(words: Vec<OsString>) -> u8 {
    crate::run_words(words)
}

impl Session {
    /// Returns the JSON document that the command prints for the words after its name and `--json`,
    /// on the current pool of threads.
    ///
    /// # Errors
    ///
    /// Those of the command in its words, and options that write files or set the number of threads.
    pub fn answer(&self, words: &[String]) -> Result<String, Failure> {
        self.run_with(words, |command, global| {
            crate::execute(command, global)?;
            Ok(global.session.take_output())
        })
    }

    /// Returns the result of `task` for the command that the words name.
    fn run_with<T>(
        &self,
        words: &[String],
        task: impl FnOnce(Command, &Global) -> Result<T, CliError>,
    ) -> Result<T, Failure> {
        let (command, global) = self.question(words)?;
        let result = task(command, &global);
        self.check_stopped()?;
        result.map_err(|error| Failure::of_run(error, self))
    }

    /// Returns the command that the words name, with the session of its run.
    fn question(&self, words: &[String]) -> Result<(Command, Global), Failure> {
        // The provenance of a document is that of the command that prints it.
        let is_named = words.iter().any(|word| word == JSON);
        let json = (!is_named).then(|| JSON.to_owned());
        let words: Vec<String> = words.iter().cloned().chain(json).collect();
        let (command, mut global) = parsing::parse(&words)?;
        global.session = self.run(&words);
        Ok((command, global))
    }

    /// Returns the failure of stopped work, which is unfinished also where a command reports parts of
    /// it as unavailable.
    fn check_stopped(&self) -> Result<(), Failure> {
        if self.is_stopped() {
            let message = sphvar_samplers::Stopped.to_string();
            return Err(Failure { kind: FailureKind::Stopped, message });
        }
        Ok(())
    }
}

/// Returns the error of words that name another command than the expected one.
fn other_command(expected: &str) -> CliError {
    CliError::Usage(format!("expected the words of the command {expected}"))
}
