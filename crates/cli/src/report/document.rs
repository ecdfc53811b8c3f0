//! The output of a result: to the output of the run, or to a file in the format of its extension.

use std::path::Path;

use schemars::JsonSchema;
use serde::Serialize;

use super::{Provenance, is_stdout, lower_extension, write_text};
use crate::error::CliError;
use crate::files::is_stream;
use crate::global::Global;
use crate::plots::{Chart, ImageFormat};
use crate::session::Session;

/// A result with what makes it reproducible: the document of `--json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Document<'a, T> {
    #[serde(flatten)]
    body: &'a T,
    /// The data that make the result reproducible.
    provenance: &'a Provenance,
}

impl<'a, T: Serialize> Document<'a, T> {
    pub(crate) fn new(body: &'a T, provenance: &'a Provenance) -> Self {
        Self { body, provenance }
    }

    /// Returns the document.
    pub(crate) fn json(&self) -> Result<String, CliError> {
        serde_json::to_string(self).map_err(CliError::failed)
    }

    /// Prints the document to the output of the run.
    pub(crate) fn print(&self, session: &Session) -> Result<(), CliError> {
        session.print(
            &(self.json()?
                + "
"),
        )
    }
}

/// The forms of a result besides JSON, each generated on demand.
pub(crate) struct Forms<'a> {
    pub(crate) csv: &'a dyn Fn() -> Result<String, CliError>,
    /// The plot, if the result has one; the provenance is added to its notes.
    pub(crate) chart: Option<&'a dyn Fn() -> Result<Chart, CliError>>,
    /// The text for the terminal.
    pub(crate) text: &'a dyn Fn() -> String,
}

/// Writes a result to `out`, if given, in the format of its extension, and prints it: as a document
/// with `--json`, otherwise as text, unless the file is standard output.
pub(crate) fn emit<T: Serialize>(
    out: Option<&Path>,
    global: &Global,
    provenance: &Provenance,
    body: &T,
    forms: &Forms<'_>,
) -> Result<(), CliError> {
    let document = Document::new(body, provenance);
    let to_stdout = out.is_some_and(is_stdout);
    if let Some(path) = out
        && !(global.json && to_stdout)
    {
        match (forms.chart, ImageFormat::of_path(path)) {
            (Some(chart), Some(_)) => {
                let mut chart = chart()?;
                chart.notes.push(provenance.line());
                chart.render(path)?;
            }
            _ => write_result(path, &document, forms.csv)?,
        }
    }
    if global.json {
        document.print(&global.session)
    } else if to_stdout {
        Ok(())
    } else {
        global.session.print(&(forms.text)())
    }
}

/// Writes a result to `path` in the format of its extension, `.json` or `.csv`.
fn write_result(
    path: &Path,
    document: &impl Serialize,
    csv: &dyn Fn() -> Result<String, CliError>,
) -> Result<(), CliError> {
    match lower_extension(path).as_deref() {
        Some("json") => {
            let json = serde_json::to_string(document).map_err(CliError::failed)?;
            write_text(path, &(json + "\n"))
        }
        Some("csv") => write_text(path, &csv()?),
        None if is_stream(path) => write_text(path, &csv()?),
        _ => Err(CliError::Usage(format!(
            "{}: results are written as .csv or .json",
            path.display()
        ))),
    }
}
