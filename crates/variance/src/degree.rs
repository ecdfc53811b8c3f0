use sphvar_samplers::{Domain, Sampler, SetDistribution};
use sphvar_spectrum::Resolution;

use crate::Error;
use sphvar_integrands::{Energy, Integrand};

/// Returns the default degree to which a spectrum is computed for predicting the variance of an
/// integrand.
///
/// The power of a random pattern is 1 beyond about 2 sqrt(N), so its tail is known from degree 4
/// sqrt(N) on. A lattice or a given set has peaks at all degrees, and only their mean is 1: the
/// degree is 40 sqrt(N), unless the integrand's energies fall off fast before that. The degree does
/// not exceed the integrand's band limit.
#[must_use]
pub fn prediction_degree(sampler: &dyn Sampler, integrand: &dyn Integrand) -> usize {
    let is_lattice =
        matches!(sampler.distribution(), SetDistribution::Fixed | SetDistribution::OneOf(_));
    degree_limit(sampler.n_points(), sampler.domain(), integrand, is_lattice)
}

/// Returns [`prediction_degree`] of a random pattern or a lattice.
pub(crate) fn degree_limit(
    n_points: usize,
    domain: Domain,
    integrand: &dyn Integrand,
    is_lattice: bool,
) -> usize {
    let natural = Resolution::natural_degree(n_points);
    let degree = if is_lattice { natural.saturating_mul(10) } else { natural };
    let resolved =
        integrand.resolved_degree().map_or(degree, |limit| degree.min(limit.max(natural)));
    let band = integrand.band_limit().filter(|&limit| is_limited(integrand, domain, limit));
    band.map_or(resolved, |limit| resolved.min(limit))
}

/// Returns whether a band-limited function stays band-limited on the domain. The even extension of
/// a function that the equator cuts may not be.
fn is_limited(integrand: &dyn Integrand, domain: Domain, limit: usize) -> bool {
    domain == Domain::Sphere
        || integrand.energy(domain, limit).is_ok_and(|e| e.beyond(limit) == 0.0)
}

/// Returns the degree from which the mean power of any pattern is about 1: 2 sqrt(N), with the N of
/// the same density on the whole sphere.
#[must_use]
pub fn settled_degree(sampler: &dyn Sampler) -> usize {
    settled_degree_of(sampler.n_points(), sampler.domain())
}

/// Returns [`settled_degree`] for any pattern of `n_points`.
#[must_use]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the root of a number of points"
)]
pub fn settled_degree_of(n_points: usize, domain: Domain) -> usize {
    (2.0 * domain.count_on_sphere(n_points).sqrt()).ceil() as usize
}

/// Checks that a largest degree is high enough to predict a meaningful rate.
///
/// Beyond `lmax` a prediction uses the limit of the pattern's mean power. Below [`settled_degree`]
/// the true power can be any number from 0 up. If the integrand has energy between the two degrees,
/// the prediction reflects that energy and not the pattern, with a rate of -1; if the tail were
/// dropped, the rate would be too fast. Let `B = sum_{lmax < l <= settled} E(l)`. `B` must be at
/// most a tenth of the energy beyond the settled degree, whose contribution is correct, plus a
/// millionth of the total energy without that of the mean.
///
/// White noise is settled from degree 1 and needs no check.
///
/// # Errors
///
/// Returns [`Error::Unsettled`] with the least sufficient degree. `energy` must reach the settled
/// degree; otherwise all of its remaining energy is treated as lying beyond it.
pub fn check_degree(sampler: &dyn Sampler, energy: &Energy, lmax: usize) -> Result<(), Error> {
    let settled = settled_degree(sampler);
    let beyond = energy.beyond(settled);
    let allowed = 0.1 * beyond + 1e-6 * energy.beyond(0);
    let settles = |l: usize| l >= settled || energy.beyond(l) - beyond <= allowed;
    if settles(lmax) {
        return Ok(());
    }
    // The energy beyond a degree decreases with the degree, so bisection applies.
    let (mut low, mut min_lmax) = (lmax, settled);
    while min_lmax - low > 1 {
        let middle = low + (min_lmax - low) / 2;
        if settles(middle) {
            min_lmax = middle;
        } else {
            low = middle;
        }
    }
    Err(Error::Unsettled { lmax, min_lmax, settled, n_points: sampler.n_points() })
}

#[cfg(test)]
mod tests {
    use sphvar_samplers::{Domain, Pattern};

    use super::{check_degree, settled_degree};
    use crate::Error;
    use sphvar_integrands::{Cap, Harmonic, Integrand, VonMisesFisher};

    #[test]
    fn a_degree_too_low_for_a_rate_is_rejected() {
        let sampler = Pattern::Jittered.build(12 * 64 * 64, Domain::Sphere).unwrap();
        assert_eq!(settled_degree(&*sampler), 444);
        // The thesis uses 256 degrees for up to 120 000 points.
        let cap = Cap::from_degrees(60.0).unwrap().energy(Domain::Sphere, 444).unwrap();
        let error = check_degree(&*sampler, &cap, 255).unwrap_err();
        let Error::Unsettled { lmax: 255, min_lmax, settled: 444, n_points: 49152 } = error else {
            panic!("{error}");
        };
        // The energy falls as l^-2: a tenth more of it lies beyond 444/1.1 = 403.6, up to its
        // oscillation.
        assert!((400..410).contains(&min_lmax), "{min_lmax}");
        assert!(check_degree(&*sampler, &cap, min_lmax).is_ok());
        assert!(check_degree(&*sampler, &cap, min_lmax - 1).is_err());
        let message = error.to_string();
        assert!(message.contains("255") && message.contains(&min_lmax.to_string()), "{message}");
    }

    #[test]
    fn degrees_without_energy_are_not_needed() {
        let sampler = Pattern::Jittered.build(12 * 64 * 64, Domain::Sphere).unwrap();
        let harmonic = Harmonic::new(4, 0).unwrap().energy(Domain::Sphere, 444).unwrap();
        assert!(check_degree(&*sampler, &harmonic, 4).is_ok());
        let error = check_degree(&*sampler, &harmonic, 3).unwrap_err();
        assert!(matches!(error, Error::Unsettled { min_lmax: 4, .. }), "{error}");
        let smooth = VonMisesFisher::new(10.0).unwrap().energy(Domain::Sphere, 444).unwrap();
        let error = check_degree(&*sampler, &smooth, 3).unwrap_err();
        assert!(matches!(error, Error::Unsettled { min_lmax: 5..30, .. }), "{error}");
        // The power of a single point is settled immediately.
        let few = Pattern::WhiteNoise.build(1, Domain::Hemisphere).unwrap();
        assert!(check_degree(&*few, &smooth, 3).is_ok());
    }
}
