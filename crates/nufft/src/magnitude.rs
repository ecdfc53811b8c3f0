/// Returns the largest power of two that does not exceed the maximum absolute value; 1 if there is
/// none or it is not finite.
///
/// Division by it keeps numbers in range, even of f32, and is exact.
pub fn magnitude(numbers: impl IntoIterator<Item = f64>) -> f64 {
    let largest = numbers.into_iter().fold(0.0, |size: f64, x| size.max(x.abs()));
    let exponent = f64::from_bits(largest.to_bits() & f64::INFINITY.to_bits());
    if largest > 0.0 && exponent.is_finite() { exponent.max(f64::MIN_POSITIVE) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::magnitude;

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
