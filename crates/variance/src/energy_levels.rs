//! The degrees to which energies are computed, in steps that do not depend on earlier requests.

use sphvar_sh::MAX_DEGREE;

/// Returns the largest degree of the energies at `level`: 256, 384, 512, 768, 1024, ...
pub(crate) fn degrees_of(level: usize) -> usize {
    let power = 256_usize << (level / 2);
    (power + level % 2 * power / 2).min(MAX_DEGREE)
}

/// Returns the lowest level that reaches `lmax`; beyond the maximum degree, the highest level.
pub(crate) fn level(lmax: usize) -> usize {
    (0..).find(|&k| degrees_of(k) >= lmax.min(MAX_DEGREE)).unwrap_or(0)
}
