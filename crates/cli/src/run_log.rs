//! The log of a run, `--log FILE`: one line of JSON for its start, its progress and its end.
//!
//! Lines of progress are also signs of life: a thread writes them at growing intervals, and each
//! states when the next one follows. Other processes, on any machine that shares the file, tell a
//! run that works from one that has ended without a word.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Write};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::CliError;
use crate::files::{is_stdout, is_stream, record_output};
use crate::message;
use crate::shards::Part;

/// The interval between lines of progress grows with the time of the run between these bounds, in
/// seconds.
const INTERVALS: (f64, f64) = (1.0, 60.0);
/// The ratio of the time of the run to the interval.
const LINES: f64 = 10.0;
/// No first line of a log is longer, because no command line is.
const MAX_LINE: u64 = 1 << 22;
/// The number of ticks per unit of work, because atomic counters are integers.
const TICKS: f64 = 16.0;

/// What a line reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Event {
    Start,
    Progress,
    End,
    Error,
}

/// A line of the log of a run. The lines of several runs may be mixed.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(crate) struct LogLine {
    /// What the line reports: `start`, `progress`, `end` or `error`. A run that has ended has one of
    /// the last two, unless it was killed.
    #[schemars(with = "String")]
    pub(crate) event: Event,
    /// The time in seconds since 1970-01-01 UTC.
    pub(crate) time: f64,
    /// The name of the machine.
    pub(crate) host: String,
    /// The number of the process on that machine.
    pub(crate) process: u32,
    /// At the start, the version of sphvar.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) version: Option<String>,
    /// At the start, the part that is computed, from 1; absent without `--shard`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) part: Option<u64>,
    /// At the start, the number of all parts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) parts: Option<u64>,
    /// At the start, the words after the name of the command.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) words: Option<Vec<String>>,
    /// Later, the seconds since the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) seconds: Option<f64>,
    /// In progress, the current stage, such as the name of a pattern.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) stage: Option<String>,
    /// In progress, the share of the work known so far that is done, from 0 to 1; absent if none is
    /// known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) done: Option<f64>,
    /// In progress, the expected remaining seconds at the pace measured so far; absent before it is
    /// measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) seconds_left: Option<f64>,
    /// In progress, the maximum number of seconds to the next line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) next: Option<f64>,
    /// In an error, the exit status.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) status: Option<i32>,
    /// In an error, the message.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) message: Option<String>,
}

/// The log of this run. It is written by a thread of its own until the run ends.
#[derive(Debug)]
pub(crate) struct RunLog {
    file: File,
    path: String,
    host: String,
    started: Instant,
    stage: Mutex<String>,
    expected: AtomicU64,
    done: AtomicU64,
    /// Whether the last line is written.
    is_over: Mutex<bool>,
    over: Condvar,
}

/// The time and the share of the work from which the pace is measured.
type Reference = (f64, f64);

impl RunLog {
    /// Opens the log of a run with these words after the name of the command and writes its start.
    ///
    /// # Errors
    ///
    /// If the file cannot be appended to or is another kind of file.
    pub(crate) fn open(
        path: &Path,
        words: &[String],
        part: Option<Part>,
    ) -> Result<Arc<Self>, CliError> {
        if is_stdout(path) {
            return Err(CliError::Usage("--log must name a file".to_owned()));
        }
        let shown = path.display().to_string();
        let failed = |error: io::Error| CliError::File(format!("cannot write {shown}: {error}"));
        if path.exists() && !is_stream(path) {
            check_is_log(path, &shown)?;
        }
        let file = File::options().append(true).create(true).open(path).map_err(failed)?;
        record_output(path);
        let log = Arc::new(Self {
            file,
            path: shown.clone(),
            host: this_host(),
            started: Instant::now(),
            stage: Mutex::default(),
            expected: AtomicU64::new(0),
            done: AtomicU64::new(0),
            is_over: Mutex::new(false),
            over: Condvar::new(),
        });
        let start = LogLine {
            version: Some(env!("CARGO_PKG_VERSION").to_owned()),
            part: part.map(|part| part.part),
            parts: part.map(|part| part.parts),
            words: Some(words.to_vec()),
            ..log.line(Event::Start)
        };
        log.write(&start).map_err(failed)?;
        let for_thread = Arc::clone(&log);
        std::thread::Builder::new()
            .name("log".to_owned())
            .spawn(move || for_thread.report_progress())
            .map_err(failed)?;
        Ok(log)
    }

    /// Sets the description of the current stage.
    pub(crate) fn stage(&self, what: &str) {
        what.clone_into(&mut lock(&self.stage));
    }

    /// Adds the result of the run, after which nothing is written.
    pub(crate) fn end(&self, result: &Result<(), CliError>) {
        let seconds = Some(self.seconds());
        let line = match result {
            Ok(()) | Err(CliError::ClosedPipe) => LogLine { seconds, ..self.line(Event::End) },
            Err(error) => LogLine {
                seconds,
                status: Some(error.status().into()),
                message: Some(message::clean(&error.to_string())),
                ..self.line(Event::Error)
            },
        };
        self.write_last(&line);
    }

