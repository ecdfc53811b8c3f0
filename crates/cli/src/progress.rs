//! Progress for long work: on standard error with the remaining time, or that of an embedding
//! program.

use std::fmt::Write;
use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use sphvar_samplers::{SECONDS_PER_WORK, Stopped};

use crate::message;
use crate::report::number;
use crate::run_log::LoggedWork;
use crate::session::Session;

/// The progress of nominal work: that of the embedding program, or a bar on standard error. If
/// standard error is not a terminal, lines at growing intervals take the place of the bar.
pub(crate) struct Progress {
    display: Display,
    log: Option<LoggedWork>,
}

enum Display {
    Host(Arc<dyn sphvar_samplers::Progress + Send + Sync>),
    Bar(Bar),
}

struct Bar {
    bar: ProgressBar,
    /// The remaining seconds that were shown last; later values do not exceed them.
    longest: Arc<AtomicU64>,
    started: Instant,
    /// Where lines take the place of the bar, the seconds from the start to the next one.
    next_line: Option<AtomicU64>,
}

/// The least expected time that is stated first, in seconds of one core.
const LONG: f64 = 10.0;

/// The seconds to the first line; each later one comes after twice the time.
const FIRST_LINE: u64 = 15;

/// The number of ticks per unit of work, because the bar counts integers.
const TICKS: f64 = 16.0;

impl Progress {
    /// Returns the progress of `work` units as [`new`](Self::new) does, after a line on their
    /// expected time if it is long. The work must be the nominal one rather than a maximum or a share.
    pub(crate) fn with_expected_time(work: f64, session: &Session) -> Self {
        let of_run = work * session.tasks().share();
        if let Some(text) = expected_time(of_run).filter(|_| !session.is_embedded()) {
            session.say(&text);
        }
        Self::new(work, session)
    }

    /// Returns the progress of `work` units, of which this process does its share.
    pub(crate) fn new(work: f64, session: &Session) -> Self {
        let work = work * session.tasks().share();
        let display = match session.host_progress() {
            Some(host) => {
                host.expect(work);
                Display::Host(host)
            }
            None => Display::Bar(Bar::new(work, session.shows_progress())),
        };
        Self { display, log: session.log().map(|log| LoggedWork::new(log, work)) }
    }

    /// Sets the description of the current stage.
    pub(crate) fn stage(&self, what: &str) {
        if let Some(log) = &self.log {
            log.stage(what);
        }
        if let Display::Bar(bar) = &self.display {
            bar.bar.set_message(message::escape(what).into_owned());
        }
    }

    /// Counts `work` units as done.
    ///
    /// # Errors
    ///
    /// If the embedding program stops the work; an interrupt ends the process of the command.
    pub(crate) fn advance(&self, work: f64) -> Result<(), Stopped> {
        if let Some(log) = &self.log {
            log.advance(work);
        }
        match &self.display {
            Display::Host(host) => host.tick(work),
            Display::Bar(bar) => {
                bar.advance(work);
                Ok(())
            }
        }
    }

    /// Prints a line above the bar, if it is visible.
    pub(crate) fn line(&self, text: &str) {
        if let Display::Bar(bar) = &self.display {
            bar.bar.println(text);
        }
    }
}

impl sphvar_samplers::Progress for Progress {
    fn tick(&self, work: f64) -> Result<(), Stopped> {
        self.advance(work)
    }

    fn expect(&self, work: f64) {
        if let Some(log) = &self.log {
            log.expect(work);
        }
        match &self.display {
            Display::Host(host) => host.expect(work),
            Display::Bar(bar) => bar.expect(work),
        }
    }
}

