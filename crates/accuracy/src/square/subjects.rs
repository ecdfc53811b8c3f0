use std::sync::Arc;

use num_complex::Complex;
use sphvar_nufft::{
    CircleTransform, CircleWorkspace, TorusCoefficients, TorusTransform, TorusWorkspace,
};

use super::input::Input;
use crate::{Errors, Subject};

const VALID: &str = "an accuracy and frequency in range, and points in [0, 1)";

/// A transform from points to coefficients. The first run creates plan and memory, so that listing
/// trials costs nothing.
#[derive(Debug)]
pub(super) struct ToCoefficients {
    input: Arc<Input>,
    epsilon: f64,
    state: Option<(TorusTransform, TorusWorkspace, TorusCoefficients)>,
}

impl ToCoefficients {
    pub(super) fn new(input: Arc<Input>, epsilon: f64) -> Self {
        Self { input, epsilon, state: None }
    }
}

impl Subject for ToCoefficients {
    fn run(&mut self) {
        let kmax = self.input.size().kmax;
        let (plan, workspace, out) = self.state.get_or_insert_with(|| {
            let plan = TorusTransform::new(kmax, self.epsilon).expect(VALID);
            (plan, TorusWorkspace::default(), TorusCoefficients::zeros(kmax).expect(VALID))
        });
        plan.adjoint_into(self.input.points(), None, workspace, out).expect(VALID);
    }

    fn errors(&mut self) -> Errors {
        let out = self.state.as_ref().map(|(_, _, out)| out);
        out.map_or_else(Errors::default, |out| self.input.errors_of_coefficients(out))
    }
}

/// A transform from coefficients to values at points.
#[derive(Debug)]
pub(super) struct ToValues {
    input: Arc<Input>,
    epsilon: f64,
    state: Option<(TorusTransform, TorusWorkspace, Vec<f64>)>,
}

impl ToValues {
    pub(super) fn new(input: Arc<Input>, epsilon: f64) -> Self {
        Self { input, epsilon, state: None }
    }
}

impl Subject for ToValues {
    fn run(&mut self) {
        let (points, function) = (self.input.points(), self.input.function());
        let (plan, workspace, out) = self.state.get_or_insert_with(|| {
            let plan = TorusTransform::new(function.kmax(), self.epsilon).expect(VALID);
            (plan, TorusWorkspace::default(), vec![f64::NAN; points.len()])
        });
        plan.evaluate_into(function, points, workspace, out).expect(VALID);
    }

    fn errors(&mut self) -> Errors {
        let out = self.state.as_ref().map(|(_, _, out)| out);
        out.map_or_else(Errors::default, |out| self.input.errors_of_values(out))
    }
}

/// A transform from the first coordinate of points to coefficients.
#[derive(Debug)]
pub(super) struct OfCoordinate {
    input: Arc<Input>,
    epsilon: f64,
    state: Option<(CircleTransform, CircleWorkspace, Vec<Complex<f64>>)>,
}

impl OfCoordinate {
    pub(super) fn new(input: Arc<Input>, epsilon: f64) -> Self {
        Self { input, epsilon, state: None }
    }
}

impl Subject for OfCoordinate {
    fn run(&mut self) {
        let kmax = self.input.size().axis_max;
        let (plan, workspace, out) = self.state.get_or_insert_with(|| {
            let plan = CircleTransform::new(kmax, self.epsilon).expect(VALID);
            (plan, CircleWorkspace::default(), vec![Complex::ZERO; kmax + 1])
        });
        plan.adjoint_into(self.input.coordinates(), None, workspace, out).expect(VALID);
    }

    fn errors(&mut self) -> Errors {
        let out = self.state.as_ref().map(|(_, _, out)| out);
        out.map_or_else(Errors::default, |out| self.input.errors_on_axis(out))
    }
}
