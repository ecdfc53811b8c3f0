//! Questions to the command with arrays and callables in place of files.

use std::sync::{Arc, PoisonError, RwLock};

use numpy::{Complex64, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use sphvar::glam::DVec3;
use sphvar::integrands::{
    Circle, DeferredFunction, Domain, Integrand, SampledFunction, Tolerance, VectorIntegrand,
};
use sphvar::samplers::{Progress, Stopped};
use sphvar_cli::embedding::{self, PointTable};

use crate::arrays::{
    check_copy, elements, float_array, floats, of_directions, of_floats, reserved, rows,
    shape_error, unmasked, zeros,
};
use crate::errors::{of_failure, runtime_error, value_error};
use crate::function::{Failures, Function};
use crate::transforms::degree;
use crate::work;

/// The progress of the run of a session that is under way.
#[derive(Default)]
struct Relay(RwLock<Option<Arc<work::Watch>>>);

impl Relay {
    fn set(&self, watch: Option<Arc<work::Watch>>) {
        *self.0.write().unwrap_or_else(PoisonError::into_inner) = watch;
    }

    fn with<T>(&self, action: impl FnOnce(&work::Watch) -> T) -> Option<T> {
        self.0.read().unwrap_or_else(PoisonError::into_inner).as_deref().map(action)
    }
}

impl Progress for Relay {
    fn tick(&self, work: f64) -> Result<(), Stopped> {
        self.with(|watch| watch.tick(work)).unwrap_or(Ok(()))
    }

    fn expect(&self, work: f64) {
        self.with(|watch| watch.expect(work));
    }
}

/// What questions read besides files: arrays and callables by name.
///
/// Names have precedence over files. Arrays are copied. `progress` is called with the work done and
/// expected.
#[pyclass(module = "sphvar._sphvar", frozen)]
pub(crate) struct Session {
    inner: embedding::Session,
    relay: Arc<Relay>,
    failures: Failures,
    progress: Option<Py<PyAny>>,
}

#[pymethods]
impl Session {
    #[new]
    #[pyo3(signature = (progress = None))]
    fn new(progress: Option<Py<PyAny>>) -> Self {
        let relay = Arc::new(Relay::default());
        let inner = embedding::Session::new(Arc::clone(&relay) as _);
        Self { inner, relay, failures: Failures::default(), progress }
    }

    /// Add directions of shape (n, 3), or (m, n, 3) for m sets, as `file:name`.
    #[pyo3(signature = (name, points, weights = None, values = None, errors = None))]
    fn add_points(
        &self,
        name: &str,
        points: &Bound<'_, PyAny>,
        weights: Option<&Bound<'_, PyAny>>,
        values: Option<&Bound<'_, PyAny>>,
        errors: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let table = table(points, 3, [weights, values, errors])?;
        self.inner.add_points(name, table).map_err(of_failure)
    }

    /// Add points of the unit square of shape (n, 2), or (m, n, 2) for m sets, as `file:name`.
    #[pyo3(signature = (name, points, weights = None))]
    fn add_square_points(
        &self,
        name: &str,
        points: &Bound<'_, PyAny>,
        weights: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let table = table(points, 2, [weights, None, None])?;
        self.inner.add_points(name, table).map_err(of_failure)
    }

    /// Add a picture of linear values of shape (h, w) or (h, w, 3), rows from the top, as `env:name`.
    fn add_picture(&self, name: &str, texels: &Bound<'_, PyAny>) -> PyResult<()> {
        let texels = float_array("image", texels)?;
        let (height, width) = match *texels.shape() {
            [height, width] | [height, width, 3] => (height, width),
            _ => return Err(shape_error("image", "(h, w) or (h, w, 3)", texels.shape())),
        };
        let texels = elements("image", &texels)?;
        self.inner.add_picture(name, width, height, texels).map_err(of_failure)
    }

    /// Add a HEALPix map as `map:name`.
    #[pyo3(signature = (name, values, nest = false))]
    fn add_map(&self, name: &str, values: &Bound<'_, PyAny>, nest: bool) -> PyResult<()> {
        self.inner.add_map(name, floats("map", values)?, nest).map_err(of_failure)
    }

    /// Add coefficients in the order of healpy as `alm:name`.
    fn add_coefficients(&self, name: &str, alm: &Bound<'_, PyAny>) -> PyResult<()> {
        let alm = complex("alm", alm)?;
        if alm.ndim() != 1 {
            return Err(shape_error("alm", "(n,)", alm.shape()));
        }
        let alm: Vec<[f64; 2]> = alm.as_array().iter().map(|a| [a.re, a.im]).collect();
        self.inner.add_coefficients(name, &alm).map_err(of_failure)
    }

    /// Add energies per degree from 0, with their standard errors, as `energy:name`.
    #[pyo3(signature = (name, energies, errors = None))]
    fn add_energies(
        &self,
        name: &str,
        energies: &Bound<'_, PyAny>,
        errors: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let energies = floats("energies", energies)?;
        let errors = errors.map(|errors| floats("errors", errors)).transpose()?;
        self.inner.add_energies(name, energies, errors).map_err(of_failure)
    }

    /// Add powers per degree from 0, with their standard errors, as the spectrum `name`;
    /// `realizations` is 0 if their number is unknown.
    fn add_spectrum(
        &self,
        name: &str,
        power: &Bound<'_, PyAny>,
        stderr: &Bound<'_, PyAny>,
        realizations: u64,
    ) -> PyResult<()> {
        let (power, stderr) = (floats("power", power)?, floats("stderr", stderr)?);
        self.inner.add_spectrum(name, &power, &stderr, realizations).map_err(of_failure)
    }

    /// Add a callable as `function:name`; `label` names it in messages.
    ///
    /// With `degree`, energies are those of a polynomial of this degree between the `edges`, circles
    /// as pairs of an axis and an angle in degrees. Otherwise they are found to a tolerance, on the
    /// upper hemisphere alone if `hemisphere` is true.
    #[pyo3(signature = (
        name, callable, label, *, degree = None, edges = None, tolerance = None,
        min_evaluations = None, max_evaluations = None, hemisphere = false
    ))]
    #[expect(clippy::too_many_arguments, reason = "keywords")]
    fn add_function(
        &self,
        name: &str,
        callable: &Bound<'_, PyAny>,
        label: String,
        degree: Option<usize>,
        edges: Option<Vec<([f64; 3], f64)>>,
        tolerance: Option<f64>,
        min_evaluations: Option<usize>,
        max_evaluations: Option<usize>,
        hemisphere: bool,
    ) -> PyResult<()> {
        let function = self.function(callable, label.clone())?;
        if let Some(components) = function.components() {
            return Err(value_error(format!(
                "{label} returned {components} values for a direction, expected one: shape (n,)"
            )));
        }
        let function: Arc<dyn Integrand + Send + Sync> = match degree {
            Some(degree) => {
                let mut sampled = SampledFunction::new(function, degree);
                for (axis, degrees) in edges.unwrap_or_default() {
                    sampled = sampled.with_edge(edge(&label, axis, degrees)?);
                }
                Arc::new(sampled)
            }
            None => {
                let base = Tolerance::default();
                let tolerance = Tolerance {
                    relative: tolerance.unwrap_or(base.relative),
                    min_evaluations: min_evaluations.unwrap_or(base.min_evaluations),
                    max_evaluations: max_evaluations.unwrap_or(base.max_evaluations),
                };
                let shared = Shared(Arc::new(function));
                let wrong = |error| value_error(format!("{label}: {error}"));
                let deferred = DeferredFunction::new(shared, tolerance).map_err(wrong)?;
                Arc::new(if hemisphere { deferred.above_equator() } else { deferred })
            }
        };
        self.inner.add_function(name, function);
        Ok(())
    }

    /// Add a callable of which only values are needed as `function:name`.
    fn add_values_function(
        &self,
        name: &str,
        callable: &Bound<'_, PyAny>,
        label: String,
    ) -> PyResult<Option<usize>> {
        let function = self.function(callable, label)?;
        let components = function.components();
        self.inner.add_function(name, Arc::new(function));
        Ok(components)
    }

    /// Return the JSON document of the command for the words after its name.
    fn answer(&self, py: Python<'_>, words: Vec<String>) -> PyResult<String> {
        self.run(py, move |session| session.answer(&words).map_err(of_failure))
    }

    /// Return the messages of all answers.
    fn remarks(&self) -> Vec<String> {
        self.inner.remarks()
    }

    /// Return the values of an integrand at directions of shape (n, 3).
    fn evaluate<'py>(
        &self,
        py: Python<'py>,
        integrand: String,
        points: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let points = directions("points", points)?;
        // Only the interpreter's lock lets a callable run, so no other thread would help.
        let is_callable = integrand.starts_with("function:") && !integrand.contains(' ');
        let task = move |session: &embedding::Session| {
            let integrand = session.integrand(&integrand).map_err(of_failure)?;
            let mut values = zeros(points.len())?;
            integrand.eval_into(&points, &mut values).map_err(runtime_error)?;
            Ok(values)
        };
        let values = if is_callable {
            self.unless_failed(work::short(|| task(&self.inner)))?
        } else {
            self.run(py, task)?
        };
        Ok(of_floats(py, &values).into_any())
    }

    /// Return the energies of an integrand to degree `lmax` and their errors, or None.
    fn energies<'py>(
        &self,
        py: Python<'py>,
        integrand: String,
        lmax: &Bound<'py, PyAny>,
        hemisphere: bool,
    ) -> PyResult<(Bound<'py, PyAny>, Option<Bound<'py, PyAny>>)> {
        let (domain, lmax) = (domain(hemisphere), degree("lmax", lmax)?);
        let energy = self
            .run(py, move |session| session.energy(&integrand, domain, lmax).map_err(of_failure))?;
        let errors = energy.per_band_stderr().map(|errors| of_floats(py, errors).into_any());
        Ok((of_floats(py, energy.per_band()).into_any(), errors))
    }

    /// Integrate with the words of the command `integrate`, or a callable of several components in
    /// place of the integrand that they name.
    #[pyo3(signature = (words, vector = None, label = None))]
    fn integrate(
        &self,
        py: Python<'_>,
        words: Vec<String>,
        vector: Option<&Bound<'_, PyAny>>,
        label: Option<String>,
    ) -> PyResult<Integral> {
        let label = label.unwrap_or_else(|| "the function".to_owned());
        let vector = vector.map(|callable| self.function(callable, label)).transpose()?;
        let inner = self.run(py, move |session| {
            let vector = vector.as_ref().map(|function| function as &dyn VectorIntegrand);
            session.integrate(&words, vector).map_err(of_failure)
        })?;
        Ok(Integral { inner })
    }
}

