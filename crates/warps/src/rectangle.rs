use glam::{DMat3, DVec3};

use crate::newton::increasing_root;
use crate::polar::half_open;
use crate::{Error, Support, Warp, WarpSample};

/// Rounding error of the sine of an angle from a side, for tests of boundaries.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Uniform directions of the solid angle of a rectangle, seen from the origin.
///
/// In the frame of the rectangle its points are (x, y, z) with x in [x0, x1], y in [y0, y1] and z
/// fixed. About the y axis, with longitude alpha = atan(x/z) and height h(x, y) = y/sqrt(x^2 + y^2
/// + z^2), areas are d alpha dh, so the strip between x and the farther end x1 has the solid angle
///
/// ```text
/// F(alpha) = int_alpha^alpha1 (h(x, y1) - h(x, y0)) d alpha
/// ```
///
/// u selects alpha by the solid angle of the strip and v the height between h(x, y0) and h(x, y1).
/// This is the map of Urena, Fajardo and King, whose closed form loses all digits for small solid
/// angles. Here F is a sum over corners or, where these cancel, of two triangles (Van Oosterom and
/// Strackee 1983). Newton's iteration for alpha starts from the closed form where corners do not
/// cancel. F is accurate to a few roundings also for rectangles of 1e-12 steradian, or seen nearly
/// edge-on.
///
/// Round trips are accurate to about 1e-15 plus 2e-16 divided by the smallest angular extent.
///
/// # Examples
///
/// ```
/// use glam::DVec3;
/// use sphvar_warps::{SphericalRectangle, Warp};
///
/// // A face of a cube, from its centre.
/// let corner = DVec3::new(-1.0, -1.0, -1.0);
/// let face = SphericalRectangle::new(corner, 2.0 * DVec3::X, 2.0 * DVec3::Y)?;
/// assert!((face.solid_angle() - 4.0 * std::f64::consts::PI / 6.0).abs() < 1e-14);
/// # Ok::<(), sphvar_warps::Error>(())
/// ```
///
/// # References
///
/// Urena, Fajardo and King 2013, "An area-preserving parametrization for spherical rectangles".
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphericalRectangle {
    /// Columns: the axes of the frame.
    frame: DMat3,
    /// Ends with |x0| <= |x1| and x0 < x1, in units of the largest coordinate.
    x: [f64; 2],
    y: [f64; 2],
    z: f64,
    /// Whether x runs against the first edge.
    is_reversed: bool,
    /// alpha1 with its sin and cos.
    end: f64,
    sin_end: f64,
    cos_end: f64,
    /// alpha1 - alpha0.
    range: f64,
    /// Whether solid angles follow from corners, otherwise from triangles.
    has_corners: bool,
    /// The corners at x1, and the rounding error of sums of corners.
    corners_at_end: f64,
    rounding: f64,
    solid_angle: f64,
}

/// The ratio of corners to their sum at which rounding of the corners matters.
const MAX_CANCELLATION: f64 = 16.0;

