use glam::DVec3;
use pulp::Arch;

use super::block::Block;
use super::encounters::{Encounters, chord};
use crate::Stopped;

/// Steps to the mean after which a site is left where it is. Each step shortens the way by the
/// squared radius of the cell, at worst (half the sphere) to a quarter.
const MAX_STEPS: usize = 60;

/// Steps shorter than this (radians) are rounding.
const SHORTEST_STEP: f64 = 1e-15;

/// The longest way to its mean (radians) of a site that counts as there: it changes no squared
/// distance by more than the tolerance of exchanges, and is more than steps of rounding add up to.
const AT_REST: f64 = 1e-13;

/// By how much balls may outgrow those that the list of pairs was made for, in units of
/// sqrt(4 pi/N). Anything from 0.05 to 0.5 takes the same time: more makes the list longer, less makes
/// it more often.
const SLACK: f64 = 0.2;

/// Squared geodesic distances below this difference are equal: a few roundings of `2 - 2 cos d`.
const ROUNDING: f64 = 2e-15;

/// Mass points sorted by site, `capacity` to each, and the exchanges that lower their energy.
#[derive(Clone, Debug)]
pub(super) struct Relaxation {
    arch: Arch,
    lines: bool,
    capacity: usize,
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
    sites: Vec<DVec3>,
    /// Bounds on the chord from a site to its points.
    radii: Vec<f64>,
}

/// How a relaxation ended.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outcome {
    pub(super) passes: usize,
    pub(super) is_settled: bool,
}

/// Two sites whose points might be worth exchanging.
#[derive(Clone, Copy, Debug)]
struct Pair {
    sites: [usize; 2],
    /// The changes of the two sites' points when last looked at, none if never.
    seen: Option<[u32; 2]>,
    /// The sum of the sites' paths up to which nothing can be worth exchanging.
    limit: f64,
}

/// What is remembered from pass to pass.
#[derive(Debug)]
struct Progress {
    pairs: Vec<Pair>,
    encounters: Encounters,
    /// How often the points of each site have changed.
    changes: Vec<u32>,
    /// Whether the site has not moved to its mean since.
    stale: Vec<bool>,
    /// The length of the site's way so far.
    paths: Vec<f64>,
    /// Radius and path when the list of pairs was made.
    reach: Vec<f64>,
    slack: f64,
    /// Scratch: what giving each point of the two sites away would gain, and those worth it.
    gains: [Vec<f64>; 2],
    offers: [Vec<(f64, usize)>; 2],
}

impl Relaxation {
    /// Gives `capacity` points in a row to each site, and puts the sites to their means.
    pub(super) fn new(points: &[DVec3], capacity: usize, lines: bool) -> Self {
        let column = |of: fn(&DVec3) -> f64| points.iter().map(of).collect();
        let middle = |cell: &[DVec3]| {
            // Points that cancel out, as few can, have no mean: any of them is as good a start.
            cell.iter().sum::<DVec3>().try_normalize().unwrap_or(cell[0])
        };
        let sites: Vec<_> = points.chunks_exact(capacity).map(middle).collect();
        let radii = vec![2.0; sites.len()];
        let (x, y, z) = (column(|p| p.x), column(|p| p.y), column(|p| p.z));
        Self { arch: Arch::new(), lines, capacity, x, y, z, sites, radii }
    }

    pub(super) fn sites(&self) -> &[DVec3] {
        &self.sites
    }

    /// Puts a site to a place of its own choice.
    pub(super) fn place(&mut self, k: usize, site: DVec3) {
        self.sites[k] = site;
        self.radii[k] = 2.0;
    }

