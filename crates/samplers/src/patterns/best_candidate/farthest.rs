use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use rand::{Rng, RngExt};

use super::bisector::Region;
use super::sum_tree::SumTree;
use super::voronoi_edges::{Edge, VoronoiEdges};
use crate::Domain;

/// The minimum number of candidates expected above a new level. Fewer mean fewer draws, and more
/// new levels.
const EXPECTED: f64 = 5.0;

/// The number of expected candidates above which the level is raised.
const MAX_EXPECTED: f64 = 4.0 * EXPECTED;

/// The depth of the first level, about the share of one in 10^10 candidates; levels are not set at
/// smaller depths.
const MIN_DEPTH: f64 = 1e-10;

/// The factor by which the level is lowered further below the largest distance until it is low
/// enough.
const WIDER: f64 = 1.3;

/// No slot.
const NONE: u32 = u32::MAX;

/// Draws the farthest of a number of uniform candidates from a growing set of points without
/// drawing the others.
///
/// The Voronoi diagram of the points divides the directions farther than a level from all points
/// into regions of known area, one on each side of the foot of an edge and on both sides of the
/// edge. From their total area A follows whether there is a next candidate above the level; only
/// these are drawn, and the farthest of them is the farthest of all. If there is none, a lower
/// level is next, and the candidates between the two. The result has exactly the distribution of
/// the farthest of independent uniform candidates, for any levels.
///
/// On the hemisphere distances are antipodal: each point is two sites, and candidates are drawn on
/// the whole sphere.
#[derive(Debug)]
pub(super) struct Farthest {
    domain: Domain,
    diagram: VoronoiEdges,
    /// Half the square of a distance, as in [`Bisector`](super::bisector::Bisector).
    level: f64,
    /// What the level was below the largest distance when it was set.
    depth: f64,
    /// The areas above the level of the pieces of the edges with a slot, two for each slot.
    areas: SumTree,
    /// The edges by slot: those that reach above the level, and what is left of others.
    slots: Vec<u32>,
    unused: Vec<u32>,
    /// The slots by edge.
    slot_of: Vec<u32>,
}

/// A candidate and the number of its nearest site.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub(super) direction: DVec3,
    nearest: u32,
}

/// A candidate on either side of an edge, as in [`Bisector::draw`](super::bisector::Bisector).
#[derive(Clone, Copy, Debug)]
struct Drawn {
    edge: u32,
    region: Region,
    half: DVec2,
    distance: f64,
}

impl Farthest {
    /// Returns the set of one point.
    pub(super) fn new(domain: Domain, point: DVec3) -> Self {
        let mut set = Self {
            domain,
            diagram: VoronoiEdges::default(),
            level: f64::INFINITY,
            depth: MIN_DEPTH,
            areas: SumTree::new(&[]),
            slots: Vec::new(),
            unused: Vec::new(),
            slot_of: Vec::new(),
        };
        set.insert_sites(point, 0);
        set
    }

    /// Adds a candidate to the set.
    pub(super) fn insert(&mut self, Candidate { direction, nearest }: Candidate) {
        self.insert_sites(direction, nearest);
    }

    fn insert_sites(&mut self, point: DVec3, nearest: u32) {
        self.insert_site(point, nearest);
        if self.domain == Domain::Hemisphere {
            // Antipodes have successive numbers. That of the first point is nearest to it.
            self.insert_site(-point, nearest ^ u32::from(self.diagram.n_sites() > 1));
        }
    }

    fn insert_site(&mut self, site: DVec3, nearest: u32) {
        self.diagram.insert(site, nearest);
        for index in 0..self.diagram.changed().len() {
            let edge = self.diagram.changed()[index];
            self.update(edge);
        }
    }

