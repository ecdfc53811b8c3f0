//! The value that a picture shows as white.

use std::str::FromStr;

use sphvar_scene::Image;

use super::colours::quantile;
use super::stage::Stage;
use crate::report::number;
use crate::session::Session;

/// A value shown as white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum White {
    /// The value itself.
    Value(f64),
    /// The percentage of lit pixels, those above 0, that are not brighter.
    Percentile(f64),
}

impl White {
    /// The rule for pictures of light: a sun or fireflies do not darken the rest of the picture.
    pub(super) const AUTOMATIC: Self = Self::Percentile(99.0);
}

impl FromStr for White {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (number, is_percentile) = match text.strip_suffix('%') {
            Some(number) => (number, true),
            None => (text, false),
        };
        let wrong = || {
            format!(
                "--white must be a number above 0, or a percentage up to 100 such as 99%, got \"{text}\""
            )
        };
        let value: f64 = number.trim().parse().map_err(|_| wrong())?;
        let is_valid = value > 0.0 && value.is_finite() && !(is_percentile && value > 100.0);
        match (is_valid, is_percentile) {
            (false, _) => Err(wrong()),
            (true, true) => Ok(Self::Percentile(value)),
            (true, false) => Ok(Self::Value(value)),
        }
    }
}

/// Pixels are outliers if 99 % of a picture are below this share of them.
const SPIKE: f64 = 0.1;
/// The linear share of white below which an 8-bit pixel looks black.
const BLACK: f64 = 1.0 / 256.0;

/// Returns the value shown as white: the requested one, or 1 for shares, or the 99th percentile of
/// the lit pixels. Prints a remark if few pixels are far brighter, or most of the picture would be
/// black.
pub(super) fn white(
    requested: Option<White>,
    stage: &Stage,
    picture: &Image,
    session: &Session,
) -> f64 {
    let seen = || {
        let pixels = picture.values.iter().zip(&picture.coverage);
        pixels.filter(|(_, coverage)| **coverage > 0.0).map(|(&value, _)| value)
    };
    let brightest = seen().fold(0.0, f64::max);
    let rule = match requested {
        Some(white) => white,
        None if stage.is_share() => White::Value(1.0),
        None => White::AUTOMATIC,
    };
    let white = match rule {
        White::Value(value) => value,
        White::Percentile(_) if brightest == 0.0 => 1.0,
        White::Percentile(percent) => quantile(seen().filter(|x| *x > 0.0), percent / 100.0),
    };
    let median = quantile(seen(), 0.5);
    let is_spiky = matches!(rule, White::Percentile(_)) && white < SPIKE * brightest;
    if brightest > 0.0 && (median < BLACK * white || is_spiky) {
        let smallest = seen().fold(f64::INFINITY, f64::min);
        let text = format!(
            "values range from {} to {} with median {}; white is {} (change it with --white)",
            number::value(smallest),
            number::value(brightest),
            number::value(median),
            number::value(white),
        );
        session.say(&text);
    }
    white
}
