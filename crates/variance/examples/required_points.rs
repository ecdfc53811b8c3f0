//! Prints the number of points with which patterns integrate a closure to a relative error of 1 %:
//! `cargo run --release -p sphvar-variance --example required_points`.

use std::io::Write;

use glam::DVec3;
use sphvar_integrands::{AdaptiveFunction, Tolerance};
use sphvar_samplers::{Domain, Pattern};
use sphvar_variance::{PredictedCurve, PredictionBudget, Predictor, required_points};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (domain, seed) = (Domain::Sphere, 0);
    let function = |d: DVec3| (4.0 * d.x).exp() + d.y * d.z;
    let integrand = AdaptiveFunction::new(function, domain, Tolerance::default())?;
    let (integral, _) = integrand.integral();
    let mut predictor = Predictor::new(&integrand, domain, seed, PredictionBudget::DEFAULT)?;
    let variance = (0.01 * integral).powi(2);
    let mut out = std::io::stdout().lock();
    for pattern in [Pattern::WhiteNoise, Pattern::Jittered, Pattern::Healpix, Pattern::FIBONACCI] {
        let mut curve = PredictedCurve::new(pattern);
        let required = required_points(&mut predictor, &mut curve, variance, 100_000, &())?;
        match required.n_points() {
            Some(n) => writeln!(out, "{:12} {n}", curve.pattern())?,
            None => writeln!(out, "{:12} more than 100000", curve.pattern())?,
        }
    }
    Ok(())
}
