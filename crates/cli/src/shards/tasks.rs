//! The expensive work of a run, as tasks whose results can be kept and divided.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Instant;

use serde::Serialize;
use serde::de::DeserializeOwned;
use sphvar_samplers::SECONDS_PER_WORK;

use super::file::{Content, Piece, Record, Results, ShardFile};
use super::fingerprint::Fingerprint;
use super::unfinished::Unfinished;
use super::{Part, Request};
use crate::error::CliError;
use crate::files::{inputs, set_last_output};
use crate::progress::Progress;
use crate::session::lock;

/// The tasks of a run.
///
/// Tasks are requested in the same order by every part and by the merge. A task has a name that no
/// other task of the run has, unless it has the same result. Clones share everything.
#[derive(Clone, Default)]
pub(crate) struct Tasks(Kind);

#[derive(Clone, Default)]
enum Kind {
    /// Everything is computed and nothing is kept.
    #[default]
    All,
    Part(Arc<PartOfRun>),
    Merged(Arc<MergedRun>),
    Planned(Arc<PlannedRun>),
}

/// A run that computes nothing: it shows which tasks a part would have.
struct PlannedRun {
    part: Part,
    /// The number of units of all tasks so far.
    units: Mutex<u64>,
}

/// A run that keeps its results.
struct PartOfRun {
    part: Part,
    target: PathBuf,
    state: Mutex<State>,
}

struct State {
    request: Request,
    unfinished: Option<Unfinished>,
    /// What was known at the start.
    known: ShardFile,
    /// What the file will contain.
    results: Results,
    inputs: BTreeMap<String, Fingerprint>,
    /// The number of parts before the one that takes the next unit in turn.
    in_turn: u64,
}

/// A run whose results are known.
struct MergedRun {
    known: ShardFile,
    /// Whether results may be missing.
    is_partial: bool,
    are_inputs_checked: Mutex<bool>,
}

/// A task over units such as realizations, which can be computed in any ranges.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Divided<'a> {
    pub(crate) name: &'a str,
    /// The number of units.
    pub(crate) count: u64,
    /// The nominal work of a unit.
    pub(crate) work: f64,
}

/// The time of a piece, which is the most that is lost when a process is killed.
const PIECE_SECONDS: f64 = 5.0;
/// A piece takes at least this many times the time that it takes to keep it.
const MIN_RATIO: f64 = 30.0;
/// A piece has at least this many units for every thread.
const UNITS_PER_THREAD: u64 = 4;

impl Tasks {
    /// Returns the tasks of a run that keeps its results in `target`, where it has a part of the
    /// work. Results that are there already, or that an interrupted run of the same question has
    /// left, are not computed again.
    ///
    /// # Errors
    ///
    /// If another process has the unfinished work open and `waits` is false, or it is of another
    /// question.
    pub(crate) fn of_part(
        request: Request,
        part: Part,
        target: &Path,
        waits: bool,
    ) -> Result<Self, CliError> {
        let (unfinished, mut known) = Unfinished::open(target, &request, waits)?;
        match ShardFile::read(target) {
            // Unfinished work is later than the file, whose inputs have changed since.
            Ok(done) if done.request == request => {
                if known.results.is_empty() {
                    known = done;
                }
            }
            Ok(other) => return Err(has_others(target, &other.request)),
            Err(_) if ShardFile::may_replace(target) => {}
            Err(_) => {
                return Err(CliError::File(format!(
                    "{} exists and is not a file of --save; remove it, or name another file",
                    target.display()
                )));
            }
        }
        let state = State {
            request,
            unfinished: Some(unfinished),
            known,
            results: Results::new(),
            inputs: BTreeMap::new(),
            in_turn: 0,
        };
        let (target, state) = (target.to_path_buf(), Mutex::new(state));
        Ok(Self(Kind::Part(Arc::new(PartOfRun { part, target, state }))))
    }

    /// Returns the tasks of a run with known results, all of them unless it is partial.
    pub(crate) fn of_results(known: ShardFile, is_partial: bool) -> Self {
        let are_inputs_checked = Mutex::default();
        Self(Kind::Merged(Arc::new(MergedRun { known, is_partial, are_inputs_checked })))
    }

