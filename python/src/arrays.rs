//! numpy arrays as points, weights and values, and back.

use numpy::ndarray::{IxDyn, arr0};
use numpy::{
    Element, PyArray, PyArray1, PyArray2, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn,
    PyUntypedArray, PyUntypedArrayMethods, ToPyArray,
};
use pyo3::exceptions::{PyMemoryError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyFloat, PyInt, PySlice};
use sphvar::glam::DVec3;
use sphvar_cli::embedding::check_memory;

use crate::errors::{of_failure, value_error};

/// Returns an array-like object as a numpy array of `float64`, without a copy where it is one.
/// `name` is its name in messages.
///
/// Integers and floats of every size and byte order are converted; other types are a `TypeError`, and
/// masked elements a `ValueError`. The elements may be read only while the interpreter's lock is held:
/// without it, other threads may write to an array that was not copied.
pub(crate) fn float_array<'py>(
    name: &str,
    object: &Bound<'py, PyAny>,
) -> PyResult<PyReadonlyArrayDyn<'py, f64>> {
    number_array(name, object, "float64", "fiu", "numbers")
}

/// Returns an array-like object of integers as a numpy array of `int64`, as [`float_array`] does.
pub(crate) fn integer_array<'py>(
    name: &str,
    object: &Bound<'py, PyAny>,
) -> PyResult<PyReadonlyArrayDyn<'py, i64>> {
    number_array(name, object, "int64", "iu", "integers")
}

fn number_array<'py, T: Element + FromPyObjectOwned<'py>>(
    name: &str,
    object: &Bound<'py, PyAny>,
    dtype: &str,
    kinds: &str,
    expected: &str,
) -> PyResult<PyReadonlyArrayDyn<'py, T>> {
    let py = object.py();
    if object.is_exact_instance_of::<PyUntypedArray>()
        && let Ok(array) = object.cast::<PyArrayDyn<T>>()
        && array.ndim() <= MAX_DIMENSIONS
        && is_plain(array)
    {
        return Ok(array.try_readonly()?);
    }
    let is_number = object.is_exact_instance_of::<PyInt>()
        || kinds.contains('f') && object.is_exact_instance_of::<PyFloat>();
    if is_number && let Ok(number) = object.extract::<T>() {
        let array = PyArray::from_owned_array(py, arr0(number).into_dyn());
        return Ok(array.try_readonly()?);
    }
    let numpy = py.import("numpy")?;
    let array = unmasked(name, object)?;
    let ndim: usize = array.getattr("ndim")?.extract()?;
    if ndim > MAX_DIMENSIONS {
        return Err(value_error(format!("{name}: an array has at most 32 dimensions, got {ndim}")));
    }
    let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
    // The dtype of an empty list is float64.
    let is_empty = array.getattr("size")?.extract::<usize>()? == 0 && kind == "f";
    if !kinds.contains(&kind) && !is_empty {
        let dtype = array.getattr("dtype")?.str()?;
        return Err(PyTypeError::new_err(format!(
            "{name}: expected an array of {expected}, got one of dtype {dtype}"
        )));
    }
    if kind == "u"
        && dtype == "int64"
        && !array.call_method1("__le__", (i64::MAX,))?.call_method0("all")?.is_truthy()?
    {
        return Err(value_error(format!("{name}: an integer is above {}", i64::MAX)));
    }
    // A copy unless it is an aligned array of this type.
    check_copy::<T>(name, array.getattr("size")?.extract()?)?;
    let requirements = ["ALIGNED", "ENSUREARRAY"];
    let array = numpy.call_method1("require", (array, dtype, requirements))?;
    let array = array.cast::<PyArrayDyn<T>>()?;
    if !is_plain(array) {
        return Ok(array.call_method0("copy")?.cast::<PyArrayDyn<T>>()?.try_readonly()?);
    }
    Ok(array.try_readonly()?)
}

