//! Legendre functions and longitudes of several points side by side, in double-double arithmetic.

use glam::DVec3;

use crate::double::Double;

/// Number of points side by side.
pub(crate) const LANES: usize = 8;

/// Scale of values below the range of `f64`, applied `blocks` times.
const BLOCK: f64 = f64::from_bits((1023 + 512) << 52);
const PER_BLOCK: f64 = f64::from_bits((1023 - 512) << 52);

/// A number for each of the points.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Lanes {
    hi: [f64; LANES],
    lo: [f64; LANES],
}

impl Lanes {
    #[inline(always)]
    pub(crate) fn lane(&self, i: usize) -> Double {
        Double { hi: self.hi[i], lo: self.lo[i] }
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, i: usize, x: Double) {
        (self.hi[i], self.lo[i]) = (x.hi, x.lo);
    }

    /// Adds a rounded number to each.
    #[inline(always)]
    pub(crate) fn add(&mut self, terms: &[f64; LANES]) {
        for ((hi, lo), term) in self.hi.iter_mut().zip(&mut self.lo).zip(terms) {
            let sum = Double::sum(*hi, *term);
            (*hi, *lo) = (sum.hi, *lo + sum.lo);
        }
    }

    pub(crate) fn total(&self) -> f64 {
        (0..LANES).fold(Double::default(), |sum, i| sum + self.lane(i)).hi
    }
}

/// The step of the recurrence from `l` to `l + 1` at one order, as in `sphvar_sh::Recurrence`.
#[derive(Clone, Copy)]
struct Step {
    growth: Double,
    damping: Double,
    forcing: Double,
}

/// The recurrence at one order and its initial constant.
pub(crate) struct Order {
    sectoral: Double,
    steps: Vec<Step>,
}

/// Returns the orders from 0 to `lmax`.
pub(crate) fn orders(lmax: usize) -> impl Iterator<Item = Order> {
    let number = |n: usize| Double::from(n as f64);
    // sectoral(m)^2 = 1/(4 pi) prod_{k=1}^m (2k + 1)/(2k)
    let mut squared = Double::ONE / Double::PI.scaled(4.0);
    (0..=lmax).map(move |m| {
        if m > 0 {
            squared = squared * number(2 * m + 1) / number(2 * m);
        }
        let sectoral = squared.sqrt().scaled(if m % 2 == 1 { -1.0 } else { 1.0 });
        let step = |l: usize| {
            let quotient = number((2 * l + 3) * (l + m + 1)) / number((2 * l + 1) * (l + 1 - m));
            let (growth, r) = (quotient.sqrt(), number(l - m) / number(l + m + 1));
            Step { growth, damping: growth * r, forcing: growth * (Double::ONE + r) }
        };
        Order { sectoral, steps: (m..=lmax).map(step).collect() }
    })
}

/// Points at one order, advanced order by order.
#[derive(Clone, Debug, Default)]
pub(crate) struct Group {
    sin: Lanes,
    versine: Lanes,
    /// -1 in the southern hemisphere.
    parity: [f64; LANES],
    /// `e^{-i phi}`.
    phase: [Lanes; 2],
    /// At the current order m: `sin^m theta BLOCK^blocks`, and `e^{-i m phi}`.
    sectoral: Lanes,
    blocks: [f64; LANES],
    pub(crate) power: [Lanes; 2],
}

impl Group {
    /// Returns a group of at most `LANES` directions at order 0. Vectors are normalized in
    /// double-double arithmetic.
    pub(crate) fn new(points: &[DVec3]) -> Self {
        let mut group = Self::default();
        for (i, p) in points.iter().enumerate() {
            // Squares of very small numbers underflow.
            let lift = if p.x.abs().max(p.y.abs()) < 1e-100 { 2f64.powi(800) } else { 1.0 };
            let (x, y) = (p.x * lift, p.y * lift);
            let rho = (Double::product(x, x) + Double::product(y, y)).sqrt();
            let z = Double::from(p.z.abs());
            let low = rho.scaled(1.0 / lift);
            let length = (low * low + z * z).sqrt();
            let (sin, cos) = (low / length, z / length);
            group.sin.set(i, sin);
            group.versine.set(i, sin * sin / (Double::ONE + cos));
            group.parity[i] = if p.z < 0.0 { -1.0 } else { 1.0 };
            if rho.hi > 0.0 {
                group.phase[0].set(i, Double::from(x) / rho);
                group.phase[1].set(i, Double::from(-y) / rho);
            }
            group.sectoral.set(i, Double::ONE);
            group.power[0].set(i, Double::ONE);
        }
        group
    }

    /// Calls `visit` with `lambda_lm` of each point for l = m, m + 1, ...
    #[inline(always)]
    pub(crate) fn for_each_degree(
        &self,
        order: &Order,
        mut visit: impl FnMut(usize, &[f64; LANES]),
    ) {
        let (mut values, mut differences) = (Lanes::default(), Lanes::default());
        let (mut blocks, mut signs) = (self.blocks, [1.0; LANES]);
        for i in 0..LANES {
            values.set(i, order.sectoral * self.sectoral.lane(i));
        }
        for (n, step) in order.steps.iter().enumerate() {
            let mut lambdas = [0.0; LANES];
            for i in 0..LANES {
                // Values two blocks down are negligible in any sum.
                let inside = if blocks[i] > 0.0 { PER_BLOCK } else { 1.0 };
                let scale = if blocks[i] > 1.0 { 0.0 } else { inside };
                lambdas[i] = values.hi[i] * (scale * signs[i]);
                signs[i] *= self.parity[i];
            }
            visit(n, &lambdas);
            for (i, blocks) in blocks.iter_mut().enumerate() {
                let forced = self.versine.lane(i) * values.lane(i);
                let difference = step.damping * differences.lane(i) - step.forcing * forced;
                let value = step.growth * values.lane(i) + difference;
                let out = *blocks > 0.0 && value.hi.abs() > 1.0;
                let (factor, fewer) = if out { (PER_BLOCK, 1.0) } else { (1.0, 0.0) };
                *blocks -= fewer;
                values.set(i, value.scaled(factor));
                differences.set(i, difference.scaled(factor));
            }
        }
    }

    /// Advances to the next order.
    pub(crate) fn advance(&mut self) {
        for i in 0..LANES {
            let sectoral = self.sectoral.lane(i) * self.sin.lane(i);
            let small = sectoral.hi < PER_BLOCK;
            let (factor, more) = if small { (BLOCK, 1.0) } else { (1.0, 0.0) };
            self.sectoral.set(i, sectoral.scaled(factor));
            self.blocks[i] += more;
            let [re, im] = [0, 1].map(|part: usize| self.power[part].lane(i));
            let [c, s] = [0, 1].map(|part: usize| self.phase[part].lane(i));
            self.power[0].set(i, re * c - im * s);
            self.power[1].set(i, re * s + im * c);
        }
    }
}
