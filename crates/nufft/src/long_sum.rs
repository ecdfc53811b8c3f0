/// Number of sums that are added without compensation before the total enters a longer sum. If all
/// rounding errors have the same sign, they amount to half this number.
pub const SHORT: usize = 64;

/// Adds `terms` to `sums`, element by element, and the rounding errors to `rests` (Knuth's
/// two-sum).
#[inline(always)]
pub fn add_with_rests(sums: &mut [f64], rests: &mut [f64], terms: &[f64]) {
    for ((sum, rest), &term) in sums.iter_mut().zip(rests).zip(terms) {
        let total = *sum + term;
        let part = total - *sum;
        *rest += (*sum - (total - part)) + (term - part);
        *sum = total;
    }
}

#[cfg(test)]
mod tests {
    use super::add_with_rests;

    #[test]
    fn the_rest_accumulates_rounding_errors() {
        let (mut sums, mut rests) = ([1.0, 0.0], [0.0; 2]);
        for _ in 0..1000 {
            add_with_rests(&mut sums, &mut rests, &[2f64.powi(-60), 0.5]);
        }
        let bits = |numbers: [f64; 2]| numbers.map(f64::to_bits);
        assert_eq!(bits(sums), bits([1.0, 500.0]), "{sums:?}");
        assert_eq!(bits(rests), bits([1000.0 * 2f64.powi(-60), 0.0]), "{rests:?}");
    }
}
