use sphvar_samplers::{Domain, Law, Sampler};
use sphvar_spectrum::Resolution;

use crate::Error;
use sphvar_integrands::{Energy, Integrand};

/// The degree to which a spectrum is needed for predicting the variance of an integrand, if the
/// caller has no wish of his own.
///
/// A random pattern's power is 1 beyond some 2 sqrt(N), so 4 sqrt(N) leave a tail that is known. A
/// lattice, and a given set, has peaks at all degrees whose mean only is 1: 40 sqrt(N), unless the integrand's energies
/// fall fast before that. Degrees that the integrand does not have are not needed.
#[must_use]
pub fn prediction_degree(sampler: &dyn Sampler, integrand: &dyn Integrand) -> usize {
    let law = Resolution::natural_degree(sampler.n_points());
    let is_lattice = matches!(sampler.law(), Law::Fixed | Law::OneOf(_));
    let degree = if is_lattice { law.saturating_mul(10) } else { law };
    let resolved = integrand.resolved_degree().map_or(degree, |most| degree.min(most.max(law)));
    let band = integrand.band_limit().filter(|&most| is_limited(integrand, sampler.domain(), most));
    band.map_or(resolved, |most| resolved.min(most))
}

/// Whether a function of a band limit keeps it on the domain: the even extension of what the equator cuts may not.
fn is_limited(integrand: &dyn Integrand, domain: Domain, most: usize) -> bool {
    domain == Domain::Sphere || integrand.energy(domain, most).is_ok_and(|e| e.beyond(most) == 0.0)
}

/// The degree from which on the mean power of any pattern is about 1: 2 sqrt(N), with the N of the
/// same density on the whole sphere.
#[must_use]
pub fn settled_degree(sampler: &dyn Sampler) -> usize {
    settled_degree_of(sampler.n_points(), sampler.domain())
}

/// [`settled_degree`] of any pattern of `n_points`.
#[must_use]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the root of a number of points"
)]
pub fn settled_degree_of(n_points: usize, domain: Domain) -> usize {
    (2.0 * domain.count_on_sphere(n_points).sqrt()).ceil() as usize
}

/// Refuses a largest degree that would fake a rate.
///
/// Beyond `lmax` a prediction takes the mean power that the pattern tends to. Below [`settled_degree`] it can be anything
/// from 0 on; if the integrand has energy between the two, then what is predicted is that energy and not the
/// pattern, with a rate of -1 (or, were the rest dropped, with one that is too fast). Let
/// `B = sum_{lmax < l <= settled} E(l)`. It has to be at most a tenth of the energy beyond the settled
/// degree, whose share is right, plus a millionth of all energy but that of the mean.
///
/// White noise is settled from degree 1 on and needs no such care.
///
/// # Errors
///
/// [`Error::Unsettled`] with the least degree that would do. `energy` must reach to the settled degree, else the
/// answer is as if the integrand had all of its remaining energy beyond.
pub fn check_degree(sampler: &dyn Sampler, energy: &Energy, lmax: usize) -> Result<(), Error> {
    let settled = settled_degree(sampler);
    let beyond = energy.beyond(settled);
    let allowed = 0.1 * beyond + 1e-6 * energy.beyond(0);
    let settles = |l: usize| l >= settled || energy.beyond(l) - beyond <= allowed;
    if settles(lmax) {
        return Ok(());
    }
    // The energy beyond a degree falls with it: bisection.
    let (mut low, mut least) = (lmax, settled);
    while least - low > 1 {
        let middle = low + (least - low) / 2;
        if settles(middle) {
            least = middle;
        } else {
            low = middle;
        }
    }
    Err(Error::Unsettled { lmax, least, settled, n_points: sampler.n_points() })
}

#[cfg(test)]
mod tests {
    use sphvar_samplers::{Domain, Pattern};

    use super::{check_degree, settled_degree};
    use crate::Error;
    use sphvar_integrands::{Cap, Harmonic, Integrand, VonMisesFisher};

    #[test]
    fn a_degree_that_fakes_a_rate_is_refused() {
        let sampler = Pattern::Jittered.build(12 * 64 * 64, Domain::Sphere).unwrap();
        assert_eq!(settled_degree(&*sampler), 444);
        // 256 degrees were the thesis's own, for up to 120 000 points.
        let cap = Cap::from_degrees(60.0).unwrap().energy(Domain::Sphere, 444).unwrap();
        let refused = check_degree(&*sampler, &cap, 255).unwrap_err();
        let Error::Unsettled { lmax: 255, least, settled: 444, n_points: 49152 } = refused else {
            panic!("{refused}");
        };
        // Energy as l^-2: a tenth more of it is beyond 444/1.1 = 403.6, give or take its oscillation.
        assert!((400..410).contains(&least), "{least}");
        assert!(check_degree(&*sampler, &cap, least).is_ok());
        assert!(check_degree(&*sampler, &cap, least - 1).is_err());
        let message = refused.to_string();
        assert!(message.contains("255") && message.contains(&least.to_string()), "{message}");
    }

    #[test]
    fn degrees_without_energy_are_not_needed() {
        let sampler = Pattern::Jittered.build(12 * 64 * 64, Domain::Sphere).unwrap();
        let harmonic = Harmonic::new(4, 0).unwrap().energy(Domain::Sphere, 444).unwrap();
        assert!(check_degree(&*sampler, &harmonic, 4).is_ok());
        let refused = check_degree(&*sampler, &harmonic, 3).unwrap_err();
        assert!(matches!(refused, Error::Unsettled { least: 4, .. }), "{refused}");
        let smooth = VonMisesFisher::new(10.0).unwrap().energy(Domain::Sphere, 444).unwrap();
        let refused = check_degree(&*sampler, &smooth, 3).unwrap_err();
        assert!(matches!(refused, Error::Unsettled { least: 5..30, .. }), "{refused}");
        // A handful of points is settled at once.
        let few = Pattern::WhiteNoise.build(1, Domain::Hemisphere).unwrap();
        assert!(check_degree(&*few, &smooth, 3).is_ok());
    }
}
