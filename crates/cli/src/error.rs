use std::io;

/// Why the command ends without having done its work.
#[derive(Debug, thiserror::Error)]
pub(crate) enum CliError {
    /// What was asked for cannot be meant: exit status 2.
    #[error("{0}")]
    Usage(String),
    /// It was meant but did not work out: exit status 1.
    #[error("{0}")]
    Failed(String),
    /// The reader of standard output has gone.
    #[error("standard output was closed")]
    ClosedPipe,
}

impl CliError {
    /// The exit status.
    pub(crate) fn status(&self) -> u8 {
        match self {
            Self::Usage(_) => 2,
            Self::Failed(_) => 1,
            Self::ClosedPipe => 0,
        }
    }

    /// Wrong usage with the message of `error`.
    pub(crate) fn usage(error: impl std::fmt::Display) -> Self {
        Self::Usage(error.to_string())
    }

    /// A failure with the message of `error`.
    pub(crate) fn failed(error: impl std::fmt::Display) -> Self {
        Self::Failed(error.to_string())
    }

    /// A failure of writing to standard output.
    pub(crate) fn stdout(error: &io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::BrokenPipe => Self::ClosedPipe,
            _ => Self::Failed(format!("cannot write to standard output: {error}")),
        }
    }
}

/// Files and figures fail while the work is done, whatever is wrong with them.
macro_rules! failure_from {
    ($($error:ty),*) => {$(
        impl From<$error> for CliError {
            fn from(error: $error) -> Self {
                Self::failed(error)
            }
        }
    )*};
}

failure_from!(
    crate::files::FileError,
    crate::plots::PlotError,
    sphvar_spectrum::Error,
    sphvar_variance::Error
);
