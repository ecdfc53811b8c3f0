//! Radical inverses: the digits of an integer mirrored at the radix point (van der Corput 1935),
//! exact or correctly rounded, and fractions from digits.

/// Returns the exact radical inverse of `i` in base 2, in [0, 1).
pub(crate) fn base_2(i: u32) -> f64 {
    f64::from(i.reverse_bits()) * 2f64.powi(-32)
}

/// Returns the correctly rounded radical inverse of `i` in base 3, in [0, 1).
///
/// The mirrored digits and the power of 3 are integers of at most 21 trits, exact in `f64`, so only
/// the division rounds.
pub(crate) fn base_3(mut i: u32) -> f64 {
    let (mut mirrored, mut power) = (0u64, 1u64);
    while i > 0 {
        mirrored = 3 * mirrored + u64::from(i % 3);
        power *= 3;
        i /= 3;
    }
    mirrored as f64 / power as f64
}

/// Returns the number in [0, 1) whose binary digits are the 53 highest bits of a word.
pub(super) fn fraction(word: u64) -> f64 {
    (word >> 11) as f64 * 2f64.powi(-53)
}

#[cfg(test)]
mod tests {
    use super::{base_2, base_3};

    #[test]
    fn the_first_values() {
        let twos = [0.0, 0.5, 0.25, 0.75, 0.125, 0.625, 0.375, 0.875, 0.0625];
        let threes = [0.0, 1.0, 2.0, 1.0 / 3.0, 4.0 / 3.0, 7.0 / 3.0, 2.0 / 3.0].map(|x| x / 3.0);
        for (i, expected) in (0..).zip(twos) {
            assert!((base_2(i) - expected).abs() <= 0.0, "i = {i}: {}", base_2(i));
        }
        for (i, expected) in (0..).zip(threes) {
            assert!((base_3(i) - expected).abs() < f64::EPSILON, "i = {i}: {}", base_3(i));
        }
        assert!((base_2(u32::MAX) - (1.0 - 2f64.powi(-32))).abs() <= 0.0);
        // In base 3, 3^20 - 1 is twenty digits 2.
        assert!((base_3(3u32.pow(20) - 1) - (1.0 - 3f64.powi(-20))).abs() < f64::EPSILON);
    }
}
