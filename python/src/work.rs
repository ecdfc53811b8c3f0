//! Work without the interpreter's lock that Ctrl-C stops, and panics as exceptions.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use pyo3::exceptions::{PyKeyboardInterrupt, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use sphvar::samplers::{Progress, SECONDS_PER_WORK, Stopped};

/// The time between two looks at signals and progress.
const LOOK: Duration = Duration::from_millis(50);

/// The time that work has to stop by itself; what does not is left to end in the background.
const PATIENCE: Duration = Duration::from_millis(700);

/// The longest expected time of work that runs in the calling thread, in seconds: the interpreter's
/// lock is released in all that takes longer.
const SHORT: f64 = 1e-3;

/// The largest number of threads, that of the command's option `--threads`.
const MAX_THREADS: usize = 1024;

/// The progress of work, which can be told to stop.
#[derive(Debug, Default)]
pub(crate) struct Watch {
    stopped: AtomicBool,
    /// The bits of the work that is done and expected, in nominal units.
    done: AtomicU64,
    expected: AtomicU64,
}

impl Watch {
    fn stop(&self) {
        self.stopped.store(true, Ordering::Relaxed);
    }

    fn state(&self) -> (f64, f64) {
        let read = |bits: &AtomicU64| f64::from_bits(bits.load(Ordering::Relaxed));
        (read(&self.done), read(&self.expected))
    }
}

fn add(bits: &AtomicU64, work: f64) {
    let sum = |bits| Some((f64::from_bits(bits) + work).to_bits());
    // Never fails: the closure always returns a value.
    let _ = bits.fetch_update(Ordering::Relaxed, Ordering::Relaxed, sum);
}

impl Progress for Watch {
    fn tick(&self, work: f64) -> Result<(), Stopped> {
        add(&self.done, work);
        if self.stopped.load(Ordering::Relaxed) { Err(Stopped) } else { Ok(()) }
    }

    fn expect(&self, work: f64) {
        add(&self.expected, work);
    }
}

/// The pool of threads of this process. A process that was forked has none of its parent's threads,
/// so it makes a pool of its own. The lock is taken only by threads that hold the interpreter's lock,
/// as those that fork do, so no process is forked while it is taken.
static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// The text and place of the last panic, which is otherwise known to the thread that panicked only.
static PANIC: Mutex<Option<String>> = Mutex::new(None);

fn pool() -> PyResult<Arc<ThreadPool>> {
    let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    let process = std::process::id();
    match &*pool {
        Some((of, pool)) if *of == process => Ok(Arc::clone(pool)),
        _ => set_pool(&mut pool, process, 0),
    }
}

fn set_pool(
    pool: &mut Option<(u32, Arc<ThreadPool>)>,
    process: u32,
    threads: usize,
) -> PyResult<Arc<ThreadPool>> {
    let new = ThreadPoolBuilder::new()
        .num_threads(threads)
        .thread_name(|i| format!("sphvar-{i}"))
        .build();
    let new = new.map_err(|e| PyRuntimeError::new_err(format!("cannot start threads: {e}")))?;
    let new = Arc::new(new);
    // A pool of the parent process must not be dropped here: its threads do not exist.
    if let Some((of, old)) = pool.replace((process, Arc::clone(&new)))
        && of != process
    {
        std::mem::forget(old);
    }
    Ok(new)
}

/// Returns whether work of this nominal size is short enough for the calling thread.
pub(crate) fn is_short(nominal_work: f64) -> bool {
    nominal_work * SECONDS_PER_WORK < SHORT
}

/// Runs short work in the calling thread, with the interpreter's lock. It must not use rayon: outside
/// the pool of this process, that would start threads that a forked process lacks.
pub(crate) fn short<T>(task: impl FnOnce() -> PyResult<T>) -> PyResult<T> {
    catch_unwind(AssertUnwindSafe(task)).unwrap_or_else(|panic| Err(of_panic(&*panic)))
}

