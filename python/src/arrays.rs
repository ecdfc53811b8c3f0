//! numpy arrays as points, weights and values, and back.

use numpy::{
    PyArray1, PyArray2, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods,
    ToPyArray,
};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use sphvar::glam::DVec3;

use crate::errors::value_error;

/// Returns an array-like object as a numpy array of `float64`, without a copy where it is one.
/// `name` is its name in messages.
pub(crate) fn float_array<'py>(
    name: &str,
    object: &Bound<'py, PyAny>,
) -> PyResult<PyReadonlyArrayDyn<'py, f64>> {
    if let Ok(array) = object.cast::<PyArrayDyn<f64>>() {
        return Ok(array.readonly());
    }
    let py = object.py();
    let numpy = py.import("numpy")?;
    let array = numpy.call_method1("asarray", (object,))?;
    let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
    if !"fiu".contains(&kind) {
        let dtype = array.getattr("dtype")?.str()?;
        return Err(PyTypeError::new_err(format!(
            "{name}: expected an array of numbers, got one of dtype {dtype}"
        )));
    }
    let array = array.call_method1("astype", ("float64",))?;
    Ok(array.cast::<PyArrayDyn<f64>>()?.readonly())
}

/// Returns an array-like object of shape `(n,)`.
pub(crate) fn floats(name: &str, object: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let array = float_array(name, object)?;
    if array.ndim() != 1 {
        return Err(shape_error(name, "(n,)", array.shape()));
    }
    Ok(array.as_array().iter().copied().collect())
}

/// Returns the error of an array of the wrong shape.
pub(crate) fn shape_error(name: &str, expected: &str, got: &[usize]) -> PyErr {
    let sizes: Vec<String> = got.iter().map(usize::to_string).collect();
    let comma = if sizes.len() == 1 { "," } else { "" };
    value_error(format!("{name}: expected shape {expected}, got ({}{comma})", sizes.join(", ")))
}

/// Returns directions as an array of shape `(n, 3)`.
pub(crate) fn of_directions<'py>(
    py: Python<'py>,
    points: &[DVec3],
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let flat: Vec<f64> = points.iter().flat_map(|point| point.to_array()).collect();
    PyArray1::from_vec(py, flat).reshape([points.len(), 3])
}

/// Returns numbers as an array of shape `(n,)`.
pub(crate) fn of_floats<'py>(py: Python<'py>, values: &[f64]) -> Bound<'py, PyArray1<f64>> {
    values.to_pyarray(py)
}
