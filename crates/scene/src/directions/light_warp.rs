use glam::DVec3;
use sphvar_warps::{SphericalRectangle, SphericalTriangle, Warp, WarpSample};

use crate::Quad;

/// The map from the square to the directions of a quadrilateral light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LightMap {
    /// [`SphericalRectangle`] where the light is a rectangle, otherwise [`Self::Triangles`].
    Automatic,
    /// Two [`SphericalTriangle`]s, of corners 0, 1, 2 and of corners 0, 2, 3. The first one has the
    /// points with u below its share of the solid angle.
    Triangles,
}

/// The uniform density on the solid angle of a light, seen from a point.
#[derive(Clone, Debug)]
pub(crate) struct LightWarp<'a> {
    light: &'a Quad,
    origin: DVec3,
    shape: Shape,
    solid_angle: f64,
}

#[derive(Clone, Debug)]
enum Shape {
    Rectangle(Box<SphericalRectangle>),
    Triangle(Box<SphericalTriangle>),
    /// Two triangles with the share of the first.
    Triangles(Box<[SphericalTriangle; 2]>, f64),
}

impl<'a> LightWarp<'a> {
    /// Returns the map from `origin`; `None` behind the light, in its plane, and where the solid
    /// angle rounds to 0: such points receive nothing.
    pub(crate) fn new(light: &'a Quad, map: LightMap, origin: DVec3) -> Option<Self> {
        let corners = light.corners().map(|corner| corner - origin);
        if corners[0].dot(light.normal()) >= 0.0 {
            return None;
        }
        let rectangle = match map {
            LightMap::Automatic => rectangle(light, corners[0]),
            LightMap::Triangles => None,
        };
        let shape = match rectangle {
            Some(rectangle) => Shape::Rectangle(Box::new(rectangle?)),
            None => triangles(corners)?,
        };
        let solid_angle = match &shape {
            Shape::Rectangle(rectangle) => rectangle.solid_angle(),
            Shape::Triangle(triangle) => triangle.solid_angle(),
            Shape::Triangles(both, _) => both.iter().map(SphericalTriangle::solid_angle).sum(),
        };
        Some(Self { light, origin, shape, solid_angle })
    }

    pub(crate) fn sample(&self, [u, v]: [f64; 2]) -> WarpSample {
        let point = match &self.shape {
            Shape::Rectangle(rectangle) => rectangle.map([u, v]),
            Shape::Triangle(triangle) => triangle.map([u, v]),
            Shape::Triangles(both, share) if u < *share => both[0].map([u / share, v]),
            Shape::Triangles(both, share) => both[1].map([(u - share) / (1.0 - share), v]),
        };
        WarpSample { point, density: 1.0 / self.solid_angle }
    }

    pub(crate) fn density(&self, dir: DVec3) -> f64 {
        let is_hit = self.light.intersect(self.origin, dir).is_some();
        if is_hit { 1.0 / self.solid_angle } else { 0.0 }
    }
}

/// Returns the light as a rectangle with its first corner at `corner`; `None` if it is no rectangle,
/// `Some(None)` if its solid angle rounds to 0.
fn rectangle(light: &Quad, corner: DVec3) -> Option<Option<SphericalRectangle>> {
    /// The limit of [`SphericalRectangle`] on the cosine between its edges.
    const PERPENDICULAR: f64 = 1e-9;
    let [a, b, c, d] = light.corners();
    let (u, v) = (b - a, d - a);
    let is_right = u.dot(v).abs() <= PERPENDICULAR * u.length() * v.length();
    let is_closed = (c - b - v).length() <= PERPENDICULAR * (u.length() + v.length());
    (is_right && is_closed).then(|| SphericalRectangle::new(corner, u, v).ok())
}

/// Returns the triangles with a solid angle; `None` if there are none.
fn triangles([a, b, c, d]: [DVec3; 4]) -> Option<Shape> {
    let [first, second] = [[a, b, c], [a, c, d]].map(|t| SphericalTriangle::new(t).ok());
    match (first, second) {
        (Some(first), Some(second)) => {
            let share = first.solid_angle() / (first.solid_angle() + second.solid_angle());
            Some(Shape::Triangles(Box::new([first, second]), share))
        }
        (first, second) => first.or(second).map(|one| Shape::Triangle(Box::new(one))),
    }
}
