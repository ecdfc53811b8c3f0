//! Reads the rows of files in blocks, of which only a few are in memory at a time.

use std::collections::BTreeMap;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread::JoinHandle;

use sphvar_samplers::PointSet;

use super::tally::RowTally;
use super::{FilePoint, Purpose, ReadOptions, read_for};
use crate::files::file_error::{FileError, Place, input_name, is_dash};
use crate::files::fits::HduChoice;

/// What is known of a file without its points.
#[derive(Clone, Debug, Default)]
pub(crate) struct FileSurvey {
    /// The name of the file for messages.
    pub(crate) name: String,
    /// The number of rows.
    pub(crate) rows: u64,
    /// Whether the rows may belong to several sets.
    pub(crate) has_sets: bool,
    /// Whether the rows have weights.
    pub(crate) has_weights: bool,
    /// Remarks on further content of the file.
    pub(crate) remarks: Vec<String>,
    /// Whether the rows can be read in blocks.
    pub(crate) is_streamed: bool,
}

/// Counts the rows of a file; `None` if they cannot be counted before they are read: those of
/// standard input and of pipes, and of files with errors.
pub(crate) fn survey<P: FilePoint>(path: &Path, options: &ReadOptions) -> Option<FileSurvey> {
    let (file, _) = HduChoice::of_path(path);
    if is_dash(path) || !file.is_file() {
        return None;
    }
    let mut survey = FileSurvey::default();
    read_for::<P>(path, options, Purpose::Count(&mut survey)).ok()?;
    Some(survey)
}

/// The points of a block.
#[derive(Debug)]
pub(crate) struct Block<P> {
    /// From 0.
    pub(crate) number: u64,
    pub(crate) set: PointSet<P>,
    /// The counts over the rows of each file, by its number.
    pub(crate) tallies: BTreeMap<usize, RowTally>,
}

/// Files whose rows, numbered through all of them in order, are divided into blocks.
#[derive(Clone, Debug)]
pub(crate) struct BlockedFiles {
    pub(crate) files: Vec<PathBuf>,
    /// The number of rows of each.
    pub(crate) rows: Vec<u64>,
    pub(crate) options: ReadOptions,
    /// The number of rows of a block; the last one may be shorter.
    pub(crate) size: u64,
}

impl BlockedFiles {
    fn total(&self) -> u64 {
        self.rows.iter().fold(0, |sum, rows| sum.saturating_add(*rows))
    }

    /// Reads the rows of some blocks and calls `send` with each block, in order, until it returns
    /// false.
    ///
    /// # Errors
    ///
    /// Those of [`read_points`](super::read_points), as soon as they are met, and if a file has
    /// other rows than when they were counted.
    pub(crate) fn read<P: FilePoint>(
        &self,
        blocks: Range<u64>,
        send: Box<dyn FnMut(Block<P>) -> bool>,
    ) -> Result<(), FileError> {
        let end = blocks.end.saturating_mul(self.size).min(self.total());
        let wanted = blocks.start.saturating_mul(self.size)..end;
        let mut writer = BlockWriter {
            size: self.size,
            next: wanted.start,
            wanted,
            file: 0,
            file_rows: 0..0,
            block: Block {
                number: blocks.start,
                set: PointSet::default(),
                tallies: BTreeMap::new(),
            },
            send,
        };
        let mut start = 0_u64;
        for (file, (path, rows)) in self.files.iter().zip(&self.rows).enumerate() {
            let file_rows = start..start.saturating_add(*rows);
            start = file_rows.end;
            let wanted = &writer.wanted;
            if file_rows.start >= wanted.end || file_rows.end <= wanted.start {
                continue;
            }
            let last = file_rows.end.min(wanted.end);
            (writer.file, writer.next) = (file, file_rows.start);
            writer.file_rows = file_rows;
            read_for::<P>(path, &self.options, Purpose::Blocks(&mut writer))?;
            if writer.next != last {
                return Err(FileError::Layout {
                    path: input_name(path),
                    place: Place::Whole,
                    expected: format!("{rows} rows as before"),
                    got: "another number; the file has changed while it was read".to_owned(),
                });
            }
        }
        writer.flush(RowTally::default());
        Ok(())
    }
}

/// Blocks that are read on a thread of their own, one ahead of those that were taken.
pub(crate) struct BlockStream<P> {
    /// The number of the next block.
    pub(crate) next: u64,
    /// `None` when the stream ends.
    receiver: Option<Receiver<Result<Block<P>, FileError>>>,
    thread: Option<JoinHandle<()>>,
}

