use glam::DVec3;
use rand::{Rng, RngExt};
use sphvar_healpix::{Cell, Nside};

use crate::Domain;
use crate::search::CubeGrid;

/// The level of the smallest cells: the finest resolution that has an [`Nside`].
const LAST_LEVEL: u8 = 29;

/// The number of binary digits of a bound after the first that tell buckets apart: the bounds of a
/// bucket differ by at most 0.4 %.
const BUCKET_BITS: u32 = 8;

/// The number of candidates expected in a bucket above which its cells are divided before any is
/// drawn.
const MAX_EXPECTED: f64 = 8.0;

/// A cell that may contain the farthest candidate is divided until its radius is this fraction of
/// its bound.
const FINE: f64 = 1.0 / 40.0;

/// Cells whose bound is at most this fraction of the last point's clearance are no longer
/// distinguished from their siblings: the number of points has to double before one is visited.
const MERGED: f64 = 0.75;

/// The index of children that do not exist: a root has no parent.
const NONE: u32 = 0;

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
    /// The points, on the hemisphere with their antipodes.
    sites: Vec<DVec3>,
    grid: CubeGrid,
    /// The number of sites at which the grid is replaced.
    crowded_at: usize,
    nodes: Vec<Node>,
    /// First indices of groups of four nodes that are not used.
    unused: Vec<u32>,
    /// The leaves by their bounds, the largest bounds first.
    buckets: Vec<Bucket>,
    /// No bucket before this one has cells.
    first_bucket: usize,
    /// The clearance of the last farthest candidate.
    last_clearance: f64,
    /// The cells of the candidates drawn for one point.
    visited: Vec<u32>,
    /// The sites that can be the nearest ones of a cell that is divided, and after them those of
    /// the child that is.
    near: Vec<DVec3>,
}

/// A cell. The four children of a divided cell are consecutive; the roots are the first nodes.
#[derive(Clone, Copy, Debug)]
struct Node {
    cell: Place,
    centre: DVec3,
    /// No point of the cell is farther from the centre.
    radius: f64,
    /// The distance of the centre from the nearest site.
    distance: f64,
    /// No point of the cell is farther from the nearest site.
    bound: f64,
    /// The first of the children, or `NONE`.
    children: u32,
    /// Where a leaf is among the cells of its level in its bucket.
    place: u32,
}

/// A HEALPix cell.
#[derive(Clone, Copy, Debug)]
struct Place {
    face: u8,
    level: u8,
    ix: u32,
    iy: u32,
}

/// The leaves whose bounds have the same leading digits.
#[derive(Clone, Debug, Default)]
struct Bucket {
    /// In units of the smallest cells.
    area: u64,
    by_level: Vec<Vec<u32>>,
}

