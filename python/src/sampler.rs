//! The numbered sets of samplers of directions, of the unit square and of rotations as arrays.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use numpy::PyUntypedArrayMethods;
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use pyo3::types::PyList;
use rayon::prelude::*;
use sphvar::glam::{DQuat, DVec3};
use sphvar::samplers::{Error, PointSet, Progress, SECONDS_PER_WORK};
use sphvar_cli::embedding::{
    DrawRequest, Draws, Failure, GivenSets, PointTable, RotationFormat, Session, check_memory,
};

use crate::arrays::{elements, float_array, of_shape, sets, shape_error, shape_text, zeros};
use crate::errors::{of_failure, runtime_error, value_error};
use crate::work::{self, Watch, interrupted};

/// The name by which a sampler refers to the array that it was made of.
const ARRAY: &str = "points";

/// Results of fewer bytes are allocated without a look at the available memory, which takes longer.
const SMALL_BYTES: f64 = (64 << 20) as f64;

/// The nominal work for each point up to which a sampler is one that generates point by point. Others
/// may use the pool of threads.
const MAX_LINEAR_WORK: f64 = 16.0;

/// The expected time of the sets that a thread generates before others may take over, in seconds.
const SECONDS_PER_PART: f64 = 50e-6;

/// A point as numbers of an array.
trait Row: Copy + Default + Send + Sync + 'static {
    /// The options beside the point that decide its numbers.
    type Form: Copy + Send + Sync + 'static;

    /// Returns the shape of a point in an array.
    fn shape(form: Self::Form) -> Vec<usize>;

    /// Writes the numbers of points.
    fn write(form: Self::Form, points: &[Self], numbers: &mut [f64]);

    /// Returns the numbers of points.
    fn numbers(form: Self::Form, points: Vec<Self>) -> Vec<f64>;
}

impl Row for DVec3 {
    type Form = ();

    fn shape((): ()) -> Vec<usize> {
        vec![3]
    }

    fn write((): (), points: &[Self], numbers: &mut [f64]) {
        for (row, point) in numbers.as_chunks_mut().0.iter_mut().zip(points) {
            *row = point.to_array();
        }
    }

    /// Reuses the memory of the points.
    fn numbers((): (), points: Vec<Self>) -> Vec<f64> {
        let rows: Vec<[f64; 3]> = points.into_iter().map(|point| point.to_array()).collect();
        rows.into_flattened()
    }
}

impl Row for [f64; 2] {
    type Form = ();

    fn shape((): ()) -> Vec<usize> {
        vec![2]
    }

    fn write((): (), points: &[Self], numbers: &mut [f64]) {
        numbers.copy_from_slice(points.as_flattened());
    }

    fn numbers((): (), points: Vec<Self>) -> Vec<f64> {
        points.into_flattened()
    }
}

impl Row for DQuat {
    type Form = RotationFormat;

    fn shape(format: RotationFormat) -> Vec<usize> {
        match format {
            RotationFormat::Quaternions => vec![4],
            RotationFormat::Matrices => vec![3, 3],
            RotationFormat::Euler | RotationFormat::EulerDegrees => vec![3],
        }
    }

    fn write(format: RotationFormat, points: &[Self], numbers: &mut [f64]) {
        for (to, from) in numbers.iter_mut().zip(points.iter().flat_map(|q| format.numbers(*q))) {
            *to = from;
        }
    }

    fn numbers(format: RotationFormat, points: Vec<Self>) -> Vec<f64> {
        points.iter().flat_map(|q| format.numbers(*q)).collect()
    }
}

/// Sets of points in C order.
struct Drawn {
    points: Vec<f64>,
    /// One weight for each point; empty if no set has weights.
    weights: Vec<f64>,
    n_points: usize,
}

/// Sets that differ in their numbers of points, or are alike.
enum Sets {
    Equal(Drawn),
    Different(Vec<Drawn>),
}

