//! An axis: its range, its ticks and their labels.

/// The map of an axis from values to lengths.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Scale {
    /// Linear.
    Linear,
    /// Logarithmic; values that are not positive are not drawn.
    Log,
    /// Names at 1, 2, ...
    Names(&'static [&'static str]),
}

/// The margin between the data and the frame, as a fraction of the range.
const MARGIN: f64 = 0.04;
/// Values of larger magnitude are omitted, so that ranges and their margins stay finite.
const MAX_MAGNITUDE: f64 = 1e300;
/// Axes of more decades have ticks at powers of ten only.
const MAX_DECADES_WITH_DIGITS: i32 = 9;
/// On a linear axis, smaller magnitudes count as zero, so that its power of ten stays a normal
/// number.
const MIN_MAGNITUDE: f64 = 1e-290;

impl Scale {
    /// Returns the position of a value on the scale, or `None` for a value that cannot be drawn.
    pub(super) fn place(self, value: f64) -> Option<f64> {
        if !value.is_finite() || value.abs() > MAX_MAGNITUDE {
            return None;
        }
        match self {
            Self::Linear | Self::Names(_) => Some(value),
            Self::Log => (value > 0.0).then(|| value.log10()),
        }
    }
}

/// A labelled tick.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tick {
    /// Its position, from 0 (start of the axis) to 1.
    pub(super) at: f64,
    /// Its label.
    pub(super) label: String,
}

/// An axis fitted to data.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axis {
    scale: Scale,
    low: f64,
    high: f64,
    /// Labelled ticks.
    pub(super) ticks: Vec<Tick>,
    /// Positions of ticks without labels, from 0 to 1.
    pub(super) minor: Vec<f64>,
    /// The power of ten that all labels have in common and that is part of the axis label.
    pub(super) power: Option<i32>,
}

impl Axis {
    /// Returns an axis that contains all drawable values, with about `max_labels` labels.
    pub(super) fn fit(scale: Scale, values: impl Iterator<Item = f64>, max_labels: u32) -> Self {
        let places = values.filter_map(|value| scale.place(value));
        let range = places.fold(None, |range: Option<(f64, f64)>, place| {
            Some(range.map_or((place, place), |(low, high)| (low.min(place), high.max(place))))
        });
        match scale {
            Scale::Linear => Self::linear(range, max_labels),
            Scale::Log => Self::log(range, max_labels),
            Scale::Names(names) => Self::names(names),
        }
    }

    /// Returns the position of a value, from 0 to 1 and beyond for values outside of the range, or
    /// `None` for a value that cannot be drawn.
    pub(super) fn position(&self, value: f64) -> Option<f64> {
        self.scale.place(value).map(|place| self.fraction(place))
    }

    fn fraction(&self, place: f64) -> f64 {
        (place - self.low) / (self.high - self.low)
    }

    fn linear(range: Option<(f64, f64)>, max_labels: u32) -> Self {
        let (mut low, mut high) = range.unwrap_or((0.0, 1.0));
        let size = low.abs().max(high.abs());
        if size < MIN_MAGNITUDE {
            (low, high) = if range.is_some() { (-1.0, 1.0) } else { (0.0, 1.0) };
        } else if high - low <= 1e-9 * size {
            // A range of a few rounding errors has no useful ticks.
            (low, high) = (low - 0.5 * size, high + 0.5 * size);
        } else {
            let margin = MARGIN * (high - low);
            // Nonnegative data get a nonnegative axis.
            (low, high) =
                (if low >= 0.0 { (low - margin).max(0.0) } else { low - margin }, high + margin);
        }
        Self::between(low, high, max_labels)
    }

