use std::f64::consts::PI;

use sphvar_sh::{Error, GaussLegendre};

/// Degree of the polynomials beyond the width, and the nodes of the quadrature beyond the width's
/// need: both leave less than the smallest accuracy asked for.
const EXTRA_DEGREE: usize = 5;

/// The widest window in grid cells.
pub(crate) const MAX_WIDTH: usize = 20;

/// The exponential-of-semicircle window, `psi(x) = exp(beta (sqrt(1 - (2x/w)^2) - 1))` for |x| <= w/2
/// grid cells, by which scattered points meet a regular grid (Barnett, Magland and af Klinteberg
/// 2019).
///
/// Values come from piecewise polynomials, one for each of the w grid cells; the polynomials of all
/// cells are evaluated together.
#[derive(Clone, Debug)]
pub(crate) struct Window {
    width: usize,
    beta: f64,
    /// Coefficient of degree d for cell i at `[d * MAX_WIDTH + i]`, highest degree first.
    coefficients: Box<[f64]>,
}

impl Window {
    /// The narrowest window that reaches `epsilon` on a grid finer than needed by `oversampling`.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a small positive number of cells"
    )]
    pub(crate) fn new(epsilon: f64, oversampling: f64) -> Result<Self, Error> {
        // Aliasing falls as exp(-pi w sqrt(1 - 1/sigma)); one cell more pays for the constants.
        let decay = PI * (1.0 - 1.0 / oversampling).sqrt();
        let width = ((1.0 / epsilon).ln() / decay).ceil() as usize + 1;
        let width = width.clamp(4, MAX_WIDTH);
        // The largest beta whose transform has decayed at the first alias, with a little room.
        let beta = 0.98 * PI * width as f64 * (1.0 - 0.5 / oversampling);
        let mut window = Self { width, beta, coefficients: Box::default() };
        window.coefficients = window.fit();
        Ok(window)
    }

    /// The width in grid cells.
    pub(crate) fn width(&self) -> usize {
        self.width
    }

    fn value(&self, x: f64) -> f64 {
        let s = 2.0 * x / self.width as f64;
        let root = 1.0 - s * s;
        if root < 0.0 { 0.0 } else { (self.beta * (root.sqrt() - 1.0)).exp() }
    }

    /// `int psi(x) cos(2 pi m x / n) dx` for a grid of `n` cells.
    pub(crate) fn transform(&self, m: usize, n: usize) -> Result<f64, Error> {
        // The substitution x = w/2 sin(t) takes the root away; the rule then converges faster than
        // exponentially.
        let half = 0.5 * self.width as f64;
        let frequency = 2.0 * PI * m as f64 / n as f64 * half;
        let rule = GaussLegendre::new(2 * self.width + 24)?;
        Ok(rule.integrate(-0.5 * PI, 0.5 * PI, |t: f64| {
            let (s, c) = t.sin_cos();
            (self.beta * (c - 1.0)).exp() * (frequency * s).cos() * half * c
        }))
    }

    /// Interpolates each cell's piece at Chebyshev points, as polynomials of t in [-1, 1].
    fn fit(&self) -> Box<[f64]> {
        let degree = self.width + EXTRA_DEGREE;
        let n = degree + 1;
        let node = |k: usize| (PI * (k as f64 + 0.5) / n as f64).cos();
        let mut all = vec![0.0; n * MAX_WIDTH];
        for cell in 0..self.width {
            let piece = |t: f64| self.value(cell_offset(self.width, cell) + 0.5 * t);
            // Chebyshev coefficients by the discrete cosine transform at the nodes.
            let chebyshev: Vec<f64> = (0..n)
                .map(|j| {
                    let sum: f64 = (0..n)
                        .map(|k| {
                            piece(node(k)) * (PI * j as f64 * (k as f64 + 0.5) / n as f64).cos()
                        })
                        .sum();
                    sum * if j == 0 { 1.0 } else { 2.0 } / n as f64
                })
                .collect();
            for (d, c) in monomials(&chebyshev).into_iter().enumerate() {
                all[(degree - d) * MAX_WIDTH + cell] = c;
            }
        }
        all.into()
    }

    /// Writes the window at the w grid points nearest to `x` (in cells) and returns the first of
    /// these points: `out[i] = psi(x - first - i)`.
    #[inline(always)]
    #[expect(clippy::cast_possible_truncation, reason = "a grid coordinate")]
    pub(crate) fn evaluate(&self, x: f64, out: &mut [f64; MAX_WIDTH]) -> isize {
        let first = (x - 0.5 * self.width as f64).ceil();
        // Grid point i lies at distance x - first - i, which runs over cell i as t goes from -1 to 1.
        let t = 2.0 * (x - first - 0.5 * self.width as f64) + 1.0;
        out.fill(0.0);
        for row in self.coefficients.chunks_exact(MAX_WIDTH) {
            for (o, c) in out.iter_mut().zip(row) {
                *o = *o * t + c;
            }
        }
        first as isize
    }
}

/// The middle of the distances that grid point `cell` of the window takes.
fn cell_offset(width: usize, cell: usize) -> f64 {
    0.5 * width as f64 - 0.5 - cell as f64
}

/// The coefficients of 1, t, t^2, ... of a Chebyshev series.
fn monomials(chebyshev: &[f64]) -> Vec<f64> {
    let n = chebyshev.len();
    let (mut before, mut current) = (vec![0.0; n], vec![0.0; n]);
    let mut sum = vec![0.0; n];
    current[0] = 1.0;
    for (j, c) in chebyshev.iter().enumerate() {
        for (s, t) in sum.iter_mut().zip(&current) {
            *s += c * t;
        }
        // T_{j+1} = 2 t T_j - T_{j-1}, and T_1 = t.
        let factor = if j == 0 { 1.0 } else { 2.0 };
        let mut next: Vec<f64> = before.iter().map(|b| if j == 0 { 0.0 } else { -b }).collect();
        for d in 1..n {
            next[d] += factor * current[d - 1];
        }
        before = std::mem::replace(&mut current, next);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::{MAX_WIDTH, Window};

    #[test]
    fn polynomials_are_the_window() {
        for (epsilon, oversampling) in [(1e-3, 1.25), (1e-5, 1.5), (1e-9, 2.0), (1e-13, 2.0)] {
            let window = Window::new(epsilon, oversampling).unwrap();
            let mut values = [0.0; MAX_WIDTH];
            for k in 0..1000 {
                let x = 7.0 + f64::from(k) / 999.0;
                let first = window.evaluate(x, &mut values);
                for (i, v) in values.iter().enumerate().take(window.width()) {
                    let expected = window.value(x - first as f64 - i as f64);
                    let off = (v - expected).abs();
                    assert!(off < 0.1 * epsilon + 1e-14, "x = {x}, cell {i}: {v} and {expected}");
                }
                assert!(values[window.width()..].iter().all(|v| v.abs() < 1e-300));
            }
        }
    }
}
