//! Progress on standard error, with the time that is left, for work that takes a while.

use std::fmt::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

use crate::message;

/// A progress bar over an estimated number of seconds of work; silent where standard error is no
/// terminal.
pub(crate) struct Progress {
    bar: ProgressBar,
    /// The seconds left that were shown last, which later ones do not exceed.
    longest: Arc<AtomicU64>,
}

/// Ticks to an estimated second: the bar counts whole numbers.
const TICKS: f64 = 1e6;

impl Progress {
    /// A bar for `cost` units of work, of any size.
    pub(crate) fn new(cost: f64, quiet: bool) -> Self {
        let longest = Arc::new(AtomicU64::new(u64::MAX));
        let bar = ProgressBar::with_draw_target(
            Some(ticks(cost)),
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

    /// Says what is being done.
    pub(crate) fn stage(&self, what: &str) {
        self.bar.set_message(message::escape(what).into_owned());
    }

    /// Adds `cost` units to what is to be done.
    pub(crate) fn lengthen(&self, cost: f64) {
        self.bar.inc_length(ticks(cost));
        self.longest.store(u64::MAX, Ordering::Relaxed);
    }

    /// Counts `cost` units as done.
    pub(crate) fn advance(&self, cost: f64) {
        self.bar.inc(ticks(cost));
    }

    /// A share of `cost` units of the work.
    pub(crate) fn share(&self, cost: f64) -> Share<'_> {
        Share { progress: self, ticks: ticks(cost), done: AtomicU64::new(0) }
    }

    /// Writes a line above the bar, if there is one to be seen.
    pub(crate) fn line(&self, text: &str) {
        self.bar.println(text);
    }
}

/// A part of the work that may turn out to be less than was expected.
pub(crate) struct Share<'a> {
    progress: &'a Progress,
    ticks: u64,
    done: AtomicU64,
}

impl Share<'_> {
    /// Counts `cost` units as done, never more than the whole share.
    pub(crate) fn advance(&self, cost: f64) {
        let step = ticks(cost);
        let before = self.done.fetch_add(step, Ordering::Relaxed);
        self.progress.bar.inc(step.min(self.ticks.saturating_sub(before)));
    }

    /// Counts what is left as done.
    pub(crate) fn finish(self) {
        self.progress.bar.inc(self.ticks.saturating_sub(self.done.into_inner()));
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// The time that is left, in seconds; it waits rather than grows. Before a twentieth is done nothing is known
/// of it.
fn left(state: &ProgressState, longest: &AtomicU64) -> String {
    if state.fraction() < 0.05 {
        return "-".to_owned();
    }
    // All that was done, at its mean pace.
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
fn ticks(cost: f64) -> u64 {
    (cost * TICKS).round() as u64
}
