//! The degrees to which energies are computed, in steps that do not depend on what was asked before.

use sphvar_sh::MAX_DEGREE;

/// The largest degree of the energies number `level`: 256, 384, 512, 768, 1024, ...
pub(crate) fn degrees_of(level: usize) -> usize {
    let power = 256_usize << (level / 2);
    (power + level % 2 * power / 2).min(MAX_DEGREE)
}

/// The number of the energies that reach `lmax`; of those to the largest degree there is, beyond.
pub(crate) fn level(lmax: usize) -> usize {
    (0..).find(|&k| degrees_of(k) >= lmax.min(MAX_DEGREE)).unwrap_or(0)
}
