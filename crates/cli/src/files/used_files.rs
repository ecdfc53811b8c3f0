//! The files that a run of the command has read and written, so that no output replaces an input or another output.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// The paths without links; `None` while nothing is recorded, as in tests of single readers and writers.
static USED: Mutex<Option<Used>> = Mutex::new(None);

#[derive(Debug, Default)]
struct Used {
    /// With the names by which they were read.
    inputs: BTreeMap<PathBuf, String>,
    outputs: BTreeSet<PathBuf>,
    /// The file that is written when everything else has been.
    last: Option<PathBuf>,
}

/// Starts recording; a process that runs one command calls it once.
pub(crate) fn record_used_files() {
    with(|used| *used = Some(Used::default()));
}

/// Records that `path` is read.
pub(crate) fn record_input(path: &Path) {
    with(|used| {
        if let (Some(used), Ok(found)) = (used, fs::canonicalize(path)) {
            used.inputs.entry(found).or_insert_with(|| path.display().to_string());
        }
    });
}

/// Returns the regular files that have been read, each with the name by which it was read.
pub(crate) fn inputs() -> Vec<(String, PathBuf)> {
    let all = with(|used| used.as_ref().map(|used| used.inputs.clone())).unwrap_or_default();
    let named = all.into_iter().map(|(path, name)| (name, path));
    named.filter(|(_, path)| path.is_file()).collect()
}

/// Records that `path` has been written.
pub(crate) fn record_output(path: &Path) {
    with(|used| {
        if let (Some(used), Ok(path)) = (used, fs::canonicalize(path)) {
            used.outputs.insert(path);
        }
    });
}

/// Sets the file that is written when everything else has been, or that this is the case.
pub(crate) fn set_last_output(path: Option<&Path>) {
    with(|used| {
        if let Some(used) = used {
            used.last = path.and_then(resolved);
        }
    });
}

/// Returns the path of a file, which need not exist, without links in its folder.
fn resolved(path: &Path) -> Option<PathBuf> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = fs::canonicalize(folder.unwrap_or(Path::new("."))).ok()?;
    fs::canonicalize(path).ok().or_else(|| Some(folder.join(path.file_name()?)))
}

/// Returns why `path` cannot be an output.
pub(super) fn conflict(path: &Path) -> Option<&'static str> {
    let path = resolved(path)?;
    with(|used| {
        let used = used.as_ref()?;
        if used.last.as_ref() == Some(&path) {
            return Some("--save names it; name a file for each output");
        }
        if used.inputs.contains_key(&path) {
            Some("it is an input of this command; name another output file")
        } else if used.outputs.contains(&path) {
            Some("this command has written it already; name a file for each output")
        } else {
            None
        }
    })
}

/// A panic elsewhere cannot leave the sets half changed.
fn with<T>(f: impl FnOnce(&mut Option<Used>) -> T) -> T {
    f(&mut USED.lock().unwrap_or_else(PoisonError::into_inner))
}
