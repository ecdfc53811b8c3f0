use glam::DVec3;
use sphvar_integrands::PulledBack;
use sphvar_samplers::{Domain, FibonacciParameters, Pattern, Purpose, Streams};
use sphvar_warps::{Support, Warp};

use crate::{Density, Error, Integral, WarpedPlan};

/// The number of directions at which densities are examined: half a degree apart.
const EXAMINED: usize = 1 << 17;

impl WarpedPlan {
    /// Rejects densities that are 0 where the integrand is not, so that part of the integral would
    /// be lost. Maps about the surface are examined about the normal, maps of the world where the
    /// environment is not black, and a light must be sampled by its own density or by one that is
    /// positive above the surface.
    ///
    /// Densities are compared with the integrand at 131072 directions, half a degree apart, so a
    /// smaller hole may go unnoticed.
    ///
    /// # Errors
    ///
    /// Returns [`Error::NoDensity`] with the direction of the largest loss and the lost share of the
    /// integral, without regard to the cosine in world directions, and [`Error::OtherLight`] for the
    /// density of a light that is not integrated.
    pub fn check(&self, integral: &Integral<'_>) -> Result<(), Error> {
        let mut has_light = false;
        let (mut of_surface, mut of_world) = (Vec::new(), Vec::new());
        for (density, _) in self.densities() {
            match density {
                Density::Light { light, .. } => match integral {
                    Integral::Light { light: lamp, .. } if *lamp == light => has_light = true,
                    _ => return Err(Error::OtherLight),
                },
                Density::Surface(warp) => of_surface.push(&**warp),
                Density::World { warp, rotation } => of_world.push((&**warp, rotation.inverse())),
            }
        }
        let covers_world = |(warp, _): &(&dyn Warp, _)| {
            warp.support() == Support::Sphere && is_reached(warp.min_density())
        };
        if has_light || of_world.iter().any(covers_world) {
            return Ok(());
        }
        if !of_surface.is_empty() {
            let positive = |dir| of_surface.iter().any(|warp| is_reached(warp.density(dir)));
            let examined = examine("about the normal", |dir| dir.z.max(0.0), positive);
            if of_world.is_empty() || examined.is_ok() {
                return examined;
            }
        }
        let value = |dir: DVec3| match integral {
            Integral::Irradiance { radiance, .. } => radiance(dir),
            _ => 1.0,
        };
        examine("of the environment", value, |dir| {
            of_world.iter().any(|(warp, rotation)| is_reached(warp.density(*rotation * dir)))
        })
    }
}

/// Returns whether points reach directions of a density.
fn is_reached(density: f64) -> bool {
    density * Domain::Sphere.area() > PulledBack::UNREACHED
}

/// Compares a function with the set where a density is positive.
fn examine(
    frame: &'static str,
    value: impl Fn(DVec3) -> f64,
    is_positive: impl Fn(DVec3) -> bool,
) -> Result<(), Error> {
    let lattice =
        Pattern::Fibonacci(FibonacciParameters::default()).build(EXAMINED, Domain::Sphere)?;
    let directions = lattice.sample(&mut Streams::new(0, Purpose::Pattern, 0).realization(0))?;
    let (mut total, mut lost, mut largest) = (0.0, 0.0, (0.0, DVec3::Z));
    for dir in directions.points {
        // Texels of a map may be slightly negative.
        let value = value(dir).abs();
        total += value;
        if value > 0.0 && !is_positive(dir) {
            lost += value;
            if value > largest.0 {
                largest = (value, dir);
            }
        }
    }
    if lost <= PulledBack::NEGLIGIBLE * total {
        return Ok(());
    }
    let dir = largest.1;
    Err(Error::NoDensity {
        theta: dir.x.hypot(dir.y).atan2(dir.z).to_degrees(),
        phi: dir.y.atan2(dir.x).to_degrees(),
        frame,
        percent: 100.0 * lost / total,
    })
}
