//! Inputs of several tests, and the comparison of results.

use std::f64::consts::TAU;

use num_complex::Complex;
use sphvar_nufft::TorusCoefficients;

pub(crate) const EPSILONS: [f64; 12] =
    [1e-1, 1e-2, 1e-3, 3e-5, 1e-5, 5e-6, 1e-7, 1e-9, 1e-10, 1e-11, 5e-13, 1e-13];
pub(crate) const JUST_BELOW_1: f64 = 1.0 - f64::EPSILON / 2.0;

/// Returns a generator of numbers in [0, 1), by linear congruence.
pub(crate) fn uniform(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 * 2f64.powi(-53)
    }
}

/// Numbers relative to their size, in a unit that keeps sums of them in range.
pub(crate) struct Size {
    pub(crate) unit: f64,
    /// The sum of the absolute values, in this unit.
    pub(crate) sum: f64,
}

impl Size {
    pub(crate) fn of(numbers: impl IntoIterator<Item = Complex<f64>> + Clone) -> Self {
        let largest = |size: f64, c: Complex<f64>| size.max(c.re.abs()).max(c.im.abs());
        let unit = numbers.clone().into_iter().fold(f64::MIN_POSITIVE, largest);
        Self { unit, sum: numbers.into_iter().map(|c| (c / unit).norm()).sum() }
    }

    /// Returns the size of the coefficients of a real function, at k and -k.
    pub(crate) fn of_real(c: &TorusCoefficients) -> Self {
        let kmax = i32::try_from(c.kmax()).unwrap();
        let all = (-kmax..=kmax).flat_map(|k1| (-kmax..=kmax).map(move |k2| (k1, k2)));
        Self::of(all.map(|(k1, k2)| c.get(k1, k2).unwrap()))
    }

    /// Asserts that numbers differ by at most `epsilon` times the sum, in multiples of `factor`.
    pub(crate) fn assert_near(
        &self,
        name: &str,
        epsilon: f64,
        factor: f64,
        numbers: impl IntoIterator<Item = (Complex<f64>, Complex<f64>)>,
    ) {
        // Subnormal results are rounded to multiples of 5e-324.
        let rounding = 5e-324 / self.unit * factor.max(1.0);
        for (i, (fast, exact)) in numbers.into_iter().enumerate() {
            let error = (fast / self.unit - exact / self.unit).norm();
            assert!(
                error <= epsilon * factor * self.sum + rounding,
                "{name}, {epsilon:e}: number {i} is {fast}, {exact} expected: {:e}",
                error / self.sum / factor
            );
        }
    }
}

pub(crate) fn real(x: f64) -> Complex<f64> {
    Complex::new(x, 0.0)
}

/// Returns the factors of epsilon in the error of a value and of its derivatives.
pub(crate) fn gradient_factors(kmax: usize, epsilon: f64) -> [f64; 3] {
    let of_derivative = 4.0 * TAU * (kmax as f64 + 1.0).max(10.0) * (1e-12 / epsilon).max(1.0);
    [1.0, of_derivative, of_derivative]
}
