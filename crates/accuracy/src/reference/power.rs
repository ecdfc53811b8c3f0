use std::ops::Mul;

/// Returns the `n`-th power of any type with multiplication; `one` for `n = 0`.
///
/// Computed by repeated squaring with `O(log n)` products, all of which the result needs, so that
/// no intermediate product overflows.
///
/// # Examples
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
