//! The formats of numbers: one for tables and one for files.
//!
//! Tables show a fixed number of significant digits, without a power of ten from 0.001 up to 100000
//! and with one outside that range. A missing value is `-`.

/// The table entry of a missing number.
pub(crate) const MISSING: &str = "-";

/// Powers of ten that tables write without an exponent.
const PLAIN: std::ops::Range<i32> = -3..5;

/// Returns a number for files: the shortest form that is read back as the same number, or an empty
/// text if the number is not finite.
pub(crate) fn full(x: f64) -> String {
    if x.is_finite() { format!("{x:e}") } else { String::new() }
}

/// Returns a value for tables, with four significant digits.
pub(crate) fn value(x: f64) -> String {
    significant(x, 4)
}

/// Returns a factor between two values for tables, with three significant digits.
pub(crate) fn ratio(x: f64) -> String {
    significant(x, 3)
}

/// Returns a standard error or another uncertainty for tables, with two significant digits. An
/// infinite one counts as missing.
pub(crate) fn uncertainty(x: f64) -> String {
    if x.is_infinite() { MISSING.to_owned() } else { significant(x, 2) }
}

/// Returns a value with its uncertainty for tables: `0.983 +- 0.012`, `(9.83 +- 0.12)e-7`. The
/// uncertainty has two digits, and the value ends at the same decimal place but has at most six
/// digits; a value without an uncertainty, or the reverse, counts as missing.
pub(crate) fn with_uncertainty(x: f64, error: f64) -> String {
    const MAX_DIGITS: i32 = 6;
    if !(x.is_finite() && error.is_finite()) {
        return MISSING.to_owned();
    }
    if error == 0.0 {
        return format!("{} +- 0", value(x));
    }
    let (size, unit) = (exponent(if x == 0.0 { error } else { x }, 4), exponent(error, 2));
    let (scale, suffix) =
        if PLAIN.contains(&size) { (0, String::new()) } else { (size, format!("e{size}")) };
    if size - unit + 2 > MAX_DIGITS {
        return format!("{} +- {}", significant(x, MAX_DIGITS), uncertainty(error));
    }
    // Scaled as text, because 10^size may exceed the range of f64.
    let scaled = |x: f64| shifted(x, -scale);
    let decimals = usize::try_from(1 - (unit - scale)).unwrap_or(0);
    let text = format!("{:.decimals$} +- {:.decimals$}", scaled(x), scaled(error));
    if suffix.is_empty() { text } else { format!("({text}){suffix}") }
}

/// Returns a share in percent for tables, with three significant digits.
pub(crate) fn percent(share: f64) -> String {
    match significant(100.0 * share, 3) {
        missing if missing == MISSING => missing,
        number => number + " %",
    }
}

/// Returns a time in seconds for tables, with three significant digits and a suitable unit.
pub(crate) fn seconds(s: f64) -> String {
    let (number, unit) = match s {
        s if s >= 1.0 || s == 0.0 => (s, "s"),
        s if s >= 1e-3 => (1e3 * s, "ms"),
        s if s >= 1e-6 => (1e6 * s, "us"),
        s => (1e9 * s, "ns"),
    };
    match significant(number, 3) {
        missing if missing == MISSING => missing,
        number => format!("{number} {unit}"),
    }
}

/// Returns a number of points or a similar count, which need not be an integer, with all its digits
/// below ten million.
pub(crate) fn count(n: f64) -> String {
    match n {
        n if n.abs() < 1e7 => format!("{n:.0}"),
        n => significant(n, 3),
    }
}

/// Returns a difference in standard errors for tables, with its sign and one decimal. An infinite
/// one counts as missing.
pub(crate) fn score(z: f64) -> String {
    match z.abs() {
        size if size < 1e4 => format!("{z:+.1}"),
        size if size.is_finite() => value(z),
        _ => MISSING.to_owned(),
    }
}

/// Returns the exponent of a power law for tables, with two decimals.
pub(crate) fn rate(b: f64) -> String {
    if b.is_finite() { format!("{b:.2}") } else { MISSING.to_owned() }
}

/// Returns an interval for tables, both ends in the same format.
pub(crate) fn interval(ends: Option<(f64, f64)>, format: fn(f64) -> String) -> String {
    ends.map_or(MISSING.to_owned(), |(low, high)| format!("{} to {}", format(low), format(high)))
}

/// Returns a number that may be missing.
pub(crate) fn optional<T>(x: Option<T>, format: impl Fn(T) -> String) -> String {
    x.map_or(MISSING.to_owned(), format)
}

/// Returns a number with the given number of significant digits.
fn significant(x: f64, digits: i32) -> String {
    if x.is_nan() {
        return MISSING.to_owned();
    }
    if x == 0.0 {
        // Drops the sign of -0.
        return "0".to_owned();
    }
    if x.is_infinite() {
        return x.to_string();
    }
    let size = exponent(x, digits);
    let decimals = if PLAIN.contains(&size) { digits - 1 - size } else { digits - 1 };
    let decimals = usize::try_from(decimals).unwrap_or(0);
    if PLAIN.contains(&size) { format!("{x:.decimals$}") } else { format!("{x:.decimals$e}") }
}

