use crate::reference::{DoubleDouble, power};
use crate::transforms::Complex;

/// Returns `e^{-2 pi i x}`.
pub(super) fn wave(x: f64) -> Complex {
    let (sin, cos) =
        (DoubleDouble::from(2.0) * DoubleDouble::pi() * DoubleDouble::from(x)).sin_cos();
    Complex { re: cos, im: -sin }
}

/// Returns the k-th power of a number of modulus 1.
pub(super) fn wave_power(wave: Complex, k: i32) -> Complex {
    let of_size = power(Complex::ONE, wave, u64::from(k.unsigned_abs()));
    if k < 0 { Complex { re: of_size.re, im: -of_size.im } } else { of_size }
}

/// Weighted points with the waves of their coordinates.
///
/// It evaluates `c(k1, k2) = sum_j w_j exp(-2 pi i (k1 u_j + k2 v_j))` term by term in twice the working
/// precision.
#[derive(Debug)]
pub(super) struct Definition {
    terms: Vec<([Complex; 2], DoubleDouble)>,
}

impl Definition {
    pub(super) fn new(points: &[[f64; 2]], weights: Option<&[f64]>) -> Self {
        let weight = |j: usize| DoubleDouble::from(weights.map_or(1.0, |w| w[j]));
        let terms = points.iter().enumerate().map(|(j, p)| (p.map(wave), weight(j)));
        Self { terms: terms.collect() }
    }

    /// Returns `c(k1, k2)`. Cost `O(N log |k|)`.
    pub(super) fn coefficient(&self, k1: i32, k2: i32) -> Complex {
        let mut sum = Complex::ZERO;
        for ([u, v], weight) in &self.terms {
            sum.add_product(wave_power(*u, k1) * wave_power(*v, k2), *weight);
        }
        sum
    }
}

/// Returns the value at a point of the real function with coefficients for k2 >= 0, in the order of
/// `TorusCoefficients::values`. Cost `O(kmax^2)`.
pub(super) fn value_at(
    point: [f64; 2],
    kmax: usize,
    coefficients: &[num_complex::Complex<f64>],
) -> DoubleDouble {
    let [u, v] = point.map(wave);
    let powers = |wave: Complex, n: usize| -> Vec<Complex> {
        std::iter::successors(Some(Complex::ONE), |last| Some(*last * wave)).take(n).collect()
    };
    let (by_u, by_v) = (powers(u, kmax + 1), powers(v, kmax + 1));
    let mut sum = DoubleDouble::ZERO;
    for (line, row) in coefficients.chunks_exact(kmax + 1).enumerate() {
        let size = by_u[line.abs_diff(kmax)];
        // The conjugate of e^{-2 pi i k1 u}, k1 = line - kmax.
        let outer = if line < kmax { size } else { Complex { re: size.re, im: -size.im } };
        let mut inner = Complex::ZERO;
        for (column, (c, wave)) in row.iter().zip(&by_v).enumerate() {
            let conjugate = Complex { re: wave.re, im: -wave.im };
            let c = Complex { re: DoubleDouble::from(c.re), im: DoubleDouble::from(c.im) };
            let multiplicity = DoubleDouble::from(if column == 0 { 1.0 } else { 2.0 });
            inner.add_product(c * conjugate, multiplicity);
        }
        sum += (inner * outer).re;
    }
    sum
}

#[cfg(test)]
mod tests {
    use num_complex::Complex as Rounded;
    use sphvar_nufft::{TorusCoefficients, direct_adjoint, direct_evaluate};

    use super::{Definition, value_at};

    /// Comparison with the direct sums of the `sphvar-nufft` crate, to their accuracy.
    #[test]
    fn it_agrees_with_direct_sums() {
        let points = [[0.1, 0.7], [0.35, 0.0], [1.0 - f64::EPSILON / 2.0, 0.25]];
        let weights = [1.0, -0.5, 2.0];
        let kmax = 5;
        let direct = direct_adjoint(kmax, &points, Some(&weights)).unwrap();
        let definition = Definition::new(&points, Some(&weights));
        let mut series = TorusCoefficients::zeros(kmax).unwrap();
        for k1 in -5..=5_i32 {
            for k2 in 0..=5_i32 {
                let c = definition.coefficient(k1, k2);
                let c = Rounded::new(c.re.value(), c.im.value());
                let index = usize::try_from((k1 + 5) * 6 + k2).unwrap();
                // A few roundings of three terms.
                assert!((c - direct.values()[index]).norm() < 1e-14, "({k1}, {k2}): {c}");
                series.values_mut()[index] = c;
            }
        }
        let values = direct_evaluate(&series, &points).unwrap();
        for (point, direct) in points.iter().zip(values) {
            let value = value_at(*point, kmax, series.values()).value();
            // A few roundings of 121 terms of size 3.
            assert!((value - direct).abs() < 1e-12, "{point:?}: {value}, {direct}");
        }
    }
}
