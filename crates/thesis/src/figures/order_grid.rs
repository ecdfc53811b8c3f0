use sphvar_spectrum::OrderPower;

use crate::{Axis, Field, Palette};

/// Mean powers of orders, drawn as in the thesis.
pub(crate) struct OrderGrid<'a> {
    /// By degree and then by order from 0.
    orders: &'a [OrderPower],
    lmax: usize,
}

impl<'a> OrderGrid<'a> {
    /// Returns the grid of the powers of every order of every degree to the last.
    pub(crate) fn new(orders: &'a [OrderPower]) -> Self {
        Self { orders, lmax: orders.last().map_or(0, |last| last.l) }
    }

    /// Returns the last degree.
    pub(crate) fn lmax(&self) -> usize {
        self.lmax
    }

    /// Returns the orders from 0 of a degree.
    pub(crate) fn degree(&self, l: usize) -> &'a [OrderPower] {
        let first = l * (l + 1) / 2;
        &self.orders[first..=first + l]
    }

    /// Returns the mean over m from -l to l of a quantity that does not depend on the sign of m.
    pub(crate) fn mean_over_orders(&self, l: usize, f: impl Fn(&OrderPower) -> f64) -> f64 {
        let sum: f64 =
            self.degree(l).iter().map(|o| if o.m == 0 { f(o) } else { 2.0 * f(o) }).sum();
        sum / (2 * l + 1) as f64
    }

    /// Returns the power of a degree.
    pub(crate) fn power(&self, l: usize) -> f64 {
        self.mean_over_orders(l, |o| o.power)
    }

    /// Returns a triangle: degrees down, orders across; degree 0 and cells without an order are
    /// omitted.
    pub(crate) fn triangle(&self, style: &Style, value: impl Fn(f64) -> f64) -> Field {
        let side = 2 * self.lmax + 1;
        let mut values = Vec::with_capacity(side * (self.lmax + 1));
        for l in 0..=self.lmax {
            for m in (0..side).map(|column| column.abs_diff(self.lmax)) {
                values.push(self.value(l, m, &value));
            }
        }
        let edge = self.lmax as f64 + 0.5;
        Field {
            size: [side, self.lmax + 1],
            values,
            label: style.label.to_owned(),
            palette: style.palette,
            x: Axis::linear("order m").over(-edge, edge),
            y: Axis::linear("degree l").over(-0.5, edge),
            rings: Vec::new(),
        }
    }

    /// Returns a square: the triangle downwards, upwards, to the left and to the right. `step` is
    /// 1, or 2 if only even degrees exist, which are then drawn twice as thick.
    pub(crate) fn square(&self, style: &Style, step: usize, value: impl Fn(f64) -> f64) -> Field {
        let half = self.lmax - self.lmax % step;
        let side = 2 * half + 1;
        let mut values = Vec::with_capacity(side * side);
        for y in (0..side).map(|row| row.abs_diff(half)) {
            for x in (0..side).map(|column| column.abs_diff(half)) {
                values.push(self.value(x.max(y).next_multiple_of(step), x.min(y), &value));
            }
        }
        let edge = half as f64 + 0.5;
        Field {
            size: [side; 2],
            values,
            label: style.label.to_owned(),
            palette: style.palette,
            x: Axis::linear("m, or l at the sides").over(-edge, edge),
            y: Axis::linear("l, or m at the sides").over(-edge, edge),
            rings: Vec::new(),
        }
    }

    /// Degree 0 would dominate the colour scale.
    fn value(&self, l: usize, m: usize, value: &impl Fn(f64) -> f64) -> f64 {
        match self.degree(l).get(m) {
            Some(order) if l > 0 => value(order.power),
            _ => f64::NAN,
        }
    }
}

/// The mapping from powers to colours.
pub(crate) struct Style {
    /// The displayed quantity.
    pub(crate) label: &'static str,
    /// The colours.
    pub(crate) palette: Palette,
}