impl Bar {
    fn new(work: f64, is_shown: bool) -> Self {
        let longest = Arc::new(AtomicU64::new(u64::MAX));
        let bar = ProgressBar::with_draw_target(
            Some(ticks(work)),
            if is_shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() },
        );
        let style =
            ProgressStyle::with_template("{msg:24!} [{bar:32}] {percent:>3} % {left:>4} left");
        if let Ok(style) = style {
            let longest = Arc::clone(&longest);
            let left = move |state: &ProgressState, out: &mut dyn Write| {
                let _ = write!(out, "{}", left(state, &longest));
            };
            bar.set_style(style.with_key("left", left).progress_chars("=> "));
        }
        bar.enable_steady_tick(Duration::from_millis(200));
        let has_lines = is_shown && !std::io::stderr().is_terminal();
        let next_line = has_lines.then(|| AtomicU64::new(FIRST_LINE));
        Self { bar, longest, started: Instant::now(), next_line }
    }

    fn advance(&self, work: f64) {
        self.bar.inc(ticks(work));
        let Some(next_line) = &self.next_line else { return };
        let (seconds, next) = (self.started.elapsed().as_secs(), next_line.load(Ordering::Relaxed));
        let later = 2 * seconds;
        // Of several threads, one writes the line.
        if seconds >= next
            && next_line.compare_exchange(next, later, Ordering::Relaxed, Ordering::Relaxed).is_ok()
        {
            let done = self.bar.position() as f64 / self.bar.length().unwrap_or_default() as f64;
            message::write(&line(&self.bar.message(), done, seconds as f64));
        }
    }

    fn expect(&self, work: f64) {
        if work > 0.0 {
            self.bar.inc_length(ticks(work));
            self.longest.store(u64::MAX, Ordering::Relaxed);
        }
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// Returns the remaining time in seconds, which never increases. It is unknown before a twentieth
/// of the work is done.
fn left(state: &ProgressState, longest: &AtomicU64) -> String {
    if state.fraction() < 0.05 {
        return "-".to_owned();
    }
    // Extrapolates from the mean pace so far.
    let done = f64::from(state.fraction());
    let now = state.elapsed().mul_f64((1.0 - done).max(0.0) / done).as_secs();
    let shown = longest.fetch_min(now, Ordering::Relaxed).min(now);
    format!("{}s", shown)
}

/// Returns a sentence on the time that `work` units are expected to take, if it is long.
fn expected_time(work: f64) -> Option<String> {
    let seconds = SECONDS_PER_WORK * work;
    (seconds >= LONG && seconds.is_finite())
        .then(|| format!("expected time on one core: about {}", rough(seconds)))
}

/// Returns the line on a stage after a number of seconds, with the share of the expected work that
/// is done.
fn line(stage: &str, done: f64, seconds: f64) -> String {
    let stage = if stage.is_empty() { "progress" } else { stage };
    // Without expected work the share is not a number.
    let state = match done {
        done if done < 1.0 => format!("{} % done after {seconds} s", (100.0 * done).floor()),
        done if done >= 1.0 => format!("longer than expected, {seconds} s so far"),
        _ => format!("{seconds} s so far"),
    };
    format!("{stage}: {state}")
}

/// Returns a time that is known to a factor of about 2.
pub(crate) fn rough(seconds: f64) -> String {
    match seconds {
        s if s < 100.0 => format!("{:.0} s", s),
        s if s < 5400.0 => format!("{:.0} min", s / 60.0),
        s => format!("{} h", number::count((s / 3600.0).round())),
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the cast saturates, and a bar may"
)]
fn ticks(work: f64) -> u64 {
    (work * TICKS).round() as u64
}

#[cfg(test)]
mod tests {
    use super::{SECONDS_PER_WORK, expected_time, line};

    #[test]
    fn long_work_states_its_expected_time() {
        let text = |seconds: f64| expected_time(seconds / SECONDS_PER_WORK);
        for seconds in [0.0, 9.0, f64::NAN, -1.0, f64::INFINITY] {
            assert_eq!(text(seconds), None, "{seconds}");
        }
        for (seconds, end) in [(40.0, "about 40 s"), (601.0, "about 10 min"), (7200.0, "about 2 h")]
        {
            let text = text(seconds).unwrap();
            assert!(text.ends_with(end), "{text}");
        }
    }

    #[test]
    fn lines_state_what_is_done() {
        assert_eq!(line("dpp", 0.239, 15.0), "dpp: 23 % done after 15 s");
        assert_eq!(line("design", 1.0, 30.0), "design: longer than expected, 30 s so far");
        assert_eq!(line("", f64::NAN, 61.0), "progress: 61 s so far");
    }
}
