//! Fuzzes every reader and grammar of the command: `fuzz [--seconds S] [--targets A,B] [--seed N] [--out FOLDER]`.
//!
//! Workers under limits of address space and processor time take batches of mutated valid inputs. An input is a
//! function of target and number, so that the batch of a worker that died or came late is bisected by running its
//! halves. A panic, an abort, memory beyond the limit or a late answer is a finding: the input is kept, shrunk,
//! in the folder. Most inputs of binary formats keep their layout (`structured`). Without `--seconds`, 10^6 inputs of each text reader and grammar are tried, 10^5 of each binary
//! one. The exit status is 1 if there are findings. `--targets planted` has three that must be found.

mod mutation;
mod structured;

use std::collections::BTreeMap;
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::{available_parallelism, scope, sleep};
use std::time::{Duration, Instant};

use mutation::{MAX_BYTES, Mutator};
use sphvar_cli::fuzzing::{PLANTED, TARGETS, Target};
use structured::Layout;

/// Limit of a worker's address space.
const MAX_KIB: u64 = 2 << 20;
/// Limits of a worker's processor time in seconds: for a batch, and for one input alone.
const BATCH_SECONDS: u64 = 30;
const INPUT_SECONDS: u64 = 5;
/// A worker that waits for something uses no processor.
const MAX_WAIT: Duration = Duration::from_secs(300);
/// The beginning of the names of the files that workers write for readers.
const SCRATCH: &str = "scratch-";
const BATCH: u64 = 1000;
/// Inputs kept of one target; further ones are counted.
const MAX_KEPT: usize = 20;
/// Attempts at making an input smaller, each a process.
const MAX_SHRINKS: usize = 200;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words[..] {
        ["--worker", name, first, count, scratch] => {
            let number = |word: &str| word.parse().expect("a number");
            work(target(name), number(first), number(count), Path::new(scratch));
            ExitCode::SUCCESS
        }
        ["--replay", name, input, scratch] => {
            let input = std::fs::read(input).expect("the input can be read");
            let target = target(name);
            let accepted = target.read(&input, &scratch_file(Path::new(scratch), target));
            say(if accepted { "accepted" } else { "rejected" });
            ExitCode::SUCCESS
        }
        _ => Run::new(&words).run(),
    }
}

fn say(text: &str) {
    // Nobody is left who could be told.
    let _ = writeln!(std::io::stdout(), "{text}");
}

fn target(name: &str) -> &'static Target {
    TARGETS.iter().find(|target| target.name == name).expect("a target")
}

fn scratch_file(folder: &Path, target: &Target) -> PathBuf {
    folder.join(format!("{SCRATCH}{}.{}", std::process::id(), target.extension))
}

/// The mutations of a target's own inputs and of those files of the tests that have its extension and are accepted.
fn mutator(target: &Target, scratch: &Path) -> Mutator {
    let mut seeds = target.seeds(scratch);
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/cli/tests/data");
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(data).into_iter().flatten().flatten().map(|entry| entry.path()).collect();
    files.sort();
    let is_own = |path: &&PathBuf| path.extension().is_some_and(|e| e == target.extension);
    let files = files.iter().filter(is_own).filter_map(|path| std::fs::read(path).ok());
    // A catalogue is no map, and most mutations of it would be rejected for that alone.
    seeds.extend(files.filter(|file| file.len() <= MAX_BYTES && target.read(file, scratch)));
    Mutator::new(target.name, seeds, Layout::of_extension(target.extension))
}

/// Tries a batch. Panics are reported at once, what else goes wrong is for the parent to find.
fn work(target: &Target, first: u64, count: u64, folder: &Path) {
    let scratch = scratch_file(folder, target);
    let mutator = mutator(target, &scratch);
    let place = std::sync::Arc::new(Mutex::new(String::new()));
    let seen = std::sync::Arc::clone(&place);
    std::panic::set_hook(Box::new(move |info| {
        if let Ok(mut place) = seen.lock() {
            *place = info.to_string().replace('\n', " ").chars().take(200).collect();
        }
    }));
    let mut accepted = 0_u64;
    for number in first..first + count {
        let input = mutator.input(number);
        match catch_unwind(AssertUnwindSafe(|| target.read(&input, &scratch))) {
            Ok(is_accepted) => accepted += u64::from(is_accepted),
            Err(_) => {
                let place = place.lock().map(|place| place.clone()).unwrap_or_default();
                say(&format!("panic\t{number}\t{place}"));
            }
        }
    }
    let _ = std::fs::remove_file(scratch);
    say(&format!("done\t{accepted}"));
}

