//! The numbers of claims as text.

use sphvar_thesis::Stated;

/// Returns what the thesis states, in words.
pub(super) fn stated(stated: &Stated) -> String {
    match *stated {
        Stated::About { value, tolerance } if tolerance > SLIGHT * value.abs().max(1.0) => {
            format!("{} \u{b1} {}", plain(value), plain(tolerance))
        }
        Stated::About { value, .. } => plain(value),
        Stated::AtMost(limit) => format!("at most {}", plain(limit)),
        Stated::AtLeast(limit) => format!("at least {}", plain(limit)),
        Stated::Words(words) => words.to_owned(),
    }
}

/// Tolerances below this only allow for rounding and are not shown.
const SLIGHT: f64 = 1e-9;

/// Returns a number of the thesis: all its digits if it is very small or large, else six.
fn plain(x: f64) -> String {
    let size = x.abs();
    if size != 0.0 && !(1e-4..1e6).contains(&size) {
        return format!("{x:e}");
    }
    #[expect(clippy::cast_possible_truncation, reason = "logarithms of f64 are below 400")]
    let decimals = if size > 0.0 { 5 - size.log10().floor() as i32 } else { 0 };
    let text = format!("{x:.*}", usize::try_from(decimals).unwrap_or(0));
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// Exact values below this are rounding residues, for which two digits suffice.
const ROUNDING: f64 = 1e-9;

/// Returns a number to two digits of its interval's width, or to four or five digits if it has
/// none.
pub(super) fn rounded(x: f64, interval: Option<(f64, f64)>) -> String {
    if !x.is_finite() {
        return "-".to_owned();
    }
    let width = interval.map_or(0.0, |(low, high)| high - low);
    let step = if width > 0.0 && width.is_finite() {
        0.05 * width
    } else if x.abs() < ROUNDING {
        0.05 * x.abs()
    } else {
        5e-5 * x.abs()
    };
    let size = x.abs().max(step);
    #[expect(clippy::cast_possible_truncation, reason = "logarithms of f64 are below 400")]
    let decimals = if step > 0.0 { (-step.log10()).floor() as i32 } else { 0 };
    if (1e-3..1e6).contains(&size) || x == 0.0 {
        let text = format!("{x:.*}", usize::try_from(decimals.clamp(0, 12)).unwrap_or(0));
        // A value that rounds to zero has no sign.
        match text.strip_prefix('-') {
            Some(digits) if digits.bytes().all(|b| b == b'0' || b == b'.') => digits.to_owned(),
            _ => text,
        }
    } else {
        #[expect(clippy::cast_possible_truncation, reason = "logarithms of f64 are below 400")]
        let digits = (size / step).log10().floor() as i32;
        format!("{x:.*e}", usize::try_from(digits.clamp(0, 12)).unwrap_or(0))
    }
}

#[cfg(test)]
mod tests {
    use sphvar_thesis::Quantity;

    use super::{plain, rounded};

    #[test]
    fn printed_numbers_stay_as_they_are() {
        for (x, text) in [
            (0.055, "0.055"),
            (300.0, "300"),
            (-1.5, "-1.5"),
            (0.0, "0"),
            (1e-6, "1e-6"),
            (232.166_318_621_979_88, "232.166"),
            (0.6, "0.6"),
        ] {
            assert_eq!(plain(x), text);
        }
    }

    #[test]
    fn numbers_have_the_digits_that_their_intervals_leave() {
        for (x, interval, text) in [
            (346.21, Some((342.0, 351.0)), "346"),
            (0.059_512, Some((0.0587, 0.0603)), "0.0595"),
            (-1.998_7, Some((-2.02, -1.97)), "-2.00"),
            (3.9e-8, Some((3.8e-8, 4.0e-8)), "3.90e-8"),
            (1.262_18, Some((1.262_18, 1.262_18)), "1.2622"),
            (1.0, Some((1.0, 1.0)), "1.0000"),
            (-0.01, Some((-0.3, 0.3)), "0.0"),
            (4.440_89e-16, Some((4.440_89e-16, 4.440_89e-16)), "4.4e-16"),
            (0.0, Some((0.0, 0.0)), "0"),
            (f64::NAN, None, "-"),
            (12.0, Some((f64::NEG_INFINITY, f64::INFINITY)), "12.000"),
        ] {
            assert_eq!(rounded(x, interval), text, "{x}");
        }
        let exact = Quantity::exact(2.0);
        assert_eq!(rounded(exact.value, Some(exact.interval)), "2.0000");
    }
}
