use crate::error::{not_negative, per_degree};
use crate::{Domain, Error, Profile};
use sphvar_sh::CompensatedSum;

/// The range of the variance of a given integrand under a profile.
///
/// The ends differ only because of the integrand's tail, of which only the total energy is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VarianceRange {
    /// The variance with the smallest value of the profile on the tail.
    pub lower: f64,
    /// The variance with the largest value of the profile on the tail.
    pub upper: f64,
}

/// Returns the variance of a given integrand for a pattern whose power is this profile.
///
/// ```text
/// prefactor * [ sum_{l <= lmax} E(l) P(l) + P_tail * tail_energy ]
/// ```
///
/// `energy_per_degree[l]` is `E(l) = (2l+1) P_F(l)` from `l = 0` to `lmax`; degree 0 is not used,
/// nor are odd degrees on the hemisphere. `tail_energy` is `sum E(l)` over the degrees beyond
/// `lmax`, where `P_tail` lies between the profile at the first such degree and its plateau. If the
/// profile is an upper bound of the spectrum then `upper` bounds the variance from above; if it is
/// a lower bound then `lower` bounds it from below.
///
/// # Errors
///
/// Returns [`Error::NoPoints`]; [`Error::DegreeValue`] or [`Error::Parameter`] for an energy that
/// is negative, infinite or NaN.
///
/// # Examples
///
/// ```
/// use sphvar_bounds::{Domain, Profile, variance_bound};
/// use std::f64::consts::PI;
/// let range = variance_bound(&Profile::linear(1.0, 1.0)?, 16, Domain::Sphere, &[9.0, 4.0, 2.0], 1.0)?;
/// // Powers 1/4 and 2/4, then 3/4 to 1 on the tail.
/// assert_eq!(range.lower, PI / 4.0 * 2.75);
/// assert_eq!(range.upper, PI / 4.0 * 3.0);
/// # Ok::<(), sphvar_bounds::Error>(())
/// ```
pub fn variance_bound(
    profile: &Profile,
    n_points: usize,
    domain: Domain,
    energy_per_degree: &[f64],
    tail_energy: f64,
) -> Result<VarianceRange, Error> {
    per_degree("energy", energy_per_degree)?;
    not_negative("tail_energy", tail_energy)?;
    if n_points == 0 {
        return Err(Error::NoPoints);
    }
    // The first degree that enters equals the spacing of the degrees.
    let step = domain.degree_step();
    let sum: CompensatedSum = energy_per_degree
        .iter()
        .enumerate()
        .skip(step)
        .step_by(step)
        .map(|(l, energy)| energy * profile.power(l, n_points))
        .collect();
    // Profiles are non-decreasing, so the smallest value beyond lmax is at the first degree there.
    let tail_start = energy_per_degree.len().next_multiple_of(step).max(step);
    let with_tail = |power: f64| {
        let mut total = sum;
        total.add(power * tail_energy);
        domain.variance_factor(n_points) * total.value()
    };
    Ok(VarianceRange {
        lower: with_tail(profile.power(tail_start, n_points)),
        upper: with_tail(profile.supremum()),
    })
}
