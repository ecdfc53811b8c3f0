//! What signals do: the process ends, and nothing unfinished is left.

#[cfg(unix)]
mod unix {
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;
    use std::time::{Duration, Instant};
    use std::{fs, io, thread};

    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
    use signal_hook::flag;
    use signal_hook::iterator::Signals;
    use signal_hook::low_level::exit;

    use crate::files::remove_all_and_exit;

    /// What users and systems end programs with.
    const ENDING: [i32; 3] = [SIGHUP, SIGINT, SIGTERM];

    /// `timeout` and terminals send a signal to a process and to its group: what comes so soon is no second request.
    const TWICE_AT_ONCE: Duration = Duration::from_millis(100);

    /// Watches for signals in a thread of its own: the first removes what is unfinished and ends the process, a later
    /// one ends it at once.
    ///
    /// # Errors
    /// When the system does not let it.
    pub(crate) fn watch() -> io::Result<()> {
        // Beyond the largest size of a file, writing fails with an error instead of ending the process.
        flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)))?;
        let ignored = ignored_signals();
        // `nohup` and shells that run a command in the background ignore signals on its behalf.
        let watched: Vec<i32> =
            ENDING.into_iter().filter(|signal| ignored >> (signal - 1) & 1 == 0).collect();
        let mut signals = Signals::new(&watched)?;
        thread::Builder::new().name("signals".to_owned()).spawn(move || {
            let mut first = None;
            for signal in signals.forever() {
                let status = 128 + signal;
                match first {
                    None => {
                        first = Some(Instant::now());
                        thread::spawn(move || remove_all_and_exit(status));
                    }
                    Some(at) if at.elapsed() >= TWICE_AT_ONCE => exit(status),
                    Some(_) => (),
                }
            }
        })?;
        Ok(())
    }

    /// The set of signals that are ignored, the first in the lowest bit; empty where the system does not tell.
    fn ignored_signals() -> u64 {
        let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
        let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
        mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
    }
}

#[cfg(unix)]
pub(crate) use unix::watch;

/// Elsewhere the system ends the process by itself, and the next run removes what it leaves.
///
/// # Errors
/// None.
#[cfg(not(unix))]
pub(crate) fn watch() -> std::io::Result<()> {
    Ok(())
}
