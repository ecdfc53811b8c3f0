//! The notation of numbers in arguments: `1000`, `1e4`, `10k`, `16,64,256`, `16..1024`.

use std::str::FromStr;

/// The numbers of `-n` for subcommands that accept several: a list of numbers and of ranges that
/// double.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Counts(Vec<usize>);

impl Counts {
    /// Returns all numbers, in the order given.
    pub(crate) fn all(&self) -> &[usize] {
        &self.0
    }

    /// Returns the numbers from `first`, doubling, up to at most `last`.
    pub(crate) fn doubling(first: usize, last: usize) -> Self {
        Self(
            std::iter::successors(Some(first), |n| n.checked_mul(2))
                .take_while(|&n| n <= last)
                .collect(),
        )
    }
}

impl FromStr for Counts {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let count = |text: &str| match parse_count(text) {
            Ok(0) => Err("numbers of points must be at least 1, got 0".to_owned()),
            Ok(n) => Ok(n),
            Err(_) => Err(format!(
                "expected numbers from 1 as in 256, 16,64,256 or 16..1024, got \"{text}\""
            )),
        };
        let mut all = Vec::new();
        for item in text.split(',') {
            let Some((first, last)) = item.split_once("..") else {
                all.push(count(item)?);
                continue;
            };
            let (first, last) = (count(first)?, count(last)?);
            if first > last {
                return Err(format!(
                    "the range {first}..{last} is empty: give the smaller number first"
                ));
            }
            all.extend(Self::doubling(first, last).0);
        }
        Ok(Self(all))
    }
}

/// Parses a single number of points, for subcommands that do not accept a list.
pub(crate) fn parse_one_count(text: &str) -> Result<usize, String> {
    if text.contains(',') || text.contains("..") {
        return Err(format!("expected one number, got \"{text}\""));
    }
    parse_count(text)
}

/// Parses an integer, which may be negative.
pub(crate) fn parse_integer(text: &str) -> Result<i64, String> {
    text.parse().map_err(|_| format!("expected a whole number such as 3 or -3, got \"{text}\""))
}

/// Parses a number of realizations.
pub(crate) fn parse_realizations(text: &str) -> Result<u64, String> {
    parse_count(text).map(|count| count as u64)
}

/// Parses a number with a fraction.
pub(crate) fn parse_number(text: &str) -> Result<f64, String> {
    text.parse().map_err(|_| format!("expected a number such as 0.5 or 1e-3, got \"{text}\""))
}

/// Parses a whole number: digits, `1e4`, or thousands and millions as `10k` and `2.5M`.
pub(crate) fn parse_count(text: &str) -> Result<usize, String> {
    let text = text.trim();
    if let Ok(n) = text.parse() {
        return Ok(n);
    }
    /// Beyond it, not every whole number is an f64.
    const MAX: f64 = (1_u64 << 53) as f64;
    let wrong = || format!("expected a whole number such as 1000, 1e4 or 10k, got \"{text}\"");
    let (number, unit) = match text.as_bytes().last() {
        Some(b'k' | b'K') => (&text[..text.len() - 1], 1e3),
        Some(b'M') => (&text[..text.len() - 1], 1e6),
        _ => (text, 1.0),
    };
    // The names of infinity and NaN, and leading signs, are not valid in counts.
    if !number.starts_with(|c: char| c.is_ascii_digit()) {
        return Err(wrong());
    }
    let value = number.parse::<f64>().map_err(|_| wrong())? * unit;
    if value > MAX {
        return Err(format!("numbers are at most 2^53 (about 9e15), got \"{text}\""));
    }
    if value.fract() == 0.0 {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a whole number from 0 to 2^53"
        )]
        return Ok(value as usize);
    }
    Err(wrong())
}

#[cfg(test)]
mod tests {
    use super::{Counts, parse_count};

    #[test]
    fn lists_and_ranges() {
        for (text, counts) in [
            ("256", &[256][..]),
            ("16..64", &[16, 32, 64]),
            ("3..13", &[3, 6, 12]),
            ("5..5", &[5]),
            ("7, 9", &[7, 9]),
            ("12,100..400,1e3", &[12, 100, 200, 400, 1000]),
            ("1k..4k", &[1000, 2000, 4000]),
        ] {
            assert_eq!(text.parse::<Counts>().unwrap().all(), counts, "{text}");
        }
        for text in ["", "0", "1..", "..", "9..3", "-4", "1,,2", "2.5", "0..8", "1...4"] {
            assert!(text.parse::<Counts>().is_err(), "{text}");
        }
    }

    #[test]
    fn numbers_in_thousands_and_powers_of_ten() {
        for (text, count) in [
            ("0", 0),
            ("1e4", 10_000),
            ("2.5e3", 2500),
            ("10k", 10_000),
            ("1.5K", 1500),
            ("2.5M", 2_500_000),
            (" 12 ", 12),
            ("18446744073709551615", usize::MAX),
            ("9007199254740992", 1 << 53),
        ] {
            assert_eq!(parse_count(text), Ok(count), "{text}");
        }
        for text in [
            "", "k", "-1", "+1e3", "1e-1", "1.5", "1e400", "1e19", "inf", "nan", "infk", "0x10",
            "1_000", "10kk", "10 k", "1m",
        ] {
            assert!(parse_count(text).is_err(), "{text}");
        }
    }
}