    /// Sets the areas of an edge that has changed.
    fn update(&mut self, edge: u32) {
        let index = edge as usize;
        if index >= self.slot_of.len() {
            self.slot_of.resize(index + 1, NONE);
        }
        let slot = self.slot_of[index];
        if self.diagram.tops()[index] > self.level {
            let slot = if slot == NONE { self.new_slot(edge) } else { slot };
            self.areas.set_pair(slot as usize, self.areas_of(edge));
        } else if slot != NONE {
            self.areas.set_pair(slot as usize, [0.0; 2]);
            self.unused.push(slot);
            self.slot_of[index] = NONE;
        }
    }

    fn new_slot(&mut self, edge: u32) -> u32 {
        let slot = match self.unused.pop() {
            Some(slot) => {
                self.slots[slot as usize] = edge;
                slot
            }
            None => {
                self.slots.push(edge);
                u32::try_from(self.slots.len() - 1).unwrap_or(NONE)
            }
        };
        self.slot_of[edge as usize] = slot;
        slot
    }

    /// Returns the areas above the level at the pieces of an edge.
    fn areas_of(&self, edge: u32) -> [f64; 2] {
        let (Edge { arc, .. }, bisector) = self.diagram.edge(edge);
        let area = |piece| bisector.area(&bisector.above(piece, self.level));
        arc.pieces().map(|piece| piece.map_or(0.0, area))
    }

    /// Returns the farthest of `n_candidates` uniform candidates, of which there is at least one.
    pub(super) fn farthest(&mut self, n_candidates: u64, rng: &mut dyn Rng) -> Candidate {
        if self.diagram.tops().is_empty() {
            return self.farthest_from_one(n_candidates, rng);
        }
        let density = n_candidates as f64 / (4.0 * PI);
        while density * self.areas.total() > MAX_EXPECTED && self.depth > MIN_DEPTH {
            let before = self.areas.total();
            self.depth *= 0.5;
            self.lower(density, f64::INFINITY);
            // Where the area depends on the level so much that there is none between, more are drawn.
            if self.areas.total() >= before {
                break;
            }
        }
        let mut best: Option<Drawn> = None;
        let mut ceiling = f64::INFINITY;
        // In the order of the levels the candidates are at ascending parts of the area: u is that
        // of the next candidate.
        let mut u = 0.0;
        let mut left = n_candidates;
        while left > 0 {
            // The least of `left` uniform numbers in [u, 1).
            let uniform = 1.0 - rng.random::<f64>();
            u -= (1.0 - u) * libm::expm1(libm::log(uniform) / left as f64);
            // Rounding does not take u beyond the last level, 0.
            while u * (4.0 * PI) >= self.areas.total() && self.level > 0.0 {
                if let Some(best) = best {
                    return self.candidate(&best, rng);
                }
                ceiling = self.level;
                self.lower(density, ceiling);
            }
            let Some(drawn) = self.draw(ceiling, rng) else {
                break;
            };
            if best.is_none_or(|best| drawn.distance > best.distance) {
                best = Some(drawn);
            }
            left -= 1;
        }
        match best {
            Some(best) => self.candidate(&best, rng),
            None => self.farthest_from_one(n_candidates, rng),
        }
    }

    /// Lowers the level to one that is `below` another and has enough candidates above it.
    fn lower(&mut self, density: f64, below: f64) {
        let top = self.diagram.tops().iter().copied().fold(0.0, f64::max);
        loop {
            let level = (top - self.depth).max(0.0);
            if level < below {
                self.set_level(level);
                let expected = density * self.areas.total();
                if level == 0.0 || expected >= EXPECTED {
                    if expected > 2.0 * EXPECTED {
                        self.depth /= WIDER;
                    }
                    return;
                }
            }
            self.depth *= WIDER;
        }
    }

