//! Files of results.
//!
//! A file is a line with the version of the form and a list of records: `length (8 bytes), CRC-32 of
//! the record (4 bytes), record`, little-endian. A complete file ends with a record that counts the
//! others; work that was interrupted has left a file without one.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::de::Visitor;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::Request;
use super::fingerprint::Fingerprint;
use crate::error::CliError;
use crate::files::{AtomicFile, FileError, Place};

/// The first bytes of the files, in every version of the form.
const NAME: &[u8] = b"sphvar shard ";
/// The rest of the first line in this version.
const FORM: &[u8] = b"5\n";

/// The content of a shard file.
#[derive(Clone, Debug)]
pub(crate) struct ShardFile {
    pub(crate) request: Request,
    /// The files that were read, by the names in the command.
    pub(super) inputs: BTreeMap<String, Fingerprint>,
    pub(super) results: Results,
}

/// The results of tasks, by name.
pub(super) type Results = BTreeMap<String, Vec<Piece>>;

/// The result for some units of a task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Piece {
    /// The number of units of the whole task.
    pub(super) count: u64,
    /// The units, from the first to before the last.
    pub(super) start: u64,
    pub(super) end: u64,
    pub(super) result: Content,
}

/// A result, or the place where it is: those of a large merge do not fit in memory.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Content {
    Held(Vec<u8>),
    /// In the record at this position of a file.
    InFile(Arc<PathBuf>, u64),
}

impl Content {
    /// Returns the bytes of the result.
    ///
    /// # Errors
    ///
    /// If the file has changed since it was read, or cannot be read again.
    pub(super) fn bytes(&self) -> Result<Cow<'_, [u8]>, FileError> {
        let (path, position) = match self {
            Self::Held(bytes) => return Ok(Cow::Borrowed(bytes)),
            Self::InFile(path, position) => (path, *position),
        };
        let mut reader = Reader::open(path)?;
        let failed = |source| FileError::Read { path: path.display().to_string(), source };
        reader.input.seek(SeekFrom::Start(position)).map_err(failed)?;
        reader.position = position;
        match reader.next(path)? {
            Found::Record(Record::Piece(_, Piece { result: Self::Held(bytes), .. })) => {
                Ok(Cow::Owned(bytes))
            }
            _ => Err(wrong(path, "one that has changed meanwhile")),
        }
    }
}

/// A record of a file.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) enum Record {
    Request(Request),
    Input(String, Fingerprint),
    Piece(String, Piece),
    /// The end of a complete file, with the number of records before it.
    End(u64),
}

/// What is at a place of a file.
enum Found {
    Record(Record),
    /// The file ends here.
    End,
    /// The record is cut or damaged.
    Damaged,
}

impl ShardFile {
    /// Returns a file without results.
    pub(super) fn new(request: Request) -> Self {
        Self { request, inputs: BTreeMap::new(), results: Results::new() }
    }

    /// Reads a complete file.
    ///
    /// # Errors
    ///
    /// If it cannot be read, has another form, is incomplete or damaged.
    pub(crate) fn read(path: &Path) -> Result<Self, FileError> {
        let mut memory = u64::MAX;
        Self::read_within(path, &mut memory)
    }

    /// Reads a complete file and keeps at most `memory` bytes of results, from which those that are
    /// kept are subtracted; others are read again when they are needed.
    ///
    /// # Errors
    ///
    /// Those of [`read`](Self::read).
    pub(crate) fn read_within(path: &Path, memory: &mut u64) -> Result<Self, FileError> {
        let wrong = |got: &str| wrong(path, got);
        let mut reader = Reader::open(path)?;
        let Found::Record(Record::Request(request)) = reader.next(path)? else {
            return Err(wrong("a damaged one"));
        };
        let mut file = Self::new(request);
        let mut records = 1;
        let shared = Arc::new(path.to_path_buf());
        loop {
            let position = reader.position;
            match reader.next(path)? {
                Found::Record(Record::End(count))
                    if count == records && reader.position == reader.length =>
                {
                    return Ok(file);
                }
                Found::Record(Record::End(_) | Record::Request(_)) | Found::Damaged => {
                    return Err(wrong("a damaged one"));
                }
                Found::End => return Err(wrong("its beginning only; run its command again")),
                Found::Record(mut record) => {
                    if let Record::Piece(_, Piece { result, .. }) = &mut record {
                        let bytes = reader.position - position;
                        match memory.checked_sub(bytes) {
                            Some(left) => *memory = left,
                            None => *result = Content::InFile(Arc::clone(&shared), position),
                        }
                    }
                    file.add(record);
                }
            }
            records += 1;
        }
    }

