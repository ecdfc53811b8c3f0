//! Pairs of near points, found by a grid of cubes.

use glam::DVec3;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use sphvar_samplers::{Domain, PointSet, Progress, Stopped};

/// The points of a set, sorted by the cubes of a grid in which they lie. On the hemisphere every
/// point is there with its antipode.
///
/// The cubes are at least as wide as the longest chord of interest, so that the partners of a point
/// are in its cube and the 26 around it. Memory: 48 bytes a point, twice that on the hemisphere.
pub(super) struct NearPairs {
    domain: Domain,
    points: Vec<Image>,
    /// The cube of each point, ascending.
    keys: Vec<u64>,
    cubes_per_side: u64,
    chord_squared: f64,
}

/// A point or its antipode.
#[derive(Clone, Copy)]
struct Image {
    dir: DVec3,
    index: usize,
    is_antipode: bool,
}

/// A pair of points, on the hemisphere of one point and the nearer end of the other line.
#[derive(Clone, Copy)]
pub(super) struct Pair {
    /// The indices of the points in the set.
    pub(super) indices: [usize; 2],
    /// The square of the chord.
    pub(super) chord_squared: f64,
    /// 1 on the sphere; 1/2 on the hemisphere, where every pair is visited from both ends.
    pub(super) share: f64,
}

/// The most cubes along a side, so that keys of three coordinates fit.
const MAX_CUBES: f64 = 1e6;
/// Points whose pairs are one unit of parallel work; results are summed by unit, in order.
const UNIT: usize = 512;
/// Visited pairs between two checks whether to stop, about a millisecond.
const BETWEEN_CHECKS: usize = 1 << 19;

impl NearPairs {
    /// Returns the pairs of `set` whose chord is at most `chord`, up to rounding.
    pub(super) fn new(set: &PointSet, domain: Domain, chord: f64) -> Self {
        // Slightly more, because places and chords are rounded.
        let chord = chord * (1.0 + 1e-9);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 1 and 1e6"
        )]
        let cubes_per_side = (2.0 / chord).clamp(1.0, MAX_CUBES) as u64;
        let images = |is_antipode| {
            set.points.iter().enumerate().map(move |(index, &p)| {
                let dir = if is_antipode { -p } else { p };
                Image { dir, index, is_antipode }
            })
        };
        let mut points: Vec<Image> = images(false).collect();
        if domain == Domain::Hemisphere {
            points.extend(images(true));
        }
        let key = |image: &Image| key(place(image.dir, cubes_per_side), cubes_per_side);
        points.sort_by_cached_key(key);
        let keys = points.iter().map(key).collect();
        Self { domain, points, keys, cubes_per_side, chord_squared: chord * chord }
    }

    /// Returns `add` of every pair, summed per bin of `0..bins`: `add` returns the bin and the
    /// value of a pair. The sums do not depend on the number of threads.
    pub(super) fn sums<F: Fn(Pair) -> Option<(usize, f64)> + Sync>(
        &self,
        bins: usize,
        add: &F,
        progress: &dyn Progress,
    ) -> Result<Vec<f64>, Stopped> {
        let units = self.points.len().div_ceil(UNIT);
        let unit = |unit: usize| {
            let range = unit * UNIT..((unit + 1) * UNIT).min(self.points.len());
            let mut sums = vec![0.0; bins];
            let mut visited = 0;
            for j in range {
                self.visit(j, &mut visited, progress, &mut |pair| {
                    if let Some((bin, value)) = add(pair) {
                        sums[bin] += value;
                    }
                })?;
            }
            Ok(sums)
        };
        let of_units: Vec<Vec<f64>> =
            (0..units).into_par_iter().map(unit).collect::<Result<_, Stopped>>()?;
        let mut total = vec![0.0; bins];
        for sums in of_units {
            total.iter_mut().zip(sums).for_each(|(t, s)| *t += s);
        }
        Ok(total)
    }

    /// Calls `f` for the pairs of the point at `j` with later ones.
    fn visit(
        &self,
        j: usize,
        visited: &mut usize,
        progress: &dyn Progress,
        f: &mut impl FnMut(Pair),
    ) -> Result<(), Stopped> {
        let point = self.points[j];
        let side = self.cubes_per_side;
        let [x, y, z] = place(point.dir, side);
        let around = |c: u64| c.saturating_sub(1)..=(c + 1).min(side - 1);
        for cx in around(x) {
            for cy in around(y) {
                // Cubes along z have consecutive keys.
                let (low, high) = (*around(z).start(), *around(z).end());
                let from = self.keys.partition_point(|&k| k < key([cx, cy, low], side)).max(j + 1);
                let end = self.keys.partition_point(|&k| k <= key([cx, cy, high], side));
                for chunk in self.points[from.min(end)..end].chunks(BETWEEN_CHECKS) {
                    for other in chunk {
                        if let Some(pair) = self.pair(point, *other) {
                            f(pair);
                        }
                    }
                    *visited += chunk.len();
                    if *visited >= BETWEEN_CHECKS {
                        *visited = 0;
                        progress.tick(0.0)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// Returns the pair of two images, if it is near and to be counted.
    #[inline]
    fn pair(&self, a: Image, b: Image) -> Option<Pair> {
        let chord_squared = a.dir.distance_squared(b.dir);
        if chord_squared > self.chord_squared {
            return None;
        }
        let mut share = 1.0;
        if self.domain == Domain::Hemisphere {
            // Of the two ends of the other line the nearer one counts, the point itself at a right
            // angle. Products of coordinates change nothing but the sign at an antipode.
            let cos = a.dir.dot(b.dir);
            let is_nearer = if a.is_antipode == b.is_antipode { cos >= 0.0 } else { cos > 0.0 };
            if !is_nearer || a.index == b.index {
                return None;
            }
            share = 0.5;
        }
        Some(Pair { indices: [a.index, b.index], chord_squared, share })
    }
}

/// Returns the cube of a direction, by its coordinates.
fn place(dir: DVec3, cubes_per_side: u64) -> [u64; 3] {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "coordinates are at least 0 and at most the number of cubes"
    )]
    let along = |c: f64| {
        let at = 0.5 * (c + 1.0).max(0.0) * cubes_per_side as f64;
        (at as u64).min(cubes_per_side - 1)
    };
    dir.to_array().map(along)
}

fn key([x, y, z]: [u64; 3], cubes_per_side: u64) -> u64 {
    (x * cubes_per_side + y) * cubes_per_side + z
}
