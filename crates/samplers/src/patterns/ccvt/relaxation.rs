use glam::DVec3;
use pulp::Arch;

use super::block::Block;
use super::site_tree::{SiteTree, chord};
use crate::Stopped;

/// Maximum number of steps of a site to its mean. Each step reduces the distance by a factor of the
/// squared radius of the cell, at worst (half the sphere) to a quarter.
const MAX_STEPS: usize = 60;

/// Steps shorter than this (radians) are within rounding.
const SHORTEST_STEP: f64 = 1e-15;

/// Distance to its mean (radians) below which a site counts as converged: it changes no squared
/// distance by more than the tolerance of exchanges, and exceeds the accumulated rounding of steps.
const AT_REST: f64 = 1e-13;

/// Margin, in units of sqrt(4 pi/N), by which balls may grow before the list of pairs is rebuilt.
/// Values from 0.05 to 0.5 take the same time: a larger margin makes the list longer, a smaller one
/// makes rebuilding more frequent.
const SLACK: f64 = 0.2;

/// Squared geodesic distances that differ by less than this count as equal: a few roundings of
/// `2 - 2 cos d`.
const ROUNDING: f64 = 2e-15;

/// Mass points sorted by site, `capacity` to each, and the exchanges that lower their energy.
#[derive(Clone, Debug)]
pub(super) struct Relaxation {
    arch: Arch,
    antipodal: bool,
    capacity: usize,
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
    sites: Vec<DVec3>,
    /// Bounds on the chord from a site to its points.
    radii: Vec<f64>,
}

/// The outcome of a relaxation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outcome {
    pub(super) passes: usize,
    pub(super) is_settled: bool,
}

/// Two sites whose exchange of points may lower the energy.
#[derive(Clone, Copy, Debug)]
struct Pair {
    sites: [usize; 2],
    /// The change counters of the two sites at the last visit; `None` if never visited.
    seen: Option<[u32; 2]>,
    /// The sum of the sites' path lengths up to which no exchange can lower the energy.
    limit: f64,
}

/// The state kept from pass to pass.
#[derive(Debug)]
struct Progress {
    pairs: Vec<Pair>,
    tree: SiteTree,
    /// Number of changes of each site's points.
    changes: Vec<u32>,
    /// Whether the site has not moved to its mean since its points changed.
    stale: Vec<bool>,
    /// The path length of the site so far.
    paths: Vec<f64>,
    /// Radius and path length when the list of pairs was built.
    reach: Vec<f64>,
    slack: f64,
    /// Scratch buffers: the energy reduction for moving each point of the two sites, and the points
    /// worth moving.
    reductions: [Vec<f64>; 2],
    candidates: [Vec<(f64, usize)>; 2],
}

impl Relaxation {
    /// Assigns `capacity` consecutive points to each site and places the sites at their means.
    pub(super) fn new(points: &[DVec3], capacity: usize, antipodal: bool) -> Self {
        let column = |of: fn(&DVec3) -> f64| points.iter().map(of).collect();
        let middle = |cell: &[DVec3]| {
            // If the points cancel, as few points can, they have no mean; the first point is the
            // start.
            cell.iter().sum::<DVec3>().try_normalize().unwrap_or(cell[0])
        };
        let sites: Vec<_> = points.chunks_exact(capacity).map(middle).collect();
        let radii = vec![2.0; sites.len()];
        let (x, y, z) = (column(|p| p.x), column(|p| p.y), column(|p| p.z));
        Self { arch: Arch::new(), antipodal, capacity, x, y, z, sites, radii }
    }

    pub(super) fn sites(&self) -> &[DVec3] {
        &self.sites
    }

    /// Places a site at the given direction.
    pub(super) fn place(&mut self, k: usize, site: DVec3) {
        self.sites[k] = site;
        self.radii[k] = 2.0;
    }

