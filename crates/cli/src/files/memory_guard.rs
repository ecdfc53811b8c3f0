//! Stops a reader before it takes more memory than there is.

use std::io;

use crate::files::FileError;
use crate::memory::{available_memory, gibibytes};

/// How much more a reader may hold before the memory is looked at again.
const STEP: u64 = 64 << 20;

/// Watches how much a reader holds.
///
/// Headers may promise anything and a small compressed file may hold anything, so that only what
/// has been read counts.
#[derive(Debug, Default)]
pub(super) struct MemoryGuard {
    checked: u64,
}

impl MemoryGuard {
    /// Returns an error if `held` bytes are held and there is no memory for more.
    ///
    /// # Errors
    /// [`FileError::Memory`].
    pub(super) fn check(&mut self, path: &str, what: &str, held: u64) -> Result<(), FileError> {
        match self.left(held) {
            Some(left) if left < STEP as f64 => {
                Err(memory_error(path, what, held as f64 + STEP as f64, held as f64 + left))
            }
            _ => Ok(()),
        }
    }

    /// Returns an error if there is no memory for what may follow this number of decompressed bytes.
    ///
    /// A reader that keeps nothing of them takes no memory, however many there are.
    ///
    /// # Errors
    /// When the memory has come to its end.
    pub(super) fn check_decompressed(&mut self, bytes: u64) -> io::Result<()> {
        match self.left(bytes) {
            Some(left) if left < STEP as f64 => Err(io::Error::other(format!(
                "{} after decompression and more do not fit, {} of memory are available",
                gibibytes(bytes as f64),
                gibibytes(left)
            ))),
            _ => Ok(()),
        }
    }

    /// Returns the memory that is left, at every step.
    fn left(&mut self, held: u64) -> Option<f64> {
        if held < self.checked.saturating_add(STEP) {
            return None;
        }
        self.checked = held;
        available_memory()
    }
}

/// Returns an error if `bytes`, which a file of sufficient length announces, exceed the memory.
///
/// # Errors
/// [`FileError::Memory`].
pub(super) fn check_announced(path: &str, what: &str, bytes: f64) -> Result<(), FileError> {
    match available_memory() {
        Some(available) if bytes > available => Err(memory_error(path, what, bytes, available)),
        _ => Ok(()),
    }
}

fn memory_error(path: &str, what: &str, needed: f64, available: f64) -> FileError {
    FileError::Memory {
        path: path.to_owned(),
        what: what.to_owned(),
        needed: gibibytes(needed),
        available: gibibytes(available),
    }
}
