use num_complex::Complex;

use crate::real::Real;

/// Returns the largest power of two that does not exceed the maximum absolute value; 1 if there is
/// none or it is not finite.
///
/// Division by it keeps numbers in range, even of f32, and is exact.
pub fn magnitude(numbers: impl IntoIterator<Item = f64>) -> f64 {
    let largest = numbers.into_iter().fold(0.0, |size: f64, x| size.max(x.abs()));
    let exponent = f64::from_bits(largest.to_bits() & f64::INFINITY.to_bits());
    if largest > 0.0 && exponent.is_finite() { exponent.max(f64::MIN_POSITIVE) } else { 1.0 }
}

/// Numbers that are compared or added side by side, which makes several passes over all numbers
/// inexpensive beside a transform.
const LANES: usize = 16;

/// Returns the [`magnitude`] of a list.
pub fn magnitude_of<R: Real>(numbers: &[R]) -> f64 {
    let mut largest = [0.0; LANES];
    let (chunks, rest) = numbers.as_chunks::<LANES>();
    for chunk in chunks {
        for (largest, x) in largest.iter_mut().zip(chunk) {
            let x = x.to_f64().abs();
            *largest = if x > *largest { x } else { *largest };
        }
    }
    magnitude(largest.into_iter().chain(rest.iter().map(|x| x.to_f64())))
}

/// Returns the magnitude of the real and imaginary parts of a list.
pub fn magnitude_of_complex<R: Real>(numbers: &[Complex<R>]) -> f64 {
    let mut largest = [[0.0; 2]; LANES / 2];
    let (chunks, rest) = numbers.as_chunks::<{ LANES / 2 }>();
    for chunk in chunks {
        for (largest, c) in largest.iter_mut().zip(chunk) {
            for (largest, x) in largest.iter_mut().zip([c.re, c.im]) {
                let x = x.to_f64().abs();
                *largest = if x > *largest { x } else { *largest };
            }
        }
    }
    let rest = rest.iter().flat_map(|c| [c.re.to_f64(), c.im.to_f64()]);
    magnitude(largest.into_iter().flatten().chain(rest))
}

/// Returns the sum of the absolute values of a list.
pub fn sum_of_sizes<R: Real>(numbers: &[R]) -> f64 {
    let mut sums = [0.0; LANES];
    let (chunks, rest) = numbers.as_chunks::<LANES>();
    for chunk in chunks {
        for (sum, x) in sums.iter_mut().zip(chunk) {
            *sum += x.to_f64().abs();
        }
    }
    sums.iter().sum::<f64>() + rest.iter().map(|x| x.to_f64().abs()).sum::<f64>()
}
