//! `sphvar plan status`: what of a plan is done, from its results and logs.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use clap::Args;
use schemars::JsonSchema;
use serde::Serialize;
use sysinfo::{Pid, ProcessRefreshKind, ProcessStatus, ProcessesToUpdate, System};

use super::manifest::{Engine, LOGS, Manifest};
use super::part_list::part_list;
use crate::error::CliError;
use crate::global::Global;
use crate::message;
use crate::progress::rough;
use crate::report::{Document, Provenance};
use crate::run_log::{Event, LogLine, now, read_log, this_host};
use crate::shards::{Request, ShardFile, UnfinishedWork};

/// A run is taken for ended if its next line is later than expected by this factor and this number of
/// seconds, for slow file systems and clocks that differ.
const PATIENCE: (f64, f64) = (2.0, 30.0);
/// The seconds to the second line of a log.
const FIRST_LINE: f64 = 1.0;
/// The number of bytes at the end of an output in which its message is searched.
const OUTPUT_END: u64 = 4096;
/// The maximum number of failed parts whose messages are printed.
const MAX_LISTED: usize = 12;

#[derive(Debug, Args)]
pub(crate) struct StatusArgs {
    /// Folder of the plan
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Print only the line of a shell that runs failed and missing parts again, and then the merge; or the merge alone if it failed
    #[arg(long)]
    resubmit: bool,
}

/// The state of a plan: `sphvar plan status DIR --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct StatusBody {
    /// The number of parts.
    parts: u64,
    /// The number of parts whose results are complete.
    done: u64,
    /// The number of parts that are computed now.
    running: u64,
    /// The number of parts that ended with an error, stopped reporting, or have results that cannot be
    /// merged.
    failed: u64,
    /// The number of parts that were not started, among them those in the queue of the engine.
    missing: u64,
    /// The parts that are computed now.
    running_parts: Vec<RunningPart>,
    /// The parts that failed.
    failed_parts: Vec<FailedPart>,
    /// The parts that were not started.
    missing_parts: Vec<u64>,
    /// The share of the work that is done, from 0 to 1.
    progress: f64,
    /// The expected remaining seconds with as many parts at a time as now; null if no part is running
    /// or none has measured its pace.
    seconds_left: Option<f64>,
    /// The instruction sets of the machines that computed the parts that are done; only parts of the
    /// same one can be merged.
    instruction_sets: Vec<String>,
    /// Whether the last merge succeeded; null if there was none, or it is running.
    merged: Option<bool>,
    /// Why the last merge failed; null if it did not.
    merge_message: Option<String>,
    /// The line of a shell that runs the failed and missing parts again, and then the merge, or the
    /// merge alone if all parts are done; null if they are merged or the merge is running.
    resubmit: Option<String>,
}

/// A part that is computed now.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub(crate) struct RunningPart {
    /// The number of the part.
    part: u64,
    /// The machine; null if the part has no log.
    host: Option<String>,
    /// The share of its work that is done, from 0 to 1; null if it is not known.
    done: Option<f64>,
    /// The expected remaining seconds; null if they are not known.
    seconds_left: Option<f64>,
}

/// A part that failed.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub(crate) struct FailedPart {
    /// The number of the part.
    part: u64,
    /// Why it failed.
    message: String,
}

/// What is known of a part.
struct PartReport {
    state: State,
    /// The seconds of all its runs.
    seconds: f64,
}

/// What is known of the merge.
enum Merge {
    NotStarted,
    Running,
    Done,
    Failed(String),
}

enum State {
    Done { instruction_set: String },
    Running(RunningPart),
    Failed(FailedPart),
    Missing,
}