/// The answer of a worker.
struct Answer {
    /// Inputs that were accepted; none if the worker did not come to its end.
    accepted: Option<u64>,
    panics: Vec<(u64, String)>,
    /// The failure of a worker that did not finish.
    end: String,
}

#[derive(Default)]
struct Counts {
    tried: u64,
    accepted: u64,
    /// By where they came from: how many, and the input of the first ones.
    findings: BTreeMap<String, u64>,
}

struct Run {
    targets: Vec<&'static Target>,
    until: Option<Instant>,
    first: u64,
    out: PathBuf,
    counts: Mutex<BTreeMap<&'static str, Counts>>,
    next: AtomicU64,
}

impl Run {
    fn new(words: &[&str]) -> Self {
        let mut run = Self {
            targets: TARGETS.iter().filter(|target| target.name != PLANTED).collect(),
            until: None,
            first: 0,
            out: PathBuf::from("target/fuzz"),
            counts: Mutex::new(BTreeMap::new()),
            next: AtomicU64::new(0),
        };
        for pair in words.chunks(2) {
            match pair {
                ["--seconds", seconds] => {
                    let seconds = seconds.parse().expect("seconds");
                    run.until = Some(Instant::now() + Duration::from_secs(seconds));
                }
                ["--targets", names] => run.targets = names.split(',').map(target).collect(),
                ["--seed", seed] => run.first = seed.parse::<u64>().expect("a seed") << 40,
                ["--out", folder] => run.out = PathBuf::from(folder),
                _ => panic!("usage: fuzz [--seconds S] [--targets A,B] [--seed N] [--out FOLDER]"),
            }
        }
        run
    }

    fn run(&self) -> ExitCode {
        std::fs::create_dir_all(&self.out).expect("the folder can be made");
        let threads = available_parallelism().map_or(1, usize::from);
        scope(|scope| {
            for _ in 0..threads {
                scope.spawn(|| while self.batch() {});
            }
        });
        self.tidy();
        let counts = self.counts.lock().expect("no thread panicked");
        let mut found = 0;
        for (name, counts) in &*counts {
            let total: u64 = counts.findings.values().sum();
            let Counts { tried, accepted, findings } = counts;
            say(&format!("{name:<16} {tried:>8} inputs, {accepted:>7} accepted, {total} findings"));
            for (what, count) in findings {
                say(&format!("    {count} times {what}"));
            }
            found += total;
        }
        let tried: u64 = counts.values().map(|counts| counts.tried).sum();
        say(&format!("{tried} inputs, {found} findings in {}", self.out.display()));
        ExitCode::from(u8::from(found > 0))
    }

    /// Removes the files that workers left which did not come to their ends.
    fn tidy(&self) {
        for entry in std::fs::read_dir(&self.out).into_iter().flatten().flatten() {
            if entry.file_name().to_string_lossy().starts_with(SCRATCH) {
                let _ = std::fs::remove_file(entry.path());
            }
        }
    }

    /// Takes the next batch, if there is one: the targets take turns.
    fn batch(&self) -> bool {
        let turn = self.next.fetch_add(1, Ordering::Relaxed);
        let n_targets = self.targets.len() as u64;
        let target = self.targets[usize::try_from(turn % n_targets).unwrap_or(0)];
        let round = turn / n_targets;
        let wanted = if target.is_text { 1_000_000 } else { 100_000 };
        let (is_over, size) = match self.until {
            // Small batches, so that the end is met.
            Some(until) => (Instant::now() >= until, BATCH / 4),
            None => (round * BATCH >= 1_000_000, BATCH),
        };
        if is_over {
            return false;
        }
        if self.until.is_some() || round * size < wanted {
            self.search(target, self.first + round * size, size);
        }
        true
    }