impl Session {
    fn function(&self, callable: &Bound<'_, PyAny>, label: String) -> PyResult<Function> {
        Function::new(callable, label, self.failures.clone())
    }

    /// Runs a task with the progress of this session. The exception of a callable is that of the
    /// task, whatever the library made of it.
    pub(crate) fn run<T, F>(&self, py: Python<'_>, task: F) -> PyResult<T>
    where
        T: Send + 'static,
        F: FnOnce(&embedding::Session) -> PyResult<T> + Send + 'static,
    {
        let (inner, relay) = (self.inner.clone(), Arc::clone(&self.relay));
        let progress = self.progress.as_ref().map(|progress| progress.bind(py));
        let result = work::run(py, progress, move |watch| {
            relay.set(Some(Arc::clone(watch)));
            let result = task(&inner);
            relay.set(None);
            result
        });
        // Work that was given up must not go on to call functions.
        if self.relay.with(|_| ()).is_some() {
            self.failures.close();
        }
        self.unless_failed(result)
    }

    /// Returns a result, or the exception of a callable.
    fn unless_failed<T>(&self, result: PyResult<T>) -> PyResult<T> {
        match self.failures.take() {
            Some(error) => Err(error),
            None => result,
        }
    }
}

/// A callable that a deferred function clones.
#[derive(Clone)]
struct Shared(Arc<Function>);

impl Integrand for Shared {
    fn eval(&self, dir: DVec3) -> f64 {
        self.0.eval(dir)
    }