pub(super) fn run(args: &StatusArgs, global: &Global) -> Result<(), CliError> {
    let manifest = Manifest::of_folder(&args.folder)?;
    let reports: Vec<PartReport> =
        (1..=manifest.parts).map(|part| report(&manifest, &args.folder, part)).collect();
    let merge = merge_state(&args.folder);
    let body = body(&manifest, &args.folder, &reports, &merge)?;
    if global.json {
        let provenance = Provenance::new(&global.session, global.seed);
        Document::new(&body, &provenance).print(&global.session)?;
    } else if args.resubmit {
        let line = body.resubmit.as_ref().map(|line| format!("{line}\n"));
        global.session.print(&line.unwrap_or_default())?;
    } else {
        global.session.print(&text(&body, &merge))?;
    }
    match merge {
        _ if body.failed > 0 => Err(CliError::PlanFailed),
        _ if body.done < body.parts => Err(CliError::NotDone),
        Merge::Done => Ok(()),
        Merge::Failed(_) => Err(CliError::PlanFailed),
        Merge::NotStarted | Merge::Running => Err(CliError::NotDone),
    }
}

fn body(
    manifest: &Manifest,
    folder: &Path,
    reports: &[PartReport],
    merge: &Merge,
) -> Result<StatusBody, CliError> {
    let (mut running, mut failed, mut missing) = (Vec::new(), Vec::new(), Vec::new());
    let (mut done, mut instruction_sets) = (0, Vec::new());
    for (part, report) in (1..).zip(reports) {
        match &report.state {
            State::Done { instruction_set } => {
                done += 1;
                if !instruction_sets.contains(instruction_set) {
                    instruction_sets.push(instruction_set.clone());
                }
            }
            State::Running(state) => running.push(state.clone()),
            State::Failed(state) => failed.push(state.clone()),
            State::Missing => missing.push(part),
        }
    }
    let mut again: Vec<u64> =
        failed.iter().map(|failed| failed.part).chain(missing.iter().copied()).collect();
    again.sort_unstable();
    let resubmit = if !again.is_empty() {
        Some(super::run_line(manifest, folder, Some(&part_list(&again)))?)
    } else if done == manifest.parts && matches!(merge, Merge::NotStarted | Merge::Failed(_)) {
        Some(super::merge_line(folder)?)
    } else {
        None
    };
    let (merged, merge_message) = match merge {
        Merge::NotStarted | Merge::Running => (None, None),
        Merge::Done => (Some(true), None),
        Merge::Failed(message) => (Some(false), Some(message.clone())),
    };
    let share = |state: &RunningPart| state.done.unwrap_or(0.0);
    let progress = (done as f64 + running.iter().map(share).sum::<f64>()) / manifest.parts as f64;
    Ok(StatusBody {
        parts: manifest.parts,
        done,
        running: running.len() as u64,
        failed: failed.len() as u64,
        missing: missing.len() as u64,
        progress,
        seconds_left: seconds_left(reports, again.len()),
        instruction_sets,
        merged,
        merge_message,
        resubmit,
        running_parts: running,
        failed_parts: failed,
        missing_parts: missing,
    })
}

/// Returns the state of a part.
fn report(manifest: &Manifest, folder: &Path, part: u64) -> PartReport {
    let path = manifest.part_path(folder, part);
    let runs = match read_log(&manifest.log_path(folder, part)) {
        Ok(lines) => runs(lines),
        Err(error) => {
            let message = format!("its log cannot be read: {error}");
            return PartReport { state: failed(part, message), seconds: 0.0 };
        }
    };
    let seconds = runs.iter().filter_map(|last| last.seconds).sum();
    let state = match state(manifest, &path, part, &runs) {
        // The program has not started, or not as far as its log.
        State::Missing => match final_message(&manifest.output_path(folder, part)) {
            Some(message) => failed(part, message),
            None => of_slurm(manifest, folder, part).unwrap_or(State::Missing),
        },
        // Without a message of its own, a part may have been killed by Slurm.
        State::Failed(known) if is_silent(&runs) => {
            of_slurm(manifest, folder, part).unwrap_or(State::Failed(known))
        }
        state => state,
    };
    PartReport { state, seconds }
}