    pub(super) fn cell(&self, k: usize) -> impl ExactSizeIterator<Item = DVec3> + '_ {
        let Block { x, y, z } = self.block(k);
        x.iter().zip(y).zip(z).map(|((&x, &y), &z)| DVec3::new(x, y, z))
    }

    /// Returns the number of sites times the mean squared distance from a point to its site.
    pub(super) fn energy(&self) -> f64 {
        let energy = |k: usize| {
            let (site, max_chord2) = (self.sites[k], self.radii[k].powi(2));
            self.block(k).moments(self.arch, self.antipodal, site, max_chord2).energy
        };
        (0..self.sites.len()).map(energy).sum::<f64>() / self.capacity as f64
    }

    /// Exchanges points until no exchange lowers the energy and all sites are at the means of their
    /// points, or until `max_passes` passes are done.
    pub(super) fn run(
        &mut self,
        max_passes: usize,
        tick: &dyn Fn() -> Result<(), Stopped>,
    ) -> Result<Outcome, Stopped> {
        let n = self.sites.len();
        for k in 0..n {
            self.centre(k, MAX_STEPS);
        }
        let mut progress = Progress::new(n, self.capacity);
        self.list_pairs(&mut progress);
        let mut is_thorough = true;
        for passes in 1..=max_passes {
            tick()?;
            if progress.has_outgrown(&self.radii) {
                self.list_pairs(&mut progress);
            }
            let mut is_quiet = true;
            for at in 0..progress.pairs.len() {
                is_quiet &= !self.visit(at, &mut progress);
            }
            // While points are still exchanged, one step suffices in place of the exact mean.
            let steps = if is_quiet { MAX_STEPS } else { 1 };
            for k in 0..n {
                if progress.stale[k] {
                    let way = self.centre(k, steps);
                    progress.paths[k] += way;
                    progress.stale[k] = way > AT_REST;
                    is_quiet &= way <= AT_REST;
                }
            }
            if is_quiet && is_thorough {
                return Ok(Outcome { passes, is_settled: true });
            }
            // Apparent convergence is verified without the cached state.
            is_thorough = is_quiet;
            if is_thorough {
                progress.pairs.clear();
                self.list_pairs(&mut progress);
            }
        }
        Ok(Outcome { passes: max_passes, is_settled: false })
    }

    fn point(&self, p: usize) -> DVec3 {
        DVec3::new(self.x[p], self.y[p], self.z[p])
    }

    fn block(&self, k: usize) -> Block<'_> {
        let cell = k * self.capacity..(k + 1) * self.capacity;
        Block { x: &self.x[cell.clone()], y: &self.y[cell.clone()], z: &self.z[cell] }
    }

    /// Takes up to `max_steps` steps to the mean of the site's points: each is the exponential of
    /// the mean logarithm, whose fixed point makes the sum of squared distances stationary (Karcher
    /// 1977). Returns the length of the path.
    fn centre(&mut self, k: usize, max_steps: usize) -> f64 {
        let mut way = 0.0;
        for _ in 0..max_steps {
            let site = self.sites[k];
            let max_chord2 = self.radii[k].powi(2);
            let moments = self.block(k).moments(self.arch, self.antipodal, site, max_chord2);
            let sum = moments.sum - moments.sum.dot(site) * site;
            let step = sum / self.capacity as f64;
            let length = step.length();
            self.radii[k] = moments.max_chord2.max(0.0).sqrt() + length;
            if length < SHORTEST_STEP {
                break;
            }
            let (sin, cos) = length.sin_cos();
            self.sites[k] = (site * cos + step * (sin / length)).normalize();
            way += length;
        }
        way
    }

    /// Lists the pairs of sites whose balls intersect within the margin, and keeps the state of
    /// known pairs.
    fn list_pairs(&mut self, progress: &mut Progress) {
        let Progress { pairs, tree, .. } = progress;
        let known = std::mem::take(pairs);
        tree.find(self.antipodal, &self.sites, &self.radii, progress.slack, |i, j| {
            pairs.push(Pair { sites: [i, j], seen: None, limit: 0.0 });
        });
        pairs.sort_unstable_by_key(|pair| pair.sites);
        let mut known = known.into_iter().peekable();
        for pair in pairs {
            while known.next_if(|other| other.sites < pair.sites).is_some() {}
            if let Some(same) = known.next_if(|other| other.sites == pair.sites) {
                *pair = same;
            }
        }
        progress.reach.clear();
        progress.reach.extend(self.radii.iter().zip(&progress.paths).map(|(r, path)| r + path));
    }

    /// Performs all exchanges between two sites that lower the energy at once, pairing the points
    /// with the largest reductions. Returns whether there were any.
    fn visit(&mut self, at: usize, progress: &mut Progress) -> bool {
        let Progress { pairs, changes, stale, paths, reductions, candidates, .. } = progress;
        let pair = &mut pairs[at];
        let [i, j] = pair.sites;
        let path = paths[i] + paths[j];
        let now = Some([changes[i], changes[j]]);
        if pair.seen == now && path <= pair.limit {
            return false;
        }
        pair.seen = now;
        let sites = [self.sites[i], self.sites[j]];
        let distance = chord(self.antipodal, sites[0], sites[1]);
        let reach = self.radii[i] + self.radii[j];
        if distance >= reach {
            // Every point of a site is at least as near to it as any point of the other site, so no
            // exchange lowers the energy.
            pair.limit = path + 0.5 * (distance - reach);
            return false;
        }
        let max_chord2 = (distance + self.radii[i].max(self.radii[j])).powi(2);
        let [max_i, max_j] = [(i, 0, 1), (j, 1, 0)].map(|(k, own, other)| {
            let [from, to] = [sites[own], sites[other]];
            self.block(k).reductions_into(
                self.arch,
                self.antipodal,
                from,
                to,
                max_chord2,
                &mut reductions[own],
            )
        });
        let tolerance = self.tolerance();
        if max_i + max_j <= tolerance {
            // A step of a site changes d^2 by at most 2 d times its length. No d exceeds `reach`
            // plus the other radius for small balls; the final verification covers large ones.
            pair.limit = path - (max_i + max_j) / (4.2 * reach);
            return false;
        }
        candidates[0].clear();
        candidates[1].clear();
        add_candidates(&reductions[0], tolerance - max_j, &mut candidates[0]);
        add_candidates(&reductions[1], tolerance - max_i, &mut candidates[1]);
        for (&(reduction_i, a), &(reduction_j, b)) in candidates[0].iter().zip(&candidates[1]) {
            if reduction_i + reduction_j <= tolerance {
                break;
            }
            let (a, b) = (i * self.capacity + a, j * self.capacity + b);
            self.x.swap(a, b);
            self.y.swap(a, b);
            self.z.swap(a, b);
            self.radii[i] = self.radii[i].max(chord(self.antipodal, sites[0], self.point(a)));
            self.radii[j] = self.radii[j].max(chord(self.antipodal, sites[1], self.point(b)));
        }
        for k in [i, j] {
            changes[k] = changes[k].wrapping_add(1);
            stale[k] = true;
            paths[k] += self.centre(k, 1);
        }
        true
    }

    /// Returns the minimum reduction of the sum of squared distances by an exchange: 1e-12 of a
    /// cell's area, and more than rounding, so that the energy decreases every time and the
    /// exchanges terminate.
    fn tolerance(&self) -> f64 {
        1e-11 / self.sites.len() as f64 + ROUNDING
    }
}

impl Progress {
    fn new(n: usize, capacity: usize) -> Self {
        Self {
            pairs: Vec::new(),
            tree: SiteTree::default(),
            changes: vec![0; n],
            stale: vec![true; n],
            paths: vec![0.0; n],
            reach: Vec::new(),
            slack: SLACK * (4.0 * std::f64::consts::PI / n as f64).sqrt(),
            reductions: [vec![0.0; capacity], vec![0.0; capacity]],
            candidates: [Vec::new(), Vec::new()],
        }
    }

    /// Returns whether balls that did not intersect when the list was built may do so now.
    fn has_outgrown(&self, radii: &[f64]) -> bool {
        let grown = radii.iter().zip(&self.paths).zip(&self.reach);
        grown.map(|((r, path), reach)| r + path - reach).fold(0.0, f64::max) > 0.5 * self.slack
    }
}

/// Adds the points with a reduction above `min`, the largest first; ties in their order.
fn add_candidates(reductions: &[f64], min: f64, candidates: &mut Vec<(f64, usize)>) {
    candidates.extend(
        reductions.iter().zip(0..).filter(|&(&reduction, _)| reduction > min).map(|(&g, k)| (g, k)),
    );
    candidates.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
}