impl CandidateCells {
    /// Returns the cells of a set of at least one point, whose last one was at a distance of
    /// `last_clearance` from the others.
    pub(super) fn new(domain: Domain, points: &[DVec3], last_clearance: f64) -> Self {
        let mut cells = Self {
            domain,
            sites: Vec::new(),
            grid: CubeGrid::for_points(1),
            crowded_at: 1,
            nodes: Vec::new(),
            unused: Vec::new(),
            buckets: Vec::new(),
            first_bucket: 0,
            last_clearance,
            visited: Vec::new(),
            near: Vec::new(),
        };
        points.iter().for_each(|&p| cells.add_site(p));
        for face in 0..cells.n_roots() {
            let cell = Place { face, level: 0, ix: 0, iy: 0 };
            let root = Node::new(cell, f64::INFINITY, &cells.sites);
            cells.nodes.push(root);
            cells.enter(u32::from(face));
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
        u64::from(self.n_roots()) << (2 * LAST_LEVEL)
    }

    /// Adds a point to the set.
    pub(super) fn insert(&mut self, point: DVec3) {
        let before = self.sites.len();
        self.add_site(point);
        for site in before..self.sites.len() {
            for root in 0..self.n_roots() {
                self.approach(u32::from(root), self.sites[site]);
            }
        }
    }

    fn add_site(&mut self, point: DVec3) {
        self.sites.push(point);
        if self.domain == Domain::Hemisphere {
            self.sites.push(-point);
        }
        if self.sites.len() >= self.crowded_at {
            self.crowded_at = 2 * self.sites.len();
            self.grid = CubeGrid::for_points(self.crowded_at);
            self.sites.iter().for_each(|&p| self.grid.insert(p));
        } else {
            self.grid.insert(point);
            if self.domain == Domain::Hemisphere {
                self.grid.insert(-point);
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
        while self.buckets[self.first_bucket].area == 0 {
            self.first_bucket += 1;
        }
        // In the order of visits the candidates are at ascending parts of the area: u is that of
        // the next candidate, `before` the area of the buckets that are complete.
        let (mut bucket, mut before, mut u) = (self.first_bucket, 0, 0.0);
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
                let after = before + self.buckets[bucket].area;
                // Rounding does not take u beyond the last cell.
                if u * total < after as f64 || after == self.area() {
                    break;
                }
                before = after;
                bucket += 1;
                is_entered = false;
            }
            if self.buckets[bucket].area == 0 {
                break;
            }
            let cell = self.buckets[bucket].random_cell(rng);
            let candidate = self.nodes[cell as usize].random_point(rng);
            self.visited.push(cell);
            if let Some(farther) = self.grid.clearance(&self.sites, candidate, clearance) {
                (best, best_cell, clearance) = (candidate, Some(cell), farther);
            }
            left -= 1;
        }
        self.last_clearance = clearance.sqrt();
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
        let mut level = 0;
        while level < self.buckets[bucket].by_level.len() {
            if self.buckets[bucket].area as f64 * density <= MAX_EXPECTED {
                return;
            }
            // Children may stay in the bucket, at the next level.
            while let Some(&cell) = self.buckets[bucket].by_level[level].last()
                && self.divide(cell)
            {}
            level += 1;
        }
    }

    /// Divides a leaf into four, and those of its parts that may contain the farthest candidate
    /// again; returns whether it has been divided. Cells that are much smaller than their bounds
    /// are not.
    fn divide(&mut self, cell: u32) -> bool {
        let node = self.nodes[cell as usize];
        let is_fine = node.radius * f64::from(2 << BUCKET_BITS) < node.bound;
        if node.children != NONE || node.cell.level == LAST_LEVEL || is_fine {
            return false;
        }
        self.leave(cell);
        self.near.clear();
        self.grid.gather(&self.sites, node.centre, node.reach(), &mut self.near);
        self.divide_among(cell, 0);
        true
    }

    /// Divides a leaf that is in no bucket and whose near sites begin at an index of `near`.
    fn divide_among(&mut self, cell: u32, start: usize) {
        let node = self.nodes[cell as usize];
        let children = self.unused.pop().unwrap_or_else(|| {
            let end = self.nodes.len();
            self.nodes.extend([node; 4]);
            u32::try_from(end).unwrap_or(u32::MAX)
        });
        self.nodes[cell as usize].children = children;
        let end = self.near.len();
        for child in 0..4 {
            let leaf = Node::new(node.cell.child(child), node.bound, &self.near[start..]);
            let index = children + child;
            self.nodes[index as usize] = leaf;
            let is_fine = leaf.radius < FINE * leaf.bound || leaf.cell.level == LAST_LEVEL;
            if is_fine || leaf.bound <= self.last_clearance {
                self.enter(index);
                continue;
            }
            let reach_squared = leaf.reach().powi(2);
            for site in start..end {
                let site = self.near[site];
                if site.distance_squared(leaf.centre) <= reach_squared {
                    self.near.push(site);
                }
            }
            self.divide_among(index, end);
            self.near.truncate(end);
        }
    }

    /// Lowers the bounds of a cell and of those below it that have `site` nearer than all others.
    fn approach(&mut self, cell: u32, site: DVec3) {
        let node = self.nodes[cell as usize];
        let distance = site.distance(node.centre);
        let radius = node.radius;
        // At a centre below this one, at most a radius away, the other sites are nearer.
        if distance - radius >= node.distance + radius {
            return;
        }
        let nearest = distance.min(node.distance);
        let bound = node.bound.min(nearest + radius);
        if node.children == NONE {
            if bucket_of(bound) != bucket_of(node.bound) {
                self.leave(cell);
                self.nodes[cell as usize].bound = bound;
                self.enter(cell);
            }
            let node = &mut self.nodes[cell as usize];
            (node.distance, node.bound) = (nearest, bound);
            return;
        }
        for child in node.children..node.children + 4 {
            self.approach(child, site);
        }
        let node = &mut self.nodes[cell as usize];
        (node.distance, node.bound) = (nearest, bound);
        if bound <= MERGED * self.last_clearance {
            self.merge(cell);
        }
    }

    /// Makes a cell a leaf if its children are leaves.
    fn merge(&mut self, cell: u32) {
        let children = self.nodes[cell as usize].children;
        let family = children as usize..children as usize + 4;
        if self.nodes[family].iter().any(|child| child.children != NONE) {
            return;
        }
        for child in children..children + 4 {
            self.leave(child);
        }
        self.unused.push(children);
        self.nodes[cell as usize].children = NONE;
        self.enter(cell);
    }

    /// Adds a leaf to its bucket.
    fn enter(&mut self, cell: u32) {
        let node = &mut self.nodes[cell as usize];
        let (number, level) = (bucket_of(node.bound), usize::from(node.cell.level));
        if number >= self.buckets.len() {
            self.buckets.resize_with(number + 1, Bucket::default);
        }
        self.first_bucket = self.first_bucket.min(number);
        let bucket = &mut self.buckets[number];
        if level >= bucket.by_level.len() {
            bucket.by_level.resize_with(level + 1, Vec::new);
        }
        let cells = &mut bucket.by_level[level];
        // Cells have 32-bit numbers.
        node.place = u32::try_from(cells.len()).unwrap_or(u32::MAX);
        cells.push(cell);
        bucket.area += area(level);
    }

    /// Removes a leaf from its bucket.
    fn leave(&mut self, cell: u32) {
        let Node { bound, cell, place, .. } = self.nodes[cell as usize];
        let level = usize::from(cell.level);
        let bucket = &mut self.buckets[bucket_of(bound)];
        bucket.area -= area(level);
        let cells = &mut bucket.by_level[level];
        cells.swap_remove(place as usize);
        if let Some(&moved) = cells.get(place as usize) {
            self.nodes[moved as usize].place = place;
        }
    }
}

impl Bucket {
    /// Returns a random cell, with probability proportional to its area, which is not 0 in all.
    fn random_cell(&self, rng: &mut dyn Rng) -> u32 {
        let mut at = rng.random_range(0..self.area);
        for (level, cells) in self.by_level.iter().enumerate() {
            let index = at / area(level);
            match usize::try_from(index).ok().and_then(|index| cells.get(index)) {
                Some(&cell) => return cell,
                None => at -= cells.len() as u64 * area(level),
            }
        }
        NONE
    }
}

impl Node {
    /// Returns a cell with a bound of at most `bound`, that of its parent. `sites` contain the
    /// nearest ones of all points of the cell.
    fn new(cell: Place, bound: f64, sites: &[DVec3]) -> Self {
        let centre = cell.point(0.5, 0.5);
        let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)];
        let corners = corners.map(|(u, v)| cell.point(u, v));
        // A ball that contains the corners contains the chords between them.
        let sagitta = cell.sagitta();
        let farthest = |p: DVec3| {
            let [a, b, c, d] = corners;
            let [a, b, c, d] = [a, b, c, d].map(|corner: DVec3| corner.distance_squared(p));
            a.max(b).max(c.max(d))
        };
        let (mut distance, mut far) = (f64::INFINITY, f64::INFINITY);
        for &site in sites {
            distance = distance.min(site.distance_squared(centre));
            far = far.min(farthest(site));
        }
        let radius = farthest(centre).sqrt() + sagitta;
        let distance = distance.sqrt();
        let bound = bound.min(far.sqrt() + sagitta).min(distance + radius);
        Self { cell, centre, radius, distance, bound, children: NONE, place: 0 }
    }

    /// Returns the distance from the centre within which the nearest sites of all points of the
    /// cell lie: they are at most `distance + radius` away from points that are at most `radius`
    /// away from the centre.
    fn reach(&self) -> f64 {
        (self.distance + 2.0 * self.radius) * (1.0 + 4.0 * f64::EPSILON)
    }

    fn random_point(&self, rng: &mut dyn Rng) -> DVec3 {
        self.cell.point(rng.random(), rng.random())
    }
}