    /// Reports that a signal ends the process with this exit status.
    pub(crate) fn interrupted(&self, signal: i32, status: i32) {
        let line = LogLine {
            seconds: Some(self.seconds()),
            status: Some(status),
            message: Some(format!("ended by signal {signal}")),
            ..self.line(Event::Error)
        };
        self.write_last(&line);
    }

    fn write_last(&self, line: &LogLine) {
        let mut is_over = lock(&self.is_over);
        if std::mem::replace(&mut *is_over, true) {
            return;
        }
        self.write_or_remark(line);
        self.over.notify_all();
    }

    /// Writes lines of progress until the run is over.
    fn report_progress(&self) {
        let mut reference = None;
        let mut is_over = lock(&self.is_over);
        let mut is_writable = true;
        while !*is_over && is_writable {
            let interval = interval(self.seconds());
            let waited = self.over.wait_timeout_while(
                is_over,
                Duration::from_secs_f64(interval),
                |is_over| !*is_over,
            );
            is_over = waited.unwrap_or_else(PoisonError::into_inner).0;
            if !*is_over {
                is_writable = self.write_or_remark(&self.progress(&mut reference));
            }
        }
    }

    /// Returns the line on the state of the work.
    fn progress(&self, reference: &mut Option<Reference>) -> LogLine {
        let seconds = self.seconds();
        let (done, expected) =
            (self.done.load(Ordering::Relaxed), self.expected.load(Ordering::Relaxed));
        let done = (expected > 0).then(|| (done as f64 / expected as f64).min(1.0));
        let stage = Some(lock(&self.stage).clone()).filter(|stage| !stage.is_empty());
        LogLine {
            seconds: Some(seconds),
            stage,
            done: done.map(rounded),
            seconds_left: done.and_then(|done| seconds_left((seconds, done), reference)),
            next: Some(rounded(interval(seconds))),
            ..self.line(Event::Progress)
        }
    }

    fn line(&self, event: Event) -> LogLine {
        LogLine {
            event,
            time: now(),
            host: self.host.clone(),
            process: std::process::id(),
            version: None,
            part: None,
            parts: None,
            words: None,
            seconds: None,
            stage: None,
            done: None,
            seconds_left: None,
            next: None,
            status: None,
            message: None,
        }
    }

    fn seconds(&self) -> f64 {
        rounded(self.started.elapsed().as_secs_f64())
    }

    /// Appends a line and makes it visible to other machines.
    fn write(&self, line: &LogLine) -> io::Result<()> {
        let text = serde_json::to_string(line).map_err(io::Error::other)? + "\n";
        // In one call, so that lines of several processes are not mixed.
        (&self.file).write_all(text.as_bytes())?;
        // A pipe cannot be synchronized, and does not need it.
        let _ = self.file.sync_data();
        Ok(())
    }

    /// Appends a line and returns whether that succeeded; a failure does not end the run.
    fn write_or_remark(&self, line: &LogLine) -> bool {
        let written = self.write(line);
        if let Err(error) = &written {
            message::write(&format!("warning: cannot write {}: {error}", self.path));
        }
        written.is_ok()
    }
}

/// The share of a progress in the log: its work counts as done at its end.
#[derive(Debug)]
pub(crate) struct LoggedWork {
    log: Arc<RunLog>,
    expected: AtomicU64,
    done: AtomicU64,
}

impl LoggedWork {
    pub(crate) fn new(log: Arc<RunLog>, work: f64) -> Self {
        let logged = Self { log, expected: AtomicU64::new(0), done: AtomicU64::new(0) };
        logged.expect(work);
        logged
    }

    pub(crate) fn stage(&self, what: &str) {
        self.log.stage(what);
    }

    pub(crate) fn expect(&self, work: f64) {
        self.expected.fetch_add(ticks(work), Ordering::Relaxed);
        self.log.expected.fetch_add(ticks(work), Ordering::Relaxed);
    }

    pub(crate) fn advance(&self, work: f64) {
        self.done.fetch_add(ticks(work), Ordering::Relaxed);
        self.log.done.fetch_add(ticks(work), Ordering::Relaxed);
    }
}

impl Drop for LoggedWork {
    fn drop(&mut self) {
        let (done, expected) =
            (self.done.load(Ordering::Relaxed), self.expected.load(Ordering::Relaxed));
        self.log.done.fetch_add(expected.wrapping_sub(done), Ordering::Relaxed);
    }
}

/// Returns the lines of a log; none if there is no such file. Invalid lines, such as one that a
/// killed process has left incomplete, are skipped.
///
/// # Errors
///
/// If the file cannot be read.
pub(crate) fn read_log(path: &Path) -> io::Result<Vec<LogLine>> {
    let file = match File::open(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        file => file?,
    };
    let mut lines = Vec::new();
    for line in BufReader::new(file).split(b'\n') {
        lines.extend(serde_json::from_slice(&line?).ok());
    }
    Ok(lines)
}

