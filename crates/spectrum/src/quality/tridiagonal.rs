use sphvar_sht::extreme_eigenvalues;

/// A symmetric tridiagonal matrix that grows by the steps of the Lanczos method.
#[derive(Debug, Default)]
pub(super) struct Tridiagonal {
    diagonal: Vec<f64>,
    /// The coupling of each row with the next one, also of the last.
    coupling: Vec<f64>,
}

impl Tridiagonal {
    pub(super) fn push(&mut self, diagonal: f64, coupling: f64) {
        self.diagonal.push(diagonal);
        self.coupling.push(coupling);
    }

    /// Returns the largest magnitude on the diagonal.
    pub(super) fn diagonal_max(&self) -> f64 {
        self.diagonal.iter().fold(0.0, |max, d| d.abs().max(max))
    }

    /// Returns the smallest and the largest eigenvalue; 0 of an empty matrix.
    pub(super) fn extremes(&self) -> (f64, f64) {
        extreme_eigenvalues(&self.diagonal, &self.coupling).unwrap_or_default()
    }

    /// Returns a bound on the distance from an extreme eigenvalue to one of the matrix that the
    /// steps are those of: the last coupling times the last component of the eigenvector, which
    /// inverse iteration finds.
    pub(super) fn residual(&self, eigenvalue: f64) -> f64 {
        let n = self.diagonal.len();
        // Away from the spectrum by a little, so that the matrix is definite.
        let shift = eigenvalue + eigenvalue.abs() * self.sign_outside(eigenvalue) * 1e-8;
        // Fractions of multiples of the golden ratio: no eigenvector is orthogonal to them.
        let mut vector: Vec<f64> = (1..=n).map(|k| (k as f64 * 0.618_034).fract() - 0.3).collect();
        for _ in 0..3 {
            self.solve(shift, &mut vector);
            let norm = vector.iter().map(|x| x * x).sum::<f64>().sqrt();
            vector.iter_mut().for_each(|x| *x /= norm);
        }
        vector.last().map_or(f64::INFINITY, |x| (x * self.coupling[n - 1]).abs())
    }

    /// Returns the direction away from the spectrum at an extreme eigenvalue.
    fn sign_outside(&self, eigenvalue: f64) -> f64 {
        let mean = self.diagonal.iter().sum::<f64>() / self.diagonal.len() as f64;
        if eigenvalue < mean { -1.0 } else { 1.0 }
    }

    /// Replaces `x` by the solution for it as the right side, with the matrix less `shift`.
    fn solve(&self, shift: f64, x: &mut [f64]) {
        let n = x.len();
        let mut pivots = vec![0.0; n];
        for k in 0..n {
            pivots[k] = self.diagonal[k] - shift;
            if k > 0 {
                let factor = self.coupling[k - 1] / pivots[k - 1];
                pivots[k] -= factor * self.coupling[k - 1];
                x[k] -= factor * x[k - 1];
            }
        }
        for k in (0..n).rev() {
            let next = if k + 1 < n { self.coupling[k] * x[k + 1] } else { 0.0 };
            x[k] = (x[k] - next) / pivots[k];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Tridiagonal;

    /// The second differences of n values: eigenvalues `2 - 2 cos(k pi/(n + 1))`.
    #[test]
    fn second_differences() {
        for n in [1, 2, 7, 100] {
            let mut matrix = Tridiagonal::default();
            (0..n).for_each(|_| matrix.push(2.0, -1.0));
            let at =
                |k: usize| 2.0 - 2.0 * (k as f64 * std::f64::consts::PI / (n + 1) as f64).cos();
            let (smallest, largest) = matrix.extremes();
            assert!((smallest - at(1)).abs() < 1e-14 && (largest - at(n)).abs() < 1e-14);
            // Eigenvectors are sines.
            let sine = |k: usize| (k as f64 * std::f64::consts::PI / (n + 1) as f64).sin();
            let norm = (1..=n).map(|k| sine(k).powi(2)).sum::<f64>().sqrt();
            for end in [smallest, largest] {
                assert!((matrix.residual(end) - sine(n) / norm).abs() < 1e-6, "{n}, {end}");
            }
        }
    }
}
