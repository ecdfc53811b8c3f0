//! Refusing work that is too large for the machine or for the transforms, before it is begun.

use sphvar_sh::MAX_DEGREE;
use sphvar_spectrum::Resolution;

use crate::error::CliError;

/// Refuses if `bytes` (a lower estimate of what `what` needs) exceed the memory that is available.
/// Where the machine does not tell, everything is tried.
pub(crate) fn check_memory(what: &str, bytes: f64) -> Result<(), CliError> {
    let mut system = sysinfo::System::new();
    system.refresh_memory();
    let available = system.available_memory() as f64;
    if available > 0.0 && bytes > available {
        let gib = |b: f64| b / f64::from(1 << 30);
        return Err(CliError::Failed(format!(
            "{what} needs {:.1} GiB of memory, {:.1} GiB are available; choose a smaller one",
            gib(bytes),
            gib(available)
        )));
    }
    Ok(())
}

/// Refuses a degree beyond those that there are; `what` asked for it.
pub(crate) fn check_degree(what: &str, l: usize) -> Result<(), CliError> {
    if l > MAX_DEGREE {
        return Err(CliError::Usage(format!(
            "{what}: the largest degree is {MAX_DEGREE}, got {l}"
        )));
    }
    Ok(())
}

/// Refuses a transform of `sets` sets that does not fit.
pub(crate) fn check_transform(resolution: Resolution, sets: u64) -> Result<(), CliError> {
    let Resolution { lmax, n_points, .. } = resolution;
    let bytes = resolution.bytes(sets, rayon::current_num_threads());
    check_memory(&format!("a spectrum of {n_points} points to degree {lmax} (--lmax)"), bytes)
}
