use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DMat3, DVec3};
use sphvar_sh::Colatitude;
use sphvar_sh::Domain;

/// Tolerance within which two axes are equal: a few roundings of a rotation.
const SAME_AXIS: f64 = 8.0 * f64::EPSILON;

/// The circle of all directions at an angle from an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circle {
    /// A unit vector.
    pub axis: DVec3,
    /// Radians, in [0, pi].
    pub angle: f64,
}

impl Circle {
    /// The equator of the coordinate system.
    pub(crate) const EQUATOR: Self = Self { axis: DVec3::Z, angle: FRAC_PI_2 };

    /// Returns whether two circles are equal to rounding; that of angle t about an axis is that of
    /// pi - t about its opposite.
    fn is_same(&self, other: &Self) -> bool {
        coaxial(self.axis, other.axis).is_some_and(|sign| {
            let angle = if sign > 0.0 { other.angle } else { PI - other.angle };
            (self.angle - angle).abs() <= 4.0 * f64::EPSILON
        })
    }

    /// Returns the circle after a rotation.
    fn rotated(self, rotation: DMat3) -> Self {
        Self { axis: rotation * self.axis, ..self }
    }
}

/// The edges of a function and its degree elsewhere, as required by a quadrature.
///
/// The [`edges`](Self::with_edge) divide the sphere; between them the function is as smooth as a
/// polynomial of some degree. Integral, coefficients and square follow from the shape by
/// quadrature.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    degree: usize,
    edges: Vec<Circle>,
    axis: Option<DVec3>,
    support: Option<Circle>,
    fractional: bool,
    even: bool,
    cost: f64,
}

/// The relation of a function to its even extension from the hemisphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fold {
    /// The domain is the sphere.
    Whole,
    /// `F(-x) = F(x)`: the function is its own even extension.
    Even,
    /// The function vanishes below the equator, its even extension is `f(x) + f(-x)`.
    Above,
    /// The equator cuts it.
    Cut,
}

impl Shape {
    /// Returns a function that is a polynomial of degree `degree` in x, y and z, to rounding,
    /// everywhere.
    #[must_use]
    pub fn smooth(degree: usize) -> Self {
        Self {
            degree,
            edges: vec![],
            axis: None,
            support: None,
            fractional: false,
            even: false,
            cost: 1.0,
        }
    }

    /// Adds a circle across which values or derivatives may jump.
    #[must_use]
    pub fn with_edge(mut self, edge: Circle) -> Self {
        self.edges.push(edge);
        self
    }

    /// Declares edges near which the function is a non-integer power of the distance.
    #[must_use]
    pub fn with_fractional_edges(mut self) -> Self {
        self.fractional = true;
        self
    }

    /// Declares a function of the angle from `axis` alone.
    #[must_use]
    pub fn zonal(mut self, axis: DVec3) -> Self {
        self.axis = Some(axis);
        self
    }

    /// Declares a function that is zero, to rounding, outside a circle.
    #[must_use]
    pub fn within(mut self, support: Circle) -> Self {
        self.support = Some(support);
        self
    }

    /// Declares a function with `f(-x) = f(x)`.
    #[must_use]
    pub fn even(mut self) -> Self {
        self.even = true;
        self
    }

    /// Declares the cost of a value relative to that of a simple function, some 20 ns.
    #[must_use]
    pub fn with_cost(mut self, cost: f64) -> Self {
        self.cost = cost;
        self
    }

    /// Returns the degree of the smooth pieces.
    #[must_use]
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Returns the circles across which the function is not smooth.
    #[must_use]
    pub fn edges(&self) -> &[Circle] {
        &self.edges
    }

    /// Returns the axis of a zonal function.
    #[must_use]
    pub fn axis(&self) -> Option<DVec3> {
        self.axis
    }