    /// Returns a linear axis from `low` to `high` without margins; the two must differ by more than
    /// rounding errors.
    pub(super) fn between(low: f64, high: f64, max_labels: u32) -> Self {
        let mut axis = Self {
            scale: Scale::Linear,
            low,
            high,
            ticks: Vec::new(),
            minor: Vec::new(),
            power: None,
        };
        let size = low.abs().max(high.abs());
        let exponent = floor_i32(size.log10());
        axis.power = (!(-3..=5).contains(&exponent)).then_some(exponent);
        let unit = axis.power.map_or(1.0, |power| 10f64.powi(power));
        let step = nice_step((high - low) / unit / f64::from(max_labels));
        let decimals = floor_i32(step.log10() + 1e-9).min(0).unsigned_abs() as usize;
        for value in multiples(low / unit, high / unit, step) {
            let value = if value.abs() < 1e-6 * step { 0.0 } else { value };
            let label = format!("{value:.decimals$}").replace('-', "\u{2212}");
            axis.ticks.push(Tick { at: axis.fraction(value * unit), label });
        }
        axis.minor_multiples(low / unit, high / unit, step, unit);
        axis
    }

    /// Returns an axis with a tick for each name.
    fn names(names: &'static [&'static str]) -> Self {
        let (scale, low, high) = (Scale::Names(names), 0.5, names.len() as f64 + 0.5);
        let mut axis = Self { scale, low, high, ticks: Vec::new(), minor: Vec::new(), power: None };
        let places = (1..).map(f64::from);
        axis.ticks = (places.zip(names))
            .map(|(place, name)| Tick { at: axis.fraction(place), label: (*name).to_owned() })
            .collect();
        axis
    }

    fn log(range: Option<(f64, f64)>, max_labels: u32) -> Self {
        let (mut low, mut high) = range.unwrap_or((0.0, 1.0));
        // One value, or several that are visually equal, get half a decade on either side.
        let margin = if high - low < 1e-6 { 0.5 } else { MARGIN * (high - low) };
        (low, high) = (low - margin, high + margin);
        let mut axis = Self {
            scale: Scale::Log,
            low,
            high,
            ticks: Vec::new(),
            minor: Vec::new(),
            power: None,
        };
        let (first, last) = (floor_i32(low), floor_i32(high));
        let max_labels = i32::try_from(max_labels).unwrap_or(i32::MAX).max(1);
        let decades = floor_i32(high) - ceil_i32(low) + 1;
        let digits: &[u8] = match decades {
            2.. => &[1],
            1 => &[1, 2, 5],
            _ => &[1, 2, 3, 4, 5, 6, 7, 8, 9],
        };
        // The spacing of labels: every decade, or every second, third, fifth, tenth, ...
        let steps = [1, 2, 3, 5, 10, 20, 50, 100];
        let step = steps.into_iter().find(|&step| decades <= step * max_labels).unwrap_or(200);
        for decade in first..=last {
            for digit in 1..=9 {
                let at = axis.fraction(f64::from(decade) + f64::from(digit).log10());
                if !(0.0..=1.0).contains(&at) {
                    continue;
                }
                if digits.contains(&digit) && decade.rem_euclid(step) == 0 {
                    axis.ticks.push(Tick { at, label: digit_and_power(digit, decade) });
                } else if digit == 1 || decades <= MAX_DECADES_WITH_DIGITS {
                    axis.minor.push(at);
                }
            }
        }
        if axis.ticks.len() < 2 {
            axis.linear_ticks(max_labels.unsigned_abs());
        }
        axis
    }

    /// Labels a logarithmic axis over a small part of a decade like a linear one.
    fn linear_ticks(&mut self, max_labels: u32) {
        let exponent = floor_i32(self.high);
        let unit = 10f64.powi(exponent.clamp(-300, 300));
        let (low, high) = (10f64.powf(self.low) / unit, 10f64.powf(self.high) / unit);
        let step = nice_step((high - low) / f64::from(max_labels));
        let decimals = floor_i32(step.log10() + 1e-9).min(0).unsigned_abs() as usize;
        self.power = (exponent != 0).then_some(exponent);
        self.ticks.clear();
        self.minor.clear();
        for value in multiples(low, high, step) {
            if let Some(at) = self.position(value * unit) {
                self.ticks.push(Tick { at, label: format!("{value:.decimals$}") });
            }
        }
        self.minor_multiples(low, high, step, unit);
    }

    /// Adds ticks without labels between multiples of `step` from `low` to `high`, all in `unit`.
    fn minor_multiples(&mut self, low: f64, high: f64, step: f64, unit: f64) {
        // Fourths of 2 times a power of ten and fifths of 1 and 5 times one are round.
        let leading = step / 10f64.powi(floor_i32(step.log10() + 1e-9));
        let part = if (1.5..3.0).contains(&leading) { 4.0 } else { 5.0 };
        let minor = multiples(low, high, step / part);
        let is_labelled = |value: f64| (value / step - (value / step).round()).abs() < 1e-6;
        let places: Vec<f64> = minor
            .filter(|&value| !is_labelled(value))
            .filter_map(|value| self.position(value * unit))
            .collect();
        self.minor.extend(places);
    }
}

