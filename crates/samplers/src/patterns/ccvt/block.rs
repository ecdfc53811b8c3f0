use glam::DVec3;
use pulp::{Arch, NullaryFnOnce};

use super::distance::{Precision, squared_angle, stretch};

/// Number of lanes for running sums and extremes. Together with the absence of fused operations it
/// makes results bit-identical for any register width.
const LANES: usize = 8;

/// Mass points by coordinate: those of one site or of consecutive sites.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block<'a> {
    pub(super) x: &'a [f64],
    pub(super) y: &'a [f64],
    pub(super) z: &'a [f64],
}

/// Moments of the mass points of a site.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moments {
    /// Sum over the points of `(d/sin d) p`, whose projection onto the site's tangent plane is the
    /// sum of the logarithms of the points.
    pub(super) sum: DVec3,
    /// Largest squared chord from the site to a point.
    pub(super) max_chord2: f64,
    /// Sum of the squared geodesic distances from the site to the points.
    pub(super) energy: f64,
}

/// Computes the reduction of the energy for moving each point from its `own` site to the `other`
/// one.
struct Reductions<'a> {
    block: Block<'a>,
    own: DVec3,
    other: DVec3,
    reductions: &'a mut [f64],
}

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

impl Block<'_> {
    /// Writes d(p, own)^2 - d(p, other)^2 for each point p to `reductions`, and returns the
    /// largest. `max_chord2` bounds the squared chords.
    pub(super) fn reductions_into(
        self,
        arch: Arch,
        antipodal: bool,
        own: DVec3,
        other: DVec3,
        max_chord2: f64,
        reductions: &mut [f64],
    ) -> f64 {
        let kernel = Reductions { block: self, own, other, reductions };
        arch.dispatch(Dispatch { kernel, antipodal, precision: Precision::up_to(max_chord2) })
    }

    /// Returns the moments of the points about a site. `max_chord2` bounds the squared chords.
    pub(super) fn moments(
        self,
        arch: Arch,
        antipodal: bool,
        site: DVec3,
        max_chord2: f64,
    ) -> Moments {
        let kernel = Sums { block: self, site };
        arch.dispatch(Dispatch { kernel, antipodal, precision: Precision::up_to(max_chord2) })
    }
}

impl Kernel for Reductions<'_> {
    type Output = f64;

    #[inline(always)]
    fn run<const TERMS: usize, const LINES: bool>(self) -> f64 {
        let Self { block, own, other, reductions } = self;
        let squared = |site: DVec3, x: f64, y: f64, z: f64| {
            squared_angle::<TERMS>(squared_chord::<LINES>(site, x, y, z).0)
        };
        // The sites are processed one after the other: in a joint loop the compiler would vectorize
        // over the two sites instead of over the points.
        for (((&x, &y), &z), reduction) in
            block.x.iter().zip(block.y).zip(block.z).zip(&mut *reductions)
        {
            *reduction = squared(own, x, y, z);
        }
        for (((&x, &y), &z), reduction) in
            block.x.iter().zip(block.y).zip(block.z).zip(&mut *reductions)
        {
            *reduction -= squared(other, x, y, z);
        }
        largest(reductions)
    }
}

#[inline(always)]
fn largest(values: &[f64]) -> f64 {
    let larger = |a: f64, b: f64| if b > a { b } else { a };
    let (chunks, rest) = values.as_chunks::<LANES>();
    let mut maxima = [f64::NEG_INFINITY; LANES];
    for chunk in chunks {
        for (maxima, &value) in maxima.iter_mut().zip(chunk) {
            *maxima = larger(*maxima, value);
        }
    }
    maxima.into_iter().chain(rest.iter().copied()).fold(f64::NEG_INFINITY, larger)
}

impl Kernel for Sums<'_> {
    type Output = Moments;

    #[inline(always)]
    fn run<const TERMS: usize, const LINES: bool>(self) -> Moments {
        let Self { block, site } = self;
        let [mut sx, mut sy, mut sz] = [[0.0; LANES]; 3];
        let [mut max_chord2, mut energy] = [[0.0; LANES]; 2];
        let mut add = |lane: usize, x: f64, y: f64, z: f64| {
            let (c, sign) = squared_chord::<LINES>(site, x, y, z);
            let weight = stretch::<TERMS>(c) * sign;
            sx[lane] += weight * x;
            sy[lane] += weight * y;
            sz[lane] += weight * z;
            energy[lane] += squared_angle::<TERMS>(c);
            max_chord2[lane] = if c > max_chord2[lane] { c } else { max_chord2[lane] };
        };
        let (xs, x_rest) = block.x.as_chunks::<LANES>();
        let (ys, y_rest) = block.y.as_chunks::<LANES>();
        let (zs, z_rest) = block.z.as_chunks::<LANES>();
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
            max_chord2: max_chord2.into_iter().fold(0.0, f64::max),
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

#[cfg(test)]
mod tests {
    use pulp::Arch;

    use super::{Block, DVec3};
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
                let block = Block { x: &x, y: &y, z: &z };
                let squares = |site| points.iter().map(move |&p| angle(antipodal, site, p).powi(2));
                let bound = |site: DVec3| {
                    squares(site)
                        .map(|d2| (2.0 * (0.5 * d2.sqrt()).sin()).powi(2))
                        .fold(0.0, f64::max)
                };
                let max_chord2 = bound(own).max(bound(other));

                let mut reductions = vec![f64::NAN; n];
                let best = block.reductions_into(
                    Arch::new(),
                    antipodal,
                    own,
                    other,
                    max_chord2,
                    &mut reductions,
                );
                // The error 1e-13 of the series and a few roundings of 2 - 2 cos d, more near
                // antipodes.
                let tolerance = if spread > 1.0 { 1e-12 } else { 1e-13 * max_chord2 + 1e-14 };
                for (k, (from, to)) in squares(own).zip(squares(other)).enumerate() {
                    let off = (reductions[k] - (from - to)).abs();
                    assert!(off < tolerance, "point {k} of {n}, spread {spread}: off by {off}");
                }
                let largest = reductions.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                assert_eq!(best.to_bits(), largest.to_bits(), "{best} is not {largest}");
                let mut narrow = vec![f64::NAN; n];
                block.reductions_into(Arch::Scalar, antipodal, own, other, max_chord2, &mut narrow);
                assert_eq!(reductions, narrow, "the bits depend on the width of registers");

                let moments = block.moments(Arch::new(), antipodal, own, max_chord2);
                assert!((moments.max_chord2 - bound(own)).abs() < 1e-15 + 1e-12 * max_chord2);
                let narrow = block.moments(Arch::Scalar, antipodal, own, max_chord2);
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
}
