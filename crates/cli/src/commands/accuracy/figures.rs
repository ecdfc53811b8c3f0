//! How times and errors are written for people.

/// Whether a bound is held, in a word.
pub(super) fn verdict(held: bool) -> &'static str {
    if held { "yes" } else { "NO" }
}

/// A time for each unit, in the fitting part of a second.
pub(super) fn time(seconds: f64, unit: &str) -> String {
    let (number, name) = match seconds {
        s if s >= 1.0 => (s, "s"),
        s if s >= 1e-3 => (1e3 * s, "ms"),
        s if s >= 1e-6 => (1e6 * s, "us"),
        s => (1e9 * s, "ns"),
    };
    format!("{} {name}/{}", three_digits(number), singular(unit))
}

/// One of the units, whose names are plurals.
pub(super) fn singular(unit: &str) -> &str {
    unit.strip_suffix('s').unwrap_or(unit)
}

/// An error or a bound with three digits.
pub(super) fn figure(x: f64) -> String {
    match x {
        0.0 => "0".to_owned(),
        0.01..1000.0 => three_digits(x),
        _ => format!("{x:.2e}"),
    }
}

/// A number of ordinary size with three digits.
fn three_digits(x: f64) -> String {
    let decimals = match x {
        100.0.. => 0,
        10.0..100.0 => 1,
        1.0..10.0 => 2,
        0.1..1.0 => 3,
        _ => 4,
    };
    format!("{x:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_digits_of_everything() {
        for (x, text) in [
            (0.0, "0"),
            (2.384e-7, "2.38e-7"),
            (0.3483, "0.348"),
            (0.04346, "0.0435"),
            (1.0, "1.00"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(figure(x), text);
        }
        assert_eq!(time(3.1359e-6, "values"), "3.14 us/value");
        assert_eq!(time(0.0999, "points"), "99.9 ms/point");
        assert_eq!(time(2.8e-8, "directions"), "28.0 ns/direction");
    }
}
