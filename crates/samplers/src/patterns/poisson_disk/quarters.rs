use glam::DVec3;
use sphvar_healpix::Cell;

/// A cell divided into its four children, with the data to test whether a disk covers them. Child k
/// is the one at `(2 ix + k % 2, 2 iy + k / 2)`.
///
/// A child is bounded by four smooth curves. Between its ends such a curve leaves its chord by
/// at most `max |X''| / (8 nside^2)`, where `X''` is the second derivative with respect to a
/// coordinate of the face, and a ball that holds the ends holds the chord. So a disk of radius r
/// that holds the four corners within `r - slack` holds the boundary, hence the child.
#[derive(Debug)]
pub(crate) struct Quarters {
    x: [f64; 9],
    y: [f64; 9],
    z: [f64; 9],
    slack: f64,
}

impl Quarters {
    /// Returns the quarters of `parent`, whose slack need not be smaller than some hundredths of
    /// `chord`.
    #[inline]
    pub(crate) fn new(parent: Cell, chord: f64) -> Self {
        let last = parent.nside().value() - 1;
        let (ix, iy) = (parent.ix(), parent.iy());
        // Cells between the parent and the pole, and whether the parent lies across |z| = 2/3,
        // where the curves of constant u or v have a kink, though not where children meet.
        let (from_pole, straddles) = match parent.face() / 4 {
            0 => (2 * last - ix - iy, ix + iy == last),
            1 => (last, false),
            _ => (ix + iy, ix + iy == last),
        };
        // With d the distance from the pole in sides of a face, |X''| < 2 in the belt and
        // < 1.3 + 2.02/d in the caps, except on the meridians through d = 0, where it is below 1.
        let side = 2.0 * f64::from(last + 1);
        let from_pole = 2.0 * f64::from(from_pole.max(1)) - f64::from(u32::from(from_pole == 0));
        let sagitta = (2.0 / side + 2.02 / from_pole) / (8.0 * side);

        let at = |i: u32| parent.uniform_point(0.5 * f64::from(i % 3), 0.5 * f64::from(i / 3));
        let [s, e, w, n] = [0, 2, 6, 8].map(at);
        // Means of corners are less expensive than five more points, and off by two sagittas of the
        // parent, each four times a child's.
        let (points, sagittas) = if straddles || sagitta > chord / 160.0 {
            ([s, at(1), e, at(3), at(4), at(5), w, at(7), n], 1.0)
        } else {
            let (south, north) = (0.5 * (s + e), 0.5 * (w + n));
            let middle = 0.5 * (south + north);
            ([s, south, e, 0.5 * (s + w), middle, 0.5 * (e + n), w, north, n], 9.0)
        };
        Self {
            x: points.map(|p| p.x),
            y: points.map(|p| p.y),
            z: points.map(|p| p.z),
            // Points are rounded by a few units in the last place.
            slack: sagittas * sagitta + 16.0 * f64::EPSILON,
        }
    }

    fn point(&self, i: usize) -> DVec3 {
        DVec3::new(self.x[i], self.y[i], self.z[i])
    }

    /// Writes to `near`, which is at least as long as `points`, those of `points` whose disks of
    /// radius `chord` can intersect the parent, and returns their number.
    #[inline]
    pub(crate) fn select(&self, points: &[DVec3], chord: f64, near: &mut [DVec3]) -> usize {
        let centre = self.point(4);
        let corner = |i| self.point(i).distance_squared(centre);
        let radius = corner(0).max(corner(2)).max(corner(6)).max(corner(8)).sqrt();
        // The edges of the parent deviate from their chords by four sagittas of a child, and its
        // inner points are nearer to the centre than its edges.
        let reach = chord + radius + 5.0 * self.slack;
        let reach_squared = reach * reach;
        let mut len = 0;
        // Branch-free, because every second branch would be mispredicted.
        for &point in points {
            near[len] = point;
            len += usize::from(point.distance_squared(centre) < reach_squared);
        }
        len
    }

