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

/// Returns why `path`, an existing file, cannot be an output.
pub(super) fn conflict(path: &Path) -> Option<&'static str> {
    let path = fs::canonicalize(path).ok()?;
    with(|used| {
        let used = used.as_ref()?;
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