/// Returns the power of ten of a finite nonzero number after rounding to the given number of
/// digits: 1 for 9.9996 with four digits.
fn exponent(x: f64, digits: i32) -> i32 {
    let decimals = usize::try_from(digits - 1).unwrap_or(0);
    let text = format!("{x:.decimals$e}");
    text.split_once('e').and_then(|(_, exponent)| exponent.parse().ok()).unwrap_or(0)
}

/// Returns `x 10^places`, correctly rounded even if the power exceeds the range of f64.
fn shifted(x: f64, places: i32) -> f64 {
    let text = format!("{x:e}");
    let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    format!("{digits}e{}", exponent + places).parse().unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TINY: f64 = 1e-320;

    #[test]
    fn values_have_four_digits() {
        for (x, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (f64::NAN, "-"),
            (f64::INFINITY, "inf"),
            (f64::NEG_INFINITY, "-inf"),
            (1.0, "1.000"),
            (9.9994, "9.999"),
            (9.9996, "10.00"),
            (-9.9996, "-10.00"),
            (1234.4, "1234"),
            (99999.4, "1.000e5"),
            (99994.0, "99994"),
            (100000.0, "1.000e5"),
            (0.001, "0.001000"),
            (0.00099996, "0.001000"),
            (0.0009999, "9.999e-4"),
            (0.25, "0.2500"),
            (TINY, "1.000e-320"),
            (1e300, "1.000e300"),
            (-f64::MAX, "-1.798e308"),
        ] {
            assert_eq!(value(x), text, "{x:e}");
        }
    }

    #[test]
    fn uncertainties_decide_the_digits_of_values() {
        for (x, error, text) in [
            (0.98342, 0.01234, "0.983 +- 0.012"),
            (1.0, 0.0, "1.000 +- 0"),
            (0.0, 0.0, "0 +- 0"),
            (0.0, 0.02, "0.000 +- 0.020"),
            (9.9996, 0.0996, "10.00 +- 0.10"),
            (12345.6, 210.0, "12346 +- 210"),
            (1.0, 5.0, "1.0 +- 5.0"),
            (1.0, 1e-12, "1.00000 +- 1.0e-12"),
            (9.8342e-7, 1.234e-8, "(9.83 +- 0.12)e-7"),
            (-2e300, 1e299, "(-2.00 +- 0.10)e300"),
            (TINY, TINY, "(1.0 +- 1.0)e-320"),
            (f64::NAN, 1.0, "-"),
            (1.0, f64::NAN, "-"),
            (1.0, f64::INFINITY, "-"),
            (f64::INFINITY, 1.0, "-"),
        ] {
            assert_eq!(with_uncertainty(x, error), text, "{x:e} +- {error:e}");
        }
        assert_eq!(uncertainty(0.012345), "0.012");
        assert_eq!(uncertainty(f64::INFINITY), "-");
    }

    #[test]
    fn shares_times_counts_and_scores() {
        for (share, text) in [
            (0.0, "0 %"),
            (0.123456, "12.3 %"),
            (1e-9, "1.00e-7 %"),
            (f64::INFINITY, "inf %"),
            (f64::NAN, "-"),
        ] {
            assert_eq!(percent(share), text);
        }
        for (s, text) in [
            (0.0, "0 s"),
            (2.84e-8, "28.4 ns"),
            (3.1359e-6, "3.14 us"),
            (0.0999, "99.9 ms"),
            (12.0, "12.0 s"),
            (TINY, "1.00e-311 ns"),
            (1e300, "1.00e300 s"),
            (f64::NAN, "-"),
        ] {
            assert_eq!(seconds(s), text);
        }
        for (n, text) in [(972.4, "972"), (9999999.0, "9999999"), (1e7, "1.00e7"), (f64::NAN, "-")]
        {
            assert_eq!(count(n), text);
        }
        for (z, text) in [
            (0.0, "+0.0"),
            (-3.25, "-3.2"),
            (1.5e6, "1.500e6"),
            (f64::NAN, "-"),
            (f64::NEG_INFINITY, "-"),
        ] {
            assert_eq!(score(z), text);
        }
        assert_eq!((rate(-1.4999), rate(f64::NAN)), ("-1.50".to_owned(), "-".to_owned()));
        assert_eq!(interval(Some((0.5, 20.0)), value), "0.5000 to 20.00");
        assert_eq!(
            (interval(None, value), optional(None, value)),
            ("-".to_owned(), "-".to_owned())
        );
    }

    /// Files preserve numbers of any size exactly.
    #[test]
    fn files_keep_every_bit() {
        for x in [0.0, -0.0, 9.9996, TINY, 1e300, f64::MIN_POSITIVE, 0.1 + 0.2, -f64::MAX] {
            assert_eq!(full(x).parse::<f64>().unwrap().to_bits(), x.to_bits(), "{x:e}");
        }
        assert_eq!((full(f64::NAN), full(f64::INFINITY)), (String::new(), String::new()));
    }
}
