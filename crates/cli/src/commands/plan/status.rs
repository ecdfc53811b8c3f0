//! `sphvar plan status`: what of a plan is done, from its results and logs.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Args;
use schemars::JsonSchema;
use serde::Serialize;
use sysinfo::{Pid, ProcessRefreshKind, ProcessStatus, ProcessesToUpdate, System};

use super::manifest::{LOGS, Manifest};
use super::part_list::part_list;
use crate::error::CliError;
use crate::global::Global;
use crate::progress::rough;
use crate::report::{Document, Provenance};
use crate::run_log::{Event, LogLine, now, read_log, this_host};
use crate::shards::{Request, ShardFile, UnfinishedWork};

/// A run is taken for ended if its next line is later than expected by this factor and this number of
/// seconds, for slow file systems and clocks that differ.
const PATIENCE: (f64, f64) = (2.0, 30.0);
/// The seconds to the second line of a log.
const FIRST_LINE: f64 = 1.0;
/// The maximum number of failed parts whose messages are printed.
const MAX_LISTED: usize = 12;

#[derive(Debug, Args)]
pub(crate) struct StatusArgs {
    /// Folder of the plan
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Print only the line of a shell that runs failed and missing parts again, and then the merge
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
    /// The line of a shell that runs the failed and missing parts again, and then the merge; null if
    /// there are none.
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
    let body = body(&manifest, &args.folder, &reports)?;
    if global.json {
        let provenance = Provenance::new(&global.session, global.seed);
        Document::new(&body, &provenance).print(&global.session)?;
    } else if args.resubmit {
        let line = body.resubmit.as_ref().map(|line| format!("{line}\n"));
        global.session.print(&line.unwrap_or_default())?;
    } else {
        global.session.print(&text(&body))?;
    }
    if body.done == body.parts { Ok(()) } else { Err(CliError::NotDone) }
}

fn body(
    manifest: &Manifest,
    folder: &Path,
    reports: &[PartReport],
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
    let resubmit = (!again.is_empty())
        .then(|| super::run_line(manifest, folder, Some(&part_list(&again))))
        .transpose()?;
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
        merged: merged(folder),
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
    PartReport { state: state(manifest, &path, part, &runs), seconds }
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

/// Returns whether the last merge succeeded.
fn merged(folder: &Path) -> Option<bool> {
    let lines = read_log(&folder.join(LOGS).join("merge.jsonl")).ok()?;
    let last = runs(lines).pop()?;
    match last.event {
        Event::End => Some(true),
        _ if is_alive(&last) => None,
        _ => Some(false),
    }
}

fn text(body: &StatusBody) -> String {
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
    match body.merged {
        Some(true) => text += "merged\n",
        Some(false) => text += "the last merge failed\n",
        None => {}
    }
    if let Some(line) = &body.resubmit {
        text += &format!("run failed and missing parts again: {line}\n");
    }
    text
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