    fn set_level(&mut self, level: f64) {
        self.level = level;
        for &edge in &self.slots {
            self.slot_of[edge as usize] = NONE;
        }
        self.slots.clear();
        self.unused.clear();
        for (edge, &top) in (0..).zip(self.diagram.tops()) {
            if top > level {
                self.slot_of[edge as usize] = u32::try_from(self.slots.len()).unwrap_or(NONE);
                self.slots.push(edge);
            }
        }
        let areas: Vec<f64> = self.slots.iter().flat_map(|&edge| self.areas_of(edge)).collect();
        self.areas = SumTree::new(&areas);
    }

    /// Draws a candidate above the level and not above `ceiling`, or `None` if there is a single
    /// site.
    fn draw(&self, ceiling: f64, rng: &mut dyn Rng) -> Option<Drawn> {
        loop {
            let leaf = self.areas.find(self.areas.total() * rng.random::<f64>());
            let edge = *self.slots.get(leaf / 2)?;
            let (Edge { arc, .. }, bisector) = self.diagram.edge(edge);
            let region = bisector.above(arc.pieces()[leaf % 2]?, self.level);
            let (distance, half) = bisector.draw(&region, rng);
            if distance <= ceiling {
                return Some(Drawn { edge, region, half, distance });
            }
        }
    }

    /// Returns the candidate that has been drawn, on a random side of its edge.
    fn candidate(&self, drawn: &Drawn, rng: &mut dyn Rng) -> Candidate {
        let (edge, bisector) = self.diagram.edge(drawn.edge);
        let nearest = edge.sites[usize::from(rng.random::<bool>())];
        let site = self.diagram.site(nearest);
        let direction = bisector.place(site, &drawn.region, drawn.half, drawn.distance);
        Candidate { direction, nearest }
    }

