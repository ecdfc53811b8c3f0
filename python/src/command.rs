//! The command `sphvar`, which the wheel installs.

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the command with the words after its name and returns its exit status.
#[pyfunction]
fn run_command(py: Python<'_>, words: Vec<OsString>) -> u8 {
    // The command prints panics, of which this package makes exceptions.
    drop(std::panic::take_hook());
    py.detach(|| sphvar_cli::embedding::run_command(words))
}

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(run_command, module)?)
}
