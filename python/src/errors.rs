//! Exceptions: `ValueError` for invalid values, `OSError` for files, `MemoryError` before memory is
//! taken, `RuntimeError` where valid work fails.

use std::fmt::Display;

use pyo3::exceptions::{
    PyKeyboardInterrupt, PyMemoryError, PyOSError, PyRuntimeError, PyValueError,
};
use pyo3::prelude::*;
use sphvar_cli::embedding::{Failure, FailureKind};

/// Returns a `ValueError` with the message of an error.
pub(crate) fn value_error(error: impl Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// Returns a `RuntimeError` with the message of an error.
pub(crate) fn runtime_error(error: impl Display) -> PyErr {
    PyRuntimeError::new_err(error.to_string())
}

/// Returns the exception of a failure of the command, with its words.
pub(crate) fn of_failure(failure: Failure) -> PyErr {
    let Failure { kind, message } = failure;
    match kind {
        FailureKind::Usage => PyValueError::new_err(message),
        FailureKind::File => PyOSError::new_err(message),
        FailureKind::Memory => PyMemoryError::new_err(message),
        FailureKind::Stopped => PyKeyboardInterrupt::new_err(()),
        FailureKind::Failed => PyRuntimeError::new_err(message),
    }
}
