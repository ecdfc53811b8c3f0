//! Stops a reader before it exhausts the memory.

use std::io;

use crate::files::FileError;
use crate::memory::{available_memory, gibibytes, memory_beyond};

/// The number of additional bytes after which the available memory is checked again.
const STEP: u64 = 64 << 20;

/// Monitors the memory that a reader holds.
///
/// Headers may announce any size and a small compressed file may expand to any size, so only data
/// that have been read count.
#[derive(Debug, Default)]
pub(super) struct MemoryGuard {
    checked: u64,
}

impl MemoryGuard {
    /// Returns an error if a reader holds `held` bytes and no memory is left.
    ///
    /// # Errors
    ///
    /// [`FileError::Memory`].
    pub(super) fn check(&mut self, path: &str, what: &str, held: u64) -> Result<(), FileError> {
        match self.left(held) {
            Some(left) if left < STEP as f64 => {
                Err(memory_error(path, what, held as f64 + STEP as f64, held as f64 + left))
            }
            _ => Ok(()),
        }
    }

    /// Returns an error if no memory is left for the data after this number of decompressed bytes.
    ///
    /// A reader that discards the data takes no memory, whatever their size.
    ///
    /// # Errors
    ///
    /// If the memory is exhausted.
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

    /// Returns the available memory at every step.
    fn left(&mut self, held: u64) -> Option<f64> {
        if held < self.checked.saturating_add(STEP) {
            return None;
        }
        self.checked = held;
        memory_beyond(held)
    }
}

/// Returns an error if `bytes`, announced by a file of sufficient length, exceed the memory.
///
/// # Errors
///
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
