use std::array;

use pulp::Arch;
use rand::Rng;

use super::division::divide;
use super::mass_space::MassSpace;
use super::settled::Tessellation;
use super::site_tree::SiteTree;
use crate::Stopped;
use crate::ensemble::progress::Tick;
use crate::vector::Vector;

/// Maximum number of steps of a site to its mean. Each step reduces the distance by a factor of the
/// squared radius of the cell, at worst (half the sphere) to a quarter.
const MAX_STEPS: usize = 60;

/// Steps shorter than this (radians) are within rounding.
const SHORTEST_STEP: f64 = 1e-15;

/// Distance to its mean (radians) below which a site counts as converged: it changes no squared
/// distance by more than the tolerance of exchanges, and exceeds the accumulated rounding of steps.
const AT_REST: f64 = 1e-13;

/// Margin, in units of the root of the area per site, by which balls may grow before the list of pairs is rebuilt.
/// Values from 0.05 to 0.5 take the same time: a larger margin makes the list longer, a smaller one
/// makes rebuilding more frequent.
const SLACK: f64 = 0.2;

/// Maximum number of passes, after which a tessellation may be unsettled: far more than the hundreds
/// that the largest tested capacities take.
pub(crate) const MAX_PASSES: usize = 10_000;

/// Returns the relaxation of mass points, `capacity` to each site, from the regions of repeated
/// bisection in random directions. `tick` is called at each pass.
///
/// A single site is a uniform point, because the mass of the whole space has no mean.
pub(crate) fn relax<S: MassSpace<D>, const D: usize>(
    space: S,
    mass_points: Vec<S::Point>,
    capacity: usize,
    rng: &mut dyn Rng,
    tick: Tick<'_>,
) -> Result<Relaxation<S, D>, Stopped> {
    if capacity == 1 || mass_points.len() > capacity {
        return settle(space, mass_points, capacity, rng, tick);
    }
    let mut relaxation = Relaxation::divided(space, mass_points, capacity, rng);
    relaxation.place(0, space.random_point(rng));
    Ok(relaxation)
}

/// Returns the relaxation as [`relax`] does, with a single site at the mean of its points.
pub(crate) fn settle<S: MassSpace<D>, const D: usize>(
    space: S,
    mass_points: Vec<S::Point>,
    capacity: usize,
    rng: &mut dyn Rng,
    tick: Tick<'_>,
) -> Result<Relaxation<S, D>, Stopped> {
    let mut relaxation = Relaxation::divided(space, mass_points, capacity, rng);
    relaxation.run(MAX_PASSES, tick)?;
    Ok(relaxation)
}

/// Mass points sorted by site, `capacity` to each, and the exchanges that lower their energy.
#[derive(Clone, Debug)]
pub(crate) struct Relaxation<S: MassSpace<D>, const D: usize> {
    arch: Arch,
    space: S,
    capacity: usize,
    /// Coordinates of the mass points.
    columns: [Vec<f64>; D],
    sites: Vec<S::Point>,
    /// Bounds on the distance from a site to its points.
    radii: Vec<f64>,
    passes: usize,
    is_settled: bool,
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
struct Progress<P> {
    pairs: Vec<Pair>,
    tree: SiteTree<P>,
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

impl<S: MassSpace<D>, const D: usize> Relaxation<S, D> {
    /// Divides mass points among sites by repeated bisection.
    fn divided(
        space: S,
        mut mass_points: Vec<S::Point>,
        capacity: usize,
        rng: &mut dyn Rng,
    ) -> Self {
        divide(space, &mut mass_points, capacity, rng);
        Self::new(space, &mass_points, capacity)
    }

    /// Assigns `capacity` consecutive points to each site and places the sites near their means.
    fn new(space: S, points: &[S::Point], capacity: usize) -> Self {
        let columns = array::from_fn(|axis| {
            points.iter().map(|&p| S::coordinates(p)[axis]).collect::<Vec<_>>()
        });
        let sites: Vec<_> = points.chunks_exact(capacity).map(|cell| space.start(cell)).collect();
        let radii = vec![S::DIAMETER; sites.len()];
        let arch = Arch::new();
        Self { arch, space, capacity, columns, sites, radii, passes: 0, is_settled: true }
    }

    pub(crate) fn sites(&self) -> &[S::Point] {
        &self.sites
    }

    /// Places a site at the given point.
    fn place(&mut self, k: usize, site: S::Point) {
        self.sites[k] = site;
        self.radii[k] = S::DIAMETER;
    }

