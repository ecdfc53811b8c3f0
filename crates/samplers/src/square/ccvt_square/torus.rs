use std::f64::consts::TAU;

use glam::DVec2;
use pulp::{Arch, NullaryFnOnce};
use rand::{Rng, RngExt};

use crate::square::turns::wrapped;
use crate::tessellation::{LANES, MassSpace, Moments, largest};

/// The unit square with opposite sides joined, whose mass points are assigned to sites by toroidal
/// distance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Torus;

impl MassSpace<2> for Torus {
    type Point = DVec2;

    const AREA: f64 = 1.0;
    const DIAMETER: f64 = 1.0;
    const TOLERANCE: f64 = 1e-12;
    /// A few roundings of squares of differences of coordinates.
    const ROUNDING: f64 = 2e-16;

    #[inline(always)]
    fn coordinates(point: DVec2) -> [f64; 2] {
        point.to_array()
    }

    #[inline(always)]
    fn point(coordinates: [f64; 2]) -> DVec2 {
        DVec2::from_array(coordinates)
    }

    #[inline(always)]
    fn distance(self, a: DVec2, b: DVec2) -> f64 {
        shortest(b - a).length()
    }

    /// Returns the mean of the images nearest to the first site.
    fn middle(self, sites: &[DVec2]) -> DVec2 {
        let from = sites[0];
        let steps: DVec2 = sites.iter().map(|&s| shortest(s - from)).sum();
        wrapped(from + steps / sites.len() as f64)
    }

    fn start(self, cell: &[DVec2]) -> DVec2 {
        self.middle(cell)
    }

    fn moved(self, site: DVec2, step: DVec2) -> DVec2 {
        wrapped(site + step)
    }

    fn random_point(self, rng: &mut dyn Rng) -> DVec2 {
        rng.random::<[f64; 2]>().into()
    }

    /// Regions are divided in the plane, as which the square is compact.
    fn prepare(self, _points: &mut [DVec2], _rng: &mut dyn Rng) {}

    fn cut(self, _mean: DVec2, rng: &mut dyn Rng) -> DVec2 {
        DVec2::from_angle(TAU * rng.random::<f64>())
    }

    fn reductions_into(
        self,
        arch: Arch,
        block: [&[f64]; 2],
        own: DVec2,
        other: DVec2,
        _max_square: f64,
        reductions: &mut [f64],
    ) -> f64 {
        arch.dispatch(Reductions { block, own, other, reductions })
    }

    fn moments(
        self,
        arch: Arch,
        block: [&[f64]; 2],
        site: DVec2,
        _max_square: f64,
    ) -> Moments<DVec2> {
        arch.dispatch(Sums { block, site })
    }
}

struct Reductions<'a> {
    block: [&'a [f64]; 2],
    own: DVec2,
    other: DVec2,
    reductions: &'a mut [f64],
}

struct Sums<'a> {
    block: [&'a [f64]; 2],
    site: DVec2,
}

impl NullaryFnOnce for Reductions<'_> {
    type Output = f64;

    #[inline(always)]
    fn call(self) -> f64 {
        let Self { block: [xs, ys], own, other, reductions } = self;
        let squared = |site: DVec2, x: f64, y: f64| {
            let (dx, dy) = (nearest(x - site.x), nearest(y - site.y));
            dx * dx + dy * dy
        };
        for ((&x, &y), reduction) in xs.iter().zip(ys).zip(&mut *reductions) {
            *reduction = squared(own, x, y) - squared(other, x, y);
        }
        largest(reductions)
    }
}

impl NullaryFnOnce for Sums<'_> {
    type Output = Moments<DVec2>;

    #[inline(always)]
    fn call(self) -> Moments<DVec2> {
        let Self { block: [x, y], site } = self;
        let [mut sx, mut sy, mut max_square, mut energy] = [[0.0; LANES]; 4];
        let mut add = |lane: usize, x: f64, y: f64| {
            let (dx, dy) = (nearest(x - site.x), nearest(y - site.y));
            let square = dx * dx + dy * dy;
            sx[lane] += dx;
            sy[lane] += dy;
            energy[lane] += square;
            max_square[lane] = if square > max_square[lane] { square } else { max_square[lane] };
        };
        let (xs, x_rest) = x.as_chunks::<LANES>();
        let (ys, y_rest) = y.as_chunks::<LANES>();
        for (x, y) in xs.iter().zip(ys) {
            for k in 0..LANES {
                add(k, x[k], y[k]);
            }
        }
        for (k, (&x, &y)) in x_rest.iter().zip(y_rest).enumerate() {
            add(k, x, y);
        }
        let total = |lanes: [f64; LANES]| lanes.into_iter().sum::<f64>();
        Moments {
            sum: DVec2::new(total(sx), total(sy)),
            max_square: max_square.into_iter().fold(0.0, f64::max),
            energy: total(energy),
        }
    }
}

