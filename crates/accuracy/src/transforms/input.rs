use std::f64::consts::PI;
use std::sync::OnceLock;

use crate::reference::DoubleDouble;
use glam::DVec3;
use num_complex::Complex as Rounded;
use sphvar_sh::Alm;

use super::definition::{Complex, Definition, value_at};
use super::points;
use crate::Errors;

/// A weighted set of points, the degree of its transform, and the reference for some of its
/// coefficients.
#[derive(Debug)]
pub(super) struct Input {
    name: &'static str,
    points: Vec<DVec3>,
    weights: Option<Vec<f64>>,
    lmax: usize,
    /// The number of parts into which the orders are divided; one order represents each.
    parts: usize,
    columns: OnceLock<Vec<Column>>,
    function: OnceLock<Alm>,
    values: OnceLock<Vec<f64>>,
}

/// The coefficients of one order, and the number of orders that it represents.
#[derive(Debug)]
struct Column {
    m: usize,
    stands_for: f64,
    values: Vec<Complex>,
}

impl Column {
    /// Returns the ratio of the sum over the represented orders to that over this order's
    /// coefficients; orders m and -m are one column.
    fn copies(&self) -> f64 {
        self.stands_for * if self.m == 0 { 1.0 } else { 2.0 }
    }
}

/// The number of points at which values are compared.
const COMPARED: usize = 40;
/// The maximum ratio of the norm of all coefficients to the norm estimated from the compared
/// orders. For the sets of the trials, including the mirrored ones, the two agree to 3 percent;
/// sets with most of their energy in few orders would differ more.
const NORM_FACTOR: f64 = 4.0;

impl Input {
    /// Returns independent uniform directions without weights.
    pub(super) fn white_noise(n: usize, lmax: usize, parts: usize) -> Self {
        Self::new("white noise", points::white_noise(n), None, lmax, parts)
    }

    /// Returns mirrored directions with weights between 1/2 and 3/2; without weights most
    /// coefficients would vanish.
    pub(super) fn mirrored(n: usize, lmax: usize, parts: usize) -> Self {
        let points = points::mirrored(n);
        let weights = points::white_noise(points.len()).iter().map(|p| 1.0 + 0.5 * p.z).collect();
        Self::new("weighted white noise, mirrored", points, Some(weights), lmax, parts)
    }

    /// Returns northern points, each followed by a point at its reflection in the equator and another
    /// longitude, with weights between 1/2 and 3/2.
    pub(super) fn pairs(n: usize, lmax: usize, parts: usize) -> Self {
        let pair = |p: &DVec3| [p.with_z(p.z.abs()), DVec3::new(p.y, p.x, -p.z.abs())];
        let points: Vec<DVec3> = points::white_noise(n).iter().flat_map(pair).collect();
        let weights = points::white_noise(points.len()).iter().map(|p| 1.0 + 0.5 * p.z).collect();
        Self::new("pairs of reflected rings", points, Some(weights), lmax, parts)
    }

    /// Returns any set; with `parts` of at least `lmax + 1` all coefficients are compared.
    pub(super) fn new(
        name: &'static str,
        points: Vec<DVec3>,
        weights: Option<Vec<f64>>,
        lmax: usize,
        parts: usize,
    ) -> Self {
        let (columns, function, values) = Default::default();
        Self { name, points, weights, lmax, parts, columns, function, values }
    }

