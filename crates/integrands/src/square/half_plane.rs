use std::f64::consts::{FRAC_1_SQRT_2, PI};

use sphvar_grammar::{Declaration, Parametric, Range};
use sphvar_sh::{ByAxis, Frequencies};

use super::SquareDefinition;
use super::energy::energy_of_coefficients;
use super::turns::sinc;
use crate::functions::cap::two_valued_kurtosis;
use crate::{Energy, Error, IntegrandResolver, SquareIntegrand};

/// The indicator of the part of the square on one side of a line: an edge of any direction, such as
/// that of a shadow.
///
/// ```text
/// (u - 1/2) cos a + (v - 1/2) sin a >= offset
/// ```
///
/// The edge ends at the border of the square, where the periodic extension has further jumps. By
/// reflections, the exchange of both coordinates and the complement, which change no `|G_k|`, the
/// part is `x + t y >= d/cos a` in coordinates x, y from the centre, with t = tan a from 0 to 1 and
/// d >= 0. Its edge crosses the square over a length L of y, which ends at y = 1/2, and
/// a length X = t L of x:
///
/// ```text
/// |G_k|^2 = (L/(2 pi k1))^2 [(s - q)^2 + 4 s q sin^2(pi k1 w)],   s = sinc((k2 - k1 t) L), q = sinc(k2 L)
/// ```
///
/// with w the distance from the middle of the edge to x = 1/2. No term cancels for edges near the
/// axes or k near the normal of the edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfPlane {
    normal: [f64; 2],
    offset: f64,
    edge: Edge,
}

/// The edge in the coordinates of the closed form.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Edge {
    /// Whether u is y and v is x.
    is_swapped: bool,
    /// Whether exactly one of x and y has the opposite sign of its coordinate.
    is_reflected: bool,
    /// Whether the edge cuts off a corner; otherwise it crosses from one side to the opposite one.
    is_at_corner: bool,
    /// The slope t.
    slope: f64,
    /// The extents L and X of the edge in y and x.
    length: f64,
    width: f64,
    /// The distance w.
    distance: f64,
    /// The lesser of the areas on both sides, at x = 1/2.
    area: f64,
}

impl HalfPlane {
    /// Returns the half plane whose inward normal has the angle `degrees` with +u, counted towards
    /// +v, and whose edge has the distance `offset` from the centre of the square along the normal;
    /// from -360 to 360 degrees and from -1 to 1.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] outside the ranges.
    pub fn new(degrees: f64, offset: f64) -> Result<Self, Error> {
        if !(-360.0..=360.0).contains(&degrees) {
            return Err(Error::Parameter { name: "angle", range: "in [-360, 360]", got: degrees });
        }
        if !(-1.0..=1.0).contains(&offset) {
            return Err(Error::Parameter { name: "offset", range: "in [-1, 1]", got: offset });
        }
        let normal = normal(degrees);
        Ok(Self { normal, offset, edge: Edge::new(normal, offset) })
    }

    /// Returns the areas inside and outside.
    fn areas(&self) -> (f64, f64) {
        let (lesser, greater) = (self.edge.area, 1.0 - self.edge.area);
        if self.offset < 0.0 { (greater, lesser) } else { (lesser, greater) }
    }
}

/// Returns the unit vector of an angle, exact for multiples of 45 degrees.
fn normal(degrees: f64) -> [f64; 2] {
    let angle = degrees.rem_euclid(360.0);
    let quarter = (angle / 90.0).floor();
    let rest = angle - 90.0 * quarter;
    let [c, s] = match rest {
        45.0 => [FRAC_1_SQRT_2; 2],
        _ if rest < 45.0 => [rest.to_radians().cos(), rest.to_radians().sin()],
        _ => [(90.0 - rest).to_radians().sin(), (90.0 - rest).to_radians().cos()],
    };
    match quarter {
        1.0 => [-s, c],
        2.0 => [-c, -s],
        3.0 => [s, -c],
        _ => [c, s],
    }
}

impl Edge {
    fn new([a, b]: [f64; 2], offset: f64) -> Self {
        let is_swapped = b.abs() > a.abs();
        let (c, s) = if is_swapped { (b.abs(), a.abs()) } else { (a.abs(), b.abs()) };
        let (slope, d) = (s / c, offset.abs());
        // From d to 1/2, and half of 1 - c: their difference keeps its digits where s or 1/2 - d is
        // small.
        let (to_side, turn) = (0.5 - d, 0.5 * s * s / (1.0 + c));
        let depth = to_side + (0.5 * s - turn);
        let is_at_corner = to_side < 0.5 * s + turn;
        let (length, width, distance, area) = if depth <= 0.0 {
            (0.0, 0.0, 0.0, 0.0)
        } else if !is_at_corner {
            let area = (to_side - turn) / c;
            (1.0, slope, area, area)
        } else {
            let (length, width) = ((depth / s).min(1.0), depth / c);
            (length, width, 0.5 * width, 0.5 * width * length)
        };
        let is_reflected = (a < 0.0) != (b < 0.0);
        Self { is_swapped, is_reflected, is_at_corner, slope, length, width, distance, area }
    }

