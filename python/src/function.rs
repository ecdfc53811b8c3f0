//! Callables as functions of direction.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use numpy::{PyArrayDyn, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::exceptions::{PyException, PyMemoryError, PyRecursionError, PyTypeError};
use pyo3::prelude::*;
use sphvar::glam::DVec3;
use sphvar::integrands::{Error, Integrand, VectorIntegrand};

use crate::arrays::{elements, of_directions, shape_text, unmasked};
use crate::errors::value_error;

/// The number of directions of a call at most.
const BATCH: usize = 1 << 16;

/// The first exception of the callables of a session. Errors of the library are texts, so the
/// exception itself waits here until the interpreter's thread raises it.
#[derive(Clone, Default)]
pub(crate) struct Failures {
    first: Arc<Mutex<Option<PyErr>>>,
    /// Whether nobody waits for values any more.
    is_closed: Arc<AtomicBool>,
}

impl Failures {
    /// Returns the exception, if there is one, and forgets it.
    pub(crate) fn take(&self) -> Option<PyErr> {
        self.first.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// Lets every later call fail, so that work that was given up ends.
    pub(crate) fn close(&self) {
        self.is_closed.store(true, Ordering::Relaxed);
    }

    fn exist(&self) -> bool {
        self.is_closed.load(Ordering::Relaxed)
            || self.first.lock().unwrap_or_else(PoisonError::into_inner).is_some()
    }

    fn keep(&self, error: PyErr) {
        self.first.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
    }
}

/// A callable that takes directions as an array of shape `(n, 3)` and returns their values, of shape
/// `(n,)`, or `(n, k)` for k components.
pub(crate) struct Function {
    callable: Py<PyAny>,
    /// Its name in messages.
    name: String,
    components: Option<usize>,
    failures: Failures,
}

impl Function {
    /// Returns the function after a call with five directions above the equator, which finds the
    /// number of components. A callable of a single direction, such as `lambda d: d[2]`, fails there.
    pub(crate) fn new(
        callable: &Bound<'_, PyAny>,
        name: String,
        failures: Failures,
    ) -> PyResult<Self> {
        if !callable.is_callable() {
            let kind = callable.get_type().name()?;
            return Err(PyTypeError::new_err(format!("{name}: expected a callable, got {kind}")));
        }
        let py = callable.py();
        let function =
            Self { callable: callable.clone().unbind(), name, components: None, failures };
        let components = function.components_of(py)?;
        Ok(Self { components, ..function })
    }

    /// Returns the number of values of a direction.
    pub(crate) fn components(&self) -> Option<usize> {
        self.components
    }

    fn components_of(&self, py: Python<'_>) -> PyResult<Option<usize>> {
        let probes = [
            DVec3::new(0.36, 0.48, 0.8),
            DVec3::new(-0.48, 0.6, 0.64),
            DVec3::new(0.0, -0.8, 0.6),
            DVec3::new(-0.8, -0.36, 0.48),
            DVec3::new(0.8, 0.0, 0.6),
        ];
        let values = self.returned(py, &probes)?;
        match *values.shape() {
            [5] => Ok(None),
            [5, components] => Ok(Some(components)),
            _ => Err(self.wrong_shape(py, &probes, values.shape())),
        }
    }

    /// Writes the values of a batch, direction by direction.
    fn batch(&self, py: Python<'_>, dirs: &[DVec3], values: &mut [f64]) -> PyResult<()> {
        let returned = self.returned(py, dirs)?;
        let is_right = match (self.components, returned.shape()) {
            (None, [n]) => *n == dirs.len(),
            (Some(components), [n, k]) => *n == dirs.len() && *k == components,
            _ => false,
        };
        if !is_right {
            return Err(self.wrong_shape(py, dirs, returned.shape()));
        }
        values.copy_from_slice(&elements("values", &returned.readonly())?);
        let width = self.components.unwrap_or(1);
        match values.iter().position(|value| !value.is_finite()) {
            None => Ok(()),
            Some(at) => {
                let value = match values[at] {
                    value if value.is_nan() => "nan",
                    value if value > 0.0 => "inf",
                    _ => "-inf",
                };
                let place = place(dirs[at / width]);
                let name = &self.name;
                let message =
                    format!("{name} returned {value} at {place}: every value must be finite");
                Err(value_error(message))
            }
        }
    }

    /// Calls the callable and returns its result as an array of `float64`.
    fn returned<'py>(
        &self,
        py: Python<'py>,
        dirs: &[DVec3],
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let result = match self.call(py, dirs) {
            Ok(result) => result,
            Err(error) => return Err(self.explained(py, dirs, error)),
        };
        if result.is_exact_instance_of::<PyUntypedArray>()
            && let Ok(array) = result.cast::<PyArrayDyn<f64>>()
        {
            return Ok(array.clone());
        }
        let array = unmasked(&format!("the values of {}", self.name), &result)?;
        let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
        if !"fiub".contains(&kind) {
            let dtype = array.getattr("dtype")?.str()?;
            let name = &self.name;
            let message = format!("{name} returned values of dtype {dtype}: expected real numbers");
            return Err(PyTypeError::new_err(message));
        }
        Ok(array.call_method1("astype", ("float64",))?.cast_into::<PyArrayDyn<f64>>()?)
    }

