use glam::DVec3;

use super::start::perturbed_lattice;
use super::{DesignEquations, dense, matrix_free, solve_dense, solve_matrix_free, stored};
use crate::optimization::RieszEnergy;
use crate::patterns::white_noise;
use crate::{Error, Progress, Purpose, Streams};

/// The largest power that is left: it is close to that of rounding errors, and steps converge
/// quadratically from 1e-12.
const TOLERANCE: f64 = 1e-22;

/// The largest number of equations for dense matrices, which then take 2.4 GB.
const MAX_DENSE: usize = 10_000;

/// Steps of relaxation by Coulomb forces before dense steps.
const RELAXATION: u32 = 30;

/// Attempts from a lattice before those from random points.
const ATTEMPTS_FROM_LATTICE: u64 = 4;

/// Returns the points of the design of `n_points` points: a stored one, or the result of a search,
/// always the same.
///
/// # Errors
///
/// [`Error::Infeasible`] if no design is known, or all searches stall; [`Error::Stopped`];
/// [`Error::OutOfMemory`]; [`Error::Degree`].
pub(crate) fn design_points(
    equations: DesignEquations,
    n_points: usize,
    progress: &dyn Progress,
) -> Result<Vec<DVec3>, Error> {
    if let Some(points) = stored::points(equations, n_points) {
        return Ok(points);
    }
    let mut attempt = 0;
    loop {
        match attempt_design(equations, n_points, attempt, progress) {
            Err(Error::Infeasible { .. }) if attempt + 1 < attempts(equations) => attempt += 1,
            result => return result,
        }
    }
}

/// Searches from the points of an attempt.
pub(super) fn attempt_design(
    equations: DesignEquations,
    n_points: usize,
    attempt: u64,
    progress: &dyn Progress,
) -> Result<Vec<DVec3>, Error> {
    let mut points = perturbed_lattice(equations, n_points, attempt)?;
    if !is_dense(equations, n_points) {
        solve_matrix_free(equations, &mut points, TOLERANCE, progress)?;
        return Ok(points);
    }
    if attempt >= ATTEMPTS_FROM_LATTICE {
        let mut rng = Streams::new(0, Purpose::Pattern, n_points).realization(attempt);
        points.fill_with(|| white_noise::uniform_direction(equations.domain(), &mut rng));
    }
    let energy = RieszEnergy::new(equations.domain(), 1.0);
    energy.descend(&mut points, RELAXATION, &|| progress.tick(0.0))?;
    solve_dense(equations, &mut points, TOLERANCE, progress)?;
    Ok(points)
}

/// Returns the maximum number of searches: single ones stall, often with few points.
fn attempts(equations: DesignEquations) -> u64 {
    match equations.count() {
        0..200 => 60,
        200..1200 => 12,
        _ => 4,
    }
}

/// Returns whether the search uses dense matrices: where they are expected to be faster, as near
/// the limit of the degrees of freedom, and fit into memory.
fn is_dense(equations: DesignEquations, n_points: usize) -> bool {
    equations.count() <= MAX_DENSE
        && dense::expected_work(equations, n_points)
            <= matrix_free::expected_work(equations, n_points)
}

/// Returns the expected nominal work of [`design_points`].
pub(crate) fn expected_work(equations: DesignEquations, n_points: usize) -> f64 {
    if stored::has(equations, n_points) {
        return n_points as f64;
    }
    let of_search = if is_dense(equations, n_points) {
        dense::expected_work(equations, n_points)
    } else {
        matrix_free::expected_work(equations, n_points)
    };
    of_search.max(n_points as f64)
}
