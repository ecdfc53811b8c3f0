//! The results of unfinished work, each of which is on the disk as soon as it is known.

use std::fs::{File, TryLockError};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::Request;
use super::file::{Record, ShardFile, write_record, write_start};
use crate::error::CliError;
use crate::files::{FileError, is_at};

/// The file of unfinished work, `FILE.unfinished`, which exists from the first result on.
///
/// It remains when the process ends early, by a signal or otherwise, and the same command continues
/// from it. Its lock is held while it is open.
#[derive(Debug)]
pub(super) struct Unfinished {
    path: PathBuf,
    /// Whether to wait for another process that has the file open.
    waits: bool,
    file: Option<File>,
}

impl Unfinished {
    /// Opens the unfinished work for the results in `target` and returns what a previous run of the
    /// same question has left.
    ///
    /// # Errors
    ///
    /// If it cannot be opened, another process has it open and `waits` is false, or it is of another
    /// question.
    pub(super) fn open(
        target: &Path,
        request: &Request,
        waits: bool,
    ) -> Result<(Self, ShardFile), CliError> {
        let mut unfinished = Self { path: unfinished_path(target), waits, file: None };
        if !unfinished.path.exists() {
            return Ok((unfinished, ShardFile::new(request.clone())));
        }
        let (file, read) = unfinished.continued(request)?;
        unfinished.file = Some(file);
        Ok((unfinished, read))
    }

    /// Opens and locks the file at the end of its valid records of a question, which are returned.
    fn continued(&self, request: &Request) -> Result<(File, ShardFile), CliError> {
        let mut file = self.locked()?;
        let shown = self.path.display();
        match ShardFile::read_unfinished(&file) {
            Some((read, valid)) if read.request == *request => {
                let cut = file.set_len(valid).and_then(|()| file.seek(SeekFrom::Start(valid)));
                cut.map_err(|source| self.error(source))?;
                Ok((file, read))
            }
            Some((read, _)) if !read.results.is_empty() => Err(CliError::File(format!(
                "{shown} has unfinished work of another run ({} {} on {}); remove it, or name another file",
                read.request.command(),
                read.request.version,
                read.request.instruction_set
            ))),
            None if !self.is_beginning(&mut file, request)? => Err(CliError::File(format!(
                "{shown} exists and is not unfinished work of this version; remove it, or name another file"
            ))),
            // Nothing was kept, or a process was killed while it wrote the first bytes.
            _ => {
                let emptied = file.set_len(0).and_then(|()| file.rewind());
                let started = emptied.and_then(|()| write_start(&mut file, request));
                started.map_err(|source| self.error(source))?;
                Ok((file, ShardFile::new(request.clone())))
            }
        }
    }

    /// Returns whether a file is empty or cut within the first bytes of unfinished work.
    fn is_beginning(&self, file: &mut File, request: &Request) -> Result<bool, CliError> {
        let mut start = Vec::new();
        let mut content = Vec::new();
        let read = write_start(&mut start, request).and_then(|()| file.rewind()).and_then(|()| {
            let limit = start.len() as u64 + 1;
            Read::by_ref(file).take(limit).read_to_end(&mut content)
        });
        read.map_err(|source| self.error(source))?;
        Ok(start.starts_with(&content))
    }

    /// Opens and locks the file, which is created if it is missing.
    fn locked(&self) -> Result<File, CliError> {
        if self.path.exists() && !self.path.is_file() {
            return Err(CliError::File(format!(
                "{} exists and is not a regular file; name another file for --save",
                self.path.display()
            )));
        }
        loop {
            let mut options = File::options();
            options.read(true).write(true).create(true).truncate(false);
            let file = options.open(&self.path).map_err(|source| self.error(source))?;
            // On a file system without locks the file is unprotected, but the run continues.
            if self.waits {
                let _ = file.lock();
            } else if matches!(file.try_lock(), Err(TryLockError::WouldBlock)) {
                return Err(CliError::File(format!(
                    "{} is in use: another process computes the same part",
                    self.path.display()
                )));
            }
            // Otherwise the process that held it has just finished and removed it.
            if is_at(&file, &self.path) {
                return Ok(file);
            }
        }
    }

    /// Appends a record of this question.
    ///
    /// # Errors
    ///
    /// If it cannot be written, or another process has the file open.
    pub(super) fn append(&mut self, request: &Request, record: &Record) -> Result<(), CliError> {
        if self.file.is_none() {
            // Another process may have kept results since this one has begun.
            self.file = Some(self.continued(request)?.0);
        }
        let Some(file) = &mut self.file else { return Ok(()) };
        Ok(write_record(file, record)
            .map_err(|source| FileError::Write { path: self.path.display().to_string(), source })?)
    }

    /// Removes the file, because the work is finished.
    ///
    /// # Errors
    ///
    /// If it cannot be removed.
    pub(super) fn remove(self) -> Result<(), CliError> {
        match &self.file {
            None => Ok(()),
            Some(_) => Ok(std::fs::remove_file(&self.path).map_err(|source| self.error(source))?),
        }
    }

    fn error(&self, source: io::Error) -> FileError {
        FileError::Write { path: self.path.display().to_string(), source }
    }
}

/// Returns the path of the unfinished work for the results in `target`.
fn unfinished_path(target: &Path) -> PathBuf {
    let mut name = target.as_os_str().to_owned();
    name.push(".unfinished");
    PathBuf::from(name)
}

/// Unfinished work as another process finds it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum UnfinishedWork {
    /// There is none.
    None,
    /// A process continues it.
    Open,
    /// The process that computed it has ended.
    Left,
}

impl UnfinishedWork {
    /// Returns what there is of the results in `target`.
    pub(crate) fn of(target: &Path) -> Self {
        let Ok(file) = File::open(unfinished_path(target)) else { return Self::None };
        // Processes that open the file at the same moment would find it in use, unless they wait.
        match file.try_lock_shared() {
            Err(TryLockError::WouldBlock) => Self::Open,
            _ => Self::Left,
        }
    }
}
