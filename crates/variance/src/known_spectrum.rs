use sphvar_samplers::{Domain, Pattern};
use sphvar_spectrum::{Spectrum, exact_spectrum, exact_spectrum_cost, has_exact_spectrum};

use crate::Error;

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

/// The spectrum of a pattern without sampling, or `None` where [`is_spectrum_known`] says no. `done`
/// is called with seconds that add up to [`exact_spectrum_cost`].
///
/// # Errors
///
/// [`Error::Spectrum`] if the pattern cannot have so many points or lmax is out of range.
pub fn known_spectrum(
    pattern: &Pattern,
    n_points: usize,
    domain: Domain,
    lmax: usize,
    seconds: f64,
    done: &(dyn Fn(f64) + Sync),
) -> Result<Option<Spectrum>, Error> {
    if is_spectrum_known(pattern, n_points, domain, lmax, seconds) {
        Ok(Some(exact_spectrum(pattern, n_points, domain, lmax, done)?))
    } else {
        Ok(None)
    }
}
