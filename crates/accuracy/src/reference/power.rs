use std::ops::Mul;

/// Returns the `n`-th power of whatever can be multiplied, `one` for `n = 0`.
///
/// By squaring: `O(log n)` products, and none that the result does not need, so that nothing overflows on the way.
///
/// ```
/// assert_eq!(sphvar_accuracy::reference::power(1, 3, 5), 243);
/// ```
#[must_use]
pub fn power<T: Copy + Mul<Output = T>>(one: T, base: T, n: u64) -> T {
    let (mut result, mut square, mut rest) = (one, base, n);
    while rest > 0 {
        if rest % 2 == 1 {
            result = result * square;
        }
        rest /= 2;
        if rest > 0 {
            square = square * square;
        }
    }
    result
}
