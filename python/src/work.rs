//! Work without the interpreter's lock that Ctrl-C stops.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use pyo3::exceptions::{PyKeyboardInterrupt, PyMemoryError, PyRuntimeError};
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use sphvar::samplers::{Progress, Stopped};

/// The time between two looks at signals and progress.
const LOOK: Duration = Duration::from_millis(50);

/// The time that work has to stop by itself; what does not is left to end in the background.
const PATIENCE: Duration = Duration::from_millis(700);

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
/// so it makes a pool of its own.
static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

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
    let new = ThreadPoolBuilder::new().num_threads(threads).build();
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

/// Runs `task` on the pool without the interpreter's lock and returns its result. Every 50 ms signals
/// are handled, and `progress`, a callable, is given the work done and expected. Work that an exception
/// stops, such as `KeyboardInterrupt`, ends at its next tick.
pub(crate) fn run<T, F>(py: Python<'_>, progress: Option<&Bound<'_, PyAny>>, task: F) -> PyResult<T>
where
    T: Send + 'static,
    F: FnOnce(&Arc<Watch>) -> PyResult<T> + Send + 'static,
{
    let pool = pool()?;
    let watch = Arc::new(Watch::default());
    let (sender, receiver) = mpsc::channel();
    // A receiver cannot be shared between threads, which the interpreter's lock requires.
    let receiver = Mutex::new(receiver);
    let worker = {
        let watch = Arc::clone(&watch);
        thread::Builder::new().name("sphvar".to_owned()).spawn(move || {
            // If nobody waits any more, the result is dropped.
            let _ = sender.send(pool.install(|| task(&watch)));
        })
    };
    worker.map_err(|e| PyMemoryError::new_err(format!("cannot start a thread: {e}")))?;
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

/// Set the number of threads of this process; 0 is one per core. Results do not depend on it.
#[pyfunction]
fn set_num_threads(threads: usize) -> PyResult<()> {
    let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    set_pool(&mut pool, std::process::id(), threads).map(drop)
}

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(set_num_threads, module)?)
}