    /// Returns the tasks of a run that checks a command as one of its parts does and computes nothing.
    pub(crate) fn planned(part: Part) -> Self {
        Self(Kind::Planned(Arc::new(PlannedRun { part, units: Mutex::default() })))
    }

    /// Returns the number of units of all tasks of a planned run, an indivisible task being one.
    pub(crate) fn planned_units(&self) -> u64 {
        match &self.0 {
            Kind::Planned(run) => *lock(&run.units),
            Kind::All | Kind::Part(_) | Kind::Merged(_) => 0,
        }
    }

    /// Returns the part that the run computes.
    pub(crate) fn part(&self) -> Part {
        match &self.0 {
            Kind::Part(run) => run.part,
            Kind::Planned(run) => run.part,
            Kind::All | Kind::Merged(_) => Part::WHOLE,
        }
    }

    /// Returns whether the run computes only a part, so that it has no result to report.
    pub(crate) fn is_part(&self) -> bool {
        !self.part().is_whole()
    }

    /// Returns whether the results are known, so that nothing is computed.
    pub(crate) fn is_merge(&self) -> bool {
        matches!(self.0, Kind::Merged(_))
    }

    /// Ends a run without results: that of a part is complete, that of a merge has too few parts.
    ///
    /// # Errors
    ///
    /// For a merge.
    pub(crate) fn without_results(&self) -> Result<(), CliError> {
        if !self.is_merge() {
            return Ok(());
        }
        let text = "the given parts do not have all that a result needs; add other parts";
        Err(CliError::File(text.to_owned()))
    }

    /// Returns the share of the work that this run does, for progress.
    pub(crate) fn share(&self) -> f64 {
        match &self.0 {
            Kind::Merged(_) | Kind::Planned(_) => 0.0,
            _ => (self.part().parts as f64).recip(),
        }
    }

    /// Returns the result of a task that one process computes; `None` if another part has it, or if it
    /// is missing from a partial merge.
    ///
    /// # Errors
    ///
    /// Those of the task, and if its result cannot be kept or is not in the merged files.
    pub(crate) fn once<T: Serialize + DeserializeOwned>(
        &self,
        name: &str,
        compute: impl FnOnce() -> Result<T, CliError>,
    ) -> Result<Option<T>, CliError> {
        let run = match &self.0 {
            Kind::All => return compute().map(Some),
            Kind::Merged(run) => {
                let pieces = run.pieces(name)?;
                return pieces.first().map(|piece| decode(name, piece)).transpose();
            }
            Kind::Planned(run) => {
                run.add(1);
                return Ok(None);
            }
            Kind::Part(run) => run,
        };
        if run.range(1).is_empty() {
            return Ok(None);
        }
        let known = run.known(name)?;
        let result = match known.first() {
            Some(piece) => decode(name, piece)?,
            None => {
                let result = compute()?;
                run.keep(name, piece(0..1, 1, &result)?)?;
                result
            }
        };
        run.finish(name, piece(0..1, 1, &result)?);
        Ok(run.part.is_whole().then_some(result))
    }

