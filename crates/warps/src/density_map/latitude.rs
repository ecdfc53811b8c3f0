//! The marginal density over theta.

use std::f64::consts::FRAC_PI_2;

use crate::newton::increasing_root;

/// A band between two parallels in which the density is linear in theta, up to its weight.
#[derive(Clone, Copy, Debug)]
pub(super) struct Band {
    /// theta of the upper edge, and the extent below it.
    pub(super) top: f64,
    pub(super) extent: f64,
    /// The rows at the upper and lower edge; the second has the share t `slope` at t below `top`.
    pub(super) rows: [usize; 2],
    pub(super) slope: f64,
}

/// The mean over longitudes of the density in a band, times sin(theta):
///
/// ```text
/// g(t) = ((a + b t) w(theta) + c) sin(theta),   theta = top + t,   w = 1 or cos(theta)
/// ```
#[derive(Clone, Copy, Debug)]
pub(super) struct Profile {
    pub(super) top: f64,
    pub(super) extent: f64,
    pub(super) a: f64,
    pub(super) b: f64,
    pub(super) c: f64,
    pub(super) has_cosine: bool,
}

impl Profile {
    fn value(&self, t: f64) -> f64 {
        let theta = self.top + t;
        let weight = if self.has_cosine { theta.cos().max(0.0) } else { 1.0 };
        ((self.a + self.b * t) * weight + self.c) * theta.sin()
    }

    /// Returns the integral of g from 0 to t.
    pub(super) fn mass(&self, t: f64) -> f64 {
        let Self { top, a, b, c, .. } = *self;
        if self.has_cosine {
            // sin cos = sin(2 theta)/2, in the variable 2t.
            0.25 * sine_moment(2.0 * top, 2.0 * t, a, 0.5 * b) + sine_moment(top, t, c, 0.0)
        } else {
            sine_moment(top, t, a + c, b)
        }
    }

    /// Returns the t in [0, extent] with this mass.
    pub(super) fn inverse(&self, mass: f64) -> f64 {
        // The root for a density that is linear between the ends; at a pole it is nearly that.
        let (first, last) = (self.value(0.0), self.value(self.extent));
        let start = linear_root(first * self.extent, last * self.extent, mass) * self.extent;
        let start = if start.is_finite() { start } else { 0.5 * self.extent };
        increasing_root(self.extent, mass, start, |t| (self.mass(t), self.value(t)))
    }
}

/// Returns the x in [0, 1] with `int_0^x (l + (r - l) y) dy = mass`, for l and r not negative.
pub(super) fn linear_root(l: f64, r: f64, mass: f64) -> f64 {
    let root = (l * l + 2.0 * (r - l) * mass).max(0.0).sqrt();
    if mass <= 0.0 { 0.0 } else { (2.0 * mass / (l + root)).min(1.0) }
}

/// Returns `int_0^t (a + b x) sin(start + x) dx`, without cancellation for small t and at the
/// poles.
fn sine_moment(start: f64, t: f64, a: f64, b: f64) -> f64 {
    let half = 0.5 * t;
    let zeroth = 2.0 * half.sin() * (start + half).sin();
    if b == 0.0 {
        return a * zeroth;
    }
    let (sin, cos) = t.sin_cos();
    let versine = 2.0 * half.sin() * half.sin();
    let (sin_start, cos_start) = start.sin_cos();
    let first = sin_start * (t * sin - versine) + cos_start * sin_minus_t_cos(t, sin, cos);
    a * zeroth + b * first
}

/// Returns sin(t) - t cos(t), which is t^3/3 for small t.
fn sin_minus_t_cos(t: f64, sin: f64, cos: f64) -> f64 {
    if t.abs() > 0.5 {
        return sin - t * cos;
    }
    // The sum over k >= 1 of (-1)^(k+1) 2k/(2k+1)! t^(2k+1).
    let square = t * t;
    let mut term = t * square / 3.0;
    let mut sum = term;
    for k in 2..9 {
        let k = f64::from(k);
        term *= -square * k / ((k - 1.0) * 2.0 * k * (2.0 * k + 1.0));
        sum += term;
    }
    sum
}

/// The end of the hemisphere.
pub(super) const EQUATOR: f64 = FRAC_PI_2;

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::{Profile, linear_root, sine_moment};

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
            for t in [1e-9, 1e-4, 0.1, 0.49, 0.51, PI] {
                let t = f64::min(t, PI - start);
                for (a, b) in [(1.0, 0.0), (1.0, 2.0), (0.0, 1.0), (1.0, -1.0 / t)] {
                    let (fast, slow) = (sine_moment(start, t, a, b), quadrature(start, t, a, b));
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
                        let profile = Profile { top, extent: 0.3, a, b, c, has_cosine };
                        let mass = profile.mass(0.3);
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

    #[test]
    fn linear_densities_are_inverted() {
        for (l, r) in [(1.0, 1.0), (0.0, 2.0), (2.0, 0.0), (1e-20, 1e20), (1e20, 1e-20)] {
            for share in [0.0, 1e-12, 0.3, 0.999, 1.0] {
                let mass = share * 0.5 * (l + r);
                let x: f64 = linear_root(l, r, mass);
                let found = x * (l + 0.5 * (r - l) * x);
                assert!((found - mass).abs() <= 1e-15 * (l + r), "{l}, {r}, {share}: {x}");
            }
        }
        assert!(linear_root(0.0, 0.0, 0.0).abs() <= 0.0);
    }
}
