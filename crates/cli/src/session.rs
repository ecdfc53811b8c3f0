//! What a run reads besides files, and where it reports.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use sphvar_samplers::{Progress, Stopped};

use crate::error::CliError;
use crate::given::Given;
use crate::message;
use crate::run_log::RunLog;
use crate::shards::Tasks;

/// The arrays that a run reads besides files, and the place of its output, messages and progress:
/// the streams of the process, or the program that the command is embedded in.
///
/// Clones share everything.
#[derive(Clone)]
pub struct Session {
    inner: Arc<Inner>,
    pub(crate) given: Given,
    tasks: Tasks,
}

struct Inner {
    words: Vec<String>,
    channel: Channel,
    log: Option<Arc<RunLog>>,
    /// The remarks of this run, each of which is reported once.
    remarked: Mutex<BTreeSet<String>>,
}

/// The place of output, messages and progress.
enum Channel {
    Terminal { quiet: bool },
    Host(Host),
}

/// The program that the command is embedded in.
struct Host {
    progress: Arc<Watched>,
    remarks: Arc<Mutex<Vec<String>>>,
    output: Mutex<String>,
}

/// The progress of an embedding program, which remembers that it has stopped the work.
struct Watched {
    progress: Arc<dyn Progress + Send + Sync>,
    is_stopped: AtomicBool,
}

impl Progress for Watched {
    fn tick(&self, work: f64) -> Result<(), Stopped> {
        if self.progress.tick(work).is_err() {
            self.is_stopped.store(true, Ordering::Relaxed);
        }
        // Work that is stopped once stops everywhere.
        if self.is_stopped.load(Ordering::Relaxed) { Err(Stopped) } else { Ok(()) }
    }

    fn expect(&self, work: f64) {
        self.progress.expect(work);
    }
}

impl Session {
    /// Returns the session of a process, with the words after its name; `quiet` omits messages and
    /// progress.
    pub(crate) fn of_process(words: &[OsString], quiet: bool, log: Option<Arc<RunLog>>) -> Self {
        let words = words.iter().map(|word| word.to_string_lossy().into_owned()).collect();
        Self::with(words, Channel::Terminal { quiet }, log, Given::default())
    }

    fn with(words: Vec<String>, channel: Channel, log: Option<Arc<RunLog>>, given: Given) -> Self {
        let inner = Arc::new(Inner { words, channel, log, remarked: Mutex::default() });
        Self { inner, given, tasks: Tasks::default() }
    }

    /// Returns the session of an embedding program without arrays. Nothing is written to the streams
    /// of the process: messages are collected, and `progress` is told the work and may stop it.
    #[must_use]
    pub fn new(progress: Arc<dyn Progress + Send + Sync>) -> Self {
        let progress = Arc::new(Watched { progress, is_stopped: AtomicBool::new(false) });
        let host = Host { progress, remarks: Arc::default(), output: Mutex::default() };
        Self::with(Vec::new(), Channel::Host(host), None, Given::default())
    }

    /// Returns the session of one run with these words after the name of the command. It shares
    /// arrays, collected messages and progress with this one.
    pub(crate) fn run(&self, words: &[String]) -> Self {
        let channel = match &self.inner.channel {
            Channel::Terminal { quiet } => Channel::Terminal { quiet: *quiet },
            Channel::Host(host) => Channel::Host(Host {
                progress: Arc::clone(&host.progress),
                remarks: Arc::clone(&host.remarks),
                output: Mutex::default(),
            }),
        };
        Self {
            tasks: self.tasks.clone(),
            ..Self::with(words.to_vec(), channel, self.inner.log.clone(), self.given.clone())
        }
    }

    /// Returns the session of one run with these words after the name of the command, whose tasks are
    /// those given.
    pub(crate) fn with_tasks(&self, words: &[String], tasks: Tasks) -> Self {
        Self { tasks, ..self.run(words) }
    }

    /// Returns the tasks of the run.
    pub(crate) fn tasks(&self) -> &Tasks {
        &self.tasks
    }

    /// Returns a session with the same arrays that reports nothing.
    pub(crate) fn muted(&self) -> Self {
        let channel = Channel::Terminal { quiet: true };
        let muted = Self::with(Vec::new(), channel, None, self.given.clone());
        Self { tasks: self.tasks.clone(), ..muted }
    }

    /// Returns the messages of all runs in their order, which the command prints to standard error,
    /// without those on progress. Warnings start with `warning: `.
    #[must_use]
    pub fn remarks(&self) -> Vec<String> {
        match &self.inner.channel {
            Channel::Terminal { .. } => Vec::new(),
            Channel::Host(host) => lock(&host.remarks).clone(),
        }
    }

    /// Returns the words after the name of the command.
    pub(crate) fn words(&self) -> &[String] {
        &self.inner.words
    }

    /// Returns whether the command is embedded in another program, so that it writes no files.
    pub(crate) fn is_embedded(&self) -> bool {
        matches!(self.inner.channel, Channel::Host(_))
    }

    /// Returns the progress of the embedding program.
    pub(crate) fn host_progress(&self) -> Option<Arc<dyn Progress + Send + Sync>> {
        match &self.inner.channel {
            Channel::Terminal { .. } => None,
            Channel::Host(host) => Some(Arc::clone(&host.progress) as _),
        }
    }

    /// Returns the log of the process.
    pub(crate) fn log(&self) -> Option<Arc<RunLog>> {
        self.inner.log.clone()
    }

    /// Returns whether the embedding program has stopped work.
    pub(crate) fn is_stopped(&self) -> bool {
        match &self.inner.channel {
            Channel::Terminal { .. } => false,
            Channel::Host(host) => host.progress.is_stopped.load(Ordering::Relaxed),
        }
    }

    /// Returns whether the process shows progress on standard error.
    pub(crate) fn shows_progress(&self) -> bool {
        matches!(self.inner.channel, Channel::Terminal { quiet: false })
    }

    /// Reports a message.
    pub(crate) fn say(&self, text: &str) {
        match &self.inner.channel {
            Channel::Terminal { quiet: true } => {}
            Channel::Terminal { quiet: false } => message::write(text),
            Channel::Host(host) => lock(&host.remarks).push(message::clean(text)),
        }
    }

    /// Reports a remark on an input: each text once, also where a run reads a file again.
    pub(crate) fn remark(&self, text: &str) {
        if lock(&self.inner.remarked).insert(text.to_owned()) {
            self.say(text);
        }
    }

    /// Writes text to the output of the run, which is standard output of a process.
    pub(crate) fn print(&self, text: &str) -> Result<(), CliError> {
        match &self.inner.channel {
            Channel::Terminal { .. } => write_stdout(text),
            Channel::Host(host) => {
                lock(&host.output).push_str(text);
                Ok(())
            }
        }
    }

    /// Returns the output of an embedded run, which is empty afterwards.
    pub(crate) fn take_output(&self) -> String {
        match &self.inner.channel {
            Channel::Terminal { .. } => String::new(),
            Channel::Host(host) => std::mem::take(&mut *lock(&host.output)),
        }
    }
}

/// The session of a process without words.
impl Default for Session {
    fn default() -> Self {
        Self::of_process(&[], false, None)
    }
}

impl fmt::Debug for Session {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Session").field("words", &self.inner.words).finish_non_exhaustive()
    }
}

fn write_stdout(text: &str) -> Result<(), CliError> {
    use std::io::Write;

    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(|e| CliError::stdout(&e))
}

/// Every change of the locked texts is complete, so a panic elsewhere leaves them valid.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