/// Returns an array-like object as an array without masked elements, whose numbers are not values.
pub(crate) fn unmasked<'py>(name: &str, object: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let numpy = object.py().import("numpy")?;
    let array = numpy.call_method1("asanyarray", (object,))?;
    if array.is_exact_instance_of::<PyUntypedArray>() {
        return Ok(array);
    }
    // False if no element of a masked array is masked.
    if numpy.getattr("ma")?.call_method1("is_masked", (&array,))?.is_truthy()? {
        return Err(value_error(format!(
            "{name}: elements are masked; pass those that are not, as array[~mask] is"
        )));
    }
    numpy.call_method1("asarray", (array,))
}

/// Copies of fewer bytes are made without a look at the available memory, which takes longer.
const SMALL_BYTES: f64 = (64 << 20) as f64;

/// Returns a `MemoryError` if `len` elements do not fit in memory: the system may promise more than
/// it has, and then ends the process that uses it.
pub(crate) fn check_copy<T>(name: &str, len: usize) -> PyResult<()> {
    let bytes = len as f64 * size_of::<T>() as f64;
    if bytes <= SMALL_BYTES {
        return Ok(());
    }
    check_memory(&format!("{name}: a copy of {len} numbers"), bytes).map_err(of_failure)
}

/// Returns whether an array can be viewed: its elements lie at multiples of their size, and an array
/// without elements has no strides that lead out of it.
fn is_plain<T: Element>(array: &Bound<'_, PyArrayDyn<T>>) -> bool {
    let size = size_of::<T>();
    let is_stride = |stride: &isize| {
        stride.unsigned_abs().is_multiple_of(size) && (*stride >= 0 || !array.is_empty())
    };
    array.data().is_aligned() && array.strides().iter().all(is_stride)
}

/// The largest number of dimensions of views.
const MAX_DIMENSIONS: usize = 32;

/// Returns an array-like object of shape `(n,)`.
pub(crate) fn floats(name: &str, object: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let array = float_array(name, object)?;
    if array.ndim() != 1 {
        return Err(shape_error(name, "(n,)", array.shape()));
    }
    elements(name, &array)
}

/// Returns the numbers of an array-like object of shape `(n, d)`, row by row.
pub(crate) fn rows(name: &str, object: &Bound<'_, PyAny>, d: usize) -> PyResult<Vec<f64>> {
    let array = float_array(name, object)?;
    match *array.shape() {
        [_, last] if last == d => elements(name, &array),
        _ => Err(shape_error(name, &format!("(n, {d})"), array.shape())),
    }
}

/// Returns the numbers of an array-like object of shape `(n, d)` or `(m, n, d)`, the points of one set
/// or of several, and that shape without d.
pub(crate) fn sets(
    name: &str,
    object: &Bound<'_, PyAny>,
    d: usize,
) -> PyResult<(Vec<f64>, Vec<usize>)> {
    let array = float_array(name, object)?;
    match *array.shape() {
        [ref shape @ .., last] if last == d && matches!(shape.len(), 1 | 2) => {
            Ok((elements(name, &array)?, shape.to_vec()))
        }
        _ => Err(shape_error(name, &format!("(n, {d}) or (m, n, {d})"), array.shape())),
    }
}

/// The number of elements that are copied between two looks at signals.
const PART: usize = 1 << 20;

/// Returns a copy of the elements in C order, or a `MemoryError` before it is made. `name` is the name
/// of the array in messages. Signals are handled.
pub(crate) fn elements<T: Element + Copy>(
    name: &str,
    array: &PyReadonlyArrayDyn<'_, T>,
) -> PyResult<Vec<T>> {
    check_copy::<T>(name, array.len())?;
    let mut all = reserved(array.len())?;
    append(array, &mut all)?;
    Ok(all)
}