/// Draws `count` sets from number `first`, on the pool of threads if it is called there.
fn draw<P: Row>(
    draws: &Draws<P>,
    form: P::Form,
    first: u64,
    count: usize,
    given: GivenSets,
    progress: &dyn Progress,
) -> PyResult<Sets> {
    let realize = |index: usize, set: &mut PointSet<P>| {
        let result = draws.realize_into(first + index as u64, given, set, progress);
        result.map_err(|error| of_samplers(&error))
    };
    let own = |set: PointSet<P>| Drawn {
        n_points: set.points.len(),
        points: P::numbers(form, set.points),
        weights: set.weights,
    };
    if count == 1 {
        let mut set = PointSet::default();
        realize(0, &mut set)?;
        return Ok(Sets::Equal(own(set)));
    }
    let n = draws.n_points();
    let width: usize = P::shape(form).iter().product();
    let (mut points, mut weights) = (zeros(n * width * count)?, zeros(n * count)?);
    let n_weighted = AtomicUsize::new(0);
    // The sets whose number of points is not that of the sampler.
    let others = Mutex::new(BTreeMap::new());
    let write = |index: usize, set: &mut PointSet<P>, (rows, w): (&mut [f64], &mut [f64])| {
        realize(index, set)?;
        if set.points.len() == n {
            P::write(form, &set.points, rows);
            // Without weights, no page of theirs takes memory.
            if !set.weights.is_empty() {
                w.copy_from_slice(&set.weights);
                n_weighted.fetch_add(1, Ordering::Relaxed);
            }
        } else {
            let set = own(std::mem::take(set));
            others.lock().unwrap_or_else(PoisonError::into_inner).insert(index, set);
        }
        Ok::<(), PyErr>(())
    };
    if rayon::current_thread_index().is_some() {
        points
            .par_chunks_exact_mut(n * width)
            .zip(weights.par_chunks_exact_mut(n))
            .enumerate()
            .with_min_len(sets_of_a_part(draws.nominal_work()))
            .try_for_each_init(PointSet::default, |set, (index, rows)| write(index, set, rows))?;
    } else {
        let mut set = PointSet::default();
        let rows = points.chunks_exact_mut(n * width).zip(weights.chunks_exact_mut(n));
        rows.enumerate().try_for_each(|(index, rows)| write(index, &mut set, rows))?;
    }
    let n_weighted = n_weighted.into_inner();
    let mut others = others.into_inner().unwrap_or_else(PoisonError::into_inner);
    if n_weighted == 0 && others.values().all(|set| set.weights.is_empty()) {
        weights = Vec::new();
    } else if n_weighted < count {
        // As in files, points of sets without weights have weight 1 if others have weights.
        for row in weights.chunks_exact_mut(n).filter(|row| row.iter().all(|w| *w == 0.0)) {
            row.fill(1.0);
        }
    }
    if others.is_empty() {
        return Ok(Sets::Equal(Drawn { points, weights, n_points: n }));
    }
    let has_weights = !weights.is_empty();
    let mut all = Vec::new();
    for (index, rows) in points.chunks_exact(n * width).enumerate() {
        let mut set = others.remove(&index).unwrap_or_else(|| Drawn {
            points: rows.to_vec(),
            weights: weights.get(index * n..(index + 1) * n).unwrap_or_default().to_vec(),
            n_points: n,
        });
        if has_weights && set.weights.is_empty() {
            set.weights = vec![1.0; set.n_points];
        }
        all.push(set);
    }
    let n_points = all[0].n_points;
    if all.iter().any(|set| set.n_points != n_points) {
        return Ok(Sets::Different(all));
    }
    Ok(Sets::Equal(Drawn {
        points: all.iter().flat_map(|set| &set.points).copied().collect(),
        weights: all.iter().flat_map(|set| &set.weights).copied().collect(),
        n_points,
    }))
}

/// Returns the number of sets that a thread generates before others may take over.
fn sets_of_a_part(nominal_work: f64) -> usize {
    let sets = SECONDS_PER_PART / (SECONDS_PER_WORK * nominal_work.max(1.0));
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "from 1 to a thousand"
    )]
    let sets = sets.max(1.0) as usize;
    sets
}

fn of_samplers(error: &Error) -> PyErr {
    match error {
        Error::Stopped(_) => interrupted(),
        Error::OutOfMemory { .. } => PyMemoryError::new_err(error.to_string()),
        other => runtime_error(other),
    }
}