    fn eval_into(
        &self,
        dirs: &[DVec3],
        values: &mut [f64],
    ) -> Result<(), sphvar::integrands::Error> {
        Integrand::eval_into(&*self.0, dirs, values)
    }
}

/// The result of an integration.
#[pyclass(module = "sphvar._sphvar", frozen)]
struct Integral {
    inner: embedding::Integration,
}

#[pymethods]
impl Integral {
    /// The JSON document of the command.
    #[getter]
    fn document(&self) -> &str {
        &self.inner.document
    }

    /// The values and the errors of all components.
    fn estimates<'py>(&self, py: Python<'py>) -> (Bound<'py, PyAny>, Bound<'py, PyAny>) {
        let values = of_floats(py, &self.inner.values).into_any();
        (values, of_floats(py, &self.inner.errors).into_any())
    }

    /// Why the tolerance is not met, or None.
    #[getter]
    fn failure(&self) -> Option<&str> {
        self.inner.failure.as_deref()
    }

    /// The nodes and their weights.
    fn nodes<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let nodes = self.inner.nodes().map_err(of_failure)?;
        let points = of_directions(py, &nodes.points)?.into_any();
        Ok((points, of_floats(py, &nodes.weights).into_any()))
    }
}

fn domain(hemisphere: bool) -> Domain {
    if hemisphere { Domain::Hemisphere } else { Domain::Sphere }
}