/// Runs `task` on the pool without the interpreter's lock and returns its result. Every 50 ms signals
/// are handled, and `progress`, a callable, is given the work done and expected. Work that an exception
/// stops, such as `KeyboardInterrupt`, ends at its next tick.
///
/// On a worker of the pool, where callables of the caller run, the task runs in that thread; signals
/// are then handled by the call that waits for the callable.
///
/// A panic is a `RuntimeError`. The task and its result may be dropped without the interpreter's lock.
pub(crate) fn run<T, F>(py: Python<'_>, progress: Option<&Bound<'_, PyAny>>, task: F) -> PyResult<T>
where
    T: Send + 'static,
    F: FnOnce(&Arc<Watch>) -> PyResult<T> + Send + 'static,
{
    let watch = Arc::new(Watch::default());
    if rayon::current_thread_index().is_some() {
        // A callable of the caller runs on a worker of the pool, which must not wait for another.
        return py.detach(|| short(|| task(&watch)));
    }
    let (sender, receiver) = mpsc::channel();
    // A receiver cannot be shared between threads, which releasing the interpreter's lock requires.
    let receiver = Mutex::new(receiver);
    let watched = Arc::clone(&watch);
    pool()?.spawn(move || {
        let result = short(|| task(&watched));
        // If nobody waits any more, the result is dropped.
        let _ = sender.send(result);
    });
    let mut stopped: Option<(PyErr, Instant)> = None;
    let mut told = None;
    loop {
        let result = py
            .detach(|| receiver.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(LOOK));
        match (result, stopped.take()) {
            (Ok(_) | Err(RecvTimeoutError::Disconnected), Some((error, _))) => return Err(error),
            (Ok(result), None) => {
                if let Some(callback) = progress
                    && result.is_ok()
                {
                    tell(callback, &watch, &mut told)?;
                }
                return result;
            }
            (Err(RecvTimeoutError::Disconnected), None) => {
                return Err(PyRuntimeError::new_err("the work ended without a result"));
            }
            (Err(RecvTimeoutError::Timeout), Some((error, at))) => {
                if at.elapsed() > PATIENCE {
                    return Err(error);
                }
                stopped = Some((error, at));
            }
            (Err(RecvTimeoutError::Timeout), None) => {
                let told = py.check_signals().and_then(|()| {
                    progress.map_or(Ok(()), |callback| tell(callback, &watch, &mut told))
                });
                if let Err(error) = told {
                    watch.stop();
                    stopped = Some((error, Instant::now()));
                }
            }
        }
    }
}

/// Runs a part of work on the pool without the interpreter's lock, and handles signals after it. The
/// part should take less than a tenth of a second.
pub(crate) fn scoped<T: Send>(py: Python<'_>, part: impl FnOnce() -> T + Send) -> PyResult<T> {
    let pool = pool()?;
    let result = short(|| Ok(py.detach(|| pool.install(part))))?;
    py.check_signals()?;
    Ok(result)
}

/// Gives the state of the work to a callable, unless it knows it.
fn tell(callback: &Bound<'_, PyAny>, watch: &Watch, told: &mut Option<(f64, f64)>) -> PyResult<()> {
    let state = watch.state();
    if *told != Some(state) {
        *told = Some(state);
        callback.call1(state)?;
    }
    Ok(())
}

/// Returns the exception of stopped work, where no other is known.
pub(crate) fn interrupted() -> PyErr {
    PyKeyboardInterrupt::new_err(())
}

/// Returns the exception of a panic, which is an error of this package.
fn of_panic(payload: &(dyn Any + Send)) -> PyErr {
    let place = PANIC.lock().unwrap_or_else(PoisonError::into_inner).take();
    let text = place.or_else(|| {
        let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
        text.or_else(|| payload.downcast_ref::<String>().cloned())
    });
    let text = text.unwrap_or_else(|| "panic".to_owned());
    PyRuntimeError::new_err(format!("internal error of sphvar, please report it: {text}"))
}

/// Set the number of threads of this process. Results do not depend on it.
///
/// Parameters
/// ----------
/// threads : int
///     The number of threads, at most 1024; 0 is one per core, which is the default.
///
/// Raises
/// ------
/// ValueError
///     If the number is out of range.
///
/// Examples
/// --------
/// >>> import sphvar
/// >>> sphvar.set_num_threads(0)
#[pyfunction]
fn set_num_threads(threads: i64) -> PyResult<()> {
    let threads = usize::try_from(threads).ok().filter(|threads| *threads <= MAX_THREADS);
    let threads = threads.ok_or_else(|| {
        PyValueError::new_err(format!("the number of threads must be from 0 to {MAX_THREADS}"))
    })?;
    let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    set_pool(&mut pool, std::process::id(), threads).map(drop)
}

/// Panic in the pool or in the calling thread, for tests.
#[pyfunction]
fn _panic(py: Python<'_>, in_pool: bool) -> PyResult<()> {
    #[expect(clippy::panic, reason = "for tests of panics")]
    let task = || panic!("a test");
    if in_pool { run(py, None, move |_| task()) } else { short(task) }
}

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    // Nothing is printed; the exception has the text. The hook is that of this extension module alone.
    std::panic::set_hook(Box::new(|panic| {
        let mut last = PANIC.lock().unwrap_or_else(PoisonError::into_inner);
        *last = Some(panic.to_string().replace('\n', " "));
    }));
    module.add_function(wrap_pyfunction!(set_num_threads, module)?)?;
    module.add_function(wrap_pyfunction!(_panic, module)?)
}
