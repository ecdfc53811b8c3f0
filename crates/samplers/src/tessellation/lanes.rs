/// Number of lanes for running sums and extremes. Together with the absence of fused operations it
/// makes results bit-identical for any register width.
pub(crate) const LANES: usize = 8;

/// Returns the largest of some values, negative infinity if there are none.
#[inline(always)]
pub(crate) fn largest(values: &[f64]) -> f64 {
    let larger = |a: f64, b: f64| if b > a { b } else { a };
    let (chunks, rest) = values.as_chunks::<LANES>();
    let mut maxima = [f64::NEG_INFINITY; LANES];
    for chunk in chunks {
        for (maxima, &value) in maxima.iter_mut().zip(chunk) {
            *maxima = larger(*maxima, value);
        }
    }
    maxima.into_iter().chain(rest.iter().copied()).fold(f64::NEG_INFINITY, larger)
}