    /// Returns the result of a task for all its units; `None` if this run computes only a part, or if
    /// nothing is known in a partial merge, which otherwise has the result for the units that are
    /// known. `append` adds the result for the units that follow.
    ///
    /// # Errors
    ///
    /// Those of the task, and if its result cannot be kept or is not in the merged files.
    pub(crate) fn divided<T: Serialize + DeserializeOwned>(
        &self,
        task: Divided<'_>,
        progress: &Progress,
        mut append: impl FnMut(&mut T, T) -> Result<(), CliError>,
        mut compute: impl FnMut(Range<u64>) -> Result<T, CliError>,
    ) -> Result<Option<T>, CliError> {
        let Divided { name, count, work } = task;
        if count == 0 {
            return compute(0..0).map(Some);
        }
        let run = match &self.0 {
            Kind::All => return compute(0..count).map(Some),
            Kind::Merged(run) => return run.sum(name, count, append),
            Kind::Planned(run) => {
                run.add(count);
                return Ok(None);
            }
            Kind::Part(run) => run,
        };
        let range = run.range(count);
        if range.is_empty() {
            return Ok(None);
        }
        let (mut sum, mut next) = (None, range.start);
        let mut add = |sum: &mut Option<T>, result: T| match sum {
            None => {
                *sum = Some(result);
                Ok(())
            }
            Some(sum) => append(sum, result),
        };
        for piece in run.known(name)? {
            if piece.start == next && piece.end <= range.end {
                add(&mut sum, decode(name, &piece)?)?;
                progress.advance(work * (piece.end - piece.start) as f64)?;
                next = piece.end;
            }
        }
        let threads = rayon::current_num_threads().max(1);
        let mut pace = SECONDS_PER_WORK * work / threads as f64;
        let mut seconds = PIECE_SECONDS;
        while next < range.end {
            let end = range.end.min(next.saturating_add(units(seconds / pace, threads)));
            let started = Instant::now();
            let result = compute(next..end)?;
            let computed = Instant::now();
            run.keep(name, piece(next..end, count, &result)?)?;
            pace = (computed - started).as_secs_f64() / (end - next) as f64;
            seconds = PIECE_SECONDS.max(MIN_RATIO * computed.elapsed().as_secs_f64());
            add(&mut sum, result)?;
            next = end;
        }
        if let Some(sum) = &sum {
            run.finish(name, piece(range, count, sum)?);
        }
        Ok(sum.filter(|_| run.part.is_whole()))
    }

    /// Ends the run: the file of a part is complete under its name.
    ///
    /// # Errors
    ///
    /// If it cannot be written.
    pub(crate) fn finish(&self) -> Result<(), CliError> {
        let Kind::Part(run) = &self.0 else { return Ok(()) };
        let mut state = run.state();
        run.check_inputs(&mut state)?;
        let file = ShardFile {
            request: state.request.clone(),
            inputs: std::mem::take(&mut state.inputs),
            results: std::mem::take(&mut state.results),
        };
        set_last_output(None);
        file.write(&run.target)?;
        state.unfinished.take().map_or(Ok(()), Unfinished::remove)
    }
}

/// Returns the error for a file that has other results.
fn has_others(target: &Path, request: &Request) -> CliError {
    let parts: Vec<String> = request.parts.iter().map(u64::to_string).collect();
    CliError::File(format!(
        "{} has part {} of {} of {} ({} on {}); remove it, or name another file",
        target.display(),
        parts.join(", "),
        request.of,
        request.command(),
        request.version,
        request.instruction_set
    ))
}

/// Returns the number of units of a piece, given how many take the time of one.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a positive number, and the cast saturates"
)]
fn units(affordable: f64, threads: usize) -> u64 {
    (affordable as u64).max(UNITS_PER_THREAD * threads as u64)
}

fn decode<T: DeserializeOwned>(name: &str, piece: &Piece) -> Result<T, CliError> {
    postcard::from_bytes(&piece.result.bytes()?)
        .map_err(|_| CliError::File(format!("the saved result of {name} has another form")))
}

impl PartOfRun {
    fn state(&self) -> MutexGuard<'_, State> {
        lock(&self.state)
    }

    /// Returns the units of this part of the next task, which has `count`. Tasks with fewer units
    /// than there are parts take their parts in turn, so that many such tasks make equal parts.
    fn range(&self, count: u64) -> Range<u64> {
        if count >= self.part.parts {
            return self.part.range(count);
        }
        let mut state = self.state();
        let first = state.in_turn;
        let left = self.part.parts - first;
        state.in_turn = if count < left { first + count } else { count - left };
        self.part.in_turn(first, count)
    }

    /// Returns the known results of a task, by units. Those of other inputs are forgotten.
    fn known(&self, name: &str) -> Result<Vec<Piece>, CliError> {
        let mut state = self.state();
        self.check_inputs(&mut state)?;
        let mut pieces = state.known.results.get(name).cloned().unwrap_or_default();
        pieces.sort_by_key(|piece| piece.start);
        Ok(pieces)
    }

    /// Records the inputs that were read since, and forgets known results if one has changed.
    fn check_inputs(&self, state: &mut State) -> Result<(), CliError> {
        for (name, path) in inputs() {
            if state.inputs.contains_key(&name) {
                continue;
            }
            let fingerprint = fingerprint(&name, &path)?;
            if state.known.inputs.get(&name).is_some_and(|known| *known != fingerprint) {
                state.known.results.clear();
            }
            if state.known.inputs.get(&name) != Some(&fingerprint) {
                let record = Record::Input(name.clone(), fingerprint);
                state.append(&record)?;
            }
            state.inputs.insert(name, fingerprint);
        }
        Ok(())
    }

    /// Keeps the result for some units until the work is finished.
    fn keep(&self, name: &str, piece: Piece) -> Result<(), CliError> {
        self.state().append(&Record::Piece(name.to_owned(), piece))
    }

    /// Adds the result of this part to the file.
    fn finish(&self, name: &str, piece: Piece) {
        self.state().results.insert(name.to_owned(), vec![piece]);
    }
}

