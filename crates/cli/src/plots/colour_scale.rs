//! The colours of values, with the labels of their scale.

use image::Rgb;

use super::axis::{Axis, Scale};

/// The maximum number of labels of a side or of the colour scale.
const MAX_LABELS: u32 = 7;
/// The smallest value of a logarithmic colour scale, as a share of the largest.
const MIN_SHARE: f64 = 1e-6;

/// The colours of values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Colours {
    /// Dark for 0 to bright yellow for the largest value.
    Heat,
    /// Black for 0 to white for the largest value.
    Grey,
    /// Red for minus the largest magnitude over white for 0 to blue for the largest magnitude.
    Signed,
}

impl Colours {
    /// Returns the values of the first and last colour.
    fn range(self, values: &[f64]) -> (f64, f64) {
        let finite = || values.iter().filter(|x| x.is_finite());
        let size = match self {
            Self::Heat | Self::Grey => finite().fold(0.0, |a: f64, &b| a.max(b)),
            Self::Signed => finite().fold(0.0, |a: f64, &b| a.max(b.abs())),
        };
        let size = if size > 0.0 { size } else { 1.0 };
        match self {
            Self::Heat | Self::Grey => (0.0, size),
            Self::Signed => (-size, size),
        }
    }

    /// Returns the colour at a position from 0 to 1.
    pub(super) fn at(self, place: f64) -> Rgb<u8> {
        let gradient = match self {
            Self::Heat => colorous::INFERNO,
            // The gradient of that name runs from white to black.
            Self::Grey => colorous::GREYS,
            Self::Signed => colorous::RED_BLUE,
        };
        let place = if self == Self::Grey { 1.0 - place } else { place };
        Rgb(gradient.eval_continuous(place.clamp(0.0, 1.0)).into_array())
    }
}

/// The map from values to colours, with labelled ticks.
pub(super) struct ColourScale {
    positions: Positions,
    pub(super) ruler: Ruler,
}

enum Positions {
    /// From the first value to the last.
    Linear((f64, f64)),
    Log(Axis),
}

impl ColourScale {
    /// Returns the scale of these values; a logarithmic one begins at the smallest positive value or
    /// six decades below the largest.
    pub(super) fn new(values: &[f64], colours: Colours, scale: Scale) -> Self {
        let (first, last) = colours.range(values);
        if scale != Scale::Log {
            let ruler = Ruler::new((last, first));
            return Self { positions: Positions::Linear((first, last)), ruler };
        }
        let shown = values.iter().copied().filter(|&x| x.is_finite() && x >= MIN_SHARE * last);
        let axis = Axis::fit(Scale::Log, shown, MAX_LABELS);
        let ticks = axis.ticks.iter().map(|tick| (1.0 - tick.at, tick.label.clone())).collect();
        let ruler = Ruler { ticks, power: axis.power };
        Self { positions: Positions::Log(axis), ruler }
    }

    /// Returns the position of a finite value from 0, the first colour, to 1.
    pub(super) fn place(&self, value: f64) -> f64 {
        match &self.positions {
            Positions::Linear((first, last)) => (value - first) / (last - first),
            Positions::Log(axis) => axis.position(value).unwrap_or(0.0),
        }
    }
}

/// Labelled ticks between two values in either order.
pub(super) struct Ruler {
    /// Positions from 0 (the first value) to 1.
    pub(super) ticks: Vec<(f64, String)>,
    pub(super) power: Option<i32>,
}

impl Ruler {
    pub(super) fn new((first, last): (f64, f64)) -> Self {
        let (low, high) = (first.min(last), first.max(last));
        if !(low.is_finite() && high > low) {
            return Self { ticks: Vec::new(), power: None };
        }
        let axis = Axis::between(low, high, MAX_LABELS);
        let place = |at: f64| if first < last { at } else { 1.0 - at };
        let ticks = axis.ticks.into_iter().map(|tick| (place(tick.at), tick.label)).collect();
        Self { ticks, power: axis.power }
    }
}

#[cfg(test)]
mod tests {
    use super::{ColourScale, Colours, Scale};

    #[test]
    fn logarithmic_scales_span_six_decades_at_most() {
        let of = |values: &[f64]| ColourScale::new(values, Colours::Heat, Scale::Log);
        let values = [f64::NAN, 0.0, -1.0, 1e-20, 1e-2, 1.0, 100.0];
        let scale = of(&values);
        let places = values[1..].iter().map(|&x| scale.place(x).clamp(0.0, 1.0));
        let places: Vec<f64> = places.collect();
        assert!(places[..3].iter().all(|&place| place <= 0.0), "{places:?}");
        let steps = [places[4] - places[3], places[5] - places[4]];
        assert!(steps[0] > 0.4 && (steps[0] - steps[1]).abs() < 1e-12, "{places:?}");
        assert!(scale.ruler.ticks.len() >= 2);
        // Without positive values there is nothing to scale.
        for values in [&[][..], &[0.0], &[f64::NAN], &[f64::INFINITY]] {
            assert!(of(values).place(0.0) <= 0.0);
        }
    }
}