    pub(super) fn cell(&self, k: usize) -> impl ExactSizeIterator<Item = DVec3> + '_ {
        let Block { x, y, z } = self.block(k);
        x.iter().zip(y).zip(z).map(|((&x, &y), &z)| DVec3::new(x, y, z))
    }

    /// Number of sites times the mean squared distance from a point to its site.
    pub(super) fn energy(&self) -> f64 {
        let energy = |k: usize| {
            let (site, most) = (self.sites[k], self.radii[k].powi(2));
            self.block(k).moments(self.arch, self.lines, site, most).energy
        };
        (0..self.sites.len()).map(energy).sum::<f64>() / self.capacity as f64
    }

    /// Exchanges points until none is left to lower the energy, all sites being at the means of
    /// their points, or `most_passes` are over.
    pub(super) fn run(
        &mut self,
        most_passes: usize,
        tick: &dyn Fn() -> Result<(), Stopped>,
    ) -> Result<Outcome, Stopped> {
        let n = self.sites.len();
        for k in 0..n {
            self.centre(k, MAX_STEPS);
        }
        let mut progress = Progress::new(n, self.capacity);
        self.list_pairs(&mut progress);
        let mut is_thorough = true;
        for passes in 1..=most_passes {
            tick()?;
            if progress.has_outgrown(&self.radii) {
                self.list_pairs(&mut progress);
            }
            let mut is_quiet = true;
            for at in 0..progress.pairs.len() {
                is_quiet &= !self.visit(at, &mut progress);
            }
            // While points are still exchanged, one step is as good as the mean itself.
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
            // What seems to be the end is looked at without the help of what is remembered.
            is_thorough = is_quiet;
            if is_thorough {
                progress.pairs.clear();
                self.list_pairs(&mut progress);
            }
        }
        Ok(Outcome { passes: most_passes, is_settled: false })
    }

    fn point(&self, p: usize) -> DVec3 {
        DVec3::new(self.x[p], self.y[p], self.z[p])
    }

    fn block(&self, k: usize) -> Block<'_> {
        let cell = k * self.capacity..(k + 1) * self.capacity;
        Block { x: &self.x[cell.clone()], y: &self.y[cell.clone()], z: &self.z[cell] }
    }

    /// Takes up to `most_steps` to the mean of the site's points: the exponential of the mean
    /// logarithm, whose fixed point is where the sum of squared distances is stationary
    /// (Karcher 1977). Returns the length of the way.
    fn centre(&mut self, k: usize, most_steps: usize) -> f64 {
        let mut way = 0.0;
        for _ in 0..most_steps {
            let site = self.sites[k];
            let most = self.radii[k].powi(2);
            let moments = self.block(k).moments(self.arch, self.lines, site, most);
            let sum = moments.sum - moments.sum.dot(site) * site;
            let step = sum / self.capacity as f64;
            let length = step.length();
            self.radii[k] = moments.most.max(0.0).sqrt() + length;
            if length < SHORTEST_STEP {
                break;
            }
            let (sin, cos) = length.sin_cos();
            self.sites[k] = (site * cos + step * (sin / length)).normalize();
            way += length;
        }
        way
    }

    /// Lists the pairs of sites whose balls meet, or nearly, and keeps what is known of them.
    fn list_pairs(&mut self, progress: &mut Progress) {
        let Progress { pairs, encounters, .. } = progress;
        let known = std::mem::take(pairs);
        encounters.find(self.lines, &self.sites, &self.radii, progress.slack, |i, j| {
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

    /// Makes all exchanges between two sites that lower the energy, at once: the points that gain
    /// most by a change of site against each other. Returns whether there were any.
    fn visit(&mut self, at: usize, progress: &mut Progress) -> bool {
        let Progress { pairs, changes, stale, paths, gains, offers, .. } = progress;
        let pair = &mut pairs[at];
        let [i, j] = pair.sites;
        let path = paths[i] + paths[j];
        let now = Some([changes[i], changes[j]]);
        if pair.seen == now && path <= pair.limit {
            return false;
        }
        pair.seen = now;
        let sites = [self.sites[i], self.sites[j]];
        let distance = chord(self.lines, sites[0], sites[1]);
        let reach = self.radii[i] + self.radii[j];
        if distance >= reach {
            // A point of either is nearer to its own site than any of the other's is.
            pair.limit = path + 0.5 * (distance - reach);
            return false;
        }
        let most = (distance + self.radii[i].max(self.radii[j])).powi(2);
        let [most_i, most_j] = [(i, 0, 1), (j, 1, 0)].map(|(k, own, other)| {
            let [from, to] = [sites[own], sites[other]];
            self.block(k).gains_into(self.arch, self.lines, from, to, most, &mut gains[own])
        });
        let tolerance = self.tolerance();
        if most_i + most_j <= tolerance {
            // A site's step changes d^2 by at most 2 d times its length; no d is above `reach`
            // plus the other radius, and the balls are small or the check at the end will tell.
            pair.limit = path - (most_i + most_j) / (4.2 * reach);
            return false;
        }
        offers[0].clear();
        offers[1].clear();
        offer(&gains[0], tolerance - most_j, &mut offers[0]);
        offer(&gains[1], tolerance - most_i, &mut offers[1]);
        for (&(gain_i, a), &(gain_j, b)) in offers[0].iter().zip(&offers[1]) {
            if gain_i + gain_j <= tolerance {
                break;
            }
            let (a, b) = (i * self.capacity + a, j * self.capacity + b);
            self.x.swap(a, b);
            self.y.swap(a, b);
            self.z.swap(a, b);
            self.radii[i] = self.radii[i].max(chord(self.lines, sites[0], self.point(a)));
            self.radii[j] = self.radii[j].max(chord(self.lines, sites[1], self.point(b)));
        }
        for k in [i, j] {
            changes[k] = changes[k].wrapping_add(1);
            stale[k] = true;
            paths[k] += self.centre(k, 1);
        }
        true
    }

    /// What an exchange must lower the sum of squared distances by: 1e-12 of a cell's area, and
    /// more than rounding, so that the energy falls every time and exchanges come to an end.
    fn tolerance(&self) -> f64 {
        1e-11 / self.sites.len() as f64 + ROUNDING
    }
}

impl Progress {
    fn new(n: usize, capacity: usize) -> Self {
        Self {
            pairs: Vec::new(),
            encounters: Encounters::default(),
            changes: vec![0; n],
            stale: vec![true; n],
            paths: vec![0.0; n],
            reach: Vec::new(),
            slack: SLACK * (4.0 * std::f64::consts::PI / n as f64).sqrt(),
            gains: [vec![0.0; capacity], vec![0.0; capacity]],
            offers: [Vec::new(), Vec::new()],
        }
    }

    /// Whether balls that did not meet when the list was made might do so now.
    fn has_outgrown(&self, radii: &[f64]) -> bool {
        let grown = radii.iter().zip(&self.paths).zip(&self.reach);
        grown.map(|((r, path), reach)| r + path - reach).fold(0.0, f64::max) > 0.5 * self.slack
    }
}

/// Adds the points with a gain above `least`, the best first; of equals the first.
fn offer(gains: &[f64], least: f64, offers: &mut Vec<(f64, usize)>) {
    offers.extend(gains.iter().zip(0..).filter(|&(&gain, _)| gain > least).map(|(&g, k)| (g, k)));
    offers.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
}