/// Returns `count` sets as an array of shape `(count, n, ...)` and their weights as one of shape
/// `(count, n)` or `None`; lists of arrays if the sets differ in their numbers of points.
fn in_arrays<'py>(
    py: Python<'py>,
    sets: Sets,
    count: usize,
    point: &[usize],
) -> PyResult<(Bound<'py, PyAny>, Option<Bound<'py, PyAny>>)> {
    let arrays = |set: Drawn, leading: &[usize]| {
        let shape = [leading, &[set.n_points], point].concat();
        let points = of_shape(py, set.points, &shape)?.into_any();
        let weights = (!set.weights.is_empty())
            .then(|| of_shape(py, set.weights, &shape[..=leading.len()]))
            .transpose()?;
        Ok::<_, PyErr>((points, weights.map(Bound::into_any)))
    };
    match sets {
        Sets::Equal(set) => arrays(set, &[count]),
        Sets::Different(all) => {
            let (points, weights) = (PyList::empty(py), PyList::empty(py));
            for set in all {
                let (of_set, of_points) = arrays(set, &[])?;
                points.append(of_set)?;
                if let Some(of_points) = of_points {
                    weights.append(of_points)?;
                }
            }
            let weights = (!weights.is_empty()).then(|| weights.into_any());
            Ok((points.into_any(), weights))
        }
    }
}

/// The sets of a sampler of one kind.
enum Source {
    Directions(Draws),
    Square(Draws<[f64; 2]>),
    Rotations(Draws<DQuat>, RotationFormat),
}

impl Source {
    /// Returns the sampler, its numbers of points and of given sets, the nominal work of a set and the
    /// shape of a point.
    fn properties(&self) -> (&str, usize, Option<usize>, f64, Vec<usize>) {
        fn of<P: Row>(
            draws: &Draws<P>,
            form: P::Form,
        ) -> (&str, usize, Option<usize>, f64, Vec<usize>) {
            let work = draws.nominal_work();
            (draws.sampler(), draws.n_points(), draws.n_given(), work, P::shape(form))
        }
        match self {
            Self::Directions(draws) => of(draws, ()),
            Self::Square(draws) => of(draws, ()),
            Self::Rotations(draws, format) => of(draws, *format),
        }
    }

    fn draw(
        &self,
        first: u64,
        count: usize,
        given: GivenSets,
        progress: &dyn Progress,
    ) -> PyResult<Sets> {
        match self {
            Self::Directions(draws) => draw(draws, (), first, count, given, progress),
            Self::Square(draws) => draw(draws, (), first, count, given, progress),
            Self::Rotations(draws, format) => draw(draws, *format, first, count, given, progress),
        }
    }
}

/// The numbered sets of a sampler: set i is a function of the arguments and i alone.
#[pyclass(module = "sphvar._sphvar", frozen)]
struct NumberedSets {
    source: Arc<Source>,
    sampler: String,
    n_points: usize,
    n_given: Option<usize>,
    nominal_work: f64,
    point: Vec<usize>,
    remarks: Vec<String>,
}

/// What kind of points a sampler has.
#[derive(Clone, Copy)]
enum Kind {
    Directions,
    Square,
    Rotations(RotationFormat),
}

impl Kind {
    fn of(name: &str) -> PyResult<Self> {
        Ok(match name {
            "directions" => Self::Directions,
            "square" => Self::Square,
            "quaternions" => Self::Rotations(RotationFormat::Quaternions),
            "matrices" => Self::Rotations(RotationFormat::Matrices),
            "euler" => Self::Rotations(RotationFormat::Euler),
            "euler-degrees" => Self::Rotations(RotationFormat::EulerDegrees),
            _ => {
                return Err(value_error(format!(
                    "unknown format `{name}`; valid: quaternions, matrices, euler, euler-degrees"
                )));
            }
        })
    }

    fn source(self, session: &Session, request: &DrawRequest) -> Result<Source, Failure> {
        Ok(match self {
            Self::Directions => Source::Directions(session.directions(request)?),
            Self::Square => Source::Square(session.square_points(request)?),
            Self::Rotations(format) => Source::Rotations(session.rotations(request)?, format),
        })
    }
}