    /// Reads the question of a complete file and which parts it has, and checks the rest.
    ///
    /// # Errors
    ///
    /// Those of [`read`](Self::read).
    pub(crate) fn verify(path: &Path) -> Result<Request, FileError> {
        let mut memory = 0;
        Ok(Self::read_within(path, &mut memory)?.request)
    }

    /// Reads the records of unfinished work up to the first damaged one, and the length of the valid
    /// bytes; `None` unless it begins with a question.
    pub(super) fn read_unfinished(file: &File) -> Option<(Self, u64)> {
        let length = file.metadata().ok()?.len();
        let mut reader = Reader::new(BufReader::new(file), length)?;
        let Ok(Some(Record::Request(request))) = reader.record() else { return None };
        let mut read = Self::new(request);
        let mut valid = reader.position;
        while let Ok(Some(record)) = reader.record() {
            read.add(record);
            valid = reader.position;
        }
        Some((read, valid))
    }

    /// Returns whether a file without readable results may be replaced: it does not exist, is empty, no
    /// regular file, or was written by this program and is damaged or of an earlier version.
    pub(super) fn may_replace(path: &Path) -> bool {
        let Ok(metadata) = std::fs::metadata(path) else { return true };
        let mut start = [0; NAME.len()];
        let read = File::open(path).and_then(|mut file| file.read_exact(&mut start));
        !metadata.is_file() || metadata.len() == 0 || (read.is_ok() && start == *NAME)
    }

    /// Returns whether it has no results.
    pub(crate) fn is_empty(&self) -> bool {
        self.results.is_empty()
    }

    /// Returns files of one run, each with its name in messages, as one.
    ///
    /// # Errors
    ///
    /// If there are none, if they are of different runs or inputs, or if a part is in two of them.
    pub(crate) fn merged(files: Vec<(String, Self)>) -> Result<Self, CliError> {
        let mut files = files.into_iter();
        let Some((first, mut all)) = files.next() else {
            return Err(CliError::Usage("no files to merge".to_owned()));
        };
        let owned = |part: &u64| (*part, first.clone());
        let mut owners: BTreeMap<u64, String> = all.request.parts.iter().map(owned).collect();
        let mut readers: BTreeMap<String, String> =
            all.inputs.keys().map(|input| (input.clone(), first.clone())).collect();
        for (name, file) in files {
            all.request.check_same(&file.request, [&first, &name])?;
            for part in file.request.parts {
                if let Some(other) = owners.insert(part, name.clone()) {
                    return Err(CliError::File(format!("part {part} is in {other} and in {name}")));
                }
            }
            for (input, fingerprint) in file.inputs {
                if all.inputs.get(&input).is_some_and(|known| *known != fingerprint) {
                    let other = &readers[&input];
                    return Err(CliError::File(format!(
                        "{other} and {name} are of different contents of {input}"
                    )));
                }
                readers.entry(input.clone()).or_insert_with(|| name.clone());
                all.inputs.insert(input, fingerprint);
            }
            for (task, pieces) in file.results {
                all.results.entry(task).or_default().extend(pieces);
            }
        }
        all.request.parts = owners.into_keys().collect();
        Ok(all)
    }

    fn add(&mut self, record: Record) {
        match record {
            Record::Input(name, fingerprint) => {
                let known = self.inputs.insert(name, fingerprint);
                // Results before it are of another content of the file.
                if known.is_some_and(|known| known != fingerprint) {
                    self.results.clear();
                }
            }
            Record::Piece(name, piece) => self.results.entry(name).or_default().push(piece),
            Record::Request(_) | Record::End(_) => {}
        }
    }

    /// Writes the file, complete or not at all.
    ///
    /// # Errors
    ///
    /// If it cannot be written.
    pub(crate) fn write(&self, path: &Path) -> Result<(), FileError> {
        let mut file = AtomicFile::create(path)?;
        let written = self.write_records(&mut file);
        written.map_err(|source| file.error(source))?;
        file.commit()
    }

    fn write_records(&self, out: &mut impl Write) -> io::Result<()> {
        out.write_all(&[NAME, FORM].concat())?;
        write_record(out, &Record::Request(self.request.clone()))?;
        let mut records = 1;
        for (name, fingerprint) in &self.inputs {
            write_record(out, &Record::Input(name.clone(), *fingerprint))?;
            records += 1;
        }
        for (name, pieces) in &self.results {
            for piece in pieces {
                let Piece { count, start, end, .. } = *piece;
                let bytes = piece.result.bytes().map_err(io::Error::other)?.into_owned();
                let piece = Piece { count, start, end, result: Content::Held(bytes) };
                write_record(out, &Record::Piece(name.clone(), piece))?;
                records += 1;
            }
        }
        write_record(out, &Record::End(records))
    }
}

