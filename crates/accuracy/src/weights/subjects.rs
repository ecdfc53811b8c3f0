use std::ops::ControlFlow;

use glam::DVec3;
use sphvar_samplers::{Pattern, Purpose, Streams};
use sphvar_sht::{QuadratureProblem, QuadratureWeights, WeightSigns};

use super::DOMAIN;
use crate::transforms::Definition;
use crate::{Errors, Subject};

/// The seed of every set.
const SEED: u64 = 7;

/// Weights for the points of a pattern, exact to a degree.
#[derive(Debug)]
pub(super) struct Rule {
    name: String,
    points: Vec<DVec3>,
    degree: usize,
    signs: WeightSigns,
    weights: Option<QuadratureWeights>,
}

impl Rule {
    pub(super) fn new(pattern: &Pattern, n: usize, degree: usize, signs: WeightSigns) -> Self {
        let name = format!("{n} {}, degree {degree}", pattern.name());
        Self { name, points: points(pattern, n), degree, signs, weights: None }
    }

    pub(super) fn name(&self) -> String {
        self.name.clone()
    }

    pub(super) fn points(&self) -> &[DVec3] {
        &self.points
    }
}

impl Subject for Rule {
    fn run(&mut self) {
        self.weights = solve(&self.points, self.degree, self.signs);
    }

    fn errors(&mut self) -> Errors {
        let mut errors = Errors::default();
        match &self.weights {
            Some(rule) => push_sums(&mut errors, &self.points, &rule.weights, self.degree),
            None => errors.push(f64::NAN, || "no weights".to_owned()),
        }
        let weights = self.weights.iter().flat_map(|rule| &rule.weights);
        if self.signs == WeightSigns::Nonnegative && weights.into_iter().any(|w| *w < 0.0) {
            errors.push(f64::INFINITY, || "a negative weight".to_owned());
        }
        errors
    }
}

/// Returns one set of a pattern.
pub(super) fn points(pattern: &Pattern, n: usize) -> Vec<DVec3> {
    let sampler = pattern.build(n, DOMAIN).expect("the number of points is valid");
    let mut rng = Streams::new(SEED, Purpose::Pattern, n).realization(0);
    sampler.sample(&mut rng).expect("a feasible pattern").points
}

pub(super) fn solve(
    points: &[DVec3],
    degree: usize,
    signs: WeightSigns,
) -> Option<QuadratureWeights> {
    let problem = QuadratureProblem::new(points, DOMAIN, signs).ok()?;
    problem.solve(degree, &mut || ControlFlow::Continue(())).ok()
}

/// Adds the sums of weights times harmonics up to a degree, relative to that of degree 0, and the
/// error of the sum of the weights.
pub(super) fn push_sums(errors: &mut Errors, points: &[DVec3], weights: &[f64], degree: usize) {
    let definition = Definition::new(points, Some(weights));
    let exact = DOMAIN.area() / (4.0 * std::f64::consts::PI).sqrt();
    for m in 0..=degree {
        for (l, sum) in (m..).zip(definition.column(m, degree)) {
            let re = sum.re.value() - if l == 0 { exact } else { 0.0 };
            errors.push(re.hypot(sum.im.value()) / exact, || format!("l = {l}, m = {m}"));
        }
    }
}
