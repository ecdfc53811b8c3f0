//! The notation of shares in arguments: `2%` or `0.02`.

/// The largest share that needs no % sign: larger numbers are more likely to be meant as
/// percentages.
const MAX_PLAIN: f64 = 0.5;

/// Parses a share above 0, as a number or in percent; above 0.5 in percent only.
pub(crate) fn parse_share(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let (number, unit) = match text.strip_suffix('%') {
        Some(percent) => (percent.trim_end(), 0.01),
        None => (text, 1.0),
    };
    match number.parse::<f64>() {
        Ok(x) if !text.ends_with('%') && x > MAX_PLAIN && x.is_finite() => {
            // Avoids the rounding of the product.
            let percent = (1e6 * x).round() / 1e4;
            Err(format!("{text} is {percent} %: did you mean {text}%? If not, write {percent}%"))
        }
        Ok(x) if x > 0.0 && x.is_finite() => Ok(unit * x),
        _ => Err("a share above 0 is needed, such as 2% or 0.02".to_owned()),
    }
}

/// Parses a share as [`parse_share`] does, or 0.
pub(crate) fn parse_share_or_zero(text: &str) -> Result<f64, String> {
    let number = text.trim().trim_end_matches('%').trim_end();
    if number.parse().is_ok_and(|x: f64| x == 0.0) { Ok(0.0) } else { parse_share(text) }
}

#[cfg(test)]
mod tests {
    use super::{parse_share, parse_share_or_zero};

    #[test]
    fn shares_may_be_zero_where_allowed() {
        for text in ["0", "0%", " 0.0 % ", "-0"] {
            assert_eq!(parse_share_or_zero(text).unwrap().to_bits(), 0, "{text}");
        }
        assert_eq!(parse_share_or_zero("2%"), parse_share("2%"));
        for text in ["", "%", "-1", "nan", "0x", "1"] {
            assert!(parse_share_or_zero(text).is_err(), "{text}");
        }
    }

    #[test]
    fn shares_are_numbers_or_percent() {
        for (text, share) in [("2%", 0.02), (" 2 % ", 0.02), ("0.5", 0.5), ("1e-3", 1e-3)] {
            let got = parse_share(text).unwrap();
            assert!((got / share - 1.0).abs() < 2.0 * f64::EPSILON, "{text}: {got}");
        }
        for text in ["60%", "100%", "250 %"] {
            assert!(parse_share(text).unwrap() > 0.5, "{text}");
        }
        for text in ["1", "0.51", "100"] {
            let error = parse_share(text).unwrap_err();
            assert!(error.contains(&format!("did you mean {text}%?")), "{text}: {error}");
        }
        for text in ["", "%", "0", "-1%", "nan", "inf", "x"] {
            assert!(parse_share(text).is_err(), "{text}");
        }
    }
}
