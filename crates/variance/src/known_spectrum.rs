use sphvar_samplers::{Domain, Pattern};
use sphvar_spectrum::{exact_spectrum_cost, has_exact_spectrum};

/// Whether the spectrum of a pattern can be had without sampling in about `seconds` of one core, by
/// the model of [`exact_spectrum_cost`] and not by a clock.
#[must_use]
pub fn is_spectrum_known(
    pattern: &Pattern,
    n_points: usize,
    domain: Domain,
    lmax: usize,
    seconds: f64,
) -> bool {
    has_exact_spectrum(pattern) && exact_spectrum_cost(pattern, n_points, domain, lmax) <= seconds
}
