use std::sync::Arc;

use sphvar_sh::Alm;

use super::input::Input;
use super::plan::{Accuracy, Plan};
use crate::{Errors, Subject};

/// A transform from points to coefficients. The first run creates plan and memory, so that listing
/// trials costs nothing.
#[derive(Debug)]
pub(super) struct ToCoefficients {
    input: Arc<Input>,
    accuracy: Accuracy,
    state: Option<(Plan, Alm)>,
}

impl ToCoefficients {
    pub(super) fn new(input: Arc<Input>, accuracy: Accuracy) -> Self {
        Self { input, accuracy, state: None }
    }
}

impl Subject for ToCoefficients {
    fn run(&mut self) {
        let input = &self.input;
        let (plan, alm) = self.state.get_or_insert_with(|| {
            let alm = Alm::zeros(input.lmax()).expect("a degree of some thousands");
            (self.accuracy.plan(input.lmax()), alm)
        });
        plan.adjoint(input.points(), input.weights(), alm);
    }

    fn errors(&mut self) -> Errors {
        self.state.as_ref().map_or_else(Errors::default, |(_, alm)| self.input.error_of(alm))
    }
}

/// A transform from coefficients to values at points.
#[derive(Debug)]
pub(super) struct ToValues {
    input: Arc<Input>,
    accuracy: Accuracy,
    state: Option<(Plan, Vec<f64>)>,
}

impl ToValues {
    pub(super) fn new(input: Arc<Input>, accuracy: Accuracy) -> Self {
        Self { input, accuracy, state: None }
    }
}

impl Subject for ToValues {
    fn run(&mut self) {
        let input = &self.input;
        let (plan, values) = self.state.get_or_insert_with(|| {
            (self.accuracy.plan(input.lmax()), vec![f64::NAN; input.points().len()])
        });
        plan.synthesis(input.coefficients(), input.points(), values);
    }

    fn errors(&mut self) -> Errors {
        let values = self.state.as_ref().map(|(_, values)| values);
        values.map_or_else(Errors::default, |values| self.input.errors_of_values(values))
    }
}
