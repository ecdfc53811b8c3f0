//! Results on their way out: tables, CSV and JSON, each with its provenance.

use std::borrow::Cow;
use std::ffi::OsString;
use std::io::Write;
use std::path::Path;

use comfy_table::{CellAlignment, Table, presets};
use serde::{Deserialize, Serialize};

use crate::error::CliError;
pub(crate) use crate::files::is_stdout;
use crate::files::{AtomicFile, is_stream};
use crate::message;
use crate::plots::ImageFormat;

/// What makes a result reproducible.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Provenance {
    /// The command line, without the number of threads: results do not depend on it, to the byte.
    pub(crate) command: String,
    /// The version of this program.
    pub(crate) version: Cow<'static, str>,
    /// The seed of all random streams.
    pub(crate) seed: u64,
}

impl Provenance {
    /// Of this run.
    pub(crate) fn new(seed: u64) -> Self {
        // A line break would end the comment that this becomes.
        let word = |word: OsString| message::escape(&word.to_string_lossy()).into_owned();
        let words = std::env::args_os().skip(1).map(word);
        Self::of(format!("sphvar {}", without_threads(words).join(" ")), seed)
    }

    /// Of a command that stands for this run.
    pub(crate) fn of(command: String, seed: u64) -> Self {
        Self { command, version: env!("CARGO_PKG_VERSION").into(), seed }
    }

    /// Of a JSON document that has one under `provenance`.
    pub(crate) fn of_document(json: &[u8]) -> Option<Self> {
        #[derive(Deserialize)]
        struct Document {
            provenance: Provenance,
        }
        serde_json::from_slice::<Document>(json).ok().map(|document| document.provenance)
    }

    /// Whether both runs write the same bytes to files: their commands differ at most in what is shown
    /// meanwhile.
    pub(crate) fn is_same_run(&self, other: &Self) -> bool {
        let words = |run: &Self| -> Vec<String> {
            let is_shown = |word: &&str| !["--json", "--quiet", "--force"].contains(word);
            run.command.split(' ').filter(is_shown).map(str::to_owned).collect()
        };
        (&self.version, self.seed) == (&other.version, other.seed) && words(self) == words(other)
    }

    /// One line for the heads of files and the feet of figures.
    pub(crate) fn line(&self) -> String {
        format!("{} (sphvar {}, seed {})", self.command, self.version, self.seed)
    }
}

/// The words of a command line without `-j` and `--threads` and their number.
fn without_threads(mut words: impl Iterator<Item = String>) -> Vec<String> {
    let mut kept = Vec::new();
    while let Some(word) = words.next() {
        if word == "-j" || word == "--threads" {
            words.next();
        } else if !word.starts_with("-j") && !word.starts_with("--threads=") {
            kept.push(word);
        }
    }
    kept
}

/// A table of text cells under a heading; every column but the `left` first ones is aligned right.
pub(crate) fn table(heading: &[&str], rows: Vec<Vec<String>>, left: usize) -> String {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_header(heading.iter().copied());
    for row in rows {
        table.add_row(row);
    }
    for (i, column) in table.column_iter_mut().enumerate() {
        column.set_padding((0, 2));
        column.set_cell_alignment(if i < left {
            CellAlignment::Left
        } else {
            CellAlignment::Right
        });
    }
    let text = table.to_string();
    // Trailing blanks are a nuisance in files and diffs.
    text.lines().map(str::trim_end).fold(String::new(), |all, line| all + line + "\n")
}

/// Prints text to standard output.
pub(crate) fn print(text: &str) -> Result<(), CliError> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(|e| CliError::stdout(&e))
}

/// Says something to the person at the terminal, unless that is unwanted.
pub(crate) fn say(quiet: bool, text: &str) {
    if !quiet {
        message::write(text);
    }
}

/// Prints the one JSON document of `--json`.
pub(crate) fn print_json(document: &impl Serialize) -> Result<(), CliError> {
    print(&(json(document)? + "\n"))
}

/// Writes a text file whole, or not at all; `-` is standard output.
pub(crate) fn write_text(path: &Path, text: &str) -> Result<(), CliError> {
    Ok(AtomicFile::write_whole(path, text.as_bytes())?)
}

/// Refuses a result file that [`write_result`], or a plot if `plots`, could not be written to: better
/// before the work than after it.
pub(crate) fn check_result(path: &Path, plots: bool) -> Result<(), CliError> {
    let extension = path.extension().and_then(|e| e.to_str());
    let result =
        matches!(extension, Some("json" | "csv")) || extension.is_none() && is_stream(path);
    let plot = plots && ImageFormat::of_path(path).is_some();
    if !(result || plot) {
        let plots = if plots { ", plots as .svg or .png" } else { "" };
        return Err(CliError::Usage(format!(
            "{}: results are written as .csv or .json{plots}",
            path.display()
        )));
    }
    Ok(AtomicFile::check(path)?)
}

/// Writes a result to `path` by its extension, `.json` or `.csv`.
pub(crate) fn write_result(
    path: &Path,
    document: &impl Serialize,
    csv: &dyn Fn() -> String,
) -> Result<(), CliError> {
    match path.extension().and_then(|e| e.to_str()) {
        Some("json") => write_text(path, &(json(document)? + "\n")),
        Some("csv") => write_text(path, &csv()),
        None if is_stream(path) => write_text(path, &csv()),
        _ => Err(CliError::Usage(format!(
            "{}: results are written as .csv or .json",
            path.display()
        ))),
    }
}

fn json(document: &impl Serialize) -> Result<String, CliError> {
    serde_json::to_string(document).map_err(CliError::failed)
}

/// CSV with the provenance as comment, a heading and rows of cells.
pub(crate) fn csv(provenance: &Provenance, heading: &str, rows: &[Vec<String>]) -> String {
    let mut text = format!("# {}\n{heading}\n", provenance.line());
    for row in rows {
        let cells: Vec<String> = row.iter().map(|cell| quoted(cell)).collect();
        text.push_str(&cells.join(","));
        text.push('\n');
    }
    text
}

/// A cell as CSV has it: names of integrands contain commas.
fn quoted(cell: &str) -> String {
    if cell.contains([',', '"', '\n']) {
        format!("\"{}\"", cell.replace('"', "\"\""))
    } else {
        cell.to_owned()
    }
}

/// A number with three significant decimals in scientific form, `-` for one that is not known.
pub(crate) fn short(x: f64) -> String {
    if x.is_finite() { format!("{x:.3e}") } else { "-".to_owned() }
}

/// A number with all its digits, as files have it.
pub(crate) fn full(x: f64) -> String {
    if x.is_finite() { format!("{x:e}") } else { String::new() }
}