/// Writes the first bytes of unfinished work.
pub(super) fn write_start(out: &mut impl Write, request: &Request) -> io::Result<()> {
    out.write_all(&[NAME, FORM].concat())?;
    write_record(out, &Record::Request(request.clone()))
}

/// Writes a record.
pub(super) fn write_record(out: &mut impl Write, record: &Record) -> io::Result<()> {
    let body = postcard::to_stdvec(record).map_err(io::Error::other)?;
    let length = body.len() as u64;
    let checksum = crc32fast::hash(&body);
    out.write_all(&[&length.to_le_bytes()[..], &checksum.to_le_bytes(), &body].concat())
}

fn wrong(path: &Path, got: &str) -> FileError {
    FileError::Layout {
        path: path.display().to_string(),
        place: Place::Whole,
        expected: "a file of --save".to_owned(),
        got: got.to_owned(),
    }
}

/// Reads the records of a file.
struct Reader<R> {
    input: R,
    position: u64,
    length: u64,
}

impl Reader<BufReader<File>> {
    fn open(path: &Path) -> Result<Self, FileError> {
        let failed = |source| FileError::Open { path: path.display().to_string(), source };
        let file = File::open(path).map_err(failed)?;
        let length = file.metadata().map_err(failed)?.len();
        let mut input = BufReader::new(file);
        let mut start = vec![0; NAME.len() + FORM.len()];
        let is_whole = input.read_exact(&mut start).is_ok();
        match start.strip_prefix(NAME) {
            Some(FORM) => Ok(Self { input, position: start.len() as u64, length }),
            Some(_) if is_whole => Err(wrong(
                path,
                "one of another version of sphvar, whose results cannot be added to those of this one; create it again",
            )),
            _ => Err(wrong(path, "something else")),
        }
    }

    fn next(&mut self, path: &Path) -> Result<Found, FileError> {
        match self.record() {
            Ok(Some(record)) => Ok(Found::Record(record)),
            Ok(None) if self.position == self.length => Ok(Found::End),
            Ok(None) => Ok(Found::Damaged),
            Err(source) => Err(FileError::Read { path: path.display().to_string(), source }),
        }
    }
}

impl<R: Read> Reader<R> {
    /// Returns the reader of a file after its first line; `None` if that is another one.
    fn new(mut input: R, length: u64) -> Option<Self> {
        let mut start = vec![0; NAME.len() + FORM.len()];
        input.read_exact(&mut start).ok()?;
        let position = start.len() as u64;
        (start == [NAME, FORM].concat()).then_some(Self { input, position, length })
    }

    /// Returns the next record; `None` at the end of the file, or if it is cut or damaged.
    fn record(&mut self) -> io::Result<Option<Record>> {
        const HEAD: u64 = 12;
        let left = self.length.saturating_sub(self.position);
        if left < HEAD {
            return Ok(None);
        }
        let (mut length, mut checksum) = ([0; 8], [0; 4]);
        self.input.read_exact(&mut length)?;
        self.input.read_exact(&mut checksum)?;
        let length = u64::from_le_bytes(length);
        // A damaged length must not exhaust the memory.
        if length > left - HEAD {
            return Ok(None);
        }
        let mut body = Vec::new();
        self.input.by_ref().take(length).read_to_end(&mut body)?;
        if body.len() as u64 != length || crc32fast::hash(&body) != u32::from_le_bytes(checksum) {
            return Ok(None);
        }
        let record = postcard::from_bytes(&body).ok();
        if record.is_some() {
            self.position += HEAD + length;
        }
        Ok(record)
    }
}

/// Results are bytes in one piece: as a list, each would be a number of its own.
impl Serialize for Content {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Held(bytes) => serializer.serialize_bytes(bytes),
            Self::InFile(..) => Err(serde::ser::Error::custom("the result is in a file")),
        }
    }
}

impl<'de> Deserialize<'de> for Content {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Bytes;

        impl Visitor<'_> for Bytes {
            type Value = Content;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("bytes")
            }

            fn visit_bytes<E: serde::de::Error>(self, bytes: &[u8]) -> Result<Content, E> {
                Ok(Content::Held(bytes.to_vec()))
            }
        }

        deserializer.deserialize_bytes(Bytes)
    }
}
