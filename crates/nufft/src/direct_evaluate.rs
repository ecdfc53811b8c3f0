use std::f64::consts::TAU;

use num_complex::Complex;

use crate::coefficients::{ComplexTorusCoefficients, TorusCoefficients};
use crate::direct::wave;
use crate::error::Error;
use crate::input;
use crate::long_sum::add_with_rests;
use crate::magnitude::magnitude;

/// Returns the values of [`TorusTransform::evaluate`](crate::TorusTransform::evaluate) by the
/// definition, to rounding.
///
/// # Errors
///
/// [`Error::Coefficient`], [`Error::Overflow`] and [`Error::Point`] as for
/// [`TorusTransform::evaluate`](crate::TorusTransform::evaluate).
///
/// # Performance
///
/// The cost is O(N kmax^2).
///
/// # Examples
///
/// ```
/// use num_complex::Complex;
/// use sphvar_nufft::{TorusCoefficients, direct_evaluate};
///
/// // cos(2 pi v) has the coefficients 1/2 at (0, 1) and (0, -1).
/// let mut c = TorusCoefficients::zeros(1)?;
/// c.values_mut()[3] = Complex::new(0.5, 0.0);
/// assert_eq!(direct_evaluate(&c, &[[0.7, 0.0], [0.2, 0.5]])?, [1.0, -1.0]);
/// # Ok::<(), sphvar_nufft::Error>(())
/// ```
pub fn direct_evaluate(
    coefficients: &TorusCoefficients,
    points: &[[f64; 2]],
) -> Result<Vec<f64>, Error> {
    // Each value stands for c(k) and c(-k).
    input::check_coefficients(coefficients.values(), 2.0)?;
    Ok(direct_gradient_unchecked(coefficients, points)?.into_iter().map(|[f, _, _]| f).collect())
}

/// Returns the values and derivatives of
/// [`TorusTransform::gradient`](crate::TorusTransform::gradient) by the definition, to rounding.
///
/// # Errors
///
/// [`Error::Coefficient`], [`Error::Overflow`] and [`Error::Point`] as for
/// [`TorusTransform::gradient`](crate::TorusTransform::gradient).
///
/// # Performance
///
/// The cost is O(N kmax^2).
pub fn direct_gradient(
    coefficients: &TorusCoefficients,
    points: &[[f64; 2]],
) -> Result<Vec<[f64; 3]>, Error> {
    let factor = 2.0 * TAU * (coefficients.kmax() as f64 + 1.0);
    input::check_coefficients(coefficients.values(), factor)?;
    direct_gradient_unchecked(coefficients, points)
}

fn direct_gradient_unchecked(
    coefficients: &TorusCoefficients,
    points: &[[f64; 2]],
) -> Result<Vec<[f64; 3]>, Error> {
    input::check::<f64>(points, None)?;
    let size = magnitude(coefficients.values().iter().flat_map(|c| [c.re, c.im]));
    let kmax = coefficients.kmax();
    let at_point = |&[u, v]: &[f64; 2]| {
        let (mut sums, mut rests) = ([0.0; 3], [0.0; 3]);
        let by_v: Vec<Complex<f64>> = (0..=kmax).map(|k| wave(k as f64, v).conj()).collect();
        for (line, row) in coefficients.values().chunks_exact(kmax + 1).enumerate() {
            let k1 = line as f64 - kmax as f64;
            let by_u = wave(k1, u).conj();
            for (column, (c, by_v)) in row.iter().zip(&by_v).enumerate() {
                let multiplicity = if column == 0 { 1.0 } else { 2.0 };
                let value = c / size * by_u * by_v * multiplicity;
                let [slope_u, slope_v] = [k1, column as f64].map(|k| -TAU * k * value.im);
                add_with_rests(&mut sums, &mut rests, &[value.re, slope_u, slope_v]);
            }
        }
        [0, 1, 2].map(|i| (sums[i] + rests[i]) * size)
    };
    Ok(points.iter().map(at_point).collect())
}

/// Returns the values of
/// [`TorusTransform::evaluate_complex`](crate::TorusTransform::evaluate_complex) by the definition,
/// to rounding.
///
/// # Errors
///
/// As for [`direct_evaluate`].
///
/// # Performance
///
/// The cost is O(N kmax^2).
pub fn direct_evaluate_complex(
    coefficients: &ComplexTorusCoefficients,
    points: &[[f64; 2]],
) -> Result<Vec<Complex<f64>>, Error> {
    input::check_coefficients(coefficients.values(), 1.0)?;
    input::check::<f64>(points, None)?;
    let size = magnitude(coefficients.values().iter().flat_map(|c| [c.re, c.im]));
    let kmax = coefficients.kmax();
    let frequency = |line: usize| line as f64 - kmax as f64;
    let at_point = |&[u, v]: &[f64; 2]| {
        let (mut sums, mut rests) = ([0.0; 2], [0.0; 2]);
        let by_v: Vec<Complex<f64>> =
            (0..=2 * kmax).map(|k| wave(frequency(k), v).conj()).collect();
        for (line, row) in coefficients.values().chunks_exact(2 * kmax + 1).enumerate() {
            let by_u = wave(frequency(line), u).conj();
            for (c, by_v) in row.iter().zip(&by_v) {
                let value = c / size * by_u * by_v;
                add_with_rests(&mut sums, &mut rests, &[value.re, value.im]);
            }
        }
        Complex::new(sums[0] + rests[0], sums[1] + rests[1]) * size
    };
    Ok(points.iter().map(at_point).collect())
}