    /// Tries inputs, and their halves if the worker does not come to its end.
    fn search(&self, target: &'static Target, first: u64, count: u64) {
        let seconds = if count == 1 { INPUT_SECONDS } else { BATCH_SECONDS };
        let count_words = [first.to_string(), count.to_string()];
        let answer =
            self.ask(&["--worker", target.name, &count_words[0], &count_words[1]], seconds);
        if let Some(accepted) = answer.accepted {
            self.count(target, |counts| {
                counts.tried += count;
                counts.accepted += accepted;
            });
            for (number, what) in answer.panics {
                self.keep(target, number, &what);
            }
        } else if count == 1 {
            self.count(target, |counts| counts.tried += 1);
            self.keep(target, first, &answer.end);
        } else {
            self.search(target, first, count / 2);
            self.search(target, first + count / 2, count - count / 2);
        }
    }

    fn count(&self, target: &Target, change: impl FnOnce(&mut Counts)) {
        let mut counts = self.counts.lock().expect("no thread panicked");
        change(counts.entry(target.name).or_default());
    }

    /// Keeps an input and a smaller one.
    fn keep(&self, target: &'static Target, number: u64, what: &str) {
        let mut is_new = false;
        self.count(target, |counts| {
            is_new = !counts.findings.contains_key(what) && counts.findings.len() < MAX_KEPT;
            // Those of one kind are counted together.
            *counts.findings.entry(what.to_owned()).or_default() += 1;
        });
        if !is_new {
            return;
        }
        let name = format!("{}-{number}", target.name);
        let scratch = self.out.join(format!("{name}.seed.{}", target.extension));
        let input = mutator(target, &scratch).input(number);
        let path = self.out.join(format!("{name}.{}", target.extension));
        let _ = std::fs::remove_file(scratch);
        std::fs::write(&path, &input).expect("the input can be kept");
        let small = self.shrunk(target, input, &self.out.join(format!("{name}.trial")));
        std::fs::write(path.with_extension(format!("small.{}", target.extension)), small)
            .expect("the input can be kept");
        say(&format!("{name}: {what}"));
    }

    /// Leaves out ever smaller pieces as long as the finding stays.
    fn shrunk(&self, target: &Target, mut input: Vec<u8>, trial: &Path) -> Vec<u8> {
        let mut size = input.len() / 2;
        let mut attempts = 0;
        while size > 0 && attempts < MAX_SHRINKS {
            let mut at = 0;
            while at < input.len() && attempts < MAX_SHRINKS {
                let mut less = input.clone();
                less.drain(at..(at + size).min(input.len()));
                std::fs::write(trial, &less).expect("a trial can be written");
                let words = ["--replay", target.name, &trial.display().to_string()];
                attempts += 1;
                if self.ask(&words, INPUT_SECONDS).accepted.is_none() {
                    input = less;
                } else {
                    at += size;
                }
            }
            size /= 2;
        }
        let _ = std::fs::remove_file(trial);
        input
    }

    /// Runs a worker under its limits.
    fn ask(&self, words: &[&str], seconds: u64) -> Answer {
        let limits = format!("ulimit -v {MAX_KIB} && ulimit -t {seconds} && exec \"$0\" \"$@\"");
        let program = std::env::current_exe().expect("the program knows its name");
        let mut child = Command::new("sh")
            .args(["-c", &limits])
            .arg(program)
            .args(words)
            .arg(&self.out)
            .env("RAYON_NUM_THREADS", "1")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("a worker can be started");
        let start = Instant::now();
        // Answers of a batch fit into a pipe, unless all of it panics; then the bisection finds that.
        while child.try_wait().expect("a worker can be waited for").is_none() {
            if start.elapsed() > MAX_WAIT {
                let _ = child.kill();
            }
            sleep(Duration::from_millis(5));
        }
        let output = child.wait_with_output().expect("a worker has an answer");
        let text = String::from_utf8_lossy(&output.stdout);
        let mut answer = Answer { accepted: None, panics: Vec::new(), end: String::new() };
        for line in text.lines() {
            match line.split('\t').collect::<Vec<_>>()[..] {
                ["done", accepted] => answer.accepted = accepted.parse().ok(),
                ["accepted"] | ["rejected"] => answer.accepted = Some(1),
                ["panic", number, what] => {
                    answer
                        .panics
                        .extend(number.parse().ok().map(|number| (number, what.to_owned())));
                }
                _ => (),
            }
        }
        let message = String::from_utf8_lossy(&output.stderr);
        let last = message.lines().next().unwrap_or_default();
        answer.end = format!("{}: {last:.150}", output.status);
        answer
    }
}
