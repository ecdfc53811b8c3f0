//! The output of results: tables, CSV and JSON, each with its provenance.

use std::collections::BTreeSet;
use std::io::Write;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use serde::Serialize;

pub(crate) use self::document::{Document, Forms, emit};
pub(crate) use self::number::full;
pub(crate) use self::provenance::Provenance;
pub(crate) use self::rows::{csv, csv_of, csv_of_present, csv_rows};
pub(crate) use self::table::{Column, table, table_of};
use crate::error::CliError;
pub(crate) use crate::files::is_stdout;
use crate::files::{AtomicFile, is_stream};
use crate::message;
use crate::plots::ImageFormat;

mod document;
pub(crate) mod number;
mod provenance;
mod rows;
mod table;

/// Prints text to standard output.
pub(crate) fn print(text: &str) -> Result<(), CliError> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(|e| CliError::stdout(&e))
}

/// Prints a message to standard error, unless `quiet`.
pub(crate) fn say(quiet: bool, text: &str) {
    if !quiet {
        message::write(text);
    }
}

/// Prints a remark on an input, unless `quiet`: each text once, also where a run reads a file again.
pub(crate) fn remark(quiet: bool, text: &str) {
    static PRINTED: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    let is_new = |printed: &mut BTreeSet<String>| printed.insert(text.to_owned());
    if !quiet && is_new(&mut PRINTED.lock().unwrap_or_else(PoisonError::into_inner)) {
        message::write(text);
    }
}

/// Prints the remarks on channels of a picture, unless `quiet`; one that all channels share does not
/// name them.
pub(crate) fn remark_on_channels(quiet: bool, of_channels: &[(&str, Vec<String>)]) {
    for (channel, remarks) in of_channels {
        for text in remarks {
            if of_channels.iter().all(|(_, others)| others.contains(text)) {
                remark(quiet, text);
            } else {
                remark(quiet, &format!("{channel} of {text}"));
            }
        }
    }
}

/// Prints the single JSON document of `--json`.
pub(crate) fn print_json(document: &impl Serialize) -> Result<(), CliError> {
    print(&(serde_json::to_string(document).map_err(CliError::failed)? + "\n"))
}

/// Writes a text file, complete or not at all; `-` is standard output.
pub(crate) fn write_text(path: &Path, text: &str) -> Result<(), CliError> {
    Ok(AtomicFile::write_whole(path, text.as_bytes())?)
}

/// Returns the extension of a file in lower case.
pub(crate) fn lower_extension(path: &Path) -> Option<String> {
    path.extension().map(|extension| extension.to_string_lossy().to_lowercase())
}

/// Returns an error for a result file that [`emit`] could not write, including plots if `plots`.
/// Commands call it before the work starts.
pub(crate) fn check_result(path: &Path, plots: bool) -> Result<(), CliError> {
    let extension = lower_extension(path);
    let result = matches!(extension.as_deref(), Some("json" | "csv"))
        || extension.is_none() && is_stream(path);
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