impl<P: FilePoint> BlockStream<P> {
    /// Starts to read some blocks.
    ///
    /// # Errors
    ///
    /// If the thread cannot be started.
    pub(crate) fn start(files: &Arc<BlockedFiles>, blocks: Range<u64>) -> io::Result<Self> {
        let (sender, receiver) = sync_channel(0);
        let (next, files) = (blocks.start, Arc::clone(files));
        let read = move || {
            let of_errors = sender.clone();
            let send = Box::new(move |block| sender.send(Ok(block)).is_ok());
            if let Err(error) = files.read::<P>(blocks, send) {
                // Without a receiver, nothing more is wanted.
                let _ = of_errors.send(Err(error));
            }
        };
        let thread = std::thread::Builder::new().name("reader".to_owned()).spawn(read)?;
        Ok(Self { next, receiver: Some(receiver), thread: Some(thread) })
    }

    /// Returns the next block.
    ///
    /// # Errors
    ///
    /// Those of reading it.
    pub(crate) fn take(&mut self) -> Result<Block<P>, FileError> {
        self.next += 1;
        let received = self.receiver.as_ref().and_then(|receiver| receiver.recv().ok());
        received.unwrap_or_else(|| Err(FileError::Stopped { path: "the points".to_owned() }))
    }
}

impl<P> Drop for BlockStream<P> {
    fn drop(&mut self) {
        // The thread ends when it cannot send.
        self.receiver = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Collects points into blocks.
pub(crate) struct BlockWriter<P> {
    size: u64,
    /// The rows that are read, numbered through all files.
    wanted: Range<u64>,
    /// The number of the file, and its rows among all.
    file: usize,
    file_rows: Range<u64>,
    /// The number of the next row.
    next: u64,
    block: Block<P>,
    send: Box<dyn FnMut(Block<P>) -> bool>,
}

impl<P: FilePoint> BlockWriter<P> {
    /// Returns the rows of the file that are read, if all can be reached directly.
    pub(super) fn jump(&mut self) -> Range<u64> {
        let Range { start, end } = self.file_rows;
        let first = self.wanted.start.clamp(start, end);
        self.next = first;
        first - start..self.wanted.end.clamp(first, end) - start
    }

    /// Returns whether the file has rows before the next one.
    pub(super) fn has_rows(&self) -> bool {
        self.next > self.file_rows.start
    }

    /// Returns whether all rows that are read of the file have been, and others follow in it.
    pub(super) fn is_done(&self) -> bool {
        self.next >= self.wanted.end && self.next < self.file_rows.end
    }

    /// Returns whether the next row is read. It is then counted in `tally`, from which the counts
    /// over the previous rows are taken if it is in another block than these.
    ///
    /// # Errors
    ///
    /// If nothing more is to be read.
    pub(super) fn begin_row(
        &mut self,
        path: &str,
        tally: &mut RowTally,
    ) -> Result<bool, FileError> {
        let row = self.next;
        self.next += 1;
        if !self.wanted.contains(&row) {
            return Ok(false);
        }
        let number = row / self.size;
        if number != self.block.number {
            if !self.flush(std::mem::take(tally)) {
                return Err(FileError::Stopped { path: path.to_owned() });
            }
            self.block.number = number;
        }
        let points = &mut self.block.set.points;
        if points.capacity() == 0 {
            let rows = self.size.min(self.wanted.end - row);
            points.reserve_exact(usize::try_from(rows).unwrap_or(0));
        }
        Ok(true)
    }

    /// Adds a point with its weight.
    pub(super) fn push(&mut self, point: P, weight: Option<f64>) {
        let PointSet { points, weights } = &mut self.block.set;
        points.push(point);
        if let Some(weight) = weight {
            if weights.capacity() == 0 {
                weights.reserve_exact(points.capacity());
            }
            weights.push(weight);
        }
    }

    /// Ends the file, with the counts over its last rows.
    pub(super) fn end_file(&mut self, tally: RowTally) {
        self.block.tallies.entry(self.file).or_default().append(tally);
    }

    /// Sends the block, and returns whether others are wanted.
    fn flush(&mut self, tally: RowTally) -> bool {
        if tally != RowTally::default() {
            self.end_file(tally);
        }
        let number = self.block.number;
        let next = Block { number, set: PointSet::default(), tallies: BTreeMap::new() };
        (self.send)(std::mem::replace(&mut self.block, next))
    }
}
