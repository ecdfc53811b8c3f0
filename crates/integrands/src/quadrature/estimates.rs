use std::sync::OnceLock;

use sphvar_sh::Domain;

use super::doubling::{Estimate, doubled};
use crate::{Energy, Error, Integrand};

/// The relative error of the energies at which the doubling stops.
const RELATIVE: f64 = 1e-8;
/// The values at which the doubling stops unless narrow features need more: rules of up to 1024
/// rings.
const NODES: usize = 1 << 22;
/// The degree of the narrowest features, which rules of 2048 rings resolve.
pub(crate) const MAX_FEATURE_DEGREE: usize = 1 << 12;

/// The energies of a function: exact to rounding where its quadratures are affordable, otherwise
/// estimates from rules of growing degree, which are kept for further calls.
#[derive(Clone, Debug, Default)]
pub(crate) struct Estimates {
    sphere: OnceLock<Result<Estimate, Error>>,
    hemisphere: OnceLock<Result<Estimate, Error>>,
}

impl Estimates {
    /// Returns the exact energies to degree `lmax`, or estimates to `lmax` or half the degree of the
    /// last rule.
    ///
    /// # Errors
    ///
    /// [`Error::NoEnergy`] if the exact energies are unavailable and the function has no
    /// [`feature_degree`](Integrand::feature_degree) or one that no rule resolves, and those of
    /// [`doubled`].
    pub(crate) fn energy(
        &self,
        function: &dyn Integrand,
        domain: Domain,
        lmax: usize,
    ) -> Result<Energy, Error> {
        self.unless_exact(exact_energy(function, domain, lmax), function, domain, lmax)
    }

    /// Returns `exact` unless those energies are unavailable, otherwise as [`energy`](Self::energy).
    pub(crate) fn unless_exact(
        &self,
        exact: Result<Energy, Error>,
        function: &dyn Integrand,
        domain: Domain,
        lmax: usize,
    ) -> Result<Energy, Error> {
        let (Err(Error::NoEnergy { .. }), Some(degree)) = (&exact, function.feature_degree())
        else {
            return exact;
        };
        let estimate = self.on(domain).get_or_init(|| estimated(function, domain, degree));
        Ok(estimate.as_ref().map_err(Error::clone)?.energy.truncated(lmax))
    }

    /// Returns the exact integral without an error, or the estimate with its error.
    pub(crate) fn integral(&self, function: &dyn Integrand, domain: Domain) -> Option<(f64, f64)> {
        if let Some(exact) = function.exact(domain) {
            return Some((exact, 0.0));
        }
        let degree = function.feature_degree()?;
        let estimate = self.on(domain).get_or_init(|| estimated(function, domain, degree));
        Some(estimate.as_ref().ok()?.integral)
    }

    fn on(&self, domain: Domain) -> &OnceLock<Result<Estimate, Error>> {
        match domain {
            Domain::Sphere => &self.sphere,
            Domain::Hemisphere => &self.hemisphere,
        }
    }
}

/// Returns the energies by coefficients, up to a degree that takes moderate time, and square. The
/// square, which may be unavailable, comes first.
pub(crate) fn exact_energy(
    function: &dyn Integrand,
    domain: Domain,
    lmax: usize,
) -> Result<Energy, Error> {
    let centred = function.centred_square(domain)?;
    let degree = function.energy_degree(domain, lmax);
    let per_degree = function.coefficients(domain, degree)?.energy_per_degree()?;
    Ok(Energy::new(domain, per_degree, centred))
}

/// Returns the estimate of a function whose narrowest features are those of a degree: the last
/// rule has at least half as many rings.
fn estimated(function: &dyn Integrand, domain: Domain, degree: usize) -> Result<Estimate, Error> {
    if degree > MAX_FEATURE_DEGREE {
        return Err(Error::NoEnergy {
            reason: "its exact energies need too many values, and features narrower than 0.1 \
                     degrees may be missed by fewer; take wider lobes",
        });
    }
    // All rules up to the one of n rings have about 4 n^2 nodes.
    let nodes = degree * degree;
    doubled(function, domain, RELATIVE, [nodes, nodes.max(NODES)])
}
