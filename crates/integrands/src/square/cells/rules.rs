use sphvar_sh::{GaussLegendre, legendre_p_into};

use crate::Error;

/// The number of nodes of the polynomials to which cells are added along an axis.
pub(super) const LINE_NODES: usize = 8;
/// The lowest and the highest order of the rules.
pub(super) const ORDERS: [usize; 2] = [2, LINE_NODES];
/// The width of a panel, in wavelengths, that the rule of the highest order resolves to 1e-3.
pub(super) const MAX_WAVELENGTHS: f64 = 2.5;

/// A Gauss-Legendre rule on [0, 1].
pub(super) struct Rule {
    pub(super) nodes: Vec<f64>,
    pub(super) weights: Vec<f64>,
    /// The linear form of the values at the nodes that is the root mean square of their component
    /// of the highest degree.
    pub(super) top: Vec<f64>,
    /// For each of the [`LINE_NODES`], the linear form that interpolates there.
    to_line: Vec<f64>,
}

/// The rules of all orders.
pub(super) struct Rules {
    of_order: Vec<Rule>,
    /// From the values at [`LINE_NODES`] to those at the same nodes of the lower and upper half.
    halves: [Vec<f64>; 2],
}

impl Rules {
    pub(super) fn new() -> Result<Self, Error> {
        let line = GaussLegendre::new(LINE_NODES)?;
        let orders = ORDERS[0]..=ORDERS[1];
        let of_order = orders.map(|n| Rule::new(n, line.nodes())).collect::<Result<_, _>>()?;
        let half = |shift: f64| {
            let nodes: Vec<f64> = line.nodes().iter().map(|x| 0.5 * (x + shift)).collect();
            interpolation(&line, &nodes)
        };
        Ok(Self { of_order, halves: [half(-1.0)?, half(1.0)?] })
    }

    pub(super) fn of_order(&self, order: usize) -> &Rule {
        &self.of_order[order - ORDERS[0]]
    }

    /// Returns the nodes and weights of polynomials along an axis.
    pub(super) fn line(&self) -> &Rule {
        self.of_order(LINE_NODES)
    }

    /// Returns the values at the nodes of the lower (0) or upper (1) half of an interval.
    pub(super) fn of_half(&self, half: usize, values: &[f64; LINE_NODES]) -> [f64; LINE_NODES] {
        apply(&self.halves[half], values)
    }

    /// Returns the order, at least `min`, that integrates waves of this number of wavelengths in a
    /// panel to about 1e-3.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a small positive number"
    )]
    pub(super) fn order(wavelengths: f64, min: usize) -> usize {
        // The error of n nodes for e^{iax} on [-1, 1], a = pi times the wavelengths, is
        // 2^(2n+1) n!^4 a^(2n)/((2n+1) (2n)!^3).
        ((1.55 + 2.5 * wavelengths).ceil() as usize).clamp(min, ORDERS[1])
    }
}

impl Rule {
    fn new(order: usize, line: &[f64]) -> Result<Self, Error> {
        let rule = GaussLegendre::new(order)?;
        let mut legendre = vec![0.0; order];
        let mut top = Vec::with_capacity(order);
        for (x, w) in rule.nodes().iter().zip(rule.weights()) {
            legendre_p_into(*x, &mut legendre)?;
            // The coefficient is 2n - 1 times the mean, the polynomial has the mean square 1/(2n - 1).
            top.push(0.5 * w * legendre[order - 1] * ((2 * order - 1) as f64).sqrt());
        }
        Ok(Self {
            nodes: rule.nodes().iter().map(|x| 0.5 + 0.5 * x).collect(),
            weights: rule.weights().iter().map(|w| 0.5 * w).collect(),
            top,
            to_line: interpolation(&rule, line)?,
        })
    }

    /// Returns the polynomial with the given values at the nodes, by its values at
    /// [`LINE_NODES`].
    pub(super) fn to_line(&self, values: &[f64]) -> [f64; LINE_NODES] {
        apply(&self.to_line, values)
    }
}

/// Returns the rows of linear forms that interpolate from the nodes of a rule to others in [-1,
/// 1].
fn interpolation(rule: &GaussLegendre, to: &[f64]) -> Result<Vec<f64>, Error> {
    let order = rule.nodes().len();
    let (mut here, mut there) = (vec![0.0; order], vec![0.0; order]);
    let mut matrix = Vec::with_capacity(order * to.len());
    for y in to {
        legendre_p_into(*y, &mut there)?;
        for (x, w) in rule.nodes().iter().zip(rule.weights()) {
            legendre_p_into(*x, &mut here)?;
            let terms = here.iter().zip(&there).enumerate();
            let sum: f64 = terms.map(|(l, (a, b))| (2 * l + 1) as f64 * a * b).sum();
            matrix.push(0.5 * w * sum);
        }
    }
    Ok(matrix)
}

fn apply(matrix: &[f64], values: &[f64]) -> [f64; LINE_NODES] {
    let mut out = [0.0; LINE_NODES];
    for (out, row) in out.iter_mut().zip(matrix.chunks_exact(values.len())) {
        *out = row.iter().zip(values).map(|(a, b)| a * b).sum();
    }
    out
}
