//! Functions of one coordinate as polynomials on nested intervals.

use num_complex::Complex;
use sphvar_nufft::{CircleTransform, CircleWorkspace};

use super::rules::{LINE_NODES, MAX_WAVELENGTHS, Rules};
use crate::Error;
use crate::square::energy::zeros;

/// The accuracy of Fourier coefficients along an axis, relative to the mean of absolute values.
const EPSILON: f64 = 1e-10;

/// Intervals of [0, 1], each halved or not.
#[derive(Clone, Debug, Default)]
pub(super) struct Intervals {
    list: Vec<Interval>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Interval {
    pub(super) ends: [f64; 2],
    /// The first of both halves.
    halves: Option<usize>,
}

impl Intervals {
    /// Adds an interval that is no half of another, and returns its number.
    pub(super) fn push(&mut self, ends: [f64; 2]) -> usize {
        self.list.push(Interval { ends, halves: None });
        self.list.len() - 1
    }

    pub(super) fn ends(&self, index: usize) -> [f64; 2] {
        self.list[index].ends
    }

    /// Returns the numbers of both halves.
    pub(super) fn halves(&mut self, index: usize) -> [usize; 2] {
        let Interval { ends: [low, high], halves } = self.list[index];
        let first = halves.unwrap_or_else(|| {
            let middle = f64::midpoint(low, high);
            let first = self.push([low, middle]);
            self.push([middle, high]);
            self.list[index].halves = Some(first);
            first
        });
        [first, first + 1]
    }

    pub(super) fn len(&self) -> usize {
        self.list.len()
    }

    /// Returns the sum of polynomials on all intervals, of which those of halves add to that of the
    /// whole.
    pub(super) fn sum(&self, rules: &Rules, mut values: Vec<[f64; LINE_NODES]>) -> LineFunction {
        let mut panels = Vec::new();
        // Halves follow the interval that they divide.
        for (i, interval) in self.list.iter().enumerate() {
            let Some(first) = interval.halves else {
                panels.push((interval.ends, values[i]));
                continue;
            };
            for half in 0..2 {
                let part = rules.of_half(half, &values[i]);
                values[first + half].iter_mut().zip(part).for_each(|(sum, x)| *sum += x);
            }
        }
        LineFunction { panels }
    }
}

/// A function of one coordinate that is a polynomial on each panel.
#[derive(Clone, Debug)]
pub(super) struct LineFunction {
    panels: Vec<([f64; 2], [f64; LINE_NODES])>,
}

impl LineFunction {
    /// Returns the variance.
    pub(super) fn variance(&self, rules: &Rules) -> f64 {
        let weights = &rules.line().weights;
        let integral = |of: &dyn Fn(f64) -> f64| -> f64 {
            let panel = |([low, high], values): &([f64; 2], [f64; LINE_NODES])| {
                let terms = values.iter().zip(weights).map(|(x, w)| w * of(*x));
                (high - low) * terms.sum::<f64>()
            };
            self.panels.iter().map(panel).sum()
        };
        let mean = integral(&|x| x);
        integral(&|x| (x - mean) * (x - mean))
    }
}

/// The Fourier transform of functions of one coordinate, which the plan makes expensive to prepare.
pub(super) struct LineTransform {
    rules: Rules,
    plan: CircleTransform,
    workspace: CircleWorkspace,
}

impl LineTransform {
    /// Prepares the transform to the frequencies k = 0 ..= `kmax`.
    pub(super) fn new(kmax: usize) -> Result<Self, Error> {
        let plan = CircleTransform::new(kmax, EPSILON).map_err(transform_error)?;
        Ok(Self { rules: Rules::new()?, plan, workspace: CircleWorkspace::default() })
    }

    /// Returns `|G_k|^2` of all frequencies.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "at most the frequency"
    )]
    pub(super) fn squares(&mut self, line: &LineFunction) -> Result<Vec<f64>, Error> {
        let kmax = self.plan.kmax();
        let rule = self.rules.line();
        let (mut points, mut weights) = (Vec::new(), Vec::new());
        let mut add = |[low, high]: [f64; 2], values: &[f64; LINE_NODES]| {
            let width = high - low;
            for ((x, w), value) in rule.nodes.iter().zip(&rule.weights).zip(values) {
                points.push((low + width * x).min(1.0f64.next_down()));
                weights.push(width * w * value);
            }
        };
        for (ends, values) in &line.panels {
            let wavelengths = (ends[1] - ends[0]) * kmax as f64;
            let depth = (wavelengths / MAX_WAVELENGTHS).log2().ceil().max(0.0) as u32;
            add_parts(&self.rules, *ends, values, depth, &mut add);
        }
        let mut out: Vec<Complex<f64>> = zeros(kmax + 1)?;
        self.plan
            .adjoint_into(&points, Some(&weights), &mut self.workspace, &mut out)
            .map_err(transform_error)?;
        Ok(out.iter().map(|c| c.norm_sqr()).collect())
    }
}

/// Divides a panel into `2^depth` parts.
fn add_parts(
    rules: &Rules,
    [low, high]: [f64; 2],
    values: &[f64; LINE_NODES],
    depth: u32,
    add: &mut dyn FnMut([f64; 2], &[f64; LINE_NODES]),
) {
    if depth == 0 {
        return add([low, high], values);
    }
    let middle = f64::midpoint(low, high);
    for (half, ends) in [[low, middle], [middle, high]].into_iter().enumerate() {
        add_parts(rules, ends, &rules.of_half(half, values), depth - 1, add);
    }
}

/// Reports a transform that rejects values, which are finite and whose number is limited.
pub(super) fn transform_error(error: sphvar_nufft::Error) -> Error {
    Error::Evaluation { reason: error.to_string() }
}
