use std::f64::consts::PI;
use std::ops::Range;

use glam::DVec3;
use rayon::prelude::ParallelSliceMut;
use sphvar_samplers::{Domain, PointSet, PointSets};
use sphvar_sh::CompensatedSum;

use crate::Error;

/// Weighted points of the sphere, sorted by zone of colatitude and by longitude. Identical points
/// are merged.
///
/// Memory: 40 bytes per point, and about 100 while they are sorted.
#[derive(Debug)]
pub(super) struct Nodes {
    pub(super) x: Vec<f64>,
    pub(super) y: Vec<f64>,
    pub(super) z: Vec<f64>,
    /// The weights, whose sum is 1.
    pub(super) w: Vec<f64>,
    longitudes: Vec<f64>,
    /// The index of the first point of each zone, and the number of points.
    zones: Vec<usize>,
    /// The height of a zone in radians.
    height: f64,
    /// Whether identical points have been merged.
    pub(super) has_repeated: bool,
}

/// A point before sorting.
#[derive(Clone, Copy)]
struct Node {
    point: DVec3,
    weight: f64,
    longitude: f64,
    zone: u32,
}

impl Nodes {
    /// Returns the points of nonzero weight in zones of at most `height` radians. On the hemisphere
    /// every point is replaced by itself and its antipode, with half of its weight each.
    ///
    /// # Errors
    ///
    /// [`Error::Sampler`] for invalid sets and for weights whose sum is 0.
    pub(super) fn new(set: &PointSet, domain: Domain, height: f64) -> Result<Self, Error> {
        let checked = PointSets::new(vec![set.clone()], domain)?;
        let set = &checked.sets()[0];
        if set.n_effective() <= 0.0 {
            let reason = "the sum of the weights is 0".to_owned();
            return Err(sphvar_samplers::Error::Given { reason }.into());
        }
        let mut scaled: PointSet = PointSet { points: Vec::new(), weights: set.weights.clone() };
        scaled.normalize_weights();
        let weight = |k: usize| scaled.weights.get(k).copied().unwrap_or(1.0);
        let sum = (0..set.len()).map(weight).collect::<CompensatedSum>().value();
        let images = if domain == Domain::Hemisphere { 2 } else { 1 };
        let n_zones = (PI / height).ceil();
        let height = PI / n_zones;
        let mut nodes = Vec::with_capacity(images * set.len());
        for (k, p) in set.points.iter().enumerate() {
            let weight = weight(k) / (sum * images as f64);
            for point in [*p, -*p].into_iter().take(images) {
                // The sum with 0 has no negative zeros.
                let point = point + DVec3::ZERO;
                let longitude = point.y.atan2(point.x);
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "a colatitude is not negative, a height above pi/2^32"
                )]
                let zone = (colatitude(point) / height).min(n_zones - 1.0) as u32;
                nodes.push(Node { point, weight, longitude, zone });
            }
        }
        drop(checked);
        nodes.retain(|node| node.weight.abs() > 0.0);
        nodes.par_sort_unstable_by(|a, b| {
            let keys = |n: &Node| [n.longitude, n.point.z, n.point.x, n.point.y, n.weight];
            let order = keys(a).into_iter().zip(keys(b)).map(|(a, b)| a.total_cmp(&b));
            order.fold(a.zone.cmp(&b.zone), std::cmp::Ordering::then)
        });
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a positive whole number"
        )]
        Ok(Self::merged(&nodes, n_zones as usize, height))
    }

    fn merged(nodes: &[Node], n_zones: usize, height: f64) -> Self {
        let distinct = || nodes.chunk_by(|a, b| a.point == b.point);
        let coordinates = |f: fn(&Node) -> f64| distinct().map(|run| f(&run[0])).collect();
        let weights = distinct().map(|run| {
            // The sum of one weight is exact.
            run.iter().map(|node| node.weight).collect::<CompensatedSum>().value()
        });
        let mut zones = vec![0; n_zones + 1];
        for run in distinct() {
            zones[run[0].zone as usize + 1] += 1;
        }
        for i in 0..n_zones {
            zones[i + 1] += zones[i];
        }
        Self {
            w: weights.collect(),
            x: coordinates(|node| node.point.x),
            y: coordinates(|node| node.point.y),
            z: coordinates(|node| node.point.z),
            longitudes: coordinates(|node| node.longitude),
            has_repeated: zones[n_zones] < nodes.len(),
            zones,
            height,
        }
    }

    pub(super) fn len(&self) -> usize {
        self.w.len()
    }

    pub(super) fn point(&self, k: usize) -> DVec3 {
        DVec3::new(self.x[k], self.y[k], self.z[k])
    }

    /// Returns the sum of the squared weights, 1/N for N equally weighted points.
    pub(super) fn sum_of_squares(&self) -> f64 {
        self.w.iter().map(|w| w * w).collect::<CompensatedSum>().value()
    }

    /// Appends ranges that contain every point after `k` within `radius` radians of point k, except
    /// some whose distance equals the radius up to rounding.
    pub(super) fn later_neighbours(&self, k: usize, radius: f64, ranges: &mut Vec<Range<usize>>) {
        let theta = colatitude(self.point(k));
        let (longitude, last) = (self.longitudes[k], self.zones.len() - 2);
        let zone_of = |theta: f64| {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a quotient of positive numbers, at most the number of zones"
            )]
            let zone = (theta.max(0.0) / self.height) as usize;
            zone.min(last)
        };
        // Zones before that of the point have only points before it.
        for zone in zone_of(theta - self.height)..=zone_of(theta + radius) {
            let (begin, end) = (self.zones[zone].max(k + 1), self.zones[zone + 1]);
            if begin >= end {
                continue;
            }
            let top = zone as f64 * self.height;
            let half_width = half_width(theta, radius, top..top + self.height);
            let within = |from: f64, to: f64| {
                let longitudes = &self.longitudes[begin..end];
                let first = longitudes.partition_point(|&phi| phi < from);
                let count = longitudes[first..].partition_point(|&phi| phi <= to);
                begin + first..begin + first + count
            };
            if half_width > 3.0 {
                ranges.push(begin..end);
                continue;
            }
            let (from, to) = (longitude - half_width, longitude + half_width);
            let wrapped = [(from + 2.0 * PI, f64::INFINITY), (f64::NEG_INFINITY, to - 2.0 * PI)];
            for (from, to) in [(from, to)].into_iter().chain(wrapped) {
                let range = within(from, to);
                if !range.is_empty() {
                    ranges.push(range);
                }
            }
        }
    }

    /// Returns an estimate of the number of points in all ranges of [`Self::later_neighbours`],
    /// from every sixteenth point of large sets.
    pub(super) fn estimated_pairs(&self, radius: f64) -> f64 {
        let step = if self.len() > 10_000 { 16 } else { 1 };
        let mut ranges = Vec::new();
        let mut pairs = 0;
        for k in (0..self.len()).step_by(step) {
            self.later_neighbours(k, radius, &mut ranges);
            pairs += ranges.drain(..).map(|range| range.len()).sum::<usize>();
        }
        (step * pairs) as f64
    }
}