impl SphericalRectangle {
    /// Returns the rectangle with a corner and the two edges that start there, relative to the
    /// point of view.
    ///
    /// # Errors
    ///
    /// [`Error::Degenerate`] unless the edges are finite, not 0 and perpendicular to 1e-9, and the
    /// point of view is outside the plane of the rectangle.
    pub fn new(corner: DVec3, edge_u: DVec3, edge_v: DVec3) -> Result<Self, Error> {
        let degenerate =
            |requirement| Error::Degenerate { shape: "a spherical rectangle", requirement };
        let scale = [corner, edge_u, edge_v].map(|x| x.abs().max_element());
        let scale = scale.into_iter().fold(0.0, f64::max);
        let [corner, edge_u, edge_v] = [corner, edge_u, edge_v].map(|x| x / scale);
        let unit = |x: DVec3| (x / x.abs().max_element()).try_normalize();
        let (true, Some(x_axis), Some(y_axis)) = (corner.is_finite(), unit(edge_u), unit(edge_v))
        else {
            return Err(degenerate("a finite corner and edges of finite length other than 0"));
        };
        if x_axis.dot(y_axis).abs() > 1e-9 {
            return Err(degenerate("perpendicular edges"));
        }
        let z_axis = x_axis.cross(y_axis).normalize();
        let y_axis = z_axis.cross(x_axis);
        let z = corner.dot(z_axis);
        let z_axis = if z < 0.0 { -z_axis } else { z_axis };
        let start = corner.dot(x_axis);
        let end = start + edge_u.length();
        let is_reversed = start.abs() > end.abs();
        let (x_axis, x) =
            if is_reversed { (-x_axis, [-end, -start]) } else { (x_axis, [start, end]) };
        let y = corner.dot(y_axis);
        let y = [y, y + edge_v.length()];
        let z = z.abs();
        let distance = x[1].hypot(z);
        let mut rectangle = Self {
            frame: DMat3::from_cols(x_axis, y_axis, z_axis),
            x,
            y,
            z,
            is_reversed,
            end: x[1].atan2(z),
            sin_end: x[1] / distance,
            cos_end: z / distance,
            range: ((x[1] - x[0]) * z).atan2(z * z + x[0] * x[1]),
            has_corners: false,
            corners_at_end: 0.0,
            rounding: 0.0,
            solid_angle: 0.0,
        };
        let corners = x.map(|x| rectangle.corners(x));
        let [sum_at_start, sum_at_end] = corners.map(|[low, high]| high - low);
        let magnitude = corners.iter().flatten().map(|corner| corner.abs()).sum::<f64>();
        rectangle.has_corners = magnitude <= MAX_CANCELLATION * (sum_at_end - sum_at_start);
        if rectangle.has_corners {
            rectangle.corners_at_end = sum_at_end;
            rectangle.rounding = 2.0 * f64::EPSILON * magnitude;
        }
        rectangle.solid_angle = rectangle.strip(x[0], x[1] - x[0]);
        if !(rectangle.solid_angle > 0.0 && rectangle.range > 0.0) {
            return Err(degenerate("a positive solid angle: it is not seen edge-on or as a point"));
        }
        Ok(rectangle)
    }

    /// Returns the solid angle, in (0, 2 pi).
    #[must_use]
    pub fn solid_angle(&self) -> f64 {
        self.solid_angle
    }

    /// Returns the solid angle of the strip from x to the far end, of this width.
    fn strip(&self, x: f64, width: f64) -> f64 {
        if self.has_corners {
            let [low, high] = self.corners(x);
            self.corners_at_end - (high - low)
        } else {
            self.sum_of_triangles(x, width)
        }
    }

    /// Returns the solid angles of the rectangles between the foot of the perpendicular and the
    /// corners at x, with signs.
    fn corners(&self, x: f64) -> [f64; 2] {
        let distance = x.hypot(self.z);
        self.y.map(|y| (x * y).atan2(self.z * distance.hypot(y)))
    }

    /// Returns the solid angle of the strip as the sum of two triangles.
    fn sum_of_triangles(&self, x: f64, width: f64) -> f64 {
        let [y0, y1] = self.y;
        let [near, far] = [x, self.x[1]].map(|x| [y0, y1].map(|y| DVec3::new(x, y, self.z)));
        let triple = self.z * width * (y1 - y0);
        let triangle = |a: DVec3, b: DVec3, c: DVec3| {
            let (la, lb, lc) = (a.length(), b.length(), c.length());
            let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
            2.0 * triple.atan2(denominator)
        };
        triangle(near[0], far[0], far[1]) + triangle(near[0], far[1], near[1])
    }

    /// Returns a longitude before the far end near that at which the strip has a solid angle.
    ///
    /// The corners of column x are asin(b sin(alpha)) with b = y/sqrt(y^2 + z^2); with their
    /// difference d, which is that at the far end minus the solid angle,
    ///
    /// ```text
    /// sin(alpha) = sin(d)/sqrt((b1 - b0)^2 + 4 b0 b1 sin(d/2)^2)
    /// ```
    fn estimate(&self, target: f64) -> f64 {
        if !self.has_corners {
            return target / self.solid_angle * self.range;
        }
        let [b0, b1] = self.y.map(|y| y / y.hypot(self.z));
        let d = self.corners_at_end - target;
        let half = (0.5 * d).sin();
        let sin = d.sin() / ((b1 - b0) * (b1 - b0) + 4.0 * b0 * b1 * half * half).sqrt();
        self.end - sin.clamp(-1.0, 1.0).asin()
    }