    /// See [`Integrand::feature_degree`](crate::Integrand::feature_degree); the narrowest features
    /// are those of the degree or the smallest circle.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "not negative; an infinite degree saturates"
    )]
    pub(crate) fn feature_degree(&self) -> usize {
        let narrowest = self.edges.iter().map(|edge| edge.angle.sin()).fold(1.0, f64::min);
        self.degree.max((TAU / narrowest.max(0.0)) as usize)
    }

    pub(crate) fn support(&self) -> Option<Circle> {
        self.support
    }

    pub(crate) fn is_even(&self) -> bool {
        self.even
    }

    pub(crate) fn cost(&self) -> f64 {
        self.cost
    }

    /// Returns the shape of `f(-x)`.
    pub(crate) fn mirrored(&self) -> Self {
        let mirror = |c: &Circle| Circle { axis: -c.axis, ..*c };
        Self {
            edges: self.edges.iter().map(mirror).collect(),
            support: self.support.as_ref().map(mirror),
            ..self.clone()
        }
    }

    /// Returns the shape of the even and the odd part of a function.
    pub(crate) fn symmetrized(&self) -> Self {
        let both = self.sum(&self.mirrored());
        Self { support: None, ..both }
    }

    pub(crate) fn is_fractional(&self) -> bool {
        self.fractional
    }

    /// Returns the shape after a rotation.
    #[must_use]
    pub fn rotated(&self, rotation: DMat3) -> Self {
        Self {
            edges: self.edges.iter().map(|e| e.rotated(rotation)).collect(),
            axis: self.axis.map(|a| rotation * a),
            support: self.support.map(|s| s.rotated(rotation)),
            ..*self
        }
    }

    /// Returns the shape of the product of two functions.
    #[must_use]
    pub fn product(&self, other: &Self) -> Self {
        let narrower = [self.support, other.support].into_iter().flatten();
        let support = narrower.min_by(|a, b| a.angle.total_cmp(&b.angle));
        Self { support, degree: self.degree + other.degree, ..self.joined(other) }
    }

    /// Returns the shape of the sum of two functions.
    #[must_use]
    pub fn sum(&self, other: &Self) -> Self {
        let support = self.support.filter(|s| other.support == Some(*s));
        Self { support, degree: self.degree.max(other.degree), ..self.joined(other) }
    }

    fn joined(&self, other: &Self) -> Self {
        let mut edges = self.edges.clone();
        edges.extend(other.edges.iter().filter(|e| !self.edges.iter().any(|own| own.is_same(e))));
        Self {
            edges,
            axis: self.axis.filter(|&a| other.axis.is_some_and(|b| coaxial(a, b).is_some())),
            fractional: self.fractional || other.fractional,
            even: self.even && other.even,
            cost: self.cost + other.cost,
            ..self.clone()
        }
    }

    /// The part of the function on the domain.
    pub(crate) fn fold(&self, domain: Domain) -> Fold {
        if domain == Domain::Sphere {
            return Fold::Whole;
        }
        let above = |s: Circle| angle_between(s.axis, DVec3::Z) + s.angle <= FRAC_PI_2;
        match self.support {
            _ if self.even => Fold::Even,
            Some(support) if above(support) => Fold::Above,
            _ => Fold::Cut,
        }
    }

    /// Returns whether the even extension (the function itself on the sphere) is smooth, so that it
    /// has no coefficients beyond its degree.
    pub(crate) fn is_band_limited(&self, domain: Domain) -> bool {
        self.edges.is_empty() && self.fold(domain) != Fold::Cut
    }

    /// Returns whether two functions are nowhere both more than rounding.
    pub(crate) fn is_apart_from(&self, other: &Self) -> bool {
        let (Some(a), Some(b)) = (self.support, other.support) else {
            return false;
        };
        angle_between(a.axis, b.axis) > a.angle + b.angle
    }
}

/// Returns the angle between two unit vectors, with all digits for small ones and those near pi.
pub(crate) fn angle_between(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b)).clamp(0.0, PI)
}

/// Returns the angle between two unit vectors in the form that Legendre functions take.
pub(crate) fn colatitude_between(a: DVec3, b: DVec3) -> Colatitude {
    Colatitude::from_direction(DVec3::new(a.cross(b).length(), 0.0, a.dot(b)))
}

/// Returns whether two unit vectors lie on one line, and then 1 if they agree and -1 if they are
/// antipodes.
pub(crate) fn coaxial(a: DVec3, b: DVec3) -> Option<f64> {
    (a.cross(b).length() <= SAME_AXIS).then(|| a.dot(b).signum())
}