impl PlannedRun {
    fn add(&self, units: u64) {
        let mut all = lock(&self.units);
        *all = all.saturating_add(units);
    }
}

impl State {
    fn append(&mut self, record: &Record) -> Result<(), CliError> {
        self.unfinished.as_mut().map_or(Ok(()), |file| file.append(&self.request, record))
    }
}

fn piece<T: Serialize>(units: Range<u64>, count: u64, result: &T) -> Result<Piece, CliError> {
    let result = postcard::to_stdvec(result).map_err(CliError::failed)?;
    Ok(Piece { count, start: units.start, end: units.end, result: Content::Held(result) })
}

fn fingerprint(name: &str, path: &Path) -> Result<Fingerprint, CliError> {
    Fingerprint::of(path).map_err(|error| CliError::File(format!("cannot read {name}: {error}")))
}

impl MergedRun {
    /// Returns the results of a task, by units.
    fn pieces(&self, name: &str) -> Result<Vec<&Piece>, CliError> {
        self.check_inputs()?;
        let mut pieces: Vec<&Piece> =
            self.known.results.get(name).map(|all| all.iter().collect()).unwrap_or_default();
        pieces.sort_by_key(|piece| piece.start);
        if pieces.is_empty() && !self.is_partial {
            return Err(missing(name));
        }
        Ok(pieces)
    }

    fn check_inputs(&self) -> Result<(), CliError> {
        let mut are_checked = lock(&self.are_inputs_checked);
        if std::mem::replace(&mut are_checked, true) {
            return Ok(());
        }
        for (name, path) in inputs() {
            let Some(known) = self.known.inputs.get(&name) else { continue };
            if fingerprint(&name, &path)? != *known {
                return Err(CliError::File(format!(
                    "{name} has changed since the parts were computed; compute them again"
                )));
            }
        }
        Ok(())
    }

    /// Returns the sum of the results of all units that are known.
    fn sum<T: DeserializeOwned>(
        &self,
        name: &str,
        count: u64,
        mut append: impl FnMut(&mut T, T) -> Result<(), CliError>,
    ) -> Result<Option<T>, CliError> {
        let mut sum: Option<T> = None;
        let mut next = 0;
        for piece in self.pieces(name)? {
            let is_next = piece.start == next || (self.is_partial && piece.start > next);
            if piece.count != count || !is_next || piece.end <= piece.start {
                return Err(missing(name));
            }
            next = piece.end;
            let result = decode(name, piece)?;
            match &mut sum {
                None => sum = Some(result),
                Some(sum) => append(sum, result)?,
            }
        }
        if next == count || self.is_partial { Ok(sum) } else { Err(missing(name)) }
    }
}

fn missing(name: &str) -> CliError {
    CliError::File(format!(
        "the files do not have the result of {name}: their command does not compute it"
    ))
}

impl fmt::Debug for Tasks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Kind::All => f.write_str("all"),
            Kind::Part(run) => write!(f, "part {}", run.part),
            Kind::Merged(_) => f.write_str("merged"),
            Kind::Planned(_) => f.write_str("planned"),
        }
    }
}
