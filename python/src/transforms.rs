//! Transforms between scattered points and coefficients of spherical harmonics.

use std::borrow::Cow;
use std::sync::Arc;

use numpy::{
    Complex64, Element, PyArray1, PyArrayDyn, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyMemoryError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::PyBool;
use rayon::prelude::*;
use sphvar::glam::DVec3;
use sphvar::samplers::{Progress, SECONDS_PER_WORK};
use sphvar::sh::{Alm, LmIndex, MAX_DEGREE};
use sphvar::sht::{Error, Method, Transform, TransformWorkspace};
use sphvar_cli::embedding::check_memory;

use crate::arrays::{check_copy, shape_error, unmasked};
use crate::errors::{of_failure, value_error};
use crate::work::{self, Watch, interrupted};

/// Work that takes less time than this runs at once: starting a thread takes about 50 microseconds.
const SHORT: f64 = 1e-3;

/// Memory below this is taken without a look at the state of the machine, which takes longer than
/// small transforms.
const SMALL: f64 = 64e6;

/// The number of sets that share a pass of the recurrence of Legendre functions.
const BATCH: usize = 4;

/// The numbers of an array, read without the interpreter's lock.
///
/// This object keeps the array alive. A thread of Python that changes an array in the meantime
/// changes the result, as it does for functions of numpy.
struct Numbers<T> {
    _array: Py<PyAny>,
    start: *const T,
    len: usize,
    shape: Vec<usize>,
}

// SAFETY: the memory belongs to the array, which `_array` keeps alive, and T is plain data.
unsafe impl<T: Send + Sync> Send for Numbers<T> {}

impl<T: Element + Copy> Numbers<T> {
    /// Returns the numbers of an array-like object in C order: those of the array itself if it has
    /// this layout and type, otherwise those of a copy. `kinds` are the kinds of numpy's dtypes that
    /// are accepted, in the words `what`.
    fn new(name: &str, object: &Bound<'_, PyAny>, kinds: &str, what: &str) -> PyResult<Self> {
        let array = match object.cast::<PyArrayDyn<T>>() {
            // A masked array is a subclass.
            Ok(array) if is_plain(array) && object.is_exact_instance_of::<PyUntypedArray>() => {
                array.clone()
            }
            _ => converted(name, object, kinds, what)?,
        };
        let (start, len, shape) = (array.data().cast_const(), array.len(), array.shape().to_vec());
        Ok(Self { _array: array.into_any().unbind(), start, len, shape })
    }

    fn all(&self) -> &[T] {
        if self.len == 0 {
            return &[];
        }
        // SAFETY: the array is contiguous, aligned and in native byte order (`is_plain`), has `len`
        // elements, and is alive.
        unsafe { std::slice::from_raw_parts(self.start, self.len) }
    }
}

impl Numbers<f64> {
    /// Returns real numbers.
    fn real(name: &str, object: &Bound<'_, PyAny>) -> PyResult<Self> {
        Self::new(name, object, "fiu", "real numbers")
    }

    /// Returns vectors of an array of shape (..., 3).
    fn vectors(&self) -> &[DVec3] {
        const { assert!(size_of::<DVec3>() == 3 * size_of::<f64>()) };
        const { assert!(align_of::<DVec3>() == align_of::<f64>()) };
        let numbers = self.all();
        // SAFETY: a DVec3 consists of three f64 in this order (it is `repr(C)`), without padding.
        unsafe { std::slice::from_raw_parts(numbers.as_ptr().cast(), numbers.len() / 3) }
    }
}

/// Returns whether the elements are one after the other in C order at aligned addresses.
fn is_plain<T: Element>(array: &Bound<'_, PyArrayDyn<T>>) -> bool {
    array.is_c_contiguous() && array.data().is_aligned()
}

/// Returns a copy of an array-like object with elements of type T in C order.
fn converted<'py, T: Element>(
    name: &str,
    object: &Bound<'py, PyAny>,
    kinds: &str,
    what: &str,
) -> PyResult<Bound<'py, PyArrayDyn<T>>> {
    let py = object.py();
    let numpy = py.import("numpy")?;
    let array = unmasked(name, object)?;
    let dtype = array.getattr("dtype")?;
    let kind: String = dtype.getattr("kind")?.extract()?;
    if !kinds.contains(&kind) {
        return Err(PyTypeError::new_err(format!(
            "{name}: expected {what}, got an array of dtype {dtype}"
        )));
    }
    check_copy::<T>(name, array.getattr("size")?.extract()?)?;
    // In C order, aligned, and no subclass.
    let array = numpy.call_method1("require", (array, T::get_dtype(py), ["C", "A", "E"]))?;
    Ok(array.cast_into::<PyArrayDyn<T>>()?)
}