/// Returns a power of ten as a label of a logarithmic axis. The exponent is always written: 10⁰
/// next to 10² is easier to read than 1.
pub(super) fn power_of_ten(exponent: i32) -> String {
    format!("10{}", raised(exponent))
}

fn digit_and_power(digit: u8, exponent: i32) -> String {
    match digit {
        1 => power_of_ten(exponent),
        _ => format!("{digit}\u{d7}{}", power_of_ten(exponent)),
    }
}

/// Returns an integer in superscript digits.
fn raised(number: i32) -> String {
    let figure = |c: char| match c {
        '-' => '\u{207b}',
        '1' => '\u{b9}',
        '2' => '\u{b2}',
        '3' => '\u{b3}',
        '0' => '\u{2070}',
        '4' => '\u{2074}',
        '5' => '\u{2075}',
        '6' => '\u{2076}',
        '7' => '\u{2077}',
        '8' => '\u{2078}',
        '9' => '\u{2079}',
        other => other,
    };
    number.to_string().chars().map(figure).collect()
}

/// Returns the smallest of 1, 2, 5 times a power of ten that is not below `min`.
fn nice_step(min: f64) -> f64 {
    let power = 10f64.powi(floor_i32(min.log10()));
    let steps = [1.0, 2.0, 5.0, 10.0];
    // The tolerance preserves a step of exactly 1, 2 or 5.
    steps
        .into_iter()
        .map(|step| step * power)
        .find(|&step| step >= min * (1.0 - 1e-9))
        .unwrap_or(10.0 * power)
}

/// Returns the multiples of `step` in [low, high], with a tolerance of half a millionth of a step.
fn multiples(low: f64, high: f64, step: f64) -> impl Iterator<Item = f64> {
    let first = (low / step - 5e-7).ceil();
    (0..400)
        .map(move |k| (first + f64::from(k)) * step)
        .take_while(move |&value| value <= high + 5e-7 * step)
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "the logarithm of a double lies in [-324, 309], and the cast saturates in any case"
)]
fn floor_i32(value: f64) -> i32 {
    value.floor() as i32
}

