//! The command inside another program: the package for Python.

use std::ffi::OsString;
use std::fmt;

/// Why a question has no answer.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum FailureKind {
    /// What was asked for is invalid.
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

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Failure {}

/// Runs the command with the words after its name and returns its exit status.
#[must_use]
pub fn run_command(words: Vec<OsString>) -> u8 {
    crate::run_words(words)
}
