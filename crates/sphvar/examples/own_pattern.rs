//! Ranks a user-defined pattern and built-in ones for a user-defined integrand:
//! `cargo run --release -p sphvar --example own_pattern`.

use std::io::Write;

use sphvar::prelude::*;
use sphvar::rand::Rng;
use sphvar::samplers::{Error, uniform_rotation};

/// Independently rotated octahedra, each of which integrates degrees up to 3 exactly.
#[derive(Debug)]
struct Octahedra(usize);

impl Sampler for Octahedra {
    fn n_points(&self) -> usize {
        6 * self.0
    }

    fn domain(&self) -> Domain {
        Domain::Sphere
    }

    fn sample_into(&self, rng: &mut dyn Rng, set: &mut PointSet) -> Result<(), Error> {
        let points = set.start();
        for _ in 0..self.0 {
            let rotation = uniform_rotation(rng);
            points.extend(
                [rotation.x_axis, rotation.y_axis, rotation.z_axis].iter().flat_map(|&p| [p, -p]),
            );
        }
        Ok(())
    }
}

/// Octahedra for every number of points that is a multiple of 6.
#[derive(Debug)]
struct AnyOctahedra;

impl std::fmt::Display for AnyOctahedra {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad("octahedra")
    }
}

impl SamplerFamily for AnyOctahedra {
    fn build(&self, n_points: usize, domain: Domain) -> Result<Box<dyn Sampler>, Error> {
        if domain != Domain::Sphere || n_points == 0 || !n_points.is_multiple_of(6) {
            let reason = "N must be a multiple of 6, on the sphere".to_owned();
            return Err(Error::Infeasible { pattern: "octahedra", n_points, reason });
        }
        Ok(Box::new(Octahedra(n_points / 6)))
    }

    fn nearest_count(&self, requested: usize, _: Domain) -> usize {
        6 * ((requested + 3) / 6).max(1)
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let function = |d: DVec3| (2.0 * d.x).exp() + d.y * d.z;
    let integrand = AdaptiveFunction::new(function, Domain::Sphere, Tolerance::default())?;
    let mut predictor = Predictor::new(&integrand, Domain::Sphere, 0, PredictionBudget::DEFAULT)?;
    let families: [&dyn SamplerFamily; 4] =
        [&AnyOctahedra, &Pattern::WhiteNoise, &Pattern::Jittered, &Pattern::FIBONACCI];
    let goal = Goal::Points(192);
    let candidates = Candidate::ranked(families, goal, &mut predictor, &())?;
    for (place, candidate) in candidates.iter().enumerate() {
        let (variance, stderr) = candidate.variance.unwrap_or((f64::NAN, f64::NAN));
        let pattern = candidate.curve.pattern();
        writeln!(
            std::io::stdout(),
            "{}. {pattern:12} variance {variance:.3e} +- {stderr:.1e}",
            place + 1
        )?;
    }
    Ok(())
}