/// Returns an error unless a file is empty or a log: lines must not be appended to other files.
fn check_is_log(path: &Path, shown: &str) -> Result<(), CliError> {
    let failed = |error| CliError::File(format!("cannot read {shown}: {error}"));
    let mut first = Vec::new();
    let file = File::open(path).map_err(failed)?;
    io::Read::take(BufReader::new(file), MAX_LINE).read_until(b'\n', &mut first).map_err(failed)?;
    if first.is_empty() || serde_json::from_slice::<LogLine>(&first).is_ok() {
        return Ok(());
    }
    Err(CliError::File(format!("{shown} exists and is not a log of sphvar; name another file")))
}

/// Returns the seconds to the next line after some seconds of a run.
fn interval(seconds: f64) -> f64 {
    (seconds / LINES).clamp(INTERVALS.0, INTERVALS.1)
}

/// Returns the expected remaining seconds at the mean pace since the reference, which the first call
/// sets: work that an earlier run has left is known at once and must not count.
fn seconds_left(now: (f64, f64), reference: &mut Option<Reference>) -> Option<f64> {
    let (seconds, done) = now;
    let (since, was_done) = *reference.get_or_insert(now);
    let pace = (done - was_done) / (seconds - since);
    // Where further work has become known, the share has decreased.
    if done < was_done {
        *reference = Some(now);
    }
    (pace > 0.0 && pace.is_finite()).then(|| rounded((1.0 - done) / pace))
}

/// Returns the seconds since 1970-01-01 UTC.
pub(crate) fn now() -> f64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    rounded(since.map_or(0.0, |since| since.as_secs_f64()))
}

/// Returns the name of this machine.
pub(crate) fn this_host() -> String {
    sysinfo::System::host_name().unwrap_or_else(|| "unknown".to_owned())
}

/// Returns a number to a thousandth.
fn rounded(x: f64) -> f64 {
    (1e3 * x).round() / 1e3
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the cast saturates, and a counter may"
)]
fn ticks(work: f64) -> u64 {
    (work * TICKS).round() as u64
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::{Event, LoggedWork, RunLog, interval, read_log, seconds_left};
    use crate::error::CliError;
    use crate::shards::Part;

    #[test]
    fn the_lines_of_a_run_are_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.jsonl");
        let words = ["spectrum".to_owned(), "a\nb \"c\"".to_owned()];
        let part = Some(Part { part: 2, parts: 3 });
        let log = RunLog::open(&path, &words, part).unwrap();
        let work = LoggedWork::new(Arc::clone(&log), 4.0);
        work.stage("step");
        work.advance(1.0);
        let line = log.progress(&mut None);
        assert_eq!((line.done, line.stage.as_deref()), (Some(0.25), Some("step")));
        drop(work);
        assert_eq!(log.progress(&mut None).done, Some(1.0));
        log.end(&Err(CliError::Usage("wrong\nnumber".to_owned())));
        // The first end stands.
        log.end(&Ok(()));
        log.interrupted(15, 143);
        let lines = read_log(&path).unwrap();
        assert_eq!(lines.len(), 2, "{lines:?}");
        assert_eq!((lines[0].event, lines[1].event), (Event::Start, Event::Error));
        assert_eq!(lines[0].words.as_deref(), Some(&words[..]));
        assert_eq!((lines[0].part, lines[0].parts), (Some(2), Some(3)));
        assert_eq!(lines[1].status, Some(2));
        assert!(!lines[1].message.as_ref().unwrap().contains('\n'), "{lines:?}");
        // A second run appends.
        RunLog::open(&path, &words, None).unwrap().end(&Ok(()));
        assert_eq!(read_log(&path).unwrap().len(), 4);
    }

    #[test]
    fn other_files_are_not_appended_to() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("data.csv");
        std::fs::write(&path, "x,y,z\n1,0,0\n").unwrap();
        let error = RunLog::open(&path, &[], None).unwrap_err().to_string();
        assert!(error.contains("not a log"), "{error}");
        assert_eq!(std::fs::read(&path).unwrap(), b"x,y,z\n1,0,0\n");
        std::fs::write(&path, "").unwrap();
        RunLog::open(&path, &[], None).unwrap().end(&Ok(()));
        assert_eq!(read_log(&folder.path().join("missing")).unwrap().len(), 0);
    }

    #[test]
    fn the_remaining_time_follows_from_the_pace_since_the_start_of_new_work() {
        let mut reference = None;
        assert_eq!(seconds_left((1.0, 0.5), &mut reference), None);
        // A tenth in 2 s after half was known.
        assert_eq!(seconds_left((3.0, 0.6), &mut reference), Some(8.0));
        // Further work has become known.
        assert_eq!(seconds_left((4.0, 0.3), &mut reference), None);
        assert_eq!(seconds_left((5.0, 0.5), &mut reference), Some(2.5));
        assert_eq!((interval(0.0), interval(50.0), interval(1e9)), (1.0, 5.0, 60.0));
    }
}
