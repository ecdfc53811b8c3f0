//! The marginal density over theta.

use std::f64::consts::FRAC_PI_2;

use crate::newton::{increasing_root, linear_root};

/// A band between two parallels in which the density is linear in theta, up to its weight.
#[derive(Clone, Copy, Debug)]
pub(super) struct Band {
    /// theta of the upper and lower edge.
    pub(super) top: Angle,
    pub(super) bottom: Angle,
    /// The rows at the upper and lower edge; the second has the share t `slope` at t below `top`.
    pub(super) rows: [usize; 2],
    pub(super) slope: f64,
}

impl Band {
    /// Returns the extent in theta.
    pub(super) fn extent(&self) -> f64 {
        self.bottom.radians - self.top.radians
    }
}

/// The mean over longitudes of the density in a band, times sin(theta):
///
/// ```text
/// g(t) = ((a + b t) w(theta) + c) sin(theta),   theta = top + t,   w = 1 or cos(theta)
/// ```
#[derive(Clone, Copy, Debug)]
pub(super) struct Profile {
    top: Angle,
    bottom: Angle,
    a: f64,
    b: f64,
    c: f64,
    has_cosine: bool,
}

impl Profile {
    /// Returns the profile of a band whose rows have these means; c is `floor`.
    pub(super) fn new(band: &Band, [first, last]: [f64; 2], floor: f64, has_cosine: bool) -> Self {
        Self {
            top: band.top,
            bottom: band.bottom,
            a: first,
            b: (last - first) * band.slope,
            c: floor,
            has_cosine,
        }
    }

    fn extent(&self) -> f64 {
        self.bottom.radians - self.top.radians
    }

    /// Returns g(t) at theta.
    fn value(&self, t: f64, theta: &Angle) -> f64 {
        let weight = if self.has_cosine { theta.cos.max(0.0) } else { 1.0 };
        ((self.a + self.b * t) * weight + self.c) * theta.sin
    }

    /// Returns the integral of g from 0 to t.
    fn integral(&self, t: &Angle) -> f64 {
        let Self { top, a, b, c, .. } = self;
        if self.has_cosine {
            // sin cos = sin(2 theta)/2, in the variable 2t.
            let product = sine_moment(&top.doubled(), &t.doubled(), *a, 0.5 * b);
            0.25 * product + sine_moment(top, t, *c, 0.0)
        } else {
            sine_moment(top, t, a + c, *b)
        }
    }

    /// Returns the integral of g from 0 to t.
    pub(super) fn mass(&self, t: f64) -> f64 {
        self.integral(&Angle::new(t))
    }

    /// Returns the integral of g over the band.
    pub(super) fn total(&self) -> f64 {
        self.mass(self.extent())
    }

    /// Returns the t in [0, extent] with this mass.
    pub(super) fn inverse(&self, mass: f64) -> f64 {
        // The root for a density that is linear between the ends; at a pole it is nearly that.
        let extent = self.extent();
        let [first, last] = [(0.0, &self.top), (extent, &self.bottom)]
            .map(|(t, theta)| self.value(t, theta) * extent);
        let start = linear_root(first, last, mass) * extent;
        let start = if start.is_finite() { start } else { 0.5 * extent };
        increasing_root(extent, mass, 0.0, start, |t| {
            let below = Angle::new(t);
            (self.integral(&below), self.value(t, &self.top.plus(&below)))
        })
    }
}

/// An angle with its functions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Angle {
    pub(super) radians: f64,
    sin: f64,
    cos: f64,
    /// 1 - cos, with full relative accuracy.
    versine: f64,
}

impl Angle {
    pub(super) fn new(radians: f64) -> Self {
        let (sin, cos) = radians.sin_cos();
        let versine = if cos > 0.0 { sin * sin / (1.0 + cos) } else { 1.0 - cos };
        Self { radians, sin, cos, versine }
    }

    fn plus(&self, t: &Self) -> Self {
        let (sin, cos) = (self.sin * t.cos + self.cos * t.sin, self.cos * t.cos - self.sin * t.sin);
        Self { radians: self.radians + t.radians, sin, cos, versine: 1.0 - cos }
    }

    fn doubled(&self) -> Self {
        let versine = 2.0 * self.sin * self.sin;
        let sin = 2.0 * self.sin * self.cos;
        Self { radians: 2.0 * self.radians, sin, cos: 1.0 - versine, versine }
    }
}

