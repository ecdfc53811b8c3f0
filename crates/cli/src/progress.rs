//! Progress on standard error, with the remaining time, for long work.

use std::fmt::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use sphvar_samplers::Stopped;

use crate::message;

/// A progress bar over nominal work; silent if standard error is not a terminal.
pub(crate) struct Progress {
    bar: ProgressBar,
    /// The remaining seconds that were shown last; later values do not exceed them.
    longest: Arc<AtomicU64>,
}

/// The number of ticks per unit of work, because the bar counts integers.
const TICKS: f64 = 16.0;

impl Progress {
    /// Returns a bar for `work` units.
    pub(crate) fn new(work: f64, quiet: bool) -> Self {
        let longest = Arc::new(AtomicU64::new(u64::MAX));
        let bar = ProgressBar::with_draw_target(
            Some(ticks(work)),
            if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() },
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
        Self { bar, longest }
    }

    /// Sets the description of the current stage.
    pub(crate) fn stage(&self, what: &str) {
        self.bar.set_message(message::escape(what).into_owned());
    }

    /// Counts `work` units as done.
    pub(crate) fn advance(&self, work: f64) {
        self.bar.inc(ticks(work));
    }

    /// Prints a line above the bar, if the bar is visible.
    pub(crate) fn line(&self, text: &str) {
        self.bar.println(text);
    }
}

impl sphvar_samplers::Progress for Progress {
    /// Never stops the work: an interrupt ends the process.
    fn tick(&self, work: f64) -> Result<(), Stopped> {
        self.advance(work);
        Ok(())
    }

    fn expect(&self, work: f64) {
        if work > 0.0 {
            self.bar.inc_length(ticks(work));
            self.longest.store(u64::MAX, Ordering::Relaxed);
        }
    }
}

impl Drop for Progress {
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

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the cast saturates, and a bar may"
)]
fn ticks(work: f64) -> u64 {
    (work * TICKS).round() as u64
}
