//! The output of results: tables, CSV and JSON, each with its provenance.

use std::path::Path;

pub(crate) use self::document::{Document, Forms, emit};
pub(crate) use self::number::full;
pub(crate) use self::provenance::{Provenance, quoted};
pub(crate) use self::rows::{csv, csv_of, csv_of_present, csv_rows};
pub(crate) use self::table::{Column, table, table_of};
use crate::error::CliError;
pub(crate) use crate::files::is_stdout;
use crate::files::{AtomicFile, is_stream};
use crate::plots::ImageFormat;
use crate::session::Session;

mod document;
pub(crate) mod number;
mod provenance;
mod rows;
mod table;

/// Reports the remarks on channels of a picture; one that all channels share does not name them.
pub(crate) fn remark_on_channels(session: &Session, of_channels: &[(&str, Vec<String>)]) {
    for (channel, remarks) in of_channels {
        for text in remarks {
            if of_channels.iter().all(|(_, others)| others.contains(text)) {
                session.remark(text);
            } else {
                session.remark(&format!("{channel} of {text}"));
            }
        }
    }
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