/// Returns a degree, a whole number from 0 to the largest that is supported.
pub(crate) fn degree(name: &str, object: &Bound<'_, PyAny>) -> PyResult<usize> {
    let is_degree = |degree: &usize| *degree <= MAX_DEGREE;
    if object.is_instance_of::<PyBool>() {
        return Err(PyTypeError::new_err(format!("{name}: expected a whole number, got {object}")));
    }
    if let Some(degree) = object.extract::<usize>().ok().filter(is_degree) {
        return Ok(degree);
    }
    let index = object.py().import("operator")?.call_method1("index", (object,)).map_err(|_| {
        let kind = object.get_type();
        let kind = kind.name().map_or_else(|_| "an object".to_owned(), |name| name.to_string());
        PyTypeError::new_err(format!("{name}: expected a whole number, got {kind}"))
    })?;
    let expected = format!("a whole number from 0 to {MAX_DEGREE}");
    Err(value_error(format!("{name}: expected {expected}, got {index}")))
}

/// Returns a method of transforms by its name.
fn method(name: &str) -> PyResult<Method> {
    match name {
        "auto" => Ok(Method::Auto),
        "exact" => Ok(Method::Exact),
        "fast" => Ok(Method::Fast),
        other => Err(value_error(format!(
            "method: expected \"auto\", \"exact\" or \"fast\", got \"{other}\""
        ))),
    }
}

/// Returns the exception of an error of transforms.
fn of_error(error: Error) -> PyErr {
    match error {
        Error::OutOfMemory { .. } => PyMemoryError::new_err(error.to_string()),
        other => value_error(other),
    }
}

/// Returns vectors as directions: themselves if all have unit length to rounding, otherwise scaled
/// copies. `row` names a vector in messages.
fn directions<'a>(
    vectors: &'a [DVec3],
    row: &dyn Fn(usize) -> String,
) -> PyResult<Cow<'a, [DVec3]>> {
    /// Vectors this close to unit length are unchanged, as those that are read from files.
    const ROUNDING: f64 = 8.0 * f64::EPSILON;
    /// A length that differs from 1 by more than this is not an effect of rounding to f32 or to
    /// seven digits.
    const TOLERANCE: f64 = 1e-6;
    // False for NaN. A square that is this close to 1 is that of a length within the rounding.
    let is_unit = |v: &DVec3| (v.length_squared() - 1.0).abs() <= ROUNDING;
    if vectors.iter().all(is_unit) {
        return Ok(Cow::Borrowed(vectors));
    }
    let direction = |(k, v): (usize, &DVec3)| {
        let DVec3 { x, y, z } = *v;
        if !v.is_finite() {
            let row = row(k);
            return Err(value_error(format!(
                "{row}: expected finite numbers, got ({x:?}, {y:?}, {z:?})"
            )));
        }
        // Scaled first, which keeps the squares of tiny and huge vectors in range.
        let size = v.abs().max_element();
        let scaled = *v / size;
        let length = size * scaled.length();
        let off = (length - 1.0).abs();
        // False for NaN, which is that of the zero vector.
        let is_direction = off <= TOLERANCE;
        if !is_direction {
            let (row, length) = (row(k), if size == 0.0 { 0.0 } else { length });
            return Err(value_error(format!(
                "{row}: expected a unit vector, got ({x:?}, {y:?}, {z:?}) of length {length:?}"
            )));
        }
        Ok(if off <= ROUNDING { *v } else { scaled.normalize() })
    };
    vectors.iter().enumerate().map(direction).collect::<PyResult<Vec<DVec3>>>().map(Cow::Owned)
}

/// Runs a task of the given nominal work: at once if it is short, otherwise without the
/// interpreter's lock, interruptibly.
fn run_sized<T, F>(
    py: Python<'_>,
    nominal_work: f64,
    progress: Option<&Bound<'_, PyAny>>,
    task: F,
) -> PyResult<T>
where
    T: Send + 'static,
    F: FnOnce(&Arc<Watch>) -> PyResult<T> + Send + 'static,
{
    if nominal_work * SECONDS_PER_WORK < SHORT {
        task(&Arc::default())
    } else {
        work::run(py, progress, task)
    }
}

/// Returns an error if a transform needs more memory than there is, before it is taken.
fn check_size(what: &str, n_points: usize, lmax: usize, bytes: f64) -> PyResult<()> {
    if bytes < SMALL {
        return Ok(());
    }
    let what = format!("{what} of {n_points} points to degree {lmax}");
    check_memory(&what, bytes).map_err(of_failure)
}

