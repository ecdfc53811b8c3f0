//! Spectra that merge, and weights and fits with their arrays.

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use sphvar_cli::embedding::SpectrumAnswer;

use crate::errors::of_failure;
use crate::session::Session;

/// A spectrum with the exact sums of its realizations.
#[pyclass(module = "sphvar._sphvar", frozen)]
struct SpectrumSums {
    inner: SpectrumAnswer,
}

#[pymethods]
impl SpectrumSums {
    /// The JSON document of the command.
    #[getter]
    fn document(&self) -> &str {
        self.inner.document()
    }

    /// Return the spectrum of the realizations of both.
    fn merged(&self, py: Python<'_>, other: &Self) -> PyResult<Self> {
        let (inner, other) = (&self.inner, &other.inner);
        let inner = py.detach(|| inner.merged(other)).map_err(of_failure)?;
        Ok(Self { inner })
    }

    /// Return the spectrum in bytes.
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = py.detach(|| self.inner.bytes()).map_err(of_failure)?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Return the spectrum of `to_bytes`.
    #[staticmethod]
    fn from_bytes(bytes: &[u8]) -> PyResult<Self> {
        Ok(Self { inner: SpectrumAnswer::of_bytes(bytes).map_err(of_failure)? })
    }
}

/// Return the spectrum for the words of the command, of part (i, k) of the realizations.
#[pyfunction]
#[pyo3(signature = (session, words, part = None))]
fn spectrum(
    py: Python<'_>,
    session: &Session,
    words: Vec<String>,
    part: Option<[u64; 2]>,
) -> PyResult<SpectrumSums> {
    let inner =
        session.run(py, move |session| session.spectrum(&words, part).map_err(of_failure))?;
    Ok(SpectrumSums { inner })
}

/// Return the document of the command `weights` without the weights, and the weights.
#[pyfunction]
fn weights<'py>(
    py: Python<'py>,
    session: &Session,
    words: Vec<String>,
) -> PyResult<(String, Bound<'py, PyAny>)> {
    let (document, weights) =
        session.run(py, move |session| session.weights(&words).map_err(of_failure))?;
    Ok((document, PyArray1::from_vec(py, weights).into_any()))
}

/// Return the document of the command `fit`, and the coefficients.
#[pyfunction]
fn fit<'py>(
    py: Python<'py>,
    session: &Session,
    words: Vec<String>,
) -> PyResult<(String, Bound<'py, PyAny>)> {
    let (document, alm) =
        session.run(py, move |session| session.fit(&words).map_err(of_failure))?;
    Ok((document, PyArray1::from_vec(py, alm.into_values()).into_any()))
}

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<SpectrumSums>()?;
    module.add_function(wrap_pyfunction!(spectrum, module)?)?;
    module.add_function(wrap_pyfunction!(weights, module)?)?;
    module.add_function(wrap_pyfunction!(fit, module)?)
}