/// Returns a difference of coordinates in (-1, 1) modulo 1, from -1/2 to 1/2.
#[inline(always)]
fn nearest(difference: f64) -> f64 {
    // Selections, since rounding is not vectorized on every machine.
    let down = if difference > 0.5 { 1.0 } else { 0.0 };
    let up = if difference < -0.5 { 1.0 } else { 0.0 };
    difference - down + up
}

fn shortest(difference: DVec2) -> DVec2 {
    DVec2::new(nearest(difference.x), nearest(difference.y))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tessellation::divide;
    use crate::{Purpose, Streams};

    /// The definition: the smallest distance to nine images.
    fn squared(a: DVec2, b: DVec2) -> f64 {
        let shifts = [-1.0, 0.0, 1.0];
        let images = shifts.iter().flat_map(|&x| shifts.map(|y| DVec2::new(x, y)));
        images.map(|shift| a.distance_squared(b + shift)).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn reductions_and_moments_match_the_definition() {
        let mut rng = Streams::new(4, Purpose::Pattern, 2).realization(0);
        for n in [1, 7, 8, 17, 64, 65] {
            let mut point = || Torus.random_point(&mut rng);
            let ends = [DVec2::ZERO, DVec2::splat(1.0 - f64::EPSILON / 2.0)];
            for (own, other) in [(point(), point()), (ends[0], ends[1])] {
                let points: Vec<DVec2> =
                    (0..n).map(|k| if k % 9 == 4 { ends[k % 2] } else { point() }).collect();
                let column = |of: fn(&DVec2) -> f64| points.iter().map(of).collect::<Vec<_>>();
                let (x, y) = (column(|p| p.x), column(|p| p.y));
                let block = [&*x, &*y];
                let mut reductions = vec![f64::NAN; n];
                let best =
                    Torus.reductions_into(Arch::new(), block, own, other, 1.0, &mut reductions);
                for (p, got) in points.iter().zip(&reductions) {
                    let off = (got - (squared(*p, own) - squared(*p, other))).abs();
                    assert!(off < 4.0 * f64::EPSILON, "{p}, {own}, {other}: off by {off}");
                    let off = (Torus.distance(*p, own).powi(2) - squared(*p, own)).abs();
                    assert!(off < 4.0 * f64::EPSILON, "{p}, {own}: off by {off}");
                }
                let max = reductions.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                assert_eq!(best.to_bits(), max.to_bits());
                let mut narrow = vec![f64::NAN; n];
                Torus.reductions_into(Arch::Scalar, block, own, other, 1.0, &mut narrow);
                assert_eq!(reductions, narrow, "the bits depend on the width of registers");

                let moments = Torus.moments(Arch::new(), block, own, 1.0);
                let narrow = Torus.moments(Arch::Scalar, block, own, 1.0);
                assert_eq!((moments.sum, moments.energy), (narrow.sum, narrow.energy));
                let energy: f64 = points.iter().map(|&p| squared(p, own)).sum();
                assert!((moments.energy - energy).abs() < 1e-14 * n as f64);
                // The sum is the slope of half the energy with respect to the site.
                let slope = |axis: DVec2| {
                    let at =
                        |h: f64| points.iter().map(|&p| squared(p, own + h * axis)).sum::<f64>();
                    (at(1e-6) - at(-1e-6)) / -4e-6
                };
                let off = moments.sum - DVec2::new(slope(DVec2::X), slope(DVec2::Y));
                assert!(off.length() < 1e-8 * n as f64, "off by {off}");
            }
        }
    }

    #[test]
    fn regions_are_compact() {
        let mut rng = Streams::new(5, Purpose::Pattern, 2).realization(0);
        let mut points: Vec<DVec2> = (0..64 * 9).map(|_| Torus.random_point(&mut rng)).collect();
        divide(Torus, &mut points, 9, &mut rng);
        for group in points.chunks_exact(9) {
            let mean = group.iter().sum::<DVec2>() / 9.0;
            let spread = group.iter().map(|p| p.distance_squared(mean)).sum::<f64>() / 9.0;
            // A square cell of this area has 1/6/64 = 0.0026, the whole square 0.17.
            assert!(spread < 0.02, "{spread}");
        }
    }
}