/// Returns the failure of a part that Slurm reported, such as a time limit that was exceeded.
fn of_slurm(manifest: &Manifest, folder: &Path, part: u64) -> Option<State> {
    if manifest.engine != Engine::Slurm {
        return None;
    }
    final_message(&manifest.slurm_path(folder, part)).map(|message| failed(part, message))
}

/// Returns whether the last run has neither ended nor reported an error.
fn is_silent(runs: &[LogLine]) -> bool {
    runs.last().is_none_or(|last| matches!(last.event, Event::Start | Event::Progress))
}

/// Returns the last error in what a process printed, or else its last line; `None` if there is
/// none.
fn final_message(path: &Path) -> Option<String> {
    let mut file = File::open(path).ok()?;
    let length = file.metadata().ok()?.len();
    file.seek(SeekFrom::Start(length.saturating_sub(OUTPUT_END))).ok()?;
    let mut bytes = Vec::new();
    file.take(OUTPUT_END).read_to_end(&mut bytes).ok()?;
    let text = String::from_utf8_lossy(&bytes);
    let lines = || text.lines().rev().map(str::trim).filter(|line| !line.is_empty());
    // Advice follows the error of a command line.
    let error = lines().find_map(|line| line.strip_prefix("error: "));
    error.or_else(|| lines().next()).map(|line| message::escape(line).into_owned())
}

fn failed(part: u64, message: String) -> State {
    State::Failed(FailedPart { part, message })
}

fn state(manifest: &Manifest, path: &Path, part: u64, runs: &[LogLine]) -> State {
    let found = path.exists().then(|| check(manifest, path, part));
    if let Some(Ok(instruction_set)) = found {
        return State::Done { instruction_set };
    }
    let alive = runs.iter().filter(|last| is_alive(last));
    let furthest = alive.max_by(|a, b| a.done.unwrap_or(0.0).total_cmp(&b.done.unwrap_or(0.0)));
    if let Some(last) = furthest {
        let host = Some(last.host.clone());
        return State::Running(RunningPart {
            part,
            host,
            done: last.done,
            seconds_left: last.seconds_left,
        });
    }
    let unfinished = UnfinishedWork::of(path);
    if unfinished == UnfinishedWork::Open {
        let (host, done, seconds_left) = (None, None, None);
        return State::Running(RunningPart { part, host, done, seconds_left });
    }
    let of_log = runs.last().map(|last| match (last.event, &last.message) {
        (Event::Error, Some(message)) => message.clone(),
        (Event::Error | Event::End, _) => "it has ended without results".to_owned(),
        (Event::Start | Event::Progress, _) => {
            format!("process {} on {} stopped without a message", last.process, last.host)
        }
    });
    match (of_log, found) {
        // An error that was reported after the results were damaged is the later one.
        (Some(message), Some(Err(_)) | None) if !is_end(runs) => failed(part, message),
        (_, Some(Err(message))) => failed(part, message),
        (Some(message), _) => failed(part, message),
        (None, _) if unfinished == UnfinishedWork::Left => {
            failed(part, "its process stopped without a message".to_owned())
        }
        (None, _) => State::Missing,
    }
}

/// Returns whether the last run ended well.
fn is_end(runs: &[LogLine]) -> bool {
    runs.last().is_some_and(|last| last.event == Event::End)
}

/// Returns the instruction set of the results of a part, or why they cannot be merged.
fn check(manifest: &Manifest, path: &Path, part: u64) -> Result<String, String> {
    let request = ShardFile::verify(path).map_err(|error| error.to_string())?;
    let shown = path.display();
    if request.version != manifest.version {
        return Err(format!(
            "{shown} is of sphvar {}, and the plan of {}",
            request.version, manifest.version
        ));
    }
    let is_it = request.words == Request::words_of(&manifest.words)
        && (request.of, &*request.parts) == (manifest.parts, &[part]);
    if is_it { Ok(request.instruction_set) } else { Err(format!("{shown} is of another plan")) }
}

