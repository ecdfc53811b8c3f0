use glam::DVec3;
use pulp::{Arch, NullaryFnOnce};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

use super::distance::{Precision, squared_angle, stretch};
use crate::tessellation::{LANES, MassSpace, Moments, largest};

/// Regions with mean vectors shorter than this have no meaningful tangent plane.
const SHORTEST_MEAN: f64 = 0.2;

/// Directions, or directions up to sign, whose mass points are assigned to sites by geodesic
/// distance. [`MassSpace::distance`] is the chord, or the smaller of two up to sign.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Directions {
    pub(crate) antipodal: bool,
}

/// The coordinates of mass points.
type Block<'a> = [&'a [f64]; 3];

impl MassSpace<3> for Directions {
    type Point = DVec3;

    const AREA: f64 = 4.0 * std::f64::consts::PI;
    const DIAMETER: f64 = 2.0;
    const TOLERANCE: f64 = 1e-11;
    /// A few roundings of `2 - 2 cos d`.
    const ROUNDING: f64 = 2e-15;

    #[inline(always)]
    fn coordinates(point: DVec3) -> [f64; 3] {
        point.to_array()
    }

    #[inline(always)]
    fn point(coordinates: [f64; 3]) -> DVec3 {
        DVec3::from_array(coordinates)
    }

    #[inline(always)]
    fn distance(self, a: DVec3, b: DVec3) -> f64 {
        let square = a.distance_squared(b);
        if self.antipodal { square.min((a + b).length_squared()).sqrt() } else { square.sqrt() }
    }

    fn middle(self, sites: &[DVec3]) -> DVec3 {
        let mut sum = sites[0];
        for &s in &sites[1..] {
            sum += if self.antipodal && s.dot(sum) < 0.0 { -s } else { s };
        }
        sum / sites.len() as f64
    }

    fn start(self, cell: &[DVec3]) -> DVec3 {
        // If the points cancel, as few points can, they have no mean; the first point is the
        // start.
        cell.iter().sum::<DVec3>().try_normalize().unwrap_or(cell[0])
    }

    /// Returns the exponential of the step.
    fn moved(self, site: DVec3, step: DVec3) -> DVec3 {
        let length = step.length();
        let (sin, cos) = length.sin_cos();
        (site * cos + step * (sin / length)).normalize()
    }

    fn random_point(self, rng: &mut dyn Rng) -> DVec3 {
        random_direction(rng)
    }

    /// Moves points up to sign to one side of a random plane.
    fn prepare(self, points: &mut [DVec3], rng: &mut dyn Rng) {
        if self.antipodal {
            let up = random_direction(rng);
            for p in points {
                if p.dot(up) < 0.0 {
                    *p = -*p;
                }
            }
        }
    }

    /// Returns a uniform direction of the tangent plane at the mean, or any direction for a region
    /// as large as the sphere.
    fn cut(self, mean: DVec3, rng: &mut dyn Rng) -> DVec3 {
        let direction = random_direction(rng);
        if mean.length() < SHORTEST_MEAN {
            return direction;
        }
        // Any positive multiple of the direction gives the same order; even the zero vector gives a
        // valid one.
        let normal = mean.normalize();
        direction - direction.dot(normal) * normal
    }

    fn reductions_into(
        self,
        arch: Arch,
        block: Block<'_>,
        own: DVec3,
        other: DVec3,
        max_square: f64,
        reductions: &mut [f64],
    ) -> f64 {
        let kernel = Reductions { block, own, other, reductions };
        self.dispatch(arch, kernel, max_square)
    }

    fn moments(self, arch: Arch, block: Block<'_>, site: DVec3, max_square: f64) -> Moments<DVec3> {
        let mut moments = self.dispatch(arch, Sums { block, site }, max_square);
        moments.sum = moments.sum - moments.sum.dot(site) * site;
        moments
    }
}

impl Directions {
    fn dispatch<K: Kernel>(self, arch: Arch, kernel: K, max_square: f64) -> K::Output {
        let precision = Precision::up_to(max_square);
        arch.dispatch(Dispatch { kernel, antipodal: self.antipodal, precision })
    }
}

/// Computes the reduction of the energy for moving each point from its `own` site to the `other`
/// one.
struct Reductions<'a> {
    block: Block<'a>,
    own: DVec3,
    other: DVec3,
    reductions: &'a mut [f64],
}

/// Sums the projected logarithms `(d/sin d) p` of the points, apart from their part along the site.
struct Sums<'a> {
    block: Block<'a>,
    site: DVec3,
}

/// A kernel for any number of terms, on vectors or on vectors up to sign.
trait Kernel {
    type Output;
    fn run<const TERMS: usize, const LINES: bool>(self) -> Self::Output;
}

/// A kernel with its parameters, dispatched to the widest registers of the machine.
struct Dispatch<K> {
    kernel: K,
    antipodal: bool,
    precision: Precision,
}