impl Place {
    /// Returns a point of the cell by its coordinates in the cell.
    fn point(self, u: f64, v: f64) -> DVec3 {
        let Self { face, level, ix, iy } = self;
        let cell = Nside::new(1 << level).and_then(|nside| Cell::new(nside, face, ix, iy));
        cell.map_or(DVec3::Z, |cell| cell.uniform_point(u, v))
    }

    fn child(self, child: u32) -> Self {
        let (ix, iy) = (2 * self.ix + child % 2, 2 * self.iy + child / 2);
        Self { face: self.face, level: self.level + 1, ix, iy }
    }

    /// Returns a distance that points of the edges do not exceed from the chords between corners.
    ///
    /// An edge leaves its chord by at most `max |X''|/(8 nside^2)`, where `X''` is the second
    /// derivative with respect to a coordinate of the face: below 2 in the belt, below `1.3 +
    /// 2.02/d` in the caps at a distance of d sides of a face from the pole, and below 1 on the
    /// meridians through the pole.
    fn sagitta(self) -> f64 {
        let side = 1 << self.level;
        let from_pole = match self.face / 4 {
            0 => 2 * (side - 1) - self.ix - self.iy,
            1 => side,
            _ => self.ix + self.iy,
        };
        let side = f64::from(side);
        let second = 2.0 + 2.02 * side / f64::from(from_pole.max(1));
        // Points are rounded by a few units in the last place.
        second / (8.0 * side * side) + 16.0 * f64::EPSILON
    }
}