/// Returns the last line of every run, in the order in which the runs started, with the seconds that
/// it took.
fn runs(lines: Vec<LogLine>) -> Vec<LogLine> {
    let mut runs: Vec<LogLine> = Vec::new();
    let mut at: BTreeMap<(String, u32), usize> = BTreeMap::new();
    for line in lines {
        let run = (line.host.clone(), line.process);
        match at.get(&run) {
            Some(&i) if line.event != Event::Start => runs[i] = line,
            _ => {
                at.insert(run, runs.len());
                runs.push(line);
            }
        }
    }
    runs
}

/// Returns whether a run with this last line goes on.
fn is_alive(last: &LogLine) -> bool {
    if matches!(last.event, Event::End | Event::Error) {
        return false;
    }
    let (factor, seconds) = PATIENCE;
    let is_recent = now() - last.time <= factor * last.next.unwrap_or(FIRST_LINE) + seconds;
    is_recent && (last.host != this_host() || is_process(last.process))
}

/// Returns whether a process of this machine exists.
fn is_process(number: u32) -> bool {
    let mut system = System::new();
    let pid = Pid::from_u32(number);
    let kind = ProcessRefreshKind::nothing();
    system.refresh_processes_specifics(ProcessesToUpdate::Some(&[pid]), true, kind);
    let ended = [ProcessStatus::Zombie, ProcessStatus::Dead];
    system.process(pid).is_some_and(|process| !ended.contains(&process.status()))
}

/// Returns the expected remaining seconds of all parts, `waiting` of which are not running.
fn seconds_left(reports: &[PartReport], waiting: usize) -> Option<f64> {
    let running: Vec<(f64, Option<f64>)> = reports
        .iter()
        .filter_map(|report| match &report.state {
            State::Running(part) => Some((report.seconds, part.seconds_left)),
            _ => None,
        })
        .collect();
    let done = |report: &PartReport| matches!(report.state, State::Done { .. });
    let measured: Vec<f64> = reports
        .iter()
        .filter(|report| done(report) && report.seconds > 0.0)
        .map(|report| report.seconds)
        .chain(running.iter().filter_map(|(seconds, left)| Some(seconds + (*left)?)))
        .collect();
    if running.is_empty() || measured.is_empty() {
        return None;
    }
    let mean = measured.iter().sum::<f64>() / measured.len() as f64;
    let left: Vec<f64> =
        running.iter().map(|(seconds, left)| left.unwrap_or((mean - seconds).max(0.0))).collect();
    let shared = (left.iter().sum::<f64>() + mean * waiting as f64) / running.len() as f64;
    Some(left.into_iter().fold(shared, f64::max))
}

/// Returns the state of the last merge.
fn merge_state(folder: &Path) -> Merge {
    let logs = folder.join(LOGS);
    let lines = match read_log(&logs.join("merge.jsonl")) {
        Ok(lines) => lines,
        Err(error) => return Merge::Failed(format!("its log cannot be read: {error}")),
    };
    let output =
        || ["merge.err", "merge.out"].iter().find_map(|name| final_message(&logs.join(name)));
    let Some(last) = runs(lines).pop() else {
        // Engines keep what is printed before the log starts.
        return output().map_or(Merge::NotStarted, Merge::Failed);
    };
    match (last.event, &last.message) {
        (Event::End, _) => Merge::Done,
        (Event::Error, Some(message)) => Merge::Failed(message.clone()),
        (Event::Error, None) => Merge::Failed("it has ended without results".to_owned()),
        (Event::Start | Event::Progress, _) if is_alive(&last) => Merge::Running,
        (Event::Start | Event::Progress, _) => Merge::Failed(format!(
            "process {} on {} stopped without a message",
            last.process, last.host
        )),
    }
}

