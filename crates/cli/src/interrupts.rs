//! Signal handling: the process ends, and unfinished files are removed.

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

    /// The signals by which users and systems end programs.
    const ENDING: [i32; 3] = [SIGHUP, SIGINT, SIGTERM];

    /// `timeout` and terminals send a signal both to a process and to its group; a second signal
    /// within this time does not count as another request.
    const TWICE_AT_ONCE: Duration = Duration::from_millis(100);

    /// Watches for signals in a separate thread: the first is reported with the exit status, removes
    /// unfinished files and ends the process, a later one ends it immediately.
    ///
    /// # Errors
    ///
    /// If the system does not permit it.
    pub(crate) fn watch(report: impl Fn(i32, i32) + Send + Sync + 'static) -> io::Result<()> {
        // Beyond the limit on file sizes, writing fails with an error instead of ending the
        // process.
        flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)))?;
        let ignored = ignored_signals();
        // `nohup` and shells that run a command in the background make it ignore signals.
        let watched: Vec<i32> =
            ENDING.into_iter().filter(|signal| ignored >> (signal - 1) & 1 == 0).collect();
        let mut signals = Signals::new(&watched)?;
        let report = Arc::new(report);
        thread::Builder::new().name("signals".to_owned()).spawn(move || {
            let mut first = None;
            for signal in signals.forever() {
                let status = 128 + signal;
                match first {
                    None => {
                        first = Some(Instant::now());
                        let report = Arc::clone(&report);
                        thread::spawn(move || {
                            report(signal, status);
                            remove_all_and_exit(status)
                        });
                    }
                    Some(at) if at.elapsed() >= TWICE_AT_ONCE => exit(status),
                    Some(_) => (),
                }
            }
        })?;
        Ok(())
    }

    /// Returns the set of ignored signals, the first in the lowest bit, or 0 if the system does not
    /// report it.
    fn ignored_signals() -> u64 {
        let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
        let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
        mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
    }
}

#[cfg(unix)]
pub(crate) use unix::watch;

/// On other systems, signals end the process, and the next run removes unfinished files.
///
/// # Errors
///
/// None.
#[cfg(not(unix))]
pub(crate) fn watch(_report: impl Fn(i32, i32) + Send + Sync + 'static) -> std::io::Result<()> {
    Ok(())
}