/// Appends the elements in C order, part by part. numpy makes copies of parts in another order: it
/// visits the memory in a better order than its views in Rust do.
fn append<T: Element + Copy>(array: &Bound<'_, PyArrayDyn<T>>, all: &mut Vec<T>) -> PyResult<()> {
    let py = array.py();
    let len = array.len();
    if len == 0 {
        return Ok(());
    }
    // A slice of an array in Fortran order would have its elements in that order.
    if array.is_c_contiguous()
        && let Ok(view) = array.try_readonly()
        && let Ok(slice) = view.as_slice()
    {
        for part in slice.chunks(PART) {
            all.extend_from_slice(part);
            if len > PART {
                py.check_signals()?;
            }
        }
        return Ok(());
    }
    let n_rows = array.shape().first().copied().unwrap_or(1);
    if len <= PART || array.ndim() == 0 {
        let copy = py.import("numpy")?.call_method1("ascontiguousarray", (array,))?;
        let copy = copy.cast::<PyArrayDyn<T>>()?.try_readonly()?;
        all.extend_from_slice(copy.as_slice()?);
        return py.check_signals();
    }
    let step = (PART / (len / n_rows)).max(1);
    for start in (0..n_rows).step_by(step) {
        let end = (start + step).min(n_rows);
        let part = if step == 1 {
            array.get_item(start)?
        } else {
            array.get_item(PySlice::new(py, start as isize, end as isize, 1))?
        };
        append(part.cast::<PyArrayDyn<T>>()?, all)?;
    }
    Ok(())
}

/// Returns an empty vector that takes `len` elements, or a `MemoryError`: an allocation that fails
/// elsewhere ends the process.
pub(crate) fn reserved<T>(len: usize) -> PyResult<Vec<T>> {
    let mut all = Vec::new();
    all.try_reserve_exact(len).map_err(|_| no_memory::<T>(len))?;
    Ok(all)
}

/// Returns `len` zeros, or a `MemoryError`. The system gives pages of zeros when they are first used,
/// so threads that fill parts of the array share that work.
pub(crate) fn zeros<T: Default + Copy>(len: usize) -> PyResult<Vec<T>> {
    drop(reserved::<T>(len)?);
    Ok(vec![T::default(); len])
}

fn no_memory<T>(len: usize) -> PyErr {
    let bytes = len as f64 * size_of::<T>() as f64;
    PyMemoryError::new_err(format!("{bytes:.3e} bytes of memory are not available"))
}

/// Returns the error of an array of the wrong shape.
pub(crate) fn shape_error(name: &str, expected: &str, got: &[usize]) -> PyErr {
    value_error(format!("{name}: expected shape {expected}, got {}", shape_text(got)))
}

/// Returns a shape or an index as Python prints it.
pub(crate) fn shape_text(sizes: &[usize]) -> String {
    let texts: Vec<String> = sizes.iter().map(usize::to_string).collect();
    let comma = if sizes.len() == 1 { "," } else { "" };
    format!("({}{comma})", texts.join(", "))
}

/// Returns numbers in C order as an array of this shape, which takes them over without a copy.
pub(crate) fn of_shape<'py, T: Element>(
    py: Python<'py>,
    numbers: Vec<T>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    PyArray1::from_vec(py, numbers).reshape(IxDyn(shape))
}

/// Returns directions as an array of shape `(n, 3)`.
pub(crate) fn of_directions<'py>(
    py: Python<'py>,
    points: &[DVec3],
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let rows: Vec<[f64; 3]> = points.iter().map(|point| point.to_array()).collect();
    PyArray1::from_vec(py, rows.into_flattened()).reshape([points.len(), 3])
}

/// Returns numbers as an array of shape `(n,)`.
pub(crate) fn of_floats<'py>(py: Python<'py>, values: &[f64]) -> Bound<'py, PyArray1<f64>> {
    values.to_pyarray(py)
}

/// Returns an array, or its element if it has the shape `()`.
pub(crate) fn or_scalar<'py, T: Element, D>(
    array: Bound<'py, PyArray<T, D>>,
) -> PyResult<Bound<'py, PyAny>> {
    if array.ndim() == 0 { array.get_item(()) } else { Ok(array.into_any()) }
}

/// Raise a `MemoryError` if a copy of `len` numbers of an array of this name does not fit in memory.
#[pyfunction]
#[pyo3(name = "check_memory")]
fn check_numbers(name: &str, len: usize) -> PyResult<()> {
    check_copy::<f64>(name, len)
}

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(check_numbers, module)?)
}
