use std::f64::consts::PI;
use std::ops::ControlFlow;

use glam::DVec3;
use num_complex::Complex;
use sphvar_samplers::{Pattern, Purpose, Streams};
use sphvar_sht::{Fit, FitError, LeastSquares};

use super::DOMAIN;
use crate::{Errors, Subject};

/// The seed of every set.
const SEED: u64 = 7;

/// The function `1 + z + x y`.
pub(super) fn function(p: DVec3) -> f64 {
    1.0 + p.z + p.x * p.y
}

/// Returns its coefficients: `sqrt(4 pi)`, `sqrt(4 pi/3)` and `-i sqrt(2 pi/15)` at m = 2.
pub(super) fn coefficient(l: usize, m: usize) -> Complex<f64> {
    match (l, m) {
        (0, 0) => Complex::new((4.0 * PI).sqrt(), 0.0),
        (1, 0) => Complex::new((4.0 * PI / 3.0).sqrt(), 0.0),
        (2, 2) => Complex::new(0.0, -(2.0 * PI / 15.0).sqrt()),
        _ => Complex::ZERO,
    }
}

/// The norm of the function, `sqrt(4 pi + 4 pi/3 + 4 pi/15)`.
pub(super) fn norm() -> f64 {
    (4.0 * PI * (1.0 + 1.0 / 3.0 + 1.0 / 15.0)).sqrt()
}

/// A fit to values of the function at the points of a pattern.
#[derive(Debug)]
pub(super) struct Problem {
    points: Vec<DVec3>,
    values: Vec<f64>,
    lmax: usize,
    /// The largest condition number that the bound allows for.
    condition: f64,
    fit: Option<Fit>,
}

impl Problem {
    pub(super) fn new(pattern: &Pattern, n: usize, lmax: usize, condition: f64) -> Self {
        let points = points(pattern, n);
        let values = points.iter().map(|p| function(*p)).collect();
        Self { points, values, lmax, condition, fit: None }
    }
}

impl Subject for Problem {
    fn run(&mut self) {
        self.fit = fit(&self.points, &self.values, self.lmax, 0.0).ok();
    }

    fn errors(&mut self) -> Errors {
        let mut errors = Errors::default();
        push_coefficients(&mut errors, self.fit.as_ref());
        let is_within = self.fit.as_ref().is_some_and(|fit| fit.condition <= self.condition);
        if !is_within {
            errors.push(f64::INFINITY, || "the condition number is larger".to_owned());
        }
        errors
    }
}

/// Adds the errors of coefficients, relative to their norm.
pub(super) fn push_coefficients(errors: &mut Errors, fit: Option<&Fit>) {
    let Some(fit) = fit else { return errors.push(f64::NAN, || "no fit".to_owned()) };
    for (l, m) in fit.alm.index().iter() {
        let error = fit.alm[(l, m)] - coefficient(l, m);
        errors.push(error.norm() / norm(), || format!("l = {l}, m = {m}"));
    }
}

/// Returns one set of a pattern.
pub(super) fn points(pattern: &Pattern, n: usize) -> Vec<DVec3> {
    let sampler = pattern.build(n, DOMAIN).expect("the number of points is valid");
    let mut rng = Streams::new(SEED, Purpose::Pattern, n).realization(0);
    sampler.sample(&mut rng).expect("a feasible pattern").points
}

pub(super) fn fit(
    points: &[DVec3],
    values: &[f64],
    lmax: usize,
    ridge: f64,
) -> Result<Fit, FitError> {
    let problem = LeastSquares::new(points, values, DOMAIN)?.with_ridge(ridge)?;
    problem.solve(lmax, &mut || ControlFlow::Continue(()))
}
