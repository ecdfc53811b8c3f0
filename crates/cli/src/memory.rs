//! Rejects work that exceeds the machine or the transforms before it starts.

use std::sync::atomic::{AtomicU64, Ordering};

use sphvar_sh::MAX_DEGREE;
use sphvar_spectrum::Resolution;

use crate::error::CliError;

/// The limit of `--memory` in bytes, 0 without one.
static LIMIT: AtomicU64 = AtomicU64::new(0);

/// Sets the limit of `--memory` of this process.
pub(crate) fn set_memory_limit(bytes: Option<u64>) {
    LIMIT.store(bytes.unwrap_or(0), Ordering::Relaxed);
}

/// Returns the limit of `--memory` in bytes, if there is one.
pub(crate) fn memory_limit() -> Option<f64> {
    let bytes = LIMIT.load(Ordering::Relaxed);
    (bytes > 0).then_some(bytes as f64)
}

/// Returns the available memory in bytes, within the limit of `--memory`, or `None` without a limit
/// if the machine does not report it.
pub(crate) fn available_memory() -> Option<f64> {
    memory_beyond(0)
}

/// Returns the memory that is available to work that holds this number of bytes already, in bytes.
pub(crate) fn memory_beyond(held: u64) -> Option<f64> {
    let allowed = memory_limit().map(|limit| (limit - held as f64).max(0.0));
    match (free_memory(), allowed) {
        (Some(free), Some(allowed)) => Some(free.min(allowed)),
        (free, allowed) => free.or(allowed),
    }
}

/// Parses a size in bytes such as 500M, 8G or 1.5 GiB; K, M, G and T are powers of 1024.
pub(crate) fn parse_size(text: &str) -> Result<u64, String> {
    let lower = text.trim().to_ascii_lowercase();
    let digits = lower.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(lower.len());
    let (number, unit) = lower.split_at(digits);
    let power = match unit.trim() {
        "" | "b" => Some(0),
        "k" | "kb" | "kib" => Some(10),
        "m" | "mb" | "mib" => Some(20),
        "g" | "gb" | "gib" => Some(30),
        "t" | "tb" | "tib" => Some(40),
        _ => None,
    };
    let bytes = number.parse::<f64>().ok().zip(power).map(|(n, power)| n * 2_f64.powi(power));
    let valid = bytes.filter(|bytes| (1.0..1e18).contains(bytes));
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below 1e18")]
    let whole = valid.map(|bytes| bytes as u64);
    whole.ok_or_else(|| format!("expected a size such as 500M or 8G, got {text:?}"))
}

/// Returns the free memory in bytes, within the limits of the control group and of the process
/// (`ulimit -v`), or `None` if the machine does not report it.
fn free_memory() -> Option<f64> {
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

/// Returns a number of bytes for a message, in a unit that a size on the command line has.
pub(crate) fn size_in_words(bytes: f64) -> String {
    let mebibytes = bytes / f64::from(1 << 20);
    if mebibytes < 1024.0 {
        format!("{:.0}M", mebibytes.ceil())
    } else {
        format!("{:.1}G", (mebibytes / 102.4).ceil() / 10.0)
    }
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

#[cfg(test)]
mod tests {
    use super::parse_size;

    #[test]
    fn sizes_have_units() {
        let gib = 1_u64 << 30;
        for (text, bytes) in [
            ("8G", 8 * gib),
            ("1.5gib", 3 * gib / 2),
            (" 500 M ", 500 << 20),
            ("4096", 4096),
            ("2kB", 2048),
            ("1T", gib << 10),
        ] {
            assert_eq!(parse_size(text), Ok(bytes), "{text}");
        }
        for text in ["", "G", "0", "-1G", "1e9", "8X", "1..5G", "nan", "99999999999T", "0.1"] {
            assert!(parse_size(text).is_err(), "{text}");
        }
    }
}