/// Returns the colatitude of a unit vector, accurate at the poles.
fn colatitude(p: DVec3) -> f64 {
    p.x.hypot(p.y).atan2(p.z)
}

/// Returns the largest difference in longitude between a point at colatitude `theta` and points
/// within `radius` of it in a zone, increased by a rounding bound; pi if it has no bound.
fn half_width(theta: f64, radius: f64, zone: Range<f64>) -> f64 {
    // The difference has its maximum over a parallel where cos(theta') = cos(theta)/cos(radius),
    // and decreases on both sides of it.
    let widest = (theta.cos() / radius.cos()).clamp(-1.0, 1.0).acos();
    let other = widest.clamp(zone.start, zone.end);
    let sines = theta.sin() * other.sin();
    // cos(radius) = cos(theta - theta') - sin(theta) sin(theta') (1 - cos(difference)).
    let versine =
        2.0 * ((0.5 * radius).sin().powi(2) - (0.5 * (theta - other)).sin().powi(2)).max(0.0);
    if sines <= 0.0 || versine >= 2.0 * sines {
        return PI;
    }
    2.0 * (0.5 * versine / sines).sqrt().asin() + 1e-6 * radius
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use sphvar_samplers::{Domain, Pattern, PointSet, Purpose, Streams};

    use super::Nodes;

    fn white(n: usize) -> Vec<DVec3> {
        let mut rng = Streams::new(5, Purpose::Pattern, n).realization(0);
        Pattern::WhiteNoise.build(n, Domain::Sphere).unwrap().sample(&mut rng).unwrap().points
    }

    /// The reference is a search through all pairs, with poles, the seam at longitude pi, points of
    /// one meridian and of one parallel.
    #[test]
    fn every_near_pair_is_visited_once() {
        let mut points = white(500);
        points.extend([DVec3::Z, DVec3::NEG_Z, DVec3::NEG_X, DVec3::new(-1.0, -0.0, 0.0)]);
        for i in 0..60 {
            let (s, c) = (0.1 * f64::from(i)).sin_cos();
            points.push(DVec3::new(s, 0.0, c));
            points.push(DVec3::new(-1.0, 1e-9 * f64::from(i), 0.0));
            points.push(DVec3::new(1e-3 * c, 1e-3 * s, -1.0));
        }
        for radius in [0.01, 0.1, 0.5, 1.1] {
            let set = PointSet::new(points.iter().map(|p| p.normalize()).collect());
            let nodes = Nodes::new(&set, Domain::Sphere, radius / 3.0).unwrap();
            assert!(nodes.has_repeated && nodes.len() < set.len());
            for k in 0..nodes.len() {
                let mut seen = vec![0; nodes.len()];
                let mut ranges = Vec::new();
                nodes.later_neighbours(k, radius, &mut ranges);
                ranges.into_iter().flatten().for_each(|other| seen[other] += 1);
                for (other, &count) in seen.iter().enumerate() {
                    let angle = 2.0 * (0.5 * nodes.point(k).distance(nodes.point(other))).asin();
                    let is_near = other > k && angle < radius * (1.0 - 1e-9);
                    assert!(
                        count <= 1 && (count == 1 || !is_near),
                        "{count} visits of {other} by {k}, {angle} apart, radius {radius}"
                    );
                }
            }
        }
    }
}