    /// Returns the tessellation, with sites and mass points in the form that `output` returns.
    pub(crate) fn tessellation<P>(
        &self,
        output: impl Fn(S::Point) -> P,
        site: impl Fn(S::Point) -> P,
    ) -> Tessellation<P> {
        Tessellation {
            sites: self.sites.iter().map(|&s| site(s)).collect(),
            mass_points: (0..self.columns[0].len()).map(|p| output(self.point(p))).collect(),
            energy: self.energy(),
            passes: self.passes,
            is_settled: self.is_settled,
        }
    }

    /// Returns the number of sites times the mean squared distance from a point to its site.
    fn energy(&self) -> f64 {
        let energy = |k: usize| {
            let (site, max_square) = (self.sites[k], self.radii[k].powi(2));
            self.space.moments(self.arch, self.block(k), site, max_square).energy
        };
        (0..self.sites.len()).map(energy).sum::<f64>() / self.capacity as f64
    }

    /// Exchanges points until no exchange lowers the energy and all sites are at the means of their
    /// points, or until `max_passes` passes are done.
    fn run(&mut self, max_passes: usize, tick: Tick<'_>) -> Result<(), Stopped> {
        let n = self.sites.len();
        for k in 0..n {
            self.centre(k, MAX_STEPS);
        }
        let slack = SLACK * (S::AREA / n as f64).sqrt();
        let mut progress = Progress::new(n, self.capacity, slack);
        self.is_settled = false;
        self.list_pairs(&mut progress);
        let mut is_thorough = true;
        for passes in 1..=max_passes {
            tick()?;
            self.passes = passes;
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
                self.is_settled = true;
                return Ok(());
            }
            // Apparent convergence is verified without the cached state.
            is_thorough = is_quiet;
            if is_thorough {
                progress.pairs.clear();
                self.list_pairs(&mut progress);
            }
        }
        Ok(())
    }

    fn point(&self, p: usize) -> S::Point {
        S::point(array::from_fn(|axis| self.columns[axis][p]))
    }

    fn block(&self, k: usize) -> [&[f64]; D] {
        let cell = k * self.capacity..(k + 1) * self.capacity;
        array::from_fn(|axis| &self.columns[axis][cell.clone()])
    }

    /// Takes up to `max_steps` steps to the mean of the site's points: each is the exponential of
    /// the mean logarithm, whose fixed point makes the sum of squared distances stationary (Karcher
    /// 1977). Returns the length of the path.
    fn centre(&mut self, k: usize, max_steps: usize) -> f64 {
        let mut way = 0.0;
        for _ in 0..max_steps {
            let site = self.sites[k];
            let max_square = self.radii[k].powi(2);
            let moments = self.space.moments(self.arch, self.block(k), site, max_square);
            let step = moments.sum / self.capacity as f64;
            let length = step.length();
            self.radii[k] = moments.max_square.max(0.0).sqrt() + length;
            if length < SHORTEST_STEP {
                break;
            }
            self.sites[k] = self.space.moved(site, step);
            way += length;
        }
        way
    }

    /// Lists the pairs of sites whose balls intersect within the margin, and keeps the state of
    /// known pairs.
    fn list_pairs(&mut self, progress: &mut Progress<S::Point>) {
        let Progress { pairs, tree, .. } = progress;
        let known = std::mem::take(pairs);
        tree.find(self.space, &self.sites, &self.radii, progress.slack, |i, j| {
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
    fn visit(&mut self, at: usize, progress: &mut Progress<S::Point>) -> bool {
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
        let distance = self.space.distance(sites[0], sites[1]);
        let reach = self.radii[i] + self.radii[j];
        if distance >= reach {
            // Every point of a site is at least as near to it as any point of the other site, so no
            // exchange lowers the energy.
            pair.limit = path + 0.5 * (distance - reach);
            return false;
        }
        let max_square = (distance + self.radii[i].max(self.radii[j])).powi(2);
        let [max_i, max_j] = [(i, 0, 1), (j, 1, 0)].map(|(k, own, other)| {
            let [from, to] = [sites[own], sites[other]];
            self.space.reductions_into(
                self.arch,
                self.block(k),
                from,
                to,
                max_square,
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
            for column in &mut self.columns {
                column.swap(a, b);
            }
            self.radii[i] = self.radii[i].max(self.space.distance(sites[0], self.point(a)));
            self.radii[j] = self.radii[j].max(self.space.distance(sites[1], self.point(b)));
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
        S::TOLERANCE / self.sites.len() as f64 + S::ROUNDING
    }
}

impl<P: Copy> Progress<P> {
    fn new(n: usize, capacity: usize, slack: f64) -> Self {
        Self {
            pairs: Vec::new(),
            tree: SiteTree::default(),
            changes: vec![0; n],
            stale: vec![true; n],
            paths: vec![0.0; n],
            reach: Vec::new(),
            slack,
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
