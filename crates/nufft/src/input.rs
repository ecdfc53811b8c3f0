use num_complex::Complex;

use crate::error::Error;
use crate::magnitude::sum_of_sizes;
use crate::real::Real;

/// Checks that points and weights are valid and that the coefficients do not overflow.
pub(crate) fn check<R: Real>(points: &[[R; 2]], weights: Option<&[R]>) -> Result<(), Error> {
    check_count(points.len())?;
    let place = |point: &[R; 2]| point.map(R::to_f64);
    if let Some(index) = points.iter().position(|point| !place(point).into_iter().all(inside)) {
        let [u, v] = place(&points[index]);
        return Err(Error::Point { index, u, v });
    }
    weights.map_or(Ok(()), |weights| check_weights(weights, points.len()))
}

/// Checks points and complex weights in the same way.
pub(crate) fn check_complex<R: Real>(
    points: &[[R; 2]],
    weights: &[Complex<R>],
) -> Result<(), Error> {
    check(points, None)?;
    if weights.len() != points.len() {
        return Err(Error::WeightCount { weights: weights.len(), points: points.len() });
    }
    check_sum::<R>(sum_of_complex(weights)).map_err(|overflow| {
        first_invalid(weights).map_or(overflow, |(index, weight)| Error::Weight { index, weight })
    })
}

/// Checks that coefficients are finite, and that `factor` times the sum of their absolute values
/// is.
pub(crate) fn check_coefficients<R: Real>(values: &[Complex<R>], factor: f64) -> Result<(), Error> {
    check_sum::<R>(sum_of_complex(values) * factor).map_err(|overflow| {
        first_invalid(values).map_or(overflow, |(index, value)| Error::Coefficient { index, value })
    })
}

/// Checks the number of values that a caller provides memory for.
pub(crate) fn check_values(expected: usize, got: usize) -> Result<(), Error> {
    if expected == got { Ok(()) } else { Err(Error::ValueCount { expected, got }) }
}

/// Returns the index of the first number that is not finite, and its part that is not.
fn first_invalid<R: Real>(numbers: &[Complex<R>]) -> Option<(usize, f64)> {
    numbers.iter().enumerate().find_map(|(index, c)| {
        let part = [c.re, c.im].map(R::to_f64).into_iter().find(|x| !x.is_finite())?;
        Some((index, part))
    })
}

/// Checks coordinates on the circle and weights in the same way.
pub(crate) fn check_circle<R: Real>(points: &[R], weights: Option<&[R]>) -> Result<(), Error> {
    check_count(points.len())?;
    if let Some(index) = points.iter().position(|u| !inside(u.to_f64())) {
        return Err(Error::Coordinate { index, u: points[index].to_f64() });
    }
    weights.map_or(Ok(()), |weights| check_weights(weights, points.len()))
}

fn check_count(points: usize) -> Result<(), Error> {
    if u32::try_from(points).is_ok() {
        Ok(())
    } else {
        Err(Error::TooManyPoints { points, max: u32::MAX })
    }
}

fn inside(x: f64) -> bool {
    (0.0..1.0).contains(&x)
}

fn check_weights<R: Real>(weights: &[R], points: usize) -> Result<(), Error> {
    if weights.len() != points {
        return Err(Error::WeightCount { weights: weights.len(), points });
    }
    // No coefficient exceeds this sum.
    check_sum::<R>(sum_of_sizes(weights)).map_err(|overflow| {
        let first = weights.iter().position(|w| !w.to_f64().is_finite());
        let error = |index: usize| Error::Weight { index, weight: weights[index].to_f64() };
        first.map_or(overflow, error)
    })
}

/// Returns the sum of the absolute values of real and imaginary parts.
fn sum_of_complex<R: Real>(numbers: &[Complex<R>]) -> f64 {
    let mut sums = [[0.0; 2]; 8];
    let (chunks, rest) = numbers.as_chunks::<8>();
    for chunk in chunks {
        for ([re, im], c) in sums.iter_mut().zip(chunk) {
            *re += c.re.to_f64().abs();
            *im += c.im.to_f64().abs();
        }
    }
    let rest = rest.iter().map(|c| c.re.to_f64().abs() + c.im.to_f64().abs());
    sums.iter().flatten().sum::<f64>() + rest.sum::<f64>()
}

/// A sum of sizes is finite only if every number is.
fn check_sum<R: Real>(sum: f64) -> Result<(), Error> {
    if R::of(sum).to_f64().is_finite() { Ok(()) } else { Err(Error::Overflow) }
}