/// Returns points with coordinates, and weights, values and errors.
fn table(
    points: &Bound<'_, PyAny>,
    dimension: usize,
    columns: [Option<&Bound<'_, PyAny>>; 3],
) -> PyResult<PointTable> {
    let array = float_array("points", points)?;
    let sets = match *array.shape() {
        [_, d] if d == dimension => None,
        [sets, _, d] if d == dimension => Some(sets),
        _ => {
            let expected = format!("(n, {dimension}) or (m, n, {dimension})");
            return Err(shape_error("points", &expected, array.shape()));
        }
    };
    // The array, and the points that are read from it.
    check_copy::<[f64; 2]>("points", array.len())?;
    let column = |name: &str, column: Option<&Bound<'_, PyAny>>| -> PyResult<Option<Vec<f64>>> {
        let Some(column) = column else { return Ok(None) };
        let numbers = float_array(name, column)?;
        let per_point = &array.shape()[..array.ndim() - 1];
        if numbers.shape() == per_point {
            return Ok(Some(elements(name, &numbers)?));
        }
        // One row of weights is that of every set.
        if let (Some(sets), [n]) = (sets, numbers.shape())
            && per_point[1] == *n
        {
            check_copy::<f64>(name, n.saturating_mul(sets))?;
            return Ok(Some(elements(name, &numbers)?.repeat(sets)));
        }
        let expected: Vec<String> = per_point.iter().map(usize::to_string).collect();
        let comma = if expected.len() == 1 { "," } else { "" };
        Err(shape_error(name, &format!("({}{comma})", expected.join(", ")), numbers.shape()))
    };
    let [weights, values, errors] = columns;
    Ok(PointTable {
        coordinates: elements("points", &array)?,
        dimension,
        sets,
        weights: column("weights", weights)?,
        values: column("values", values)?,
        errors: column("errors", errors)?,
    })
}

/// Returns unit vectors of an array of shape (n, 3).
fn directions(name: &str, object: &Bound<'_, PyAny>) -> PyResult<Vec<DVec3>> {
    /// The deviation of a length from 1 up to which a vector is a direction.
    const TOLERANCE: f64 = 1e-6;
    let numbers = rows(name, object, 3)?;
    check_copy::<f64>(name, numbers.len())?;
    let rows = numbers.as_chunks().0;
    let mut all = reserved(rows.len())?;
    for (i, row) in rows.iter().enumerate() {
        let dir = DVec3::from_array(*row);
        let length = dir.length();
        let is_unit = (length - 1.0).abs() <= TOLERANCE;
        if !is_unit {
            return Err(value_error(format!(
                "{name}[{i}] = ({}, {}, {}) is not a unit vector: its length is {length}",
                dir.x, dir.y, dir.z
            )));
        }
        // A unit vector to rounding keeps its bits.
        let is_exact = (length - 1.0).abs() <= 2.0 * f64::EPSILON;
        all.push(if is_exact { dir } else { dir / length });
    }
    Ok(all)
}

fn edge(label: &str, axis: [f64; 3], degrees: f64) -> PyResult<Circle> {
    let axis = DVec3::from_array(axis);
    match axis.try_normalize() {
        Some(axis) if (0.0..=180.0).contains(&degrees) => {
            Ok(Circle { axis, angle: degrees.to_radians() })
        }
        _ => Err(value_error(format!(
            "{label}: an edge is an axis of positive length and an angle in [0, 180] degrees, got \
             ({}, {}, {}) and {degrees}",
            axis.x, axis.y, axis.z
        ))),
    }
}

/// Returns an array-like object as an array of `complex128`.
fn complex<'py>(
    name: &str,
    object: &Bound<'py, PyAny>,
) -> PyResult<PyReadonlyArrayDyn<'py, Complex64>> {
    let array = unmasked(name, object)?;
    let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
    if !"fiuc".contains(&kind) {
        let dtype = array.getattr("dtype")?.str()?;
        return Err(PyTypeError::new_err(format!(
            "{name}: expected an array of complex numbers, got one of dtype {dtype}"
        )));
    }
    check_copy::<Complex64>(name, array.getattr("size")?.extract()?)?;
    let array = array.call_method1("astype", ("complex128",))?;
    Ok(array.cast::<PyArrayDyn<Complex64>>()?.readonly())
}

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Session>()?;
    module.add_class::<Integral>()
}
