//! Converts values to the colours of a PNG.

use crate::files::srgb;

/// Returns a grey scale whose brightest value is `white`.
pub(super) fn grey(white: f64) -> impl Fn(f64) -> [u8; 3] {
    move |x| [srgb(x / white); 3]
}

/// Returns a scale with white for 0, red above it and blue below, saturated at `full`.
pub(super) fn signed(full: f64) -> impl Fn(f64) -> [u8; 3] {
    move |x| {
        let share = if full > 0.0 { (x.abs() / full).min(1.0) } else { 0.0 };
        let pale = srgb(1.0 - share);
        if x > 0.0 { [255, pale, pale] } else { [pale, pale, 255] }
    }
}

/// Returns the quantile `q` of the values, or 0 if there are none.
pub(super) fn quantile(values: impl Iterator<Item = f64>, q: f64) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "an index within the list"
    )]
    let at = (q * sorted.len().saturating_sub(1) as f64) as usize;
    sorted.get(at).copied().unwrap_or(0.0)
}
