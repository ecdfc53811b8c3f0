//! Inner products of functions that are constant on either side of a circle, by areas of lenses.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;
use sphvar_sh::ByParity;

use crate::shape::angle_between;
use crate::{Integrand, Shape};

/// Caps smaller than this, in radians, go by quadrature: areas are differences of angles.
const SMALL: f64 = 0.1;

/// `jump` within `angle`, at most 90 degrees, of `axis`, plus a constant.
#[derive(Clone, Copy)]
struct TwoValued {
    axis: DVec3,
    angle: f64,
    jump: f64,
}

impl TwoValued {
    fn of(f: &dyn Integrand, shape: &Shape) -> Option<Self> {
        let [edge] = shape.edges() else {
            return None;
        };
        if shape.degree() > 0 || shape.axis().is_none() {
            return None;
        }
        let jump = f.eval(edge.axis) - f.eval(-edge.axis);
        let cap = if edge.angle <= FRAC_PI_2 {
            Self { axis: edge.axis, angle: edge.angle, jump }
        } else {
            Self { axis: -edge.axis, angle: PI - edge.angle, jump: -jump }
        };
        (cap.angle >= SMALL).then_some(cap)
    }

    fn area(self) -> f64 {
        4.0 * PI * (0.5 * self.angle).sin().powi(2)
    }
}

/// `int (F - mean F)(G - mean G)` over the sphere of the even and of the odd parts, if both functions are constant on
/// either side of one circle and their caps are not small.
pub(super) fn centred_inner_product(
    (f, a): (&dyn Integrand, &Shape),
    (g, b): (&dyn Integrand, &Shape),
) -> Option<ByParity> {
    let (f, g) = (TwoValued::of(f, a)?, TwoValued::of(g, b)?);
    let gamma = angle_between(f.axis, g.axis);
    let (here, there) = (lens(f.angle, g.angle, gamma), lens(f.angle, g.angle, PI - gamma));
    let means = f.area() * g.area() / (4.0 * PI);
    let parts = ByParity { even: 0.5 * (here + there) - means, odd: 0.5 * (here - there) };
    Some(parts.map(|x| f.jump * g.jump * x))
}

/// The area that caps of angles a and b, at most 90 degrees, have in common if their axes are gamma apart.
///
/// The triangle of the axes and a corner of the lens has the sides a, b and gamma; its angles, by their halves, give the
/// sectors of which the lens and two triangles consist.
fn lens(a: f64, b: f64, gamma: f64) -> f64 {
    if gamma <= (a - b).abs() {
        return 4.0 * PI * (0.5 * a.min(b)).sin().powi(2);
    }
    if gamma >= a + b {
        return 0.0;
    }
    let s = 0.5 * (a + b + gamma);
    let sines = [s, s - a, s - b, s - gamma].map(|x| x.sin().max(0.0));
    let angle = |x: f64, y: f64| 2.0 * x.sqrt().atan2(y.sqrt());
    let [whole, less_a, less_b, less_gamma] = sines;
    let corner = angle(less_a * less_b, whole * less_gamma);
    let at_a = angle(less_gamma * less_a, whole * less_b);
    let at_b = angle(less_gamma * less_b, whole * less_a);
    2.0 * (PI - corner - at_a * a.cos() - at_b * b.cos())
}

#[cfg(test)]
mod tests {
    use glam::DQuat;
    use sphvar_samplers::Domain;

    use super::centred_inner_product;
    use crate::{Cap, Integrand, Product, Rotated};

    /// Against quadratures of the products, one cap being the sphere less its complement.
    #[test]
    fn lenses_are_what_caps_share() {
        for (a, b) in [(40.0, 40.0), (20.0, 70.0), (90.0, 90.0), (130.0, 60.0), (8.0, 175.0 - 90.0)]
        {
            for tilt in [0.0, 10.0, 35.0, 80.0, 90.0, 140.0, 180.0f64] {
                let f = Cap::from_degrees(a).unwrap();
                let other = Cap::from_degrees(b).unwrap();
                let turn = |degrees: f64| DQuat::from_rotation_x(degrees.to_radians());
                let [near, far] =
                    [tilt, tilt + 180.0].map(|t| Rotated::new(other, turn(t)).unwrap());
                let got = centred_inner_product(
                    (&f, &f.shape().unwrap()),
                    (&near, &near.shape().unwrap()),
                );
                let got = got.unwrap();
                let sphere = Domain::Sphere;
                let means = f.exact(sphere).unwrap() * other.exact(sphere).unwrap() / sphere.area();
                let here = Product::new(f, near).exact(sphere).unwrap();
                let there = Product::new(f, far).exact(sphere).unwrap();
                let even = 0.5 * (here + there) - means;
                let odd = 0.5 * (here - there);
                // Quadratures of some thousand nodes.
                let near = |x: f64, y: f64| (x - y).abs() < 1e-12;
                assert!(
                    near(got.even, even) && near(got.odd, odd),
                    "{a}, {b}, {tilt}: {got:?}, {even}, {odd}"
                );
            }
        }
    }
}