    /// Returns the farthest candidate from a single site.
    fn farthest_from_one(&self, n_candidates: u64, rng: &mut dyn Rng) -> Candidate {
        // The largest of uniform numbers in (0, 1].
        let uniform = 1.0 - rng.random::<f64>();
        let q = 2.0 * libm::exp(libm::log(uniform) / n_candidates as f64);
        let (sine, cosine) = libm::sincos(2.0 * PI * rng.random::<f64>());
        let site = self.diagram.site(0);
        let (x, y) = site.any_orthonormal_pair();
        let direction = site * (1.0 - q) + (x * cosine + y * sine) * (q * (2.0 - q)).sqrt();
        Candidate { direction: direction.normalize(), nearest: 0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Pattern, Purpose, Streams};

    /// Returns half the squared distance of the nearest site, and its number.
    fn nearest(set: &Farthest, p: DVec3) -> (f64, u32) {
        let distance = |k: usize| {
            let number = u32::try_from(k).unwrap();
            (0.5 * set.diagram.site(number).distance_squared(p), number)
        };
        let sites = (0..set.diagram.n_sites()).map(distance);
        sites.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
    }

    /// Returns the share of the sphere that is above a level.
    fn share_above(set: &mut Farthest, level: f64) -> f64 {
        let before = set.level;
        set.set_level(level);
        let share = set.areas.total() / (4.0 * PI);
        set.set_level(before);
        share
    }

    /// Distances of candidates against a search of all sites, and areas that are kept up to date
    /// against new ones; at level 0 they are the sphere.
    #[test]
    fn candidates_and_areas_match_all_sites() {
        for domain in [Domain::Sphere, Domain::Hemisphere] {
            for factor in [1, 50, u64::from(u32::MAX)] {
                let mut rng = Streams::new(3, Purpose::Pattern, 1).realization(0);
                let mut set = Farthest::new(domain, DVec3::new(0.6, 0.0, 0.8));
                for n in 1..200 {
                    let candidate = set.farthest(factor * n, &mut rng);
                    let (distance, site) = nearest(&set, candidate.direction);
                    let of_nearest = set.diagram.site(candidate.nearest);
                    let stated = 0.5 * of_nearest.distance_squared(candidate.direction);
                    assert!((stated - distance).abs() < 1e-13, "{domain} {factor} {n} {site}");
                    assert!(candidate.direction.is_normalized());
                    set.insert(candidate);
                    let (kept, level) = (set.areas.total(), set.level);
                    let off = share_above(&mut set, level) - kept / (4.0 * PI);
                    assert!(off.abs() < 1e-14 || level > 4.0, "{domain} {factor} {n}: {off}");
                    let off = share_above(&mut set, 0.0) - 1.0;
                    // The sum of almost antipodal sites has few digits.
                    assert!(off.abs() < 1e-9, "{domain} {factor} {n}: {off}");
                }
            }
        }
    }

    /// Sites in special position: the areas are those of the definition within the errors of
    /// 20000 uniform directions, at 5 standard deviations.
    #[test]
    fn areas_of_hostile_sites_match_their_definition() {
        let mut rng = Streams::new(2, Purpose::Pattern, 0).realization(0);
        let mut white =
            |n| Pattern::WhiteNoise.build(n, Domain::Sphere).unwrap().sample(&mut rng).unwrap();
        let directions = white(20_000).points;
        let centre = DVec3::new(0.0, 0.6, 0.8);
        let cluster = |size: f64, points: &[DVec3]| -> Vec<DVec3> {
            points.iter().map(|&p| (centre + size * p).normalize()).collect()
        };
        let noise = white(25).points;
        let equator = |n: u32| {
            let angles = (0..n).map(move |k| 2.0 * PI * f64::from(k) / f64::from(n));
            angles.map(|t| DVec3::new(libm::cos(t), libm::sin(t), 0.0)).collect::<Vec<_>>()
        };
        let axes = [DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z];
        let cube: Vec<DVec3> = (0..8)
            .map(|k| DVec3::from([1, 2, 4].map(|bit| if k & bit == 0 { -1.0 } else { 1.0 })))
            .map(DVec3::normalize)
            .collect();
        let half = |p: &&DVec3| p.z > 0.3;
        let mut sets = vec![
            axes.to_vec(),
            cube,
            equator(4),
            equator(7),
            [equator(12), axes[4..].to_vec()].concat(),
            [vec![DVec3::X; 3], noise.clone(), noise[..5].to_vec()].concat(),
            noise.iter().filter(half).copied().collect(),
        ];
        for size in [0.5, 1e-3, 1e-6] {
            sets.push([cluster(size, &noise), axes.to_vec()].concat());
        }
        // Alone, edges of a closer cluster meet beyond the rounding errors of their directions.
        sets.extend([0.5, 1e-3].map(|size| cluster(size, &noise)));
        for (index, sites) in sets.iter().enumerate() {
            let mut set = Farthest::new(Domain::Sphere, sites[0]);
            for &site in &sites[1..] {
                let (_, nearest) = nearest(&set, site);
                set.insert(Candidate { direction: site, nearest });
            }
            let off = share_above(&mut set, 0.0) - 1.0;
            assert!(off.abs() < 1e-6, "set {index}: {off}");
            for level in [0.02, 0.1, 0.4, 1.0, 1.5] {
                let share = share_above(&mut set, level);
                let above = directions.iter().filter(|&&p| nearest(&set, p).0 > level).count();
                let measured = above as f64 / directions.len() as f64;
                let sigma = (share * (1.0 - share) / directions.len() as f64).max(0.0).sqrt();
                let off = (share - measured).abs();
                assert!(off <= 5.0 * sigma + 1e-6, "set {index}, {level}: {share} {measured}");
            }
            // Candidates of every number are available.
            for n in [1, 1000, 1 << 40] {
                let candidate = set.farthest(n, &mut rng_of(n));
                let off = nearest(&set, candidate.direction).0
                    - 0.5
                        * set.diagram.site(candidate.nearest).distance_squared(candidate.direction);
                assert!(off.abs() < 1e-6, "set {index}, {n}: {off}");
            }
        }
    }

    fn rng_of(seed: u64) -> impl Rng {
        Streams::new(seed, Purpose::Pattern, 1).realization(0)
    }
}