    /// Returns `|G_k|^2`.
    fn square(&self, k: [i32; 2]) -> f64 {
        let [k1, k2] = k.map(f64::from);
        let (k1, k2) = if self.is_swapped { (k2, k1) } else { (k1, k2) };
        let k2 = if self.is_reflected { -k2 } else { k2 };
        let Self { slope, length, width, distance, .. } = *self;
        let q = sinc(k2 * length);
        if k1 == 0.0 {
            // The length in x at each y is constant or linear in y, with the slope t over L.
            let sin = sin_half_turns(0.5 * k2 * length);
            let square = (q - 1.0).powi(2) + 4.0 * q * sin * sin;
            return (width / (2.0 * PI * k2)).powi(2) * square;
        }
        let s = sinc((k2 - k1 * slope) * length);
        let sin = sin_half_turns(k1 * distance);
        let square = (s - q).powi(2) + 4.0 * s * q * sin * sin;
        (length / (2.0 * PI * k1)).powi(2) * square.max(0.0)
    }

    /// Returns the variances of the three parts of the indicator.
    ///
    /// With h the length in y at each x and w that in x at each y, the part of x has the variance of
    /// h, that of y the variance of w, and the rest is `int h (1 - h) dx` without the variance of w.
    fn variances(&self) -> ByAxis {
        let Self { slope, length, width, area, .. } = *self;
        // (1 - l) mean^2 + l times the mean square of a linear function from -mean to height - mean.
        let triangle = |l: f64, height: f64| {
            let (from, to) = (-area, height - area);
            (1.0 - l) * area * area + l * (from * from + from * to + to * to) / 3.0
        };
        let (of_x, of_y, conditional) = if length == 0.0 {
            (0.0, 0.0, 0.0)
        } else if self.is_at_corner {
            let inside = width * length * (0.5 - length / 3.0);
            (triangle(width, length), triangle(length, width), inside)
        } else {
            (area * (1.0 - area) - slope / 6.0, slope * slope / 12.0, slope / 6.0)
        };
        let off = (conditional - of_y).max(0.0);
        let (u, v) = if self.is_swapped { (of_y, of_x) } else { (of_x, of_y) };
        ByAxis { off, u, v }
    }
}

/// Returns `sin(pi x)`, periodic in x to the last digit.
fn sin_half_turns(x: f64) -> f64 {
    (PI * (x - 2.0 * (0.5 * x).round())).sin()
}

impl SquareIntegrand for HalfPlane {
    fn eval(&self, [u, v]: [f64; 2]) -> f64 {
        let [a, b] = self.normal;
        f64::from(u8::from(a * (u - 0.5) + b * (v - 0.5) >= self.offset))
    }

    fn exact(&self) -> Option<f64> {
        Some(self.areas().0)
    }

    fn energy(&self, frequencies: &Frequencies) -> Result<Energy<Frequencies>, Error> {
        let (mean, centred) = (self.areas().0, self.edge.variances());
        energy_of_coefficients(frequencies, mean, centred, |k| self.edge.square(k))
    }

    /// Returns the extent of a corner, or the width of a strip along a side.
    fn feature_size(&self) -> Option<f64> {
        let Edge { is_at_corner, length, width, area, .. } = self.edge;
        let size = if is_at_corner { length.min(width) } else { area };
        // Without an edge there is no feature.
        Some(if area > 0.0 { size } else { 1.0 })
    }

    fn kurtosis(&self) -> Option<f64> {
        let (inside, outside) = self.areas();
        two_valued_kurtosis(inside, outside)
    }

    /// Returns 0 without an edge.
    fn band_limit(&self) -> Option<usize> {
        (self.edge.area == 0.0).then_some(0)
    }

    /// Returns 1 for an edge parallel to a side, 0 without an edge; that of other edges is infinite.
    fn variation(&self) -> Option<f64> {
        match (self.areas(), self.edge.slope) {
            ((inside, outside), _) if inside == 0.0 || outside == 0.0 => Some(0.0),
            (_, slope) => (slope == 0.0).then_some(1.0),
        }
    }
}

/// Parameters of a [`HalfPlane`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfPlaneParameters {
    /// The angle of the normal in degrees, see [`HalfPlane::new`].
    pub angle: f64,
    /// The distance of the edge from the centre.
    pub offset: f64,
}

/// An example.
impl Default for HalfPlaneParameters {
    fn default() -> Self {
        Self { angle: 30.0, offset: 0.0 }
    }
}

impl Parametric for HalfPlaneParameters {
    fn declare(&mut self, d: &mut Declaration<'_>) {
        let range = Range::closed(-360.0, 360.0);
        let summary = "direction of the inward normal, in degrees from u towards v";
        d.required_number("angle", range, summary, &mut self.angle);
        let summary = "distance of the edge from the centre along the normal";
        d.number("offset", Range::closed(-1.0, 1.0), summary, &mut self.offset);
    }
}

impl SquareDefinition for HalfPlaneParameters {
    fn build(&self, _: &dyn IntegrandResolver) -> Result<Box<dyn SquareIntegrand>, Error> {
        Ok(Box::new(HalfPlane::new(self.angle, self.offset)?))
    }
}