/// Returns `int_0^t (a + b x) sin(start + x) dx`, without cancellation for small t and at the
/// poles.
fn sine_moment(start: &Angle, t: &Angle, a: f64, b: f64) -> f64 {
    let zeroth = start.sin * t.sin + start.cos * t.versine;
    if b == 0.0 {
        return a * zeroth;
    }
    let first = start.sin * (t.radians * t.sin - t.versine) + start.cos * sin_minus_t_cos(t);
    a * zeroth + b * first
}

/// Returns sin(t) - t cos(t), which is t^3/3 for small t.
fn sin_minus_t_cos(t: &Angle) -> f64 {
    /// (-1)^(k+1) 2k/(2k+1)! for k from 1 to 10.
    const SERIES: [f64; 10] = [
        1.0 / 3.0,
        -1.0 / 30.0,
        1.0 / 840.0,
        -1.0 / 45_360.0,
        1.0 / 3_991_680.0,
        -1.0 / 518_918_400.0,
        1.0 / 93_405_312_000.0,
        -1.0 / 22_230_464_256_000.0,
        1.0 / 6_758_061_133_824_000.0,
        -1.0 / 2_554_547_108_585_472_000.0,
    ];
    if t.radians.abs() > 1.0 {
        return t.sin - t.radians * t.cos;
    }
    let square = t.radians * t.radians;
    let sum = SERIES.iter().rev().fold(0.0, |sum, term| sum * square + term);
    sum * square * t.radians
}

/// The end of the hemisphere.
pub(super) const EQUATOR: f64 = FRAC_PI_2;

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::{Angle, Band, Profile, sine_moment};

    /// Gauss-Legendre with 3 nodes on each of 2000 intervals: errors below 1e-15 of the integral.
    fn quadrature(start: f64, t: f64, a: f64, b: f64) -> f64 {
        let node = 0.6f64.sqrt();
        let h = t / 2000.0;
        let f = |x: f64| (a + b * x) * (start + x).sin();
        let panel = |k: i32| {
            let middle = (f64::from(k) + 0.5) * h;
            let outer = f(middle - 0.5 * h * node) + f(middle + 0.5 * h * node);
            h * (5.0 * outer + 8.0 * f(middle)) / 18.0
        };
        (0..2000).map(panel).sum()
    }

    #[test]
    fn moments_are_the_integrals() {
        for start in [0.0, 1e-8, 0.3, 1.5, 3.0, PI - 1e-4] {
            for t in [1e-9, 1e-4, 0.1, 0.5, 0.99, 1.01, PI] {
                let t = f64::min(t, PI - start);
                for (a, b) in [(1.0, 0.0), (1.0, 2.0), (0.0, 1.0), (1.0, -1.0 / t)] {
                    let fast = sine_moment(&Angle::new(start), &Angle::new(t), a, b);
                    let slow = quadrature(start, t, a, b);
                    // Next to the south pole the angle itself is rounded.
                    let tolerance = 1e-13 * slow + f64::EPSILON * PI * t * (a + b * t).max(a);
                    assert!(
                        (fast - slow).abs() <= tolerance,
                        "{start}, {t}, {a}, {b}: {fast}, {slow}"
                    );
                }
            }
        }
    }

    #[test]
    fn masses_are_inverted() {
        for top in [0.0, 0.2, 1.2] {
            for (a, b) in [(1.0, 0.0), (1.0, -3.0), (0.0, 2.0), (0.0, 0.0)] {
                for c in [0.0, 1e-3, 5.0] {
                    for has_cosine in [false, true] {
                        let [top, bottom] = [top, top + 0.3].map(Angle::new);
                        let band = Band { top, bottom, rows: [0, 1], slope: 1.0 };
                        let profile = Profile::new(&band, [a, a + b], c, has_cosine);
                        let mass = profile.total();
                        for share in [0.0, 1e-9, 0.1, 0.7, 1.0] {
                            let t = profile.inverse(share * mass);
                            let error = (profile.mass(t) - share * mass).abs();
                            assert!(error <= 1e-15 * mass, "{profile:?}, {share}: {t}");
                        }
                    }
                }
            }
        }
    }
}