    fn call<'py>(&self, py: Python<'py>, dirs: &[DVec3]) -> PyResult<Bound<'py, PyAny>> {
        let points = of_directions(py, dirs)?;
        // A callable that changes its argument in place is told so.
        points.getattr("flags")?.setattr("writeable", false)?;
        self.callable.bind(py).call1((points,))
    }

    /// Returns the exception of a call with a note on the first direction that raises it alone, or
    /// for a function of a single direction the error that names the expected form.
    fn explained(&self, py: Python<'_>, dirs: &[DVec3], error: PyErr) -> PyErr {
        // A function that calls itself through this package without end would be called again by each
        // of its calls, which takes time without end too.
        if !error.is_instance_of::<PyException>(py)
            || error.is_instance_of::<PyRecursionError>(py)
            || error.is_instance_of::<PyMemoryError>(py)
        {
            return error;
        }
        if self.takes_single(py, dirs) {
            let vectorized = self.not_vectorized("raised an exception");
            vectorized.set_cause(py, Some(error));
            return vectorized;
        }
        let mut part = dirs;
        while part.len() > 1 {
            let (first, second) = part.split_at(part.len() / 2);
            part = match (self.call(py, first).is_err(), self.call(py, second).is_err()) {
                (true, _) => first,
                (_, true) => second,
                _ => break,
            };
        }
        let name = &self.name;
        let note = match (part, dirs) {
            ([dir], _) => format!("sphvar: {name} was called at {}", place(*dir)),
            (_, []) => return error,
            (_, [dir, ..]) => {
                let n = dirs.len();
                format!(
                    "sphvar: {name} was called with {n} directions, the first at {}",
                    place(*dir)
                )
            }
        };
        // Exceptions have notes from CPython 3.11 on.
        if error.value(py).call_method1("add_note", (&note,)).is_ok() {
            return error;
        }
        let noted = value_error(format!("{note}: {error}"));
        noted.set_cause(py, Some(error));
        noted
    }

    /// Returns whether the callable takes one direction, of shape `(3,)`, and returns a number.
    fn takes_single(&self, py: Python<'_>, dirs: &[DVec3]) -> bool {
        let Some(dir) = dirs.first() else { return false };
        let single = || -> PyResult<bool> {
            let point = of_directions(py, &[*dir])?.get_item(0)?;
            let result = self.callable.bind(py).call1((point,))?;
            let array = py.import("numpy")?.call_method1("asarray", (result,))?;
            let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
            Ok(array.getattr("ndim")?.extract::<usize>()? == 0 && "fiub".contains(&kind))
        };
        single().unwrap_or(false)
    }

    fn wrong_shape(&self, py: Python<'_>, dirs: &[DVec3], shape: &[usize]) -> PyErr {
        let n = dirs.len();
        let shape = shape_text(shape);
        let expected = match self.components {
            Some(components) => format!("({n}, {components})"),
            None => format!("({n},)"),
        };
        let got = format!("returned shape {shape} for {n} directions, expected {expected}");
        if self.takes_single(py, dirs) {
            return self.not_vectorized(&got);
        }
        value_error(format!("{} {got}; the first direction is {}", self.name, place(dirs[0])))
    }

    fn not_vectorized(&self, what: &str) -> PyErr {
        value_error(format!(
            "{} {what}: the function must be vectorized; it is called with an array of shape (n, 3) and \
             returns n values, as lambda points: points[:, 2] does",
            self.name
        ))
    }

    fn eval_width(&self, dirs: &[DVec3], values: &mut [f64], width: usize) -> Result<(), Error> {
        for (dirs, values) in dirs.chunks(BATCH).zip(values.chunks_mut(BATCH * width)) {
            let failed = |reason: String| Err(Error::Evaluation { reason });
            if self.failures.exist() {
                return failed(format!("{} has failed", self.name));
            }
            let result = Python::attach(|py| {
                self.batch(py, dirs, values).map_err(|error| {
                    let reason = error.to_string();
                    self.failures.keep(error);
                    reason
                })
            });
            if let Err(reason) = result {
                return failed(reason);
            }
        }
        Ok(())
    }
}

impl Integrand for Function {
    /// Returns NaN where the callable fails, and keeps its exception.
    fn eval(&self, dir: DVec3) -> f64 {
        let mut value = [f64::NAN];
        match self.eval_width(&[dir], &mut value, 1) {
            Ok(()) => value[0],
            Err(_) => f64::NAN,
        }
    }

    fn eval_into(&self, dirs: &[DVec3], values: &mut [f64]) -> Result<(), Error> {
        self.eval_width(dirs, values, 1)
    }
}

impl VectorIntegrand for Function {
    fn components(&self) -> usize {
        self.components.unwrap_or(1)
    }

    fn eval_into(&self, dirs: &[DVec3], values: &mut [f64]) -> Result<(), Error> {
        self.eval_width(dirs, values, self.components.unwrap_or(1))
    }
}

/// Returns a direction in words.
fn place(dir: DVec3) -> String {
    let (theta, phi) = (dir.z.clamp(-1.0, 1.0).acos(), dir.y.atan2(dir.x));
    format!(
        "({}, {}, {}), theta = {:.4}, phi = {:.4} degrees",
        dir.x,
        dir.y,
        dir.z,
        theta.to_degrees(),
        phi.to_degrees().rem_euclid(360.0)
    )
}