impl<K: Kernel> NullaryFnOnce for Dispatch<K> {
    type Output = K::Output;

    #[inline(always)]
    fn call(self) -> K::Output {
        let Self { kernel, antipodal, precision } = self;
        match (precision, antipodal) {
            (Precision::Four, false) => kernel.run::<4, false>(),
            (Precision::Six, false) => kernel.run::<6, false>(),
            (Precision::Ten, false) => kernel.run::<10, false>(),
            (Precision::Twenty, false) => kernel.run::<20, false>(),
            (Precision::Arcsine, false) => kernel.run::<0, false>(),
            (Precision::Four, true) => kernel.run::<4, true>(),
            (Precision::Six, true) => kernel.run::<6, true>(),
            (Precision::Ten, true) => kernel.run::<10, true>(),
            (Precision::Twenty, true) => kernel.run::<20, true>(),
            (Precision::Arcsine, true) => kernel.run::<0, true>(),
        }
    }
}

impl Kernel for Reductions<'_> {
    type Output = f64;

    #[inline(always)]
    fn run<const TERMS: usize, const LINES: bool>(self) -> f64 {
        let Self { block: [xs, ys, zs], own, other, reductions } = self;
        let squared = |site: DVec3, x: f64, y: f64, z: f64| {
            squared_angle::<TERMS>(squared_chord::<LINES>(site, x, y, z).0)
        };
        // The sites are processed one after the other: in a joint loop the compiler would vectorize
        // over the two sites instead of over the points.
        for (((&x, &y), &z), reduction) in xs.iter().zip(ys).zip(zs).zip(&mut *reductions) {
            *reduction = squared(own, x, y, z);
        }
        for (((&x, &y), &z), reduction) in xs.iter().zip(ys).zip(zs).zip(&mut *reductions) {
            *reduction -= squared(other, x, y, z);
        }
        largest(reductions)
    }
}

impl Kernel for Sums<'_> {
    type Output = Moments<DVec3>;

    #[inline(always)]
    fn run<const TERMS: usize, const LINES: bool>(self) -> Moments<DVec3> {
        let Self { block: [x, y, z], site } = self;
        let [mut sx, mut sy, mut sz] = [[0.0; LANES]; 3];
        let [mut max_square, mut energy] = [[0.0; LANES]; 2];
        let mut add = |lane: usize, x: f64, y: f64, z: f64| {
            let (c, sign) = squared_chord::<LINES>(site, x, y, z);
            let weight = stretch::<TERMS>(c) * sign;
            sx[lane] += weight * x;
            sy[lane] += weight * y;
            sz[lane] += weight * z;
            energy[lane] += squared_angle::<TERMS>(c);
            max_square[lane] = if c > max_square[lane] { c } else { max_square[lane] };
        };
        let (xs, x_rest) = x.as_chunks::<LANES>();
        let (ys, y_rest) = y.as_chunks::<LANES>();
        let (zs, z_rest) = z.as_chunks::<LANES>();
        for ((x, y), z) in xs.iter().zip(ys).zip(zs) {
            for k in 0..LANES {
                add(k, x[k], y[k], z[k]);
            }
        }
        for (k, ((&x, &y), &z)) in x_rest.iter().zip(y_rest).zip(z_rest).enumerate() {
            add(k, x, y, z);
        }
        let total = |lanes: [f64; LANES]| lanes.into_iter().sum::<f64>();
        Moments {
            sum: DVec3::new(total(sx), total(sy), total(sz)),
            max_square: max_square.into_iter().fold(0.0, f64::max),
            energy: total(energy),
        }
    }
}

/// Returns the squared chord from a site to a point, or to the nearer of the point and its
/// antipode, and the sign of the nearer one.
#[inline(always)]
fn squared_chord<const LINES: bool>(site: DVec3, x: f64, y: f64, z: f64) -> (f64, f64) {
    let dot = site.x * x + site.y * y + site.z * z;
    if LINES {
        (2.0 - 2.0 * dot.abs(), if dot < 0.0 { -1.0 } else { 1.0 })
    } else {
        (2.0 - 2.0 * dot, 1.0)
    }
}

/// Returns a uniform direction.
fn random_direction(rng: &mut dyn Rng) -> DVec3 {
    loop {
        let mut normal = || -> f64 { StandardNormal.sample(&mut *rng) };
        let v = DVec3::new(normal(), normal(), normal());
        // A vector this short (probability 1e-19) would lose digits when normalised.
        if v.length_squared() > 1e-12 {
            return v.normalize();
        }
    }
}

#[cfg(test)]
mod tests {
    use pulp::Arch;

    use super::{DVec3, Directions, random_direction};
    use crate::tessellation::{MassSpace, divide};
    use crate::{Domain, Purpose, Sampler, Streams, WhiteNoise, uniform_rotation};

