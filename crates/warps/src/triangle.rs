use std::f64::consts::PI;

use glam::DVec3;

use crate::polar::half_open;
use crate::{Error, Support, Warp, WarpSample};

/// Rounding error of the distance of a direction from a great circle, for tests of boundaries.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Uniform directions of a spherical triangle with vertices A, B and C.
///
/// u selects the point D on the arc AC for which the triangle ABD has the fraction u of the solid
/// angle E, v a point on the arc BD:
///
/// ```text
/// tan(AD/2) = (1 + A.B) sin(s)/(k cos(s) - (B.T) sin(s)),   s = u E/2,   k = |T.(A x B)|
/// 1 - B.P = v (1 - B.D),   p = 1/E
/// ```
///
/// where T is the tangent at A towards C. This is Arvo's map in half angles and differences of
/// vertices, which do not cancel for small triangles; E follows from Van Oosterom and Strackee's
/// formula. The edge v = 0 collapses to B.
///
/// Round trips are accurate to about 2e-16 divided by the smallest height of the triangle, the
/// rounding error of directions relative to it; the density has the accuracy of the vertices, a
/// relative 2e-16 divided by the smallest height, or by 2 pi - E.
///
/// # Examples
///
/// ```
/// use std::f64::consts::FRAC_PI_2;
/// use sphvar_warps::{SphericalTriangle, Warp};
///
/// let octant = SphericalTriangle::OCTANT;
/// assert!((octant.solid_angle() - FRAC_PI_2).abs() < 1e-15);
/// assert!(octant.map([0.5, 0.5]).min_element() > 0.0);
/// ```
///
/// # References
///
/// Arvo 1995, "Stratified sampling of spherical triangles"; Van Oosterom and Strackee 1983.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphericalTriangle {
    a: DVec3,
    b: DVec3,
    /// The unit tangent at A towards C.
    tangent: DVec3,
    /// B - A.
    ab: DVec3,
    /// The unit or near-unit normals of the sides, all pointing inside.
    sides: [DVec3; 3],
    /// A x B and T x B, with the sign that makes them positive inside.
    a_cross_b: DVec3,
    tangent_cross_b: DVec3,
    one_plus_cos: f64,
    k: f64,
    b_tangent: f64,
    /// E/2, and pi - E/2, which keeps its digits where E is near 2 pi.
    half: f64,
    complement: f64,
}

impl SphericalTriangle {
    /// The first octant, with A = x, B = z and C = y, the orthogonal triangle of Dimov, Penzov and
    /// Stoilova 2007: 1 - z = v, phi = pi/2 u.
    pub const OCTANT: Self = Self {
        a: DVec3::X,
        b: DVec3::Z,
        tangent: DVec3::Y,
        ab: DVec3::new(-1.0, 0.0, 1.0),
        sides: [DVec3::Y, DVec3::X, DVec3::Z],
        a_cross_b: DVec3::Y,
        tangent_cross_b: DVec3::NEG_X,
        one_plus_cos: 1.0,
        k: 1.0,
        b_tangent: 0.0,
        half: PI / 4.0,
        complement: 0.75 * PI,
    };

    /// Returns the triangle of three directions, which need not be unit vectors, in either
    /// orientation. Its sides are the shorter arcs, so its solid angle is less than 2 pi.
    ///
    /// # Errors
    ///
    /// [`Error::Degenerate`] if vertices are 0 or not finite, antipodal, or on one great circle.
    pub fn new(vertices: [DVec3; 3]) -> Result<Self, Error> {
        let degenerate =
            |requirement| Error::Degenerate { shape: "a spherical triangle", requirement };
        let unit = |x: DVec3| (x / x.abs().max_element()).try_normalize();
        let [Some(a), Some(b), Some(c)] = vertices.map(unit) else {
            return Err(degenerate("vertices of finite length other than 0"));
        };
        let (ab, bc, ca) = (b - a, c - b, a - c);
        let opposite = |x: DVec3, y: DVec3| (x + y).length_squared() < f64::EPSILON * f64::EPSILON;
        if opposite(a, b) || opposite(b, c) || opposite(c, a) {
            return Err(degenerate("no antipodal vertices: the arc between them is not unique"));
        }
        let signed = a.dot(cross(ab, -ca));
        let sign = 1.0f64.copysign(signed);
        let positive = "a positive solid angle: the vertices are on one great circle";
        // The tangent at A is the part of C - A perpendicular to A.
        let chord = -ca + a * (0.5 * ca.length_squared());
        let Some(tangent) = chord.try_normalize() else { return Err(degenerate(positive)) };
        let a_cross_b = sign * cross(a, ab);
        let k = tangent.dot(a_cross_b);
        let triple = signed.abs();
        if !(triple > 0.0 && k > 0.0) {
            return Err(degenerate(positive));
        }
        // 1 + A.B + B.C + C.A, with the products as differences from 1.
        let squares = ab.length_squared() + bc.length_squared() + ca.length_squared();
        let denominator = 4.0 - 0.5 * squares;
        let (half, complement) = if denominator >= 0.0 {
            let half = triple.atan2(denominator);
            (half, PI - half)
        } else {
            let complement = triple.atan2(-denominator);
            (PI - complement, complement)
        };
        let side = |x: DVec3, edge: DVec3| sign * cross(x, edge).normalize_or_zero();
        Ok(Self {
            a,
            b,
            tangent,
            ab,
            sides: [side(a, ab), side(b, bc), side(c, ca)],
            a_cross_b,
            tangent_cross_b: sign * cross(tangent, b),
            one_plus_cos: 0.5 * (a + b).length_squared(),
            k,
            b_tangent: b.dot(tangent),
            half,
            complement,
        })
    }

