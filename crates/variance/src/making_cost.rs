use sphvar_samplers::Pattern;

/// Seconds for making one set of `n_points` of a pattern on one core of a 2.6 GHz machine, roughly: for
/// deciding what is affordable, for progress and for scaling measured times, not for promises.
///
/// Proportional to N, but to N^2 for `best-candidate` and `riesz`; N from 1. The constants were measured
/// between 1024 and 65536 points, with the parameters of [`Pattern::ALL`].
#[must_use]
pub fn making_seconds(pattern: &Pattern, n_points: usize) -> f64 {
    let n = n_points as f64;
    match pattern {
        Pattern::PoissonDisk { .. } => 2.3e-6 * n,
        // Every exchange of mass looks at the mass points.
        Pattern::Ccvt { capacity, .. } => 28e-6 * n * (*capacity).max(1) as f64 / 64.0,
        Pattern::Step { .. } => 60e-6 * n,
        Pattern::Blue { .. } => 30e-6 * n,
        Pattern::Profile { .. } => 10e-6 * n,
        Pattern::BestCandidate { factor } => 47e-9 * n * n * f64::from(*factor),
        Pattern::Lloyd { iterations } => 0.5e-6 * n * f64::from(*iterations),
        Pattern::Riesz { iterations, .. } => 4e-9 * n * n * f64::from(*iterations),
        Pattern::Sobol => 80e-9 * n,
        _ => 40e-9 * n,
    }
}
