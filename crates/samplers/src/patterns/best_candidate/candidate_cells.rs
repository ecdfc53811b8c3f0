use glam::DVec3;
use rand::{Rng, RngExt};

use super::bound_buckets::{BUCKET_BITS, BoundBuckets, bucket_of, largest_bound};
use super::cell_family::{CellFamily, Corners, FamilyCell, NONE};
use super::cell_place::{LAST_LEVEL, area};
use super::near_sites::NearSites;
use crate::Domain;

/// The number of candidates expected in a bucket above which its cells are divided before any is
/// drawn.
const MAX_EXPECTED: f64 = 8.0;

/// A cell that may contain the farthest candidate is divided until its radius is this fraction of
/// its bound.
const FINE: f64 = 1.0 / 40.0;

/// Cells whose bound is at most this fraction of the last point's clearance are no longer
/// distinguished from their siblings: the number of points has to double before one is visited.
const MERGED: f64 = 0.75;

/// Draws the farthest of a number of uniform candidates from a growing set of points without
/// drawing the others.
///
/// The domain is divided into cells, each with an upper bound of the distance of its points from
/// the nearest point of the set. A candidate in a cell whose bound does not exceed the distance of
/// another candidate is not the farthest one, wherever it lies in the cell. Cells are visited in
/// descending order of their bounds; the number of candidates in each follows from its share of the
/// area, and only these are drawn, until the farthest of them is at least as far as the bounds of
/// all remaining cells. The result has exactly the distribution of the farthest of independent
/// uniform candidates.
///
/// The cells are HEALPix cells of different levels, in a forest. Cells that are visited in vain are
/// divided, so that the area of those whose bounds exceed the distance of the farthest candidate is
/// about that of one candidate. A new point changes only the cells around it.
///
/// On the hemisphere distances are antipodal, and the cells are one of each pair of antipodes.
#[derive(Debug)]
pub(super) struct CandidateCells {
    domain: Domain,
    sites: NearSites,
    /// The cells, in families of four: cell `4 k + i` is the i-th of family k. The roots are the
    /// first ones.
    families: Vec<CellFamily>,
    /// Families that are not used.
    unused: Vec<u32>,
    buckets: BoundBuckets,
    /// The clearance of the last farthest candidate.
    last_clearance: f64,
    /// The cells of the candidates drawn for one point.
    visited: Vec<u32>,
    /// The sites that can be the nearest ones of a cell that is divided, and after them those of
    /// the child that is.
    near: Vec<DVec3>,
}

impl CandidateCells {
    /// Returns the cells of a set of at least one point, whose last one was at a distance of
    /// `last_clearance` from the others.
    pub(super) fn new(domain: Domain, points: &[DVec3], last_clearance: f64) -> Self {
        let mut cells = Self {
            domain,
            sites: NearSites::new(domain, 2.0),
            families: Vec::new(),
            unused: Vec::new(),
            buckets: BoundBuckets::default(),
            last_clearance,
            visited: Vec::new(),
            near: Vec::new(),
        };
        points.iter().for_each(|&p| cells.sites.add(p));
        cells.sites.adapt(last_clearance);
        let n_roots = cells.n_roots();
        for face in (0..n_roots).step_by(4) {
            cells.families.push(CellFamily::of_roots(face, n_roots, cells.sites.points()));
        }
        for root in 0..u32::from(n_roots) {
            cells.enter(root);
        }
        cells
    }

    /// Returns the number of the largest cells: the northern faces and the first two of the equator
    /// hold one cell of every antipodal pair.
    fn n_roots(&self) -> u8 {
        match self.domain {
            Domain::Sphere => 12,
            Domain::Hemisphere => 6,
        }
    }

    /// Returns the area of the domain in units of the smallest cells.
    fn area(&self) -> u64 {
        u64::from(self.n_roots()) * area(0)
    }

    fn cell(&self, cell: u32) -> FamilyCell {
        self.families[cell as usize / 4].cell(cell as usize % 4)
    }