    /// Returns x and x1 - x at the longitude `delta` before the far end, and cos(alpha).
    fn column(&self, delta: f64) -> (f64, f64, f64) {
        let (sin, cos) = delta.sin_cos();
        // Both terms are positive near the far end, where cos(alpha) is smallest.
        let cos_alpha = self.cos_end * cos + self.sin_end * sin;
        let sin_alpha = self.sin_end * cos - self.cos_end * sin;
        let width = self.z * sin / (cos_alpha * self.cos_end);
        (self.z * sin_alpha / cos_alpha, width, cos_alpha)
    }

    /// Returns the heights of a column.
    fn heights(&self, cos_alpha: f64) -> Heights {
        let [y0, y1] = self.y;
        let r = self.z / cos_alpha;
        let (d0, d1) = (r.hypot(y0), r.hypot(y1));
        let sum = y1 * d0 + y0 * d1;
        // The difference of the products by their squares, where they have the same sign.
        let extent = if y0 * y1 > 0.0 {
            (y1 - y0) * (y1 + y0) * r * r / (sum * d0 * d1)
        } else {
            y1 / d1 - y0 / d0
        };
        // 1 - |y|/d.
        let gap = |y: f64, d: f64| r * r / (d * (d + y.abs()));
        let (low, high) = (y0 / d0, y1 / d1);
        Heights {
            low,
            extent,
            above_bottom: if y0 < 0.0 { gap(y0, d0) } else { 1.0 + low },
            below_top: if y1 > 0.0 { gap(y1, d1) } else { 1.0 - high },
        }
    }
}

/// The heights between h(x, y0) and h(x, y1), and the distances of these from -1 and 1.
struct Heights {
    low: f64,
    extent: f64,
    above_bottom: f64,
    below_top: f64,
}

impl Warp for SphericalRectangle {
    fn sample(&self, [u, v]: [f64; 2]) -> WarpSample {
        let share = if self.is_reversed { u } else { 1.0 - u };
        let target = share * self.solid_angle;
        let delta =
            increasing_root(self.range, target, self.rounding, self.estimate(target), |delta| {
                let (x, width, cos_alpha) = self.column(delta);
                (self.strip(x, width), self.heights(cos_alpha).extent)
            });
        let (_, _, cos_alpha) = self.column(delta);
        let sin_alpha = self.sin_end * delta.cos() - self.cos_end * delta.sin();
        let heights = self.heights(cos_alpha);
        let h = heights.low + v * heights.extent;
        let above = heights.above_bottom + v * heights.extent;
        let radius = (above * (heights.below_top + (1.0 - v) * heights.extent)).sqrt();
        let local = DVec3::new(radius * sin_alpha, h, radius * cos_alpha);
        WarpSample { point: self.frame * local, density: 1.0 / self.solid_angle }
    }

    fn density(&self, dir: DVec3) -> f64 {
        if self.inverse(dir).is_some() { 1.0 / self.solid_angle } else { 0.0 }
    }

    fn inverse(&self, dir: DVec3) -> Option<[f64; 2]> {
        let local = self.frame.transpose() * dir;
        let radius = local.x.hypot(local.z);
        // The angle from the far end, of either sign.
        let sin = self.sin_end * local.z - self.cos_end * local.x;
        let cos = self.cos_end * local.z + self.sin_end * local.x;
        let delta = sin.atan2(cos);
        let slack = ROUNDING / radius;
        if !(-slack..=self.range + slack).contains(&delta) {
            return None;
        }
        let (x, width, cos_alpha) = self.column(delta.clamp(0.0, self.range));
        let Heights { low, extent, .. } = self.heights(cos_alpha);
        let above = local.y - low;
        if !(-ROUNDING..=extent + ROUNDING).contains(&above) {
            return None;
        }
        let share = self.strip(x, width) / self.solid_angle;
        let u = if self.is_reversed { share } else { 1.0 - share };
        Some([half_open(u), half_open(above / extent)])
    }

    fn support(&self) -> Support {
        Support::Directions
    }

    fn min_density(&self) -> f64 {
        1.0 / self.solid_angle
    }
}
