//! The folder of a plan, which is written completely or not at all.

use std::fs;
use std::path::Path;

use super::manifest::{LOGS, Manifest, NAME, PARTS};
use crate::error::CliError;
use crate::files::{AtomicFile, FileError, FolderLock, as_group};

/// Writes a plan: its scripts, its empty folders and, at the end, its manifest. The same plan is
/// written again.
///
/// # Errors
///
/// If the folder cannot be written to, is in use, or has another plan or files of the same names.
pub(super) fn write(
    folder: &Path,
    manifest: &Manifest,
    scripts: &[(&'static str, String)],
    command: &str,
) -> Result<(), CliError> {
    let mut lock = FolderLock::take(folder, command)?;
    let is_new = match Manifest::read(folder)? {
        Some(other) if other.is_same_plan(manifest) => false,
        Some(other) => {
            return Err(CliError::Failed(format!(
                "{} has another plan: {}; choose another folder with -o, or remove it",
                folder.display(),
                other.line()
            )));
        }
        None => {
            // A killed process may have left some of the files.
            if !lock.is_unfinished() {
                check_unused(folder, scripts)?;
            }
            true
        }
    };
    as_group(|| {
        lock.set_unfinished(true)?;
        let written = write_files(folder, manifest, scripts);
        if written.is_err() && is_new {
            remove(folder, scripts);
        }
        let cleared = lock.set_unfinished(false);
        written.and(cleared.map_err(CliError::from))
    })
}

fn write_files(
    folder: &Path,
    manifest: &Manifest,
    scripts: &[(&'static str, String)],
) -> Result<(), CliError> {
    for name in [PARTS, LOGS] {
        let inner = folder.join(name);
        let failed = |source| FileError::WriteInto { path: inner.display().to_string(), source };
        fs::create_dir_all(&inner).map_err(failed)?;
    }
    for (name, text) in scripts {
        AtomicFile::write_whole(&folder.join(name), text.as_bytes())?;
    }
    let json = serde_json::to_string_pretty(manifest).map_err(CliError::failed)?;
    Ok(AtomicFile::write_whole(&folder.join(NAME), (json + "\n").as_bytes())?)
}

/// Removes the files of a new plan.
fn remove(folder: &Path, scripts: &[(&'static str, String)]) {
    for (name, _) in scripts {
        // A file that is not there need not be removed.
        let _ = fs::remove_file(folder.join(name));
    }
    for name in [PARTS, LOGS] {
        let _ = fs::remove_dir(folder.join(name));
    }
}

/// Returns an error if a folder without a plan has files of its names.
fn check_unused(folder: &Path, scripts: &[(&'static str, String)]) -> Result<(), CliError> {
    let is_there = |name: &&str| folder.join(name).symlink_metadata().is_ok();
    let names = scripts.iter().map(|(name, _)| *name).chain([PARTS, LOGS]);
    let present: Vec<&str> = names.filter(|name| is_there(name)).collect();
    if present.is_empty() {
        return Ok(());
    }
    Err(CliError::Failed(format!(
        "{} has {}, which no plan describes; choose another folder with -o",
        folder.display(),
        present.join(", ")
    )))
}
