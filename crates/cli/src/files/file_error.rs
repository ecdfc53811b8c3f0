//! File errors, with the name of the file, the place in it, and the expected content.

use std::fmt;
use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};

/// The place of an error in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Place {
    /// The file as a whole.
    Whole,
    /// A line of a text file, counted from 1 as editors do.
    Line(usize),
    /// A row of an `(N, 3)` array, counted from 0 as `NumPy` does.
    Row(usize),
    /// A row of one realization of an `(M, N, 3)` array, both counted from 0.
    RowOfSet(usize, usize),
    /// A vertex of a PLY file, counted from 0.
    Vertex(usize),
    /// A row of a table, counted from 1 as programs for FITS tables do.
    TableRow(u64),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole => Ok(()),
            Self::Line(line) => write!(f, ":{line}"),
            Self::Row(row) => write!(f, "[{row}]"),
            Self::RowOfSet(set, row) => write!(f, "[{set}, {row}]"),
            Self::Vertex(vertex) => write!(f, ": vertex {vertex}"),
            Self::TableRow(row) => write!(f, ": row {row}"),
        }
    }
}

/// Errors of reading and writing files. Every message starts with or contains the path.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum FileError {
    /// A file could not be opened for reading.
    #[error("cannot open {path}: {source}")]
    Open {
        /// The path as the user wrote it.
        path: String,
        /// The reason that the system gave.
        source: io::Error,
    },
    /// Reading failed after the file was opened.
    #[error("cannot read {path}: {source}")]
    Read {
        /// The path as the user wrote it.
        path: String,
        /// The reason that the system gave.
        source: io::Error,
    },
    /// The folder of an output file does not exist.
    #[error("cannot write {path}: the folder {folder} does not exist; create it first")]
    MissingFolder {
        /// The output path as the user wrote it.
        path: String,
        /// The folder that is missing.
        folder: String,
    },
    /// The output path is not a valid target.
    #[error("cannot write {path}: {reason}")]
    InvalidTarget {
        /// The output path as the user wrote it.
        path: String,
        /// The reason, and a remedy.
        reason: &'static str,
    },
    /// The folder of several output files cannot be made or written to.
    #[error("cannot write into {path}: {source}")]
    WriteInto {
        /// The folder as the user wrote it.
        path: String,
        /// The reason that the system gave.
        source: io::Error,
    },
    /// The path of the folder of several output files is a file.
    #[error("{path} is a file; -o must name a folder")]
    NotAFolder {
        /// The folder as the user wrote it.
        path: String,
    },
    /// Another run writes to a folder.
    #[error("{path}: another run writes to this folder ({holder}); wait for it or choose another")]
    Busy {
        /// The folder as the user wrote it.
        path: String,
        /// The other run.
        holder: String,
    },
    /// The system failed to create, write, flush or rename the output.
    #[error("cannot write {path}: {source}")]
    Write {
        /// The output path as the user wrote it.
        path: String,
        /// The reason that the system gave.
        source: io::Error,
    },
    /// A number in a file is outside the range of its field.
    #[error("{path}{place}: {field}: expected {expected}, got {got}")]
    Value {
        /// The path as the user wrote it.
        path: String,
        /// Line, row or vertex.
        place: Place,
        /// Name of the field.
        field: String,
        /// The expected content.
        expected: String,
        /// The content found.
        got: String,
    },
    /// A line, a header or a whole file has an invalid structure.
    #[error("{path}{place}: expected {expected}, got {got}")]
    Layout {
        /// The path as the user wrote it.
        path: String,
        /// Line, row, vertex or the whole file.
        place: Place,
        /// The expected content.
        expected: String,
        /// The content found.
        got: String,
    },
    /// A binary file ends before its data do.
    #[error("{path}: truncated: expected {expected} bytes, got {got} ({what})")]
    Truncated {
        /// The path as the user wrote it.
        path: String,
        /// The data that the header announces.
        what: String,
        /// The number of bytes that the file must have.
        expected: u64,
        /// The number of bytes that it has.
        got: u64,
    },
    /// The content of a file does not fit in memory.
    #[error("{path}: the memory for {what} is {needed}, but {available} are available")]
    Memory {
        /// The path as the user wrote it.
        path: String,
        /// The content that is read.
        what: String,
        /// A lower bound of the memory that it takes.
        needed: String,
        /// The available memory.
        available: String,
    },
    /// An image is damaged or of an unsupported kind.
    #[error("cannot read {path} as {format}: {reason}")]
    Image {
        /// The path as the user wrote it.
        path: String,
        /// The format, with an article.
        format: &'static str,
        /// The defect.
        reason: String,
    },
    /// An image does not have the requested channel.
    #[error("{path}: unknown channel \"{channel}\"; valid: {known}")]
    UnknownChannel {
        /// The path as the user wrote it.
        path: String,
        /// The requested channel.
        channel: String,
        /// The channels of the image.
        known: String,
    },
    /// Nothing more of a file is to be read.
    #[error("reading {path} was stopped")]
    Stopped {
        /// The path as the user wrote it.
        path: String,
    },
    /// A file contains no points.
    #[error("{path}: no points: expected at least one")]
    Empty {
        /// The path as the user wrote it.
        path: String,
    },
    /// The extension of an output path is not that of a supported format.
    #[error("cannot write {path}: expected a name that ends in one of {known}")]
    UnknownExtension {
        /// The output path as the user wrote it.
        path: String,
        /// The supported extensions.
        known: &'static str,
    },
}

impl FileError {
    /// Returns the same error with a hint appended to the content found.
    pub(super) fn with_hint(mut self, hint: &str) -> Self {
        if let Self::Value { got, .. } | Self::Layout { got, .. } = &mut self {
            got.push_str(&format!(" ({hint})"));
        }
        self
    }
}

/// Returns the name of an input for messages; `-` is standard input.
pub(crate) fn input_name(path: &Path) -> String {
    if is_dash(path) { "standard input".to_owned() } else { path.display().to_string() }
}

/// Returns the name of an output for messages; `-` is standard output.
pub(super) fn output_name(path: &Path) -> String {
    if is_dash(path) { "standard output".to_owned() } else { path.display().to_string() }
}

/// Returns whether a path is the single dash that denotes a standard stream.
pub(super) fn is_dash(path: &Path) -> bool {
    path.as_os_str() == "-"
}
