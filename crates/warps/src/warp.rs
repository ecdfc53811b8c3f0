use std::fmt::Debug;
use std::sync::Arc;

use glam::DVec3;

/// A map from the unit square to directions, or to points of the disk, with a known density.
///
/// For u uniform in [0, 1)^2 the image T(u) has the density p(T(u)) = 1/|det dT/du|, so
///
/// ```text
/// int f(x) dx = int_square G(u) du,   G(u) = f(T(u))/p(T(u)):
/// ```
///
/// importance sampling with density p is uniform sampling of the pulled-back integrand G. Every map
/// is a bijection between the square and its [`support`](Self::support), up to sets of measure 0.
///
/// # Examples
///
/// ```
/// use sphvar_warps::{CosineHemisphere, Warp};
///
/// let sample = CosineHemisphere.sample([0.3, 0.8]);
/// assert_eq!(sample.density, CosineHemisphere.density(sample.point));
/// let [u, v] = CosineHemisphere.inverse(sample.point).expect("in the support");
/// assert!((u - 0.3).abs() < 1e-15 && (v - 0.8).abs() < 1e-15);
/// ```
pub trait Warp: Debug + Send + Sync {
    /// Returns T(u) with its density. The density is that of the piece of the map that contains u,
    /// also where rounding moves T(u) across the edge of a texel.
    fn sample(&self, point: [f64; 2]) -> WarpSample;

    /// Returns T(u).
    fn map(&self, point: [f64; 2]) -> DVec3 {
        self.sample(point).point
    }

    /// Returns the density at a unit vector (or a point of the disk), per
    /// [`measure`](Self::measure); 0 outside the support.
    fn density(&self, point: DVec3) -> f64;

    /// Returns the point of [0, 1)^2 that maps to a unit vector (or a point of the disk), or `None`
    /// outside the support. Points on the boundary of the support count as inside, to rounding.
    fn inverse(&self, point: DVec3) -> Option<[f64; 2]>;

    /// Returns the measure of the density.
    fn measure(&self) -> Measure {
        Measure::SolidAngle
    }

    /// Returns the set where the density is positive: outside, an integrand is not sampled.
    fn support(&self) -> Support;

    /// Returns the infimum of the density over its support. |G| does not exceed max |f| divided by
    /// it; 0 states that f/p may be unbounded, and that p(T(u)) is 0 on a set of measure 0.
    fn min_density(&self) -> f64;

    /// Returns the values of u in (0, 1), ascending, at which G is not smooth for smooth f, for any
    /// v. The edges of the square are not listed.
    fn breaks_in_u(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Returns the values of v in (0, 1), ascending, at which v -> G(u, v) is not smooth for
    /// smooth f.
    fn breaks_in_v(&self, u: f64) -> Vec<f64> {
        let _ = u;
        Vec::new()
    }

    /// Replaces the content of `samples` by the samples of `points`, in their order.
    fn sample_into(&self, points: &[[f64; 2]], samples: &mut Vec<WarpSample>) {
        samples.clear();
        samples.extend(points.iter().map(|&point| self.sample(point)));
    }
}

impl<W: Warp + ?Sized> Warp for Arc<W> {
    fn sample(&self, point: [f64; 2]) -> WarpSample {
        (**self).sample(point)
    }

    fn map(&self, point: [f64; 2]) -> DVec3 {
        (**self).map(point)
    }

    fn density(&self, point: DVec3) -> f64 {
        (**self).density(point)
    }

    fn inverse(&self, point: DVec3) -> Option<[f64; 2]> {
        (**self).inverse(point)
    }

    fn measure(&self) -> Measure {
        (**self).measure()
    }

    fn support(&self) -> Support {
        (**self).support()
    }

    fn min_density(&self) -> f64 {
        (**self).min_density()
    }

    fn breaks_in_u(&self) -> Vec<f64> {
        (**self).breaks_in_u()
    }

    fn breaks_in_v(&self, u: f64) -> Vec<f64> {
        (**self).breaks_in_v(u)
    }

    fn sample_into(&self, points: &[[f64; 2]], samples: &mut Vec<WarpSample>) {
        (**self).sample_into(points, samples);
    }
}

/// The image of a point of the square with its density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WarpSample {
    /// The image: a unit vector, or a point (x, y, 0) of the disk.
    pub point: DVec3,
    /// The density at the image.
    pub density: f64,
}

/// The measure of a density.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// Steradians of directions.
    SolidAngle,
    /// The area of points (x, y, 0) of the unit disk.
    DiskArea,
}

/// The set where a density is positive, up to sets of measure 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Support {
    /// All directions.
    Sphere,
    /// All directions with z > 0, and no others.
    UpperHemisphere,
    /// Another set of directions, such as a cap or the positive texels of a map.
    Directions,
    /// The unit disk.
    Disk,
}
