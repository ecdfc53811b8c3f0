//! Inputs of several tests.

pub(crate) const EPSILONS: [f64; 12] =
    [1e-1, 1e-2, 1e-3, 3e-5, 1e-5, 5e-6, 1e-7, 1e-9, 1e-10, 1e-11, 5e-13, 1e-13];
pub(crate) const JUST_BELOW_1: f64 = 1.0 - f64::EPSILON / 2.0;

/// Returns a generator of numbers in [0, 1), by linear congruence.
pub(crate) fn uniform(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 * 2f64.powi(-53)
    }
}
