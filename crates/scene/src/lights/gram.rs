use super::dot;

/// Inner products of the three channels of a function: row a, column b is `<f_a, f_b>`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Gram([[f64; 3]; 3]);

impl Gram {
    /// Adds `factor` times the product of two colours.
    #[inline]
    pub(super) fn add(&mut self, factor: f64, a: [f64; 3], b: [f64; 3]) {
        for (row, a) in self.0.iter_mut().zip(a) {
            for (sum, b) in row.iter_mut().zip(b) {
                *sum += factor * a * b;
            }
        }
    }

    /// Returns the sum with `factor` times another.
    pub(super) fn plus(self, factor: f64, other: Self) -> Self {
        Self([0, 1, 2].map(|a| [0, 1, 2].map(|b| self.0[a][b] + factor * other.0[a][b])))
    }

    /// Returns the square of the norm of the sum of the channels with these weights.
    pub(super) fn square(&self, weights: [f64; 3]) -> f64 {
        dot(weights, self.0.map(|row| dot(row, weights)))
    }
}