    /// Returns the angle between two directions, or between two directions up to sign.
    fn angle(antipodal: bool, a: DVec3, b: DVec3) -> f64 {
        let angle = a.cross(b).length().atan2(a.dot(b));
        if antipodal { angle.min(std::f64::consts::PI - angle) } else { angle }
    }

    #[test]
    fn reductions_and_moments_match_the_definition() {
        let mut rng = Streams::new(4, Purpose::Pattern, 0).realization(0);
        for (n, spread) in [(1, 0.01), (8, 0.03), (17, 0.1), (64, 0.3), (65, 0.5), (30, 10.0)] {
            for antipodal in [false, true] {
                let around = uniform_rotation(&mut rng).x_axis;
                let mut near = || {
                    let away =
                        WhiteNoise::new(1, Domain::Sphere).sample(&mut rng).unwrap().points[0];
                    (around + spread * away).normalize()
                };
                let [own, other] = [near(), near()];
                let points: Vec<DVec3> = (0..n)
                    .map(|k| if antipodal && k % 3 == 0 { -near() } else { near() })
                    .collect();
                let column = |of: fn(&DVec3) -> f64| points.iter().map(of).collect::<Vec<_>>();
                let (x, y, z) = (column(|p| p.x), column(|p| p.y), column(|p| p.z));
                let block = [&*x, &*y, &*z];
                let space = Directions { antipodal };
                let squares = |site| points.iter().map(move |&p| angle(antipodal, site, p).powi(2));
                let bound = |site: DVec3| {
                    squares(site)
                        .map(|d2| (2.0 * (0.5 * d2.sqrt()).sin()).powi(2))
                        .fold(0.0, f64::max)
                };
                let max_square = bound(own).max(bound(other));

                let mut reductions = vec![f64::NAN; n];
                let best = space.reductions_into(
                    Arch::new(),
                    block,
                    own,
                    other,
                    max_square,
                    &mut reductions,
                );
                // The error 1e-13 of the series and a few roundings of 2 - 2 cos d, more near
                // antipodes.
                let tolerance = if spread > 1.0 { 1e-12 } else { 1e-13 * max_square + 1e-14 };
                for (k, (from, to)) in squares(own).zip(squares(other)).enumerate() {
                    let off = (reductions[k] - (from - to)).abs();
                    assert!(off < tolerance, "point {k} of {n}, spread {spread}: off by {off}");
                }
                let largest = reductions.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                assert_eq!(best.to_bits(), largest.to_bits(), "{best} is not {largest}");
                let mut narrow = vec![f64::NAN; n];
                space.reductions_into(Arch::Scalar, block, own, other, max_square, &mut narrow);
                assert_eq!(reductions, narrow, "the bits depend on the width of registers");

                let moments = space.moments(Arch::new(), block, own, max_square);
                assert!((moments.max_square - bound(own)).abs() < 1e-15 + 1e-12 * max_square);
                let narrow = space.moments(Arch::Scalar, block, own, max_square);
                assert_eq!((moments.sum, moments.energy), (narrow.sum, narrow.energy));
                let energy: f64 = squares(own).sum();
                assert!((moments.energy - energy).abs() < n as f64 * tolerance);
                let tangent = |v: DVec3| v - v.dot(own) * own;
                let logarithms: DVec3 = points
                    .iter()
                    .map(|&p| if antipodal && p.dot(own) < 0.0 { -p } else { p })
                    .map(|p| tangent(p).normalize_or_zero() * angle(antipodal, own, p))
                    .sum();
                let off = (tangent(moments.sum) - logarithms).length();
                let tolerance = if spread > 1.0 { 1e-9 } else { 1e-12 * n as f64 };
                assert!(off < tolerance, "logarithms of {n}, spread {spread}: off by {off}");
            }
        }
    }

    #[test]
    fn the_order_is_a_permutation_into_compact_groups() {
        let mut rng = Streams::new(5, Purpose::Pattern, 0).realization(0);
        for (n, capacity, antipodal) in
            [(1, 7, false), (2, 5, true), (37, 16, false), (64, 9, true)]
        {
            let mut points: Vec<DVec3> =
                (0..n * capacity).map(|_| random_direction(&mut rng)).collect();
            // The key shared by a point and its antipode.
            let sorted = |points: &[DVec3]| {
                let mut all: Vec<_> =
                    points.iter().map(|p| if antipodal && p.z < 0.0 { -*p } else { *p }).collect();
                all.sort_by(|a, b| a.x.total_cmp(&b.x));
                all
            };
            let before = sorted(&points);
            divide(Directions { antipodal }, &mut points, capacity, &mut rng);
            assert_eq!(before, sorted(&points), "n = {n}, capacity = {capacity}");
            // Random groups would have mean vectors of length about 1/sqrt(capacity), 0.25.
            if n > 16 {
                for group in points.chunks_exact(capacity) {
                    let mean = group.iter().sum::<DVec3>().length() / capacity as f64;
                    assert!(mean > 0.7, "a group of n = {n} has mean length {mean}");
                }
            }
        }
    }
}