fn text(body: &StatusBody, merge: &Merge) -> String {
    let StatusBody { parts, done, running, failed, missing, .. } = body;
    let mut text = format!(
        "{parts} {}: {done} done, {running} running, {failed} failed, {missing} missing\n",
        if *parts == 1 { "part" } else { "parts" }
    );
    if done < parts {
        text += &format!("{:.0} % done", (100.0 * body.progress).floor());
        if let Some(left) = body.seconds_left {
            text += &format!(", about {} left with {running} at a time", rough(left));
        }
        text += "\n";
    }
    let numbers = |parts: &mut dyn Iterator<Item = u64>| part_list(&parts.collect::<Vec<_>>());
    if *running > 0 {
        let parts = numbers(&mut body.running_parts.iter().map(|part| part.part));
        text += &format!("running: {parts}\n");
    }
    if *failed > 0 {
        let parts = numbers(&mut body.failed_parts.iter().map(|part| part.part));
        text += &format!("failed: {parts}\n");
        for FailedPart { part, message } in body.failed_parts.iter().take(MAX_LISTED) {
            text += &format!("  part {part}: {message}\n");
        }
        if body.failed_parts.len() > MAX_LISTED {
            text += "  ...\n";
        }
    }
    if *missing > 0 {
        text += &format!("missing: {}\n", part_list(&body.missing_parts));
    }
    if body.instruction_sets.len() > 1 {
        text += &format!(
            "the parts are of machines with different instruction sets and cannot be merged: {}\n",
            body.instruction_sets.join("; ")
        );
    }
    match merge {
        Merge::Done => text += "merged\n",
        Merge::Running => text += "the merge is running\n",
        Merge::Failed(message) => text += &format!("the last merge failed: {message}\n"),
        Merge::NotStarted => {}
    }
    text + &next_step(body, merge)
}

/// Returns the line about what is to be done, or about what waits.
fn next_step(body: &StatusBody, merge: &Merge) -> String {
    let Some(line) = &body.resubmit else { return String::new() };
    match merge {
        _ if body.failed > 0 => format!("run failed and missing parts again: {line}\n"),
        _ if body.running > 0 => {
            "the missing parts wait for those that run, or in the queue of the engine\n".to_owned()
        }
        _ if body.missing > 0 => {
            format!(
                "nothing runs; unless the parts wait in the queue of the engine, run them: {line}\n"
            )
        }
        Merge::Failed(_) => format!("run the merge again: {line}\n"),
        _ => format!(
            "not merged; unless the merge waits in the queue of the engine, run it: {line}\n"
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::{PartReport, RunningPart, State, is_process, seconds_left};

    fn done(seconds: f64) -> PartReport {
        PartReport { state: State::Done { instruction_set: String::new() }, seconds }
    }

    fn running(seconds: f64, seconds_left: Option<f64>) -> PartReport {
        let part = RunningPart { part: 1, host: None, done: None, seconds_left };
        PartReport { state: State::Running(part), seconds }
    }

    #[test]
    fn the_remaining_time_is_that_of_the_parts_that_run() {
        // Nothing runs, or no pace is known.
        assert_eq!(seconds_left(&[done(10.0)], 3), None);
        assert_eq!(seconds_left(&[running(2.0, None)], 3), None);
        // Two at a time: 4 + 6 s, and two parts of 10 s on average.
        let reports = [done(10.0), running(6.0, Some(4.0)), running(4.0, Some(6.0))];
        assert_eq!(seconds_left(&reports, 2), Some(15.0));
        // Not less than the slowest part.
        assert_eq!(
            seconds_left(&[running(1.0, Some(99.0)), running(1.0, Some(1.0))], 0),
            Some(99.0)
        );
        // A part without a pace is like the others.
        assert_eq!(seconds_left(&[done(10.0), running(4.0, None)], 0), Some(6.0));
    }

    #[test]
    fn a_process_that_has_ended_is_none() {
        assert!(is_process(std::process::id()));
        let mut child = std::process::Command::new("true").spawn().unwrap();
        let number = child.id();
        std::thread::sleep(std::time::Duration::from_millis(100));
        // Not yet waited for.
        assert!(!is_process(number));
        child.wait().unwrap();
        assert!(!is_process(number));
    }
}
