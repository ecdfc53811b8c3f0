use std::io;

use sphvar_grammar::ResolveError;
use sphvar_samplers::Stopped;

use crate::files::FileError;
use crate::plots::PlotError;

/// The reason why the command ends without a result.
#[derive(Clone, Debug, thiserror::Error)]
pub(crate) enum CliError {
    /// The command line is invalid: exit status 2.
    #[error("{0}")]
    Usage(String),
    /// A file cannot be read or written, or has invalid content: exit status 1.
    #[error("{0}")]
    File(String),
    /// The work would exceed the memory and was not started: exit status 1.
    #[error("{0}")]
    Memory(String),
    /// The command line is valid but its execution failed: exit status 1.
    #[error("{0}")]
    Failed(String),
    /// Parts of a plan are not done or not merged, which the output states: exit status 1.
    #[error("not all parts are done and merged")]
    NotDone,
    /// Parts of a plan or its merge have failed, which the output states: exit status 2.
    #[error("parts or the merge have failed")]
    PlanFailed,
    /// The embedding program has stopped the work.
    #[error("{0}")]
    Stopped(Stopped),
    /// The reader of standard output has closed it.
    #[error("standard output was closed")]
    ClosedPipe,
}

impl CliError {
    /// Returns the exit status.
    pub(crate) fn status(&self) -> u8 {
        match self {
            Self::Usage(_) | Self::PlanFailed => 2,
            Self::File(_)
            | Self::Memory(_)
            | Self::Failed(_)
            | Self::NotDone
            | Self::Stopped(_) => 1,
            Self::ClosedPipe => 0,
        }
    }

    /// Returns a usage error with the message of `error`.
    pub(crate) fn usage(error: impl std::fmt::Display) -> Self {
        Self::Usage(error.to_string())
    }

    /// Returns a failure with the message of `error`.
    pub(crate) fn failed(error: impl std::fmt::Display) -> Self {
        Self::Failed(error.to_string())
    }

    /// Returns the error of a file that a text names, as the command's reader reported it.
    pub(crate) fn of_resolver(error: &ResolveError) -> Self {
        error.downcast_ref::<Self>().cloned().unwrap_or_else(|| Self::usage(error))
    }

    /// Returns the error of writing to standard output.
    pub(crate) fn stdout(error: &io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::BrokenPipe => Self::ClosedPipe,
            _ => Self::Failed(format!("cannot write to standard output: {error}")),
        }
    }
}

impl From<Stopped> for CliError {
    fn from(stopped: Stopped) -> Self {
        Self::Stopped(stopped)
    }
}

impl From<sphvar_grammar::Error> for CliError {
    fn from(error: sphvar_grammar::Error) -> Self {
        Self::usage(error)
    }
}

impl From<FileError> for CliError {
    fn from(error: FileError) -> Self {
        match error {
            FileError::UnknownExtension { .. } | FileError::UnknownChannel { .. } => {
                Self::usage(error)
            }
            FileError::Write { source, .. } if source.kind() == io::ErrorKind::BrokenPipe => {
                Self::ClosedPipe
            }
            FileError::Memory { .. } => Self::Memory(error.to_string()),
            _ => Self::File(error.to_string()),
        }
    }
}

impl From<PlotError> for CliError {
    fn from(error: PlotError) -> Self {
        match error {
            PlotError::UnknownExtension { .. } => Self::usage(error),
            PlotError::File(error) => error.into(),
            _ => Self::failed(error),
        }
    }
}

impl From<sphvar_spectrum::Error> for CliError {
    fn from(error: sphvar_spectrum::Error) -> Self {
        match error {
            sphvar_spectrum::Error::NoRealizations => Self::usage(error),
            _ => Self::failed(error),
        }
    }
}

impl From<sphvar_variance::Error> for CliError {
    fn from(error: sphvar_variance::Error) -> Self {
        match error {
            sphvar_variance::Error::Spectrum(error) => error.into(),
            sphvar_variance::Error::Integrand(error) => error.into(),
            _ => Self::failed(error),
        }
    }
}

impl From<sphvar_thesis::Error> for CliError {
    fn from(error: sphvar_thesis::Error) -> Self {
        Self::failed(error)
    }
}

impl From<sphvar_integrands::Error> for CliError {
    fn from(error: sphvar_integrands::Error) -> Self {
        Self::failed(error)
    }
}
