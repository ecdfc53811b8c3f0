//! Refusing work that the machine's memory cannot hold, before it is begun.

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

/// The bytes of one set of coefficients to degree `lmax`.
pub(crate) fn coefficient_bytes(lmax: usize) -> f64 {
    let l = lmax as f64;
    8.0 * (l + 1.0) * (l + 2.0)
}
