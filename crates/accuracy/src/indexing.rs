//! Directions to HEALPix pixels and back.

use crate::{Effort, HardCase, Trial};

/// The trials of this area.
pub(crate) fn trials(_effort: Effort) -> Vec<Trial> {
    Vec::new()
}

/// The hard cases of this area.
pub(crate) fn hard_cases() -> Vec<HardCase> {
    Vec::new()
}