    /// Adds a point to the set.
    pub(super) fn insert(&mut self, point: DVec3) {
        let before = self.sites.points().len();
        self.sites.add(point);
        for site in before..self.sites.points().len() {
            for family in 0..u32::from(self.n_roots().div_ceil(4)) {
                self.approach(family, self.sites.points()[site]);
            }
        }
    }

    /// Returns the farthest of `n_candidates` uniform candidates, of which there is at least one.
    pub(super) fn farthest(&mut self, n_candidates: u64, rng: &mut dyn Rng) -> DVec3 {
        let total = self.area() as f64;
        let mut best = DVec3::ZERO;
        let mut best_cell = None;
        // Below every squared distance, so that the first candidate is accepted.
        let mut clearance = -1.0;
        self.visited.clear();
        // In the order of visits the candidates are at ascending parts of the area: u is that of
        // the next candidate, `before` the area of the buckets that are complete.
        let (mut bucket, mut before, mut u) = (self.buckets.first(), 0, 0.0);
        let mut is_entered = false;
        let mut left = n_candidates;
        'candidates: while left > 0 {
            // The least of `left` uniform numbers in [u, 1).
            let uniform = 1.0 - rng.random::<f64>();
            u -= (1.0 - u) * libm::expm1(libm::log(uniform) / left as f64);
            loop {
                if clearance >= largest_bound(bucket).powi(2) {
                    break 'candidates;
                }
                // Cells are divided whatever u is, before candidates are drawn in them.
                if !is_entered {
                    self.refine(bucket, left as f64 / (total - before as f64));
                    is_entered = true;
                }
                let after = before + self.buckets.area(bucket);
                // Rounding does not take u beyond the last cell.
                if u * total < after as f64 || after == self.area() {
                    break;
                }
                before = after;
                bucket += 1;
                is_entered = false;
            }
            let Some(cell) = self.buckets.random_leaf(bucket, rng) else {
                break;
            };
            let candidate = self.cell(cell).place.point(rng.random(), rng.random());
            self.visited.push(cell);
            if let Some(farther) = self.sites.clearance(candidate, clearance) {
                (best, best_cell, clearance) = (candidate, Some(cell), farther);
            }
            left -= 1;
        }
        self.last_clearance = clearance.sqrt();
        self.sites.adapt(self.last_clearance);
        while let Some(cell) = self.visited.pop() {
            // The bounds in the cell of the farthest candidate change with the new point.
            if best_cell != Some(cell) {
                self.divide(cell);
            }
        }
        best
    }

    /// Divides the cells of a bucket, the largest first, until no more than `MAX_EXPECTED`
    /// candidates are expected in it or its cells are as small as its bounds are accurate.
    fn refine(&mut self, bucket: usize, density: f64) {
        for level in 0..=LAST_LEVEL {
            if self.buckets.area(bucket) as f64 * density <= MAX_EXPECTED {
                return;
            }
            // Children may stay in the bucket, at the next level.
            while let Some(cell) = self.buckets.last_of_level(bucket, level)
                && self.divide(cell)
            {}
        }
    }

    /// Divides a leaf into four, and those of its parts that may contain the farthest candidate
    /// again; returns whether it has been divided. Cells that are much smaller than their bounds
    /// are not.
    fn divide(&mut self, number: u32) -> bool {
        let cell = self.cell(number);
        let is_fine = cell.radius * f64::from(2 << BUCKET_BITS) < cell.bound;
        if cell.children != NONE || cell.place.level == LAST_LEVEL || is_fine {
            return false;
        }
        self.leave(number);
        self.near.clear();
        self.sites.gather(cell.centre, cell.reach(), &mut self.near);
        self.divide_among(number, cell.place.corners(), 0);
        true
    }

    /// Divides a leaf with these corners that is in no bucket and whose near sites begin at an
    /// index of `near`.
    fn divide_among(&mut self, number: u32, corners: [DVec3; 4], start: usize) {
        let cell = self.cell(number);
        let corners = Corners::new(cell.place, corners, cell.centre);
        let family = CellFamily::of_children(cell.place, &corners, cell.bound, &self.near[start..]);
        let children = match self.unused.pop() {
            Some(unused) => {
                self.families[unused as usize] = family;
                unused
            }
            None => {
                self.families.push(family);
                u32::try_from(self.families.len() - 1).unwrap_or(u32::MAX)
            }
        };
        self.families[number as usize / 4].set_children(number as usize % 4, children);
        let end = self.near.len();
        for index in 0..4 {
            let number = 4 * children + index;
            let leaf = self.cell(number);
            let is_fine = leaf.radius < FINE * leaf.bound || leaf.place.level == LAST_LEVEL;
            if is_fine || leaf.bound <= self.last_clearance {
                self.enter(number);
                continue;
            }
            let reach_squared = leaf.reach().powi(2);
            for site in start..end {
                let site = self.near[site];
                if site.distance_squared(leaf.centre) <= reach_squared {
                    self.near.push(site);
                }
            }
            self.divide_among(number, corners.of_child(index as usize), end);
            self.near.truncate(end);
        }
    }

    /// Lowers the bounds of the cells of a family and of those below them that have `site` nearer
    /// than all others.
    fn approach(&mut self, number: u32, site: DVec3) {
        let family = &self.families[number as usize];
        let level = family.level();
        let distances = family.approach(site);
        for (cell, (index, distance)) in (4 * number..).zip(distances.into_iter().enumerate()) {
            if distance == f64::INFINITY {
                continue;
            }
            let family = &self.families[number as usize];
            let bounds = family.with_site(index, distance);
            let (before, after) = (family.bound(index), bounds.1);
            let children = family.children(index);
            if children == NONE {
                if bucket_of(after) != bucket_of(before) {
                    self.buckets.leave(cell, level, before);
                    self.buckets.enter(cell, level, after);
                }
                self.families[number as usize].set_bounds(index, bounds);
                continue;
            }
            self.approach(children, site);
            self.families[number as usize].set_bounds(index, bounds);
            if after <= MERGED * self.last_clearance {
                self.merge(cell);
            }
        }
    }

    /// Makes a cell a leaf if its children are leaves.
    fn merge(&mut self, cell: u32) {
        let children = self.cell(cell).children;
        if !self.families[children as usize].has_leaves_only() {
            return;
        }
        for child in 0..4 {
            self.leave(4 * children + child);
        }
        self.unused.push(children);
        self.families[cell as usize / 4].set_children(cell as usize % 4, NONE);
        self.enter(cell);
    }

    /// Adds a leaf to its bucket.
    fn enter(&mut self, cell: u32) {
        let family = &self.families[cell as usize / 4];
        self.buckets.enter(cell, family.level(), family.bound(cell as usize % 4));
    }

    /// Removes a leaf from its bucket.
    fn leave(&mut self, cell: u32) {
        let family = &self.families[cell as usize / 4];
        self.buckets.leave(cell, family.level(), family.bound(cell as usize % 4));
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::patterns::white_noise::uniform_direction;

    const DOMAINS: [Domain; 2] = [Domain::Sphere, Domain::Hemisphere];

    fn rng(seed: u64) -> ChaCha8Rng {
        ChaCha8Rng::seed_from_u64(seed)
    }

    fn clearance(points: &[DVec3], domain: Domain, p: DVec3) -> f64 {
        let nearest = |p: DVec3| points.iter().map(|q| q.distance(p)).fold(f64::INFINITY, f64::min);
        match domain {
            Domain::Sphere => nearest(p),
            Domain::Hemisphere => nearest(p).min(nearest(-p)),
        }
    }

    /// Points in general position, in a cluster with coincident ones, and at both poles.
    fn hostile_sets(domain: Domain) -> Vec<Vec<DVec3>> {
        let own = &mut rng(4);
        let scattered: Vec<_> = (0..40).map(|_| uniform_direction(domain, own)).collect();
        let near = |p: &DVec3| (DVec3::new(0.6, 0.0, 0.8) + 1e-6 * *p).normalize();
        let cluster = scattered.iter().map(near).collect();
        vec![scattered, cluster, vec![DVec3::Z, DVec3::Z, -DVec3::Z], vec![DVec3::X]]
    }

    fn with_points(domain: Domain, points: &[DVec3]) -> CandidateCells {
        let (first, others) = points.split_at(points.len().div_ceil(2));
        let mut cells = CandidateCells::new(domain, first, 0.5);
        others.iter().for_each(|&p| cells.insert(p));
        cells
    }

    /// After points and draws in any order, the leaves cover the domain once, each in its bucket,
    /// and no point of a leaf is farther from the set than its bound.
    #[test]
    fn bounds_hold_and_leaves_cover_the_domain() {
        for domain in DOMAINS {
            for mut points in hostile_sets(domain) {
                let mut cells = with_points(domain, &points);
                let mut rng = rng(5);
                for step in 0..60 {
                    let k = [1, 7, 100_000][step % 3];
                    let next = cells.farthest(k, &mut rng);
                    if step % 4 > 0 {
                        cells.insert(next);
                        points.push(next);
                    }
                }
                let mut total = 0;
                for bucket in 0..cells.buckets.n_buckets() {
                    let mut in_bucket = 0;
                    for level in 0..=LAST_LEVEL {
                        for &leaf in cells.buckets.leaves(bucket, level) {
                            let cell = cells.cell(leaf);
                            assert_eq!(cell.place.level, level);
                            assert!(cell.children == NONE && bucket_of(cell.bound) == bucket);
                            assert!(cell.bound <= largest_bound(bucket));
                            in_bucket += area(level);
                            let p = cell.place.point(rng.random(), rng.random());
                            let far = clearance(&points, domain, p);
                            assert!(far <= cell.bound, "{domain}: {far} in {cell:?}");
                        }
                    }
                    assert_eq!(cells.buckets.area(bucket), in_bucket, "{domain}");
                    total += in_bucket;
                }
                assert_eq!(total, cells.area(), "{domain}");
            }
        }
    }

    /// Returns sqrt(n/2) times the largest difference of the distributions of two samples of equal
    /// number; above 2.7 with probability 1e-6 if both have the same distribution
    /// (Kolmogorov-Smirnov).
    fn difference(mut a: Vec<f64>, mut b: Vec<f64>) -> f64 {
        a.sort_by(f64::total_cmp);
        b.sort_by(f64::total_cmp);
        let below = |x: f64| b.partition_point(|y| *y < x) as f64;
        let largest = a.iter().enumerate().map(|(i, x)| (below(*x) - i as f64).abs());
        largest.fold(0.0, f64::max) / a.len() as f64 * (0.5 * a.len() as f64).sqrt()
    }

    /// Distance from the set and coordinates of the farthest of k candidates, against those of
    /// candidates that are all drawn. A correct program fails with probability 1e-4 (128
    /// comparisons).
    #[test]
    fn the_farthest_candidate_has_the_distribution_of_the_definition() {
        const DRAWS: usize = 1000;
        for domain in DOMAINS {
            for points in hostile_sets(domain) {
                let mut cells = with_points(domain, &points);
                let mut rng = rng(6);
                for k in [1, 2, 12, 90] {
                    let [mut fast, mut slow] = [(); 2].map(|()| vec![Vec::new(); 4]);
                    let record = |to: &mut Vec<Vec<f64>>, p: DVec3| {
                        let features = [clearance(&points, domain, p), p.x, p.y, p.z];
                        to.iter_mut().zip(features).for_each(|(to, x)| to.push(x));
                    };
                    for _ in 0..DRAWS {
                        let p = cells.farthest(k, &mut rng);
                        record(&mut fast, domain.representative(p));
                        let candidates = (0..k).map(|_| uniform_direction(domain, &mut rng));
                        let best = candidates
                            .map(|p| (clearance(&points, domain, p), p))
                            .fold((-1.0, DVec3::ZERO), |a, b| if b.0 > a.0 { b } else { a });
                        record(&mut slow, best.1);
                    }
                    for (i, (fast, slow)) in fast.into_iter().zip(slow).enumerate() {
                        let off = difference(fast, slow);
                        assert!(off < 2.7, "{domain}, {} points, {k}, {i}: {off}", points.len());
                    }
                }
            }
        }
    }
}
