use std::f64::consts::E;

use glam::DVec3;

/// The factor c of `c (1 - x.y)`, half the squared distance times c, whose logarithm has mean 0
/// over the sphere: products of any number of factors keep within the range of numbers.
pub(super) const UNIT_MEAN: f64 = E / 2.0;

/// Maximum number of Newton steps; from most candidates three suffice.
const MAX_STEPS: u32 = 4;

/// The last step in units of the first one's maximum: convergence is quadratic, so the distance
/// from the maximum after it is of the order of its square.
const CONVERGED: f64 = 1e-4;

/// Curvatures below this fraction of their mean absolute value are taken as 0: the maximum is a
/// curve, as after two antipodes.
const FLAT: f64 = 1e-6;

/// Returns the end of Newton's method for the logarithm of the product of distances from `points`,
/// started from `start`, where it is finite. No step is longer than `reach`, and none decreases the
/// product by more than rounding.
pub(super) fn local_maximum(points: &[DVec3], start: DVec3, reach: f64) -> DVec3 {
    let rounding = points.len() as f64 * f64::EPSILON;
    let mut here = Expansion::at(points, start);
    for _ in 0..MAX_STEPS {
        let end = here.newton_end(points.len(), reach);
        if end.distance(here.at) < CONVERGED * reach {
            return end;
        }
        let next = Expansion::at(points, end);
        if next.product >= here.product * (1.0 - rounding) {
            here = next;
        } else {
            break;
        }
    }
    here.at
}

/// The product of `c (1 - x.y)` over the points y, with the gradient and the Hessian of its
/// logarithm in the tangent plane at x.
struct Expansion {
    at: DVec3,
    axes: [DVec3; 2],
    product: f64,
    gradient: [f64; 2],
    /// The entries (1, 1), (1, 2) and (2, 2).
    hessian: [f64; 3],
}

impl Expansion {
    /// Along a tangent vector a, `log(1 - x.y)` has the derivative `-a.y/(1 - x.y)` and the second
    /// derivative `x.y/(1 - x.y) - (a.y/(1 - x.y))^2` of great circles.
    fn at(points: &[DVec3], at: DVec3) -> Self {
        let first = at.any_orthonormal_vector();
        let axes = [first, at.cross(first)];
        let (mut product, mut gradient, mut hessian) = (1.0, [0.0; 2], [0.0; 3]);
        for y in points {
            let cosine = at.dot(*y);
            let inverse = 1.0 / (1.0 - cosine);
            let [a, b] = axes.map(|axis| axis.dot(*y) * inverse);
            let radial = cosine * inverse;
            product *= UNIT_MEAN * (1.0 - cosine);
            gradient[0] -= a;
            gradient[1] -= b;
            hessian[0] += radial - a * a;
            hessian[1] -= a * b;
            hessian[2] += radial - b * b;
        }
        Self { at, axes, product, gradient, hessian }
    }

    /// Returns the end of an ascent step: along each principal axis the slope over the absolute
    /// curvature, none where the curvature is negligible.
    fn newton_end(&self, n_points: usize, reach: f64) -> DVec3 {
        let [aa, ab, bb] = self.hessian;
        let angle = 0.5 * (2.0 * ab).atan2(aa - bb);
        let (sin, cos) = angle.sin_cos();
        let [a, b] = self.axes;
        let mut step = DVec3::ZERO;
        for [c, s] in [[cos, sin], [-sin, cos]] {
            let curvature = c * c * aa + 2.0 * c * s * ab + s * s * bb;
            let slope = c * self.gradient[0] + s * self.gradient[1];
            if curvature.abs() > FLAT * n_points as f64 {
                step += (c * a + s * b) * (slope / curvature.abs());
            }
        }
        (self.at + step.clamp_length_max(reach)).normalize_or(self.at)
    }
}
