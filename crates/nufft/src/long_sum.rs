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
