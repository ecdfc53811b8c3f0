//! Inner products of two-valued functions, with one value inside a circle or two opposite caps and
//! another outside, from areas of lenses.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;
use sphvar_sh::ByParity;

use crate::shape::angle_between;
use crate::{Circle, Integrand, Shape};

/// Caps smaller than this, in radians, use quadrature, because areas are differences of angles.
const SMALL: f64 = 0.1;

/// `jump` within `angle`, at most 90 degrees, of `axis`, plus a constant; an even function within
/// that of `-axis`, too.
#[derive(Clone, Copy)]
struct TwoValued {
    axis: DVec3,
    angle: f64,
    jump: f64,
    is_even: bool,
}

impl TwoValued {
    fn of(f: &dyn Integrand, shape: &Shape) -> Option<Self> {
        let axis = shape.axis().filter(|_| shape.degree() == 0)?;
        let cap = match shape.edges() {
            [edge] => {
                let jump = f.eval(edge.axis) - f.eval(-edge.axis);
                if edge.angle <= FRAC_PI_2 {
                    Self { axis: edge.axis, angle: edge.angle, jump, is_even: false }
                } else {
                    Self { axis: -edge.axis, angle: PI - edge.angle, jump: -jump, is_even: false }
                }
            }
            [edge, other]
                if shape.is_even()
                    && edge.angle <= FRAC_PI_2 - SMALL
                    && are_opposite(edge, other) =>
            {
                let jump = f.eval(edge.axis) - f.eval(axis.any_orthonormal_vector());
                Self { axis: edge.axis, angle: edge.angle, jump, is_even: true }
            }
            _ => return None,
        };
        (cap.angle >= SMALL).then_some(cap)
    }

    /// Returns the factors by which the even and the odd part of one cap occur in the function.
    fn copies(self) -> ByParity {
        if self.is_even { ByParity { even: 2.0, odd: 0.0 } } else { ByParity::both(1.0) }
    }

    fn area(self) -> f64 {
        4.0 * PI * (0.5 * self.angle).sin().powi(2)
    }
}

/// `int (F - mean F)(G - mean G)` over the sphere of the even and of the odd parts, if both
/// functions are constant on either side of one circle, or of two opposite ones, and their caps are
/// not small.
pub(super) fn centred_inner_product(
    (f, a): (&dyn Integrand, &Shape),
    (g, b): (&dyn Integrand, &Shape),
) -> Option<ByParity> {
    let (f, g) = (TwoValued::of(f, a)?, TwoValued::of(g, b)?);
    let gamma = angle_between(f.axis, g.axis);
    let (here, there) = (lens(f.angle, g.angle, gamma), lens(f.angle, g.angle, PI - gamma));
    let means = f.area() * g.area() / (4.0 * PI);
    let parts = ByParity { even: 0.5 * (here + there) - means, odd: 0.5 * (here - there) };
    let jumps = f.jump * g.jump;
    let (f, g) = (f.copies(), g.copies());
    Some(ByParity {
        even: jumps * f.even * g.even * parts.even,
        odd: jumps * f.odd * g.odd * parts.odd,
    })
}

fn are_opposite(a: &Circle, b: &Circle) -> bool {
    (a.axis + b.axis).length() + (a.angle - b.angle).abs() <= 4.0 * f64::EPSILON
}

/// Returns the area of the intersection of caps of angles a and b, at most 90 degrees, with axes at
/// the angle gamma.
///
/// The triangle of the axes and a corner of the lens has the sides a, b and gamma; its angles, by
/// their halves, give the sectors of which the lens and two triangles consist.
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
    use sphvar_sh::Domain;

    use super::centred_inner_product;
    use crate::{Cap, DoubleCap, Integrand, Product, Rotated};

    /// Against quadratures of the products, one cap being the sphere less its complement.
    #[test]
    fn lenses_are_the_intersections_of_caps() {
        for (a, b) in [(40.0, 40.0), (20.0, 70.0), (90.0, 90.0), (130.0, 60.0), (8.0, 175.0 - 90.0)]
        {
            for tilt in [0.0, 10.0, 35.0, 80.0, 90.0, 140.0, 180.0f64] {
                let f = Cap::from_degrees(a).unwrap();
                let other = Cap::from_degrees(b).unwrap();
                let rotation = |degrees: f64| DQuat::from_rotation_x(degrees.to_radians());
                let [near, far] =
                    [tilt, tilt + 180.0].map(|t| Rotated::new(other, rotation(t)).unwrap());
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

    /// Against quadratures of the products: of two double caps, and of one with a cap.
    #[test]
    fn lenses_of_double_caps_count_on_both_sides() {
        let sphere = Domain::Sphere;
        for (a, b) in [(40.0, 40.0), (20.0, 70.0), (80.0, 8.0), (30.0, 65.0)] {
            for tilt in [0.0, 10.0, 35.0, 80.0, 90.0, 140.0f64] {
                let rotation = DQuat::from_rotation_x(tilt.to_radians());
                let f = DoubleCap::from_degrees(a).unwrap();
                let g = Rotated::new(DoubleCap::from_degrees(b).unwrap(), rotation).unwrap();
                let cap = Rotated::new(Cap::from_degrees(b).unwrap(), rotation).unwrap();
                let check = |g: &dyn Integrand, product: f64| {
                    let got =
                        centred_inner_product((&f, &f.shape().unwrap()), (g, &g.shape().unwrap()));
                    let got = got.unwrap();
                    let means = f.exact(sphere).unwrap() * g.exact(sphere).unwrap() / sphere.area();
                    let even = product - means;
                    assert!((got.even - even).abs() < 1e-12, "{a}, {b}, {tilt}: {got:?}, {even}");
                    assert!(got.odd == 0.0, "{got:?}");
                };
                check(&g.clone(), Product::new(f, g).exact(sphere).unwrap());
                check(&cap.clone(), Product::new(f, cap).exact(sphere).unwrap());
            }
        }
        // Nearly all of the sphere, and small: not by lenses.
        for degrees in [87.0, 2.0] {
            let f = DoubleCap::from_degrees(degrees).unwrap();
            let shape = f.shape().unwrap();
            assert!(centred_inner_product((&f, &shape), (&f, &shape)).is_none(), "{degrees}");
        }
    }
}