/// Returns the area of a cell in units of the smallest ones.
fn area(level: usize) -> u64 {
    1 << (2 * (usize::from(LAST_LEVEL) - level))
}

/// More than every bound.
const TOP: f64 = 4.0;

/// The number of digits of a bound that buckets do not distinguish.
const SHIFT: u32 = f64::MANTISSA_DIGITS - 1 - BUCKET_BITS;

fn bucket_of(bound: f64) -> usize {
    // Fewer than 2^(BUCKET_BITS + 6), since bounds are not below the radius of the smallest cells.
    usize::try_from((TOP.to_bits() - bound.to_bits()) >> SHIFT).unwrap_or(usize::MAX)
}

/// Returns the largest bound of a bucket.
fn largest_bound(bucket: usize) -> f64 {
    f64::from_bits(TOP.to_bits() - ((bucket as u64) << SHIFT))
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

    #[test]
    fn cells_lie_within_their_radius() {
        for level in 0..=6_u8 {
            let side = 1 << level;
            for (face, ix, iy) in
                (0..12).flat_map(|f| (0..side * side).map(move |i| (f, i % side, i / side)))
            {
                let cell = Place { face, level, ix, iy };
                let at = |u, v| cell.point(u, v);
                let Node { centre, radius, .. } = Node::new(cell, 9.0, &[DVec3::Z]);
                let mut farthest: f64 = 0.0;
                for t in (0..=8).map(|t| f64::from(t) / 8.0) {
                    for p in [at(t, 0.0), at(t, 1.0), at(0.0, t), at(1.0, t)] {
                        farthest = farthest.max(p.distance(centre));
                    }
                }
                assert!(farthest < radius, "{level} {face} {ix} {iy}: {farthest}, {radius}");
                // Small cells away from the poles have straight edges.
                let is_flat = level == 6 && face / 4 == 1;
                assert!(!is_flat || farthest > 0.98 * radius, "{ix} {iy}: {farthest}, {radius}");
            }
        }
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
                for (number, bucket) in cells.buckets.iter().enumerate() {
                    let mut in_bucket = 0;
                    for (level, leaves) in bucket.by_level.iter().enumerate() {
                        for (place, &leaf) in leaves.iter().enumerate() {
                            let node = cells.nodes[leaf as usize];
                            assert_eq!(
                                (usize::from(node.cell.level), node.place as usize),
                                (level, place)
                            );
                            assert!(node.children == NONE && node.bound <= largest_bound(number));
                            in_bucket += area(level);
                            let far = clearance(&points, domain, node.random_point(&mut rng));
                            assert!(far <= node.bound, "{domain}: {far} in {node:?}");
                        }
                    }
                    assert_eq!(bucket.area, in_bucket, "{domain}");
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