/// Returns given points as a table.
fn table(
    kind: Kind,
    points: &Bound<'_, PyAny>,
    weights: Option<&Bound<'_, PyAny>>,
) -> PyResult<PointTable> {
    let dimension = if matches!(kind, Kind::Square) { 2 } else { 3 };
    let (coordinates, shape) = sets("points", points, dimension)?;
    let weights = weights.map(|weights| {
        let array = float_array("weights", weights)?;
        if array.shape() != shape {
            return Err(shape_error("weights", &shape_text(&shape), array.shape()));
        }
        elements("weights", &array)
    });
    Ok(PointTable {
        coordinates,
        dimension,
        sets: (shape.len() == 2).then(|| shape[0]),
        weights: weights.transpose()?,
        ..PointTable::default()
    })
}

#[pymethods]
impl NumberedSets {
    #[new]
    #[expect(clippy::too_many_arguments, reason = "the options of the command")]
    fn new(
        py: Python<'_>,
        kind: &str,
        sampler: String,
        n: Option<usize>,
        seed: u64,
        hemisphere: bool,
        is_randomized: bool,
        nearest: bool,
        points: Option<&Bound<'_, PyAny>>,
        weights: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let kind = Kind::of(kind)?;
        let table = points.map(|points| table(kind, points, weights)).transpose()?;
        let request = DrawRequest { sampler, n, nearest, hemisphere, is_randomized, seed };
        work::run(py, None, move |watch| {
            let progress: Arc<Watch> = Arc::clone(watch);
            let session = Session::new(progress);
            if let Some(table) = table {
                session.add_points(ARRAY, table).map_err(of_failure)?;
            }
            let source = kind.source(&session, &request).map_err(of_failure)?;
            let (sampler, n_points, n_given, nominal_work, point) = source.properties();
            Ok(Self {
                sampler: sampler.to_owned(),
                n_points,
                n_given,
                nominal_work,
                point,
                remarks: session.remarks(),
                source: Arc::new(source),
            })
        })
    }

    /// The sampler with its parameters.
    #[getter]
    fn sampler(&self) -> &str {
        &self.sampler
    }

    /// The number of points of every set; where it varies, the requested or the mean number.
    #[getter]
    fn n_points(&self) -> usize {
        self.n_points
    }

    /// The number of given sets, or None.
    #[getter]
    fn n_given(&self) -> Option<usize> {
        self.n_given
    }

    /// What the command would print on files and numbers of points.
    #[getter]
    fn remarks(&self) -> Vec<String> {
        self.remarks.clone()
    }

    /// Returns sets and their weights or None.
    fn draw<'py>(
        &self,
        py: Python<'py>,
        first: u64,
        count: usize,
        in_order: bool,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<(Bound<'py, PyAny>, Option<Bound<'py, PyAny>>)> {
        let n = self.n_points;
        let total = n as f64 * count as f64;
        let width: usize = self.point.iter().product();
        let bytes = size_of::<f64>() as f64 * width as f64 * total;
        if bytes > SMALL_BYTES {
            check_memory(&format!("{count} sets of {n} points"), bytes).map_err(of_failure)?;
        }
        let given = if in_order { GivenSets::InOrder } else { GivenSets::Drawn };
        let work = if in_order { 0.0 } else { count as f64 * self.nominal_work };
        let is_linear = self.nominal_work <= MAX_LINEAR_WORK * n as f64;
        let sets = if is_linear && work::is_short(work.max(total)) {
            work::short(|| self.source.draw(first, count, given, &()))
        } else {
            let source = Arc::clone(&self.source);
            work::run(py, progress, move |watch| {
                watch.expect(work);
                source.draw(first, count, given, &**watch)
            })
        };
        in_arrays(py, sets?, count, &self.point)
    }
}

/// Returns a value in the form in which samplers and integrands contain it.
#[pyfunction]
fn quote(value: &str) -> String {
    sphvar::grammar::quote(value)
}

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<NumberedSets>()?;
    module.add_function(wrap_pyfunction!(quote, module)?)
}
