//! Rejects work that exceeds the machine or the transforms before it starts.

use sphvar_sh::MAX_DEGREE;
use sphvar_spectrum::Resolution;

use crate::error::CliError;

/// Returns the available memory in bytes, within the limits of the control group and of the process
/// (`ulimit -v`), or `None` if the machine does not report it.
pub(crate) fn available_memory() -> Option<f64> {
    let mut system = sysinfo::System::new();
    system.refresh_memory();
    let machine = system.available_memory();
    if machine == 0 {
        return None;
    }
    // The file cache of the group can be reclaimed, so its free memory would be an underestimate.
    let group = system.cgroup_limits().map(|group| group.total_memory.saturating_sub(group.rss));
    let free = group.map_or(machine, |group| group.min(machine)) as f64;
    Some(free.min(address_space().unwrap_or(f64::INFINITY)))
}

/// Returns a number of bytes for a message.
pub(crate) fn gibibytes(bytes: f64) -> String {
    format!("{:.1} GiB", bytes / f64::from(1 << 30))
}

/// Returns an error if `bytes`, a lower bound of the memory of `what`, exceed the available memory.
/// If the machine does not report it, the work is attempted.
pub(crate) fn check_memory(what: &str, bytes: f64) -> Result<(), CliError> {
    match available_memory() {
        Some(available) if bytes > available => Err(CliError::Memory(format!(
            "{what} requires {} of memory, but {} are available; use a smaller value",
            gibibytes(bytes),
            gibibytes(available)
        ))),
        _ => Ok(()),
    }
}

/// Returns the bytes that a limit such as `ulimit -v` leaves to this process, or `None` without a
/// limit or if the system does not report it.
fn address_space() -> Option<f64> {
    let limits = std::fs::read_to_string("/proc/self/limits").ok()?;
    let line = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    let limit: f64 = line.split_whitespace().next()?.parse().ok()?;
    let sizes = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = sizes.lines().find_map(|line| line.strip_prefix("VmSize:"))?;
    let kib: f64 = line.split_whitespace().next()?.parse().ok()?;
    Some((limit - 1024.0 * kib).max(0.0))
}

/// Rejects points that do not fit in memory: each takes at least 24 bytes.
pub(crate) fn check_points(n: usize) -> Result<(), CliError> {
    check_memory(&format!("a set of {n} points (-n)"), 24.0 * n as f64)
}

/// Rejects a degree above the supported maximum; `what` names the option that requested it.
pub(crate) fn check_degree(what: &str, l: usize) -> Result<(), CliError> {
    if l > MAX_DEGREE {
        return Err(CliError::Usage(format!(
            "{what}: the largest degree is {MAX_DEGREE}, got {l}"
        )));
    }
    Ok(())
}

/// Rejects a transform of `sets` sets that does not fit in memory.
pub(crate) fn check_transform(resolution: Resolution, sets: u64) -> Result<(), CliError> {
    let Resolution { lmax, n_points, .. } = resolution;
    let bytes = resolution.bytes(sets, rayon::current_num_threads());
    check_memory(&format!("a spectrum of {n_points} points to degree {lmax} (--lmax)"), bytes)
}