    /// Returns the solid angle E, in (0, 2 pi).
    #[must_use]
    pub fn solid_angle(&self) -> f64 {
        2.0 * self.half
    }

    /// Returns the chord from B to D and its squared length, for tan(AD/2).
    fn chord_to_arc(&self, tan: f64) -> (DVec3, f64) {
        // sin and 1 - cos of AD.
        let (sin, drop) = if tan <= 1.0 {
            let scale = 2.0 / (1.0 + tan * tan);
            (tan * scale, tan * tan * scale)
        } else {
            let cot = 1.0 / tan;
            let scale = 2.0 / (1.0 + cot * cot);
            (cot * scale, scale)
        };
        let chord = self.tangent * sin - self.a * drop - self.ab;
        (chord, chord.length_squared())
    }

    fn contains(&self, dir: DVec3) -> bool {
        self.sides.iter().all(|side| side.dot(dir) >= -ROUNDING)
    }
}

/// Returns x cross y with products accurate to twice the precision: those of the nearly parallel
/// sides of slivers cancel.
fn cross(x: DVec3, y: DVec3) -> DVec3 {
    let difference = |a: f64, b: f64, c: f64, d: f64| {
        let product = c * d;
        let error = c.mul_add(d, -product);
        a.mul_add(b, -product) - error
    };
    DVec3::new(
        difference(x.y, y.z, x.z, y.y),
        difference(x.z, y.x, x.x, y.z),
        difference(x.x, y.y, x.y, y.x),
    )
}

impl Warp for SphericalTriangle {
    fn sample(&self, [u, v]: [f64; 2]) -> WarpSample {
        let s = u * self.half;
        // Beyond pi/2, sin and cos of the supplement keep the digits of angles near pi.
        let (sin, cos) = if s <= 0.5 * PI {
            s.sin_cos()
        } else {
            let supplement = (1.0 - u) * PI + u * self.complement;
            let (sin, cos) = supplement.sin_cos();
            (sin, -cos)
        };
        let tan = self.one_plus_cos * sin / (self.k * cos - self.b_tangent * sin).max(0.0);
        let (chord, square) = self.chord_to_arc(tan);
        // 1 - B.D = |D - B|^2/2, and the direction at B towards D.
        let towards = (chord + self.b * (0.5 * square)).normalize_or_zero();
        // 1 - B.P and 1 + B.P; the second is small where D is nearly antipodal to B.
        let drop = v * 0.5 * square;
        let rise = 0.5 * ((chord + 2.0 * self.b).length_squared() + (1.0 - v) * square);
        let point = self.b - (self.b * drop - towards * (drop * rise).sqrt());
        // Rounding of `towards` grows where D is nearly antipodal to B.
        WarpSample { point: point.normalize(), density: 0.5 / self.half }
    }

    fn density(&self, dir: DVec3) -> f64 {
        if self.contains(dir) { 0.5 / self.half } else { 0.0 }
    }

    fn inverse(&self, dir: DVec3) -> Option<[f64; 2]> {
        if !self.contains(dir) {
            return None;
        }
        let offset = dir - self.b;
        // n = B x P is the normal of the arc BD, so tan(AD) = -n.A/n.T.
        let (x, y) = (-offset.dot(self.tangent_cross_b), offset.dot(self.a_cross_b).max(0.0));
        let length = x.hypot(y);
        if length == 0.0 {
            return Some([0.0, 0.0]);
        }
        let (sin, cos) = (y, length + x);
        // At AD = pi only the sum of length and x vanishes; D is then the antipode of A.
        let tan = if x >= 0.0 { sin / cos } else { (length - x) / sin };
        let (_, square) = self.chord_to_arc(tan);
        let (s, c) = (self.k * tan, self.one_plus_cos + self.b_tangent * tan);
        let u = if c >= 0.0 { s.atan2(c) / self.half } else { (PI - s.atan2(-c)) / self.half };
        Some([half_open(u), half_open(offset.length_squared() / square)])
    }

    fn support(&self) -> Support {
        Support::Directions
    }

    fn min_density(&self) -> f64 {
        0.5 / self.half
    }
}