    pub(super) fn name(&self) -> &'static str {
        self.name
    }

    pub(super) fn points(&self) -> &[DVec3] {
        &self.points
    }

    pub(super) fn weights(&self) -> Option<&[f64]> {
        self.weights.as_deref()
    }

    pub(super) fn lmax(&self) -> usize {
        self.lmax
    }

    /// Returns the numbers of points and degrees in words.
    pub(super) fn size(&self) -> String {
        format!("N = {}, lmax = {}", self.points.len(), self.lmax)
    }

    /// Returns the error `||a - b||/||a||` of all coefficients, estimated from some orders, each of
    /// which represents a part. NaN if `||a||` is far above the estimate from these orders, so that
    /// an error in another order cannot make the result small.
    pub(super) fn error_of(&self, got: &Alm) -> Errors {
        let (mut squares, mut energy, mut worst) = (0.0, 0.0, (0.0, 0, 0));
        for column in self.columns.get_or_init(|| self.columns()) {
            for ((l, exact), got) in (column.m..).zip(&column.values).zip(got.column(column.m)) {
                let rest = |exact, got: f64| (DoubleDouble::from(got) - exact).value();
                let square = rest(exact.re, got.re).powi(2) + rest(exact.im, got.im).powi(2);
                squares += column.copies() * square;
                energy += column.copies() * (exact.re * exact.re + exact.im * exact.im).value();
                if square > worst.0 || square.is_nan() {
                    worst = (square, l, column.m);
                }
            }
        }
        // The norm is needed to a few digits only.
        let norm = got.energy_per_degree().iter().sum::<f64>().sqrt();
        let mut errors = Errors::default();
        let (_, l, m) = worst;
        if norm <= NORM_FACTOR * energy.sqrt() {
            errors.push(squares.sqrt() / norm, || format!("most of it at l = {l}, m = {m}"));
        } else {
            errors.push(f64::NAN, || format!("a norm of {norm:.1e}, not {:.1e}", energy.sqrt()));
        }
        errors
    }

    /// Returns one order of each part; the first and the last order are parts by themselves.
    fn columns(&self) -> Vec<Column> {
        let definition = Definition::new(&self.points, self.weights());
        let column = |first: usize, last: usize| {
            // The middle order has the mean number of coefficients.
            let m = first + (last - first) / 2;
            let stands_for = (last + 1 - first) as f64;
            Column { m, stands_for, values: definition.column(m, self.lmax) }
        };
        let between = self.lmax.saturating_sub(1);
        let parts = self.parts.min(between);
        let start = |i: usize| 1 + i * between / parts;
        let mut columns = vec![column(0, 0)];
        columns.extend((0..parts).map(|i| column(start(i), start(i + 1) - 1)));
        if self.lmax > 0 {
            columns.push(column(self.lmax, self.lmax));
        }
        columns
    }

    /// Returns random coefficients of a function whose root mean square over the sphere is 1.
    pub(super) fn coefficients(&self) -> &Alm {
        self.function.get_or_init(|| {
            let mut alm = Alm::zeros(self.lmax).expect("a degree of some thousands");
            let numbers = points::white_noise(alm.values().len());
            for (a, p) in alm.values_mut().iter_mut().zip(numbers) {
                *a = Rounded::new(p.x, p.y);
            }
            for a in alm.column_mut(0) {
                a.im = 0.0;
            }
            let mean_square = alm.energy_per_degree().iter().sum::<f64>() / (4.0 * PI);
            for a in alm.values_mut() {
                *a /= mean_square.sqrt();
            }
            alm
        })
    }

    /// Returns the errors of the function's values at the first points.
    pub(super) fn errors_of_values(&self, got: &[f64]) -> Errors {
        let mut errors = Errors::default();
        let exact = self.values.get_or_init(|| {
            let compared = self.points.iter().take(COMPARED);
            compared.map(|p| value_at(*p, self.coefficients()).value()).collect()
        });
        errors.push_length(got.len(), self.points.len());
        for ((exact, got), p) in exact.iter().zip(got).zip(&self.points) {
            errors.push(got - exact, || format!("the point ({:.6}, {:.6}, {:.6})", p.x, p.y, p.z));
        }
        errors
    }
}

#[cfg(test)]
mod tests {
    use super::Input;
    use crate::transforms::plan::Accuracy;

    #[test]
    fn the_norm_does_not_hide_errors_of_other_orders() {
        const LMAX: usize = 20;
        for input in [Input::white_noise(300, LMAX, 3), Input::mirrored(320, LMAX, 3)] {
            let mut alm = sphvar_sh::Alm::zeros(LMAX).unwrap();
            Accuracy::Exact.plan(LMAX).adjoint(input.points(), input.weights(), &mut alm);
            let right = input.error_of(&alm);
            assert!(right.max() < 1e-14, "{right:?}");
            let compared = input.columns.get().unwrap();
            let orders: f64 = compared.iter().map(|c| c.stands_for).sum();
            assert!(
                (orders - (LMAX as f64 + 1.0)).abs() < 1e-12,
                "{orders} orders are represented"
            );
            assert!(compared.last().is_some_and(|c| c.m == LMAX));
            let other = (0..=LMAX).find(|m| compared.iter().all(|c| c.m != *m)).unwrap();
            alm[(LMAX, other)].re += 1e6;
            let wrong = input.error_of(&alm);
            assert!(wrong.max().is_infinite(), "{wrong:?}");
        }
    }
}