/// Returns `sum_k w_k conj Y_lm(x_k)` of points of shape (n, 3) or (m, n, 3).
#[pyfunction]
#[pyo3(signature = (points, lmax, weights=None, epsilon=1e-12, method="auto", progress=None))]
fn points2alm<'py>(
    py: Python<'py>,
    points: &Bound<'py, PyAny>,
    lmax: &Bound<'py, PyAny>,
    weights: Option<&Bound<'py, PyAny>>,
    epsilon: f64,
    method: &str,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let (lmax, method) = (degree("lmax", lmax)?, self::method(method)?);
    let points = Numbers::real("points", points)?;
    let (sets, n) = match points.shape[..] {
        [n, 3] => (None, n),
        [m, n, 3] => (Some(m), n),
        _ => return Err(shape_error("points", "(n, 3) or (m, n, 3)", &points.shape)),
    };
    let weights = weights.map(|weights| Numbers::real("weights", weights)).transpose()?;
    if let Some(weights) = &weights {
        let of_each = sets.is_some_and(|m| weights.shape == [m, n]);
        if weights.shape != [n] && !of_each {
            let expected = sets.map_or(format!("({n},)"), |m| format!("({n},) or ({m}, {n})"));
            return Err(shape_error("weights", &expected, &weights.shape));
        }
    }
    let count = sets.unwrap_or(1);
    let len = LmIndex::new(lmax).map_err(of_error)?.len();
    let together = count.clamp(1, BATCH) as u64;
    // A thread for each batch at most; the lower bound is that of one.
    let bytes = method.bytes(n, lmax, together) + 16.0 * len as f64 * count as f64;
    check_size("points2alm", n, lmax, bytes)?;
    let transform = Transform::new(method, lmax, n, epsilon).map_err(of_error)?;
    let work = method.nominal_work(n, lmax);
    let values = run_sized(py, count as f64 * work, progress, move |watch| {
        watch.expect(count as f64 * work);
        let row = |k: usize| match sets {
            None => format!("points[{k}]"),
            Some(_) => format!("points[{}, {}]", k / n, k % n),
        };
        let vectors = directions(points.vectors(), &row)?;
        let weights = weights.as_ref().map(Numbers::all);
        if let Some(k) = weights.and_then(|w| w.iter().position(|w| !w.is_finite())) {
            let got = weights.map_or(f64::NAN, |w| w[k]);
            let index = if k < n { k.to_string() } else { format!("{}, {}", k / n, k % n) };
            return Err(value_error(format!(
                "weights[{index}]: expected a finite number, got {got:?}"
            )));
        }
        let inputs: Vec<(&[DVec3], Option<&[f64]>)> = (0..count)
            .map(|i| {
                let of_set = |w: &'_ [f64]| if w.len() > n { i * n..(i + 1) * n } else { 0..n };
                (&vectors[i * n..(i + 1) * n], weights.map(|w| &w[of_set(w)]))
            })
            .collect();
        let values = adjoints(&transform, &inputs, lmax, &|sets| {
            watch.tick(sets as f64 * work).map_err(|_| interrupted())
        })?;
        // Only weights make sums overflow.
        if values.iter().all(|a| a.is_finite()) {
            Ok(values)
        } else {
            Err(value_error("weights: their sums exceed the largest finite number"))
        }
    })?;
    let array = PyArray1::from_vec(py, values);
    match sets {
        None => Ok(array.into_any()),
        Some(m) => Ok(array.reshape([m, len])?.into_any()),
    }
}

/// Returns the coefficients of each of the sets, one after the other; `done` is told the number of
/// sets of a batch and may stop the work.
fn adjoints(
    transform: &Transform,
    sets: &[(&[DVec3], Option<&[f64]>)],
    lmax: usize,
    done: &(dyn Fn(usize) -> PyResult<()> + Sync),
) -> PyResult<Vec<Complex64>> {
    let batch = |workspace: &mut TransformWorkspace, sets: &[(&[DVec3], Option<&[f64]>)]| {
        let zeros = || Alm::zeros(lmax).map_err(of_error);
        let mut alms = sets.iter().map(|_| zeros()).collect::<PyResult<Vec<Alm>>>()?;
        transform.adjoint_batch_into(sets, workspace, &mut alms);
        done(sets.len())?;
        Ok::<Vec<Alm>, PyErr>(alms)
    };
    if sets.len() <= BATCH {
        let mut alms = batch(&mut TransformWorkspace::default(), sets)?;
        if alms.len() == 1 {
            return Ok(alms.swap_remove(0).into_values());
        }
        return Ok(alms.iter().flat_map(|alm| alm.values().iter().copied()).collect());
    }
    let len = LmIndex::new(lmax).map_err(of_error)?.len();
    let mut values = Vec::new();
    let total = len.saturating_mul(sets.len());
    values.try_reserve_exact(total).map_err(|error| PyMemoryError::new_err(error.to_string()))?;
    values.resize(total, Complex64::ZERO);
    let out = values.par_chunks_mut(BATCH * len).zip(sets.par_chunks(BATCH));
    out.try_for_each_init(TransformWorkspace::default, |workspace, (out, sets)| {
        for (out, alm) in out.chunks_exact_mut(len).zip(batch(workspace, sets)?) {
            out.copy_from_slice(alm.values());
        }
        Ok::<(), PyErr>(())
    })?;
    Ok(values)
}