fn ceil_i32(value: f64) -> i32 {
    -floor_i32(-value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(scale: Scale, values: &[f64]) -> Vec<String> {
        let axis = Axis::fit(scale, values.iter().copied(), 8);
        axis.ticks.into_iter().map(|tick| tick.label).collect()
    }

    #[test]
    fn decades_are_powers() {
        assert_eq!(
            labels(Scale::Log, &[0.5e-3, 200.0]),
            ["10⁻³", "10⁻²", "10⁻¹", "10⁰", "10¹", "10²"]
        );
        assert_eq!(labels(Scale::Log, &[1e-9, 30.0]), ["10⁻⁸", "10⁻⁶", "10⁻⁴", "10⁻²", "10⁰"]);
        assert_eq!(labels(Scale::Log, &[8.0, 1100.0]), ["10¹", "10²", "10³"]);
        assert_eq!(labels(Scale::Log, &[16.0, 700.0]), ["2×10¹", "5×10¹", "10²", "2×10²", "5×10²"]);
        assert_eq!(
            labels(Scale::Log, &[2.1e-8, 8e-8]),
            ["2×10⁻⁸", "3×10⁻⁸", "4×10⁻⁸", "5×10⁻⁸", "6×10⁻⁸", "7×10⁻⁸", "8×10⁻⁸"]
        );
    }

    #[test]
    fn minor_ticks_are_round() {
        // 1 to 100 on a logarithmic axis: 2 to 9 and 20 to 90, and those within the margins.
        let axis = Axis::fit(Scale::Log, [1.0, 100.0].into_iter(), 8);
        assert!((16..=20).contains(&axis.minor.len()), "{}", axis.minor.len());
        // 0 to 10 by 2: the odd numbers between.
        let axis = Axis::fit(Scale::Linear, [0.0, 10.0].into_iter(), 6);
        assert_eq!((axis.ticks.len(), axis.minor.len()), (6, 15));
        let near = |at: f64| axis.minor.iter().any(|minor| (minor - at).abs() < 1e-9);
        assert!(near(axis.position(0.5).unwrap()) && !near(axis.position(4.0).unwrap()));
    }

    #[test]
    fn linear_labels_are_short() {
        assert_eq!(labels(Scale::Linear, &[0.0, 10.0]), ["0", "2", "4", "6", "8", "10"]);
        assert_eq!(
            labels(Scale::Linear, &[-0.3, 0.31]),
            ["−0.3", "−0.2", "−0.1", "0.0", "0.1", "0.2", "0.3"]
        );
        let axis = Axis::fit(Scale::Linear, [1e-7, 4e-7].into_iter(), 8);
        assert_eq!(axis.power, Some(-7));
        assert_eq!(axis.ticks.first().map(|tick| tick.label.as_str()), Some("1.0"));
    }

    #[test]
    fn log_axis_places_no_zero() {
        let axis = Axis::fit(Scale::Log, [0.0, -1.0, f64::NAN, 1.0, 100.0].into_iter(), 8);
        for value in [0.0, -0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(axis.position(value), None, "{value}");
        }
        let middle = axis.position(10.0).unwrap();
        assert!((middle - 0.5).abs() <= 4.0 * f64::EPSILON, "{middle}");
    }

    #[test]
    fn any_data_give_a_few_ticks_inside() {
        let extremes = [
            0.0,
            -0.0,
            1.0,
            -1.0,
            5e-324,
            1e-300,
            1e-12,
            1.0 + f64::EPSILON,
            3.0,
            7.5,
            1e3,
            1e6,
            1e15,
            9e299,
            1e300,
            f64::MAX,
            f64::NAN,
            f64::NEG_INFINITY,
            -1e300,
        ];
        for scale in [Scale::Linear, Scale::Log] {
            for a in extremes {
                for b in extremes {
                    for max_labels in [4, 8] {
                        let axis = Axis::fit(scale, [a, b].into_iter(), max_labels);
                        let count = axis.ticks.len();
                        assert!((1..=20).contains(&count), "{scale:?} {a:e} {b:e}: {count} ticks");
                        for tick in &axis.ticks {
                            let inside = (-1e-6..=1.0 + 1e-6).contains(&tick.at);
                            assert!(inside, "{scale:?} {a:e} {b:e}: {tick:?}");
                        }
                        for value in [a, b] {
                            if let Some(at) = axis.position(value) {
                                assert!((0.0..=1.0).contains(&at), "{scale:?} {a:e} {b:e}: {at}");
                            }
                        }
                    }
                }
            }
        }
    }
}
