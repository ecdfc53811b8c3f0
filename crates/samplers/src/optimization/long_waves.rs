use glam::DVec3;

use super::descent::{ManifoldPoint, Objective};
use super::spectral_control::{DistancePenalty, SpectralEnergy, SphereBands, degree_within};
use crate::{Domain, Error, SpectralTarget};

/// The last degree that is removed, in units of sqrt(N) (2N on the hemisphere).
const SHARE: f64 = 0.5;

/// Number of displacements: each lowers the power of white noise to about a tenth.
const DISPLACEMENTS: u32 = 5;

/// Removes the low degrees of the density of points by smooth displacements.
///
/// A displacement is the gradient of the solution of Poisson's equation for the density of the
/// points up to degree `sqrt(N)/2`: the potential flow that makes this density uniform to first
/// order. Sets too small to have such degrees are left unchanged.
///
/// # Errors
///
/// [`Error::Degree`] if the degree exceeds what a transform supports.
pub(crate) fn remove_long_waves(points: &mut [DVec3], domain: Domain) -> Result<(), Error> {
    let n = points.len();
    let last = degree_within(SHARE, n, domain);
    if last == 0 {
        return Ok(());
    }
    let target = SpectralTarget::new(vec![0.0; last + 1])?;
    let bands = SphereBands::targets(&target, domain);
    let no_core = DistancePenalty { space: domain, sigma: 0.0 };
    let mut energy = SpectralEnergy::new(SphereBands::new(last, n)?, bands, no_core, n);
    let reach = 8.0 * (domain.area() / n as f64).sqrt();
    let mut gradient = Vec::new();
    for _ in 0..DISPLACEMENTS {
        energy.energy(points);
        energy.gradient(points, &mut gradient);
        for (p, &gradient) in points.iter_mut().zip(&gradient) {
            *p = p.moved(DVec3::tangent(-gradient, *p).clamp_length_max(reach));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use sphvar_sht::ExactTransform;

    use super::{DVec3, degree_within, remove_long_waves};
    use crate::{Domain, Pattern, Purpose, Streams};

    /// Returns the largest power of the degrees of `domain` up to `last`, by the exact transform.
    fn largest_power(points: &[DVec3], domain: Domain, last: usize) -> f64 {
        let alm = ExactTransform::new(last).unwrap().adjoint(points, None).unwrap();
        let scale = 4.0 * PI / points.len() as f64;
        let powers = alm.power_per_degree().into_iter().enumerate().skip(1);
        powers.filter(|(l, _)| domain.has_degree(*l)).map(|(_, p)| scale * p).fold(0.0, f64::max)
    }

    #[test]
    fn low_degrees_lose_their_power() {
        for domain in [Domain::Sphere, Domain::Hemisphere] {
            for n in [1, 2, 3, 4, 16, 100, 2000] {
                let mut rng = Streams::new(3, Purpose::Pattern, n).realization(0);
                let white = Pattern::WhiteNoise.build(n, domain).unwrap();
                let mut points = white.sample(&mut rng).unwrap().points;
                let before = points.clone();
                remove_long_waves(&mut points, domain).unwrap();
                assert!(points.iter().all(|p| (p.length() - 1.0).abs() < 1e-15), "{domain} {n}");
                let last = degree_within(0.5, n, domain);
                if last == 0 {
                    assert_eq!(points, before, "{domain} {n}");
                } else if n >= 16 {
                    let [from, to] = [&before, &points].map(|p| largest_power(p, domain, last));
                    assert!(to < 0.05 * from, "{domain} {n}: {from} to {to}");
                }
            }
        }
    }

    /// Points that coincide stay finite and on the sphere.
    #[test]
    fn coincident_points_are_handled() {
        for domain in [Domain::Sphere, Domain::Hemisphere] {
            let mut points = vec![DVec3::Z; 200];
            remove_long_waves(&mut points, domain).unwrap();
            assert!(points.iter().all(|p| (p.length() - 1.0).abs() < 1e-15), "{domain}");
        }
    }
}