    /// Returns a mask of the children that lie within one disk of radius `chord` around one of
    /// `points`.
    #[inline]
    pub(crate) fn covered(&self, points: &[DVec3], chord: f64) -> u32 {
        let inner = chord - self.slack;
        if inner <= 0.0 {
            return 0;
        }
        // For each child, the minimum over the disks of the maximum squared distance of a corner.
        let mut best = [f64::INFINITY; 4];
        for q in points {
            let d: [f64; 9] = std::array::from_fn(|i| {
                let (dx, dy, dz) = (self.x[i] - q.x, self.y[i] - q.y, self.z[i] - q.z);
                dx * dx + dy * dy + dz * dz
            });
            let [west, east]: [[f64; 3]; 2] =
                [0, 1].map(|i| [0, 3, 6].map(|row| larger(d[row + i], d[row + i + 1])));
            let worst = [
                larger(west[0], west[1]),
                larger(east[0], east[1]),
                larger(west[1], west[2]),
                larger(east[1], east[2]),
            ];
            for (best, worst) in best.iter_mut().zip(worst) {
                *best = if worst < *best { worst } else { *best };
            }
        }
        let is_covered = |child: usize| u32::from(best[child] <= inner * inner) << child;
        is_covered(0) | is_covered(1) | is_covered(2) | is_covered(3)
    }
}

/// Returns the larger of two numbers that are not NaN, which `f64::max` would have to check.
#[inline]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use sphvar_healpix::Nside;

    use super::*;

    /// Every point of a child's boundary is within the slack of the chord between its corners.
    #[test]
    fn the_slack_bounds_how_far_edges_bulge() {
        const STEPS: u32 = 16;
        for n in [1, 2, 3, 5, 8, 21, 64] {
            let nside = Nside::new(n).unwrap();
            // With the large chord means of corners are accurate enough; with the small one they
            // are not.
            for chord in [1e-9, 1.0] {
                for (face, ix, iy) in (0..12)
                    .flat_map(|face| (0..n).map(move |ix| (face, ix)))
                    .flat_map(|(face, ix)| (0..n).map(move |iy| (face, ix, iy)))
                {
                    let parent = Cell::new(nside, face, ix, iy).unwrap();
                    let quarters = Quarters::new(parent, chord);
                    for (from, to) in (0..9_u32)
                        .flat_map(|i| [(i, i + 1), (i, i + 3)])
                        .filter(|&(from, to)| to < 9 && (to - from == 3 || from % 3 < 2))
                    {
                        let ends = [from, to].map(|i| quarters.point(i as usize));
                        for step in 0..=STEPS {
                            let t = f64::from(step) / f64::from(STEPS);
                            let along = |a: u32, b: u32| {
                                0.5 * (f64::from(a) + t * (f64::from(b) - f64::from(a)))
                            };
                            let on_edge = parent
                                .uniform_point(along(from % 3, to % 3), along(from / 3, to / 3));
                            let off = on_edge.distance(ends[0].lerp(ends[1], t));
                            assert!(
                                off <= quarters.slack,
                                "{parent:?}, chord {chord}, {from} to {to} at {t}: {off} is more \
                                 than {}",
                                quarters.slack
                            );
                        }
                    }
                }
            }
        }
    }

    /// No point of a child that counts as covered is outside the disk; no disk that touches the
    /// cell is left out.
    #[test]
    fn covered_children_are_inside_and_selected_points_are_all() {
        const STEPS: u32 = 12;
        let mut covered_children = 0;
        for n in [1, 2, 7, 40] {
            let nside = Nside::new(n).unwrap();
            for k in 0..300_u32 {
                let parent =
                    Cell::new(nside, (k % 12) as u8, k * 7 % n, (k * 13 + k / 12) % n).unwrap();
                for size in [0.7, 1.1, 1.9, 4.0] {
                    let chord = size / f64::from(n);
                    let quarters = Quarters::new(parent, chord);
                    // A point around the cell, at about the radius of the disk from it.
                    let (sin, cos) = f64::from(k).sin_cos();
                    let distance = (0.3 + 0.4 * f64::from(k % 5)) * chord;
                    let shift = DVec3::new(cos, sin, (2.3 * f64::from(k)).sin()) * distance;
                    let point = (parent.centre() + shift).normalize();

                    let covered = quarters.covered(&[point], chord);
                    covered_children += covered.count_ones();
                    let selected = quarters.select(&[point], chord, &mut [DVec3::ZERO]) == 1;
                    for (i, j) in (0..=STEPS).flat_map(|i| (0..=STEPS).map(move |j| (i, j))) {
                        let (u, v) =
                            (f64::from(i) / f64::from(STEPS), f64::from(j) / f64::from(STEPS));
                        let inside = parent.uniform_point(u, v).distance(point) < chord;
                        let child = u32::from(2 * i >= STEPS) + 2 * u32::from(2 * j >= STEPS);
                        assert!(inside || covered >> child & 1 == 0, "{parent:?} {size} {point}");
                        assert!(selected || !inside, "{parent:?} {size} {point}");
                    }
                }
            }
        }
        assert!(covered_children > 500, "only {covered_children} children were covered");
    }
}