/// Returns `sum_lm a_lm Y_lm(x)` at points of shape (..., 3).
#[pyfunction]
#[pyo3(signature = (alm, points, lmax=None, epsilon=1e-12, method="auto", progress=None))]
fn alm2points<'py>(
    py: Python<'py>,
    alm: &Bound<'py, PyAny>,
    points: &Bound<'py, PyAny>,
    lmax: Option<&Bound<'py, PyAny>>,
    epsilon: f64,
    method: &str,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let method = self::method(method)?;
    let alm = Numbers::<Complex64>::new("alm", alm, "fiuc", "numbers")?;
    if alm.shape.len() != 1 {
        return Err(shape_error("alm", "((lmax + 1)(lmax + 2)/2,)", &alm.shape));
    }
    let lmax = match lmax {
        None => degree_of(alm.len)?,
        Some(lmax) => {
            let lmax = degree("lmax", lmax)?;
            let expected = LmIndex::new(lmax).map_err(of_error)?.len();
            if alm.len != expected {
                let got = alm.len;
                return Err(of_error(Error::CoefficientCount { lmax, expected, got }));
            }
            lmax
        }
    };
    let points = Numbers::real("points", points)?;
    let shape = match &points.shape[..] {
        [shape @ .., 3] if !shape.is_empty() => shape.to_vec(),
        _ => return Err(shape_error("points", "(..., 3)", &points.shape)),
    };
    let n = points.len / 3;
    let bytes = method.bytes(n, lmax, 1) + 8.0 * n as f64;
    check_size("alm2points", n, lmax, bytes)?;
    let transform = Transform::new(method, lmax, n, epsilon).map_err(of_error)?;
    let work = method.nominal_work(n, lmax);
    let of_row = shape.clone();
    let values = run_sized(py, work, progress, move |watch| {
        watch.expect(work);
        let row = |k: usize| format!("points[{}]", unravelled(k, &of_row));
        let vectors = directions(points.vectors(), &row)?;
        let alm = coefficients(lmax, alm.all())?;
        let mut values = Vec::new();
        values.try_reserve_exact(n).map_err(|error| PyMemoryError::new_err(error.to_string()))?;
        values.resize(n, 0.0);
        let workspace = &mut TransformWorkspace::default();
        transform.synthesis_into(&alm, &vectors, workspace, &mut values);
        watch.tick(work).map_err(|_| interrupted())?;
        if !values.iter().all(|value| value.is_finite()) {
            return Err(value_error("alm: values exceed the largest finite number"));
        }
        Ok(values)
    })?;
    Ok(PyArray1::from_vec(py, values).reshape(shape)?.into_any())
}

/// Returns the coefficients of a real function. The imaginary parts for m = 0 have no effect.
fn coefficients(lmax: usize, values: &[Complex64]) -> PyResult<Alm> {
    if let Some(k) = values.iter().position(|a| !a.is_finite()) {
        let a = values[k];
        return Err(value_error(format!(
            "alm[{k}]: expected a finite number, got ({:?}, {:?})",
            a.re, a.im
        )));
    }
    let mut alm = Alm::from_values(lmax, values.to_vec()).map_err(of_error)?;
    alm.column_mut(0).iter_mut().for_each(|a| a.im = 0.0);
    Ok(alm)
}

/// Returns the largest degree of this number of coefficients.
fn degree_of(len: usize) -> PyResult<usize> {
    // (lmax + 1)(lmax + 2)/2 coefficients are between (lmax + 1)^2/2 and (lmax + 2)^2/2.
    let below = len.saturating_mul(2).isqrt().saturating_sub(2);
    let count = |lmax: usize| LmIndex::new(lmax).ok().map(LmIndex::len);
    (below..=below + 2).find(|lmax| count(*lmax) == Some(len)).ok_or_else(|| {
        value_error(format!(
            "alm: expected (lmax + 1)(lmax + 2)/2 coefficients, as 1, 3, 6 or 10, got {len}"
        ))
    })
}

/// Returns the indices of element k of an array of this shape.
fn unravelled(mut k: usize, shape: &[usize]) -> String {
    let mut indices = Vec::new();
    for size in shape.iter().rev() {
        indices.push((k % size.max(&1)).to_string());
        k /= size.max(&1);
    }
    indices.reverse();
    indices.join(", ")
}

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(points2alm, module)?)?;
    module.add_function(wrap_pyfunction!(alm2points, module)?)
}
