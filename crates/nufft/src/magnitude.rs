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
pub(crate) fn magnitude_of<R: Real>(numbers: &[R]) -> f64 {
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
pub(crate) fn magnitude_of_complex<R: Real>(numbers: &[Complex<R>]) -> f64 {
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
pub(crate) fn sum_of_sizes<R: Real>(numbers: &[R]) -> f64 {
    let mut sums = [0.0; LANES];
    let (chunks, rest) = numbers.as_chunks::<LANES>();
    for chunk in chunks {
        for (sum, x) in sums.iter_mut().zip(chunk) {
            *sum += x.to_f64().abs();
        }
    }
    sums.iter().sum::<f64>() + rest.iter().map(|x| x.to_f64().abs()).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use num_complex::Complex;

    use super::{magnitude, magnitude_of, magnitude_of_complex, sum_of_sizes};

    #[test]
    fn lists_have_the_same_magnitude_and_their_sum() {
        let numbers: Vec<f64> = (0..100).map(|i| f64::from((i * 37) % 101) - 50.0).collect();
        for n in 0..=100 {
            let some = &numbers[..n];
            let expected = magnitude(some.iter().copied());
            assert_eq!(magnitude_of(some).to_bits(), expected.to_bits(), "{n}");
            let complex: Vec<_> = some.iter().map(|x| Complex::new(0.5, *x)).collect();
            let expected = magnitude(some.iter().copied().chain((n > 0).then_some(0.5)));
            assert_eq!(magnitude_of_complex(&complex).to_bits(), expected.to_bits(), "{n}");
            // Integers, whose sums are exact.
            let sum = some.iter().fold(0.0, |sum: f64, x| sum + x.abs());
            assert_eq!(sum_of_sizes(some).to_bits(), sum.to_bits(), "{n}");
        }
    }

    #[test]
    fn it_is_the_largest_power_of_two_up_to_the_maximum() {
        for (numbers, expected) in [
            (vec![], 1.0),
            (vec![0.0, -0.0], 1.0),
            (vec![-3.0, 2.0], 2.0),
            (vec![0.75], 0.5),
            (vec![5e-324], f64::MIN_POSITIVE),
            (vec![f64::MAX], 2f64.powi(1023)),
            (vec![f64::INFINITY, 3.0], 1.0),
            (vec![f64::NAN, 3.0], 2.0),
        ] {
            let got = magnitude(numbers.iter().copied());
            assert!(got.to_bits() == f64::to_bits(expected), "{numbers:?}: {got:e}");
        }
    }
}
