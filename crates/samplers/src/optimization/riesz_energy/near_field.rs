use std::f64::consts::{PI, TAU};
use std::ops::Range;

use glam::DVec3;
use pulp::NullaryFnOnce;
use rayon::prelude::*;

use super::splitting::{Splitting, TERMS, angle_of};
use super::{Kernel, LANES};

/// The side of cells in units of the cut-off distance: smaller ones have fewer pairs beyond the
/// cut-off, but fewer points that share a list of neighbours.
const CELL_SIDE: f64 = 0.5;

/// The number of cells that one task computes.
const CELLS_PER_TASK: usize = 32;

/// A coordinate beyond every cut-off.
const OUTSIDE: f64 = 1e3;

/// The points by cells: bands of equal extent in latitude, divided into sectors of longitude.
///
/// On the hemisphere the antipodes of the points are sources as well.
#[derive(Debug)]
pub(super) struct NearField {
    cutoff: f64,
    n_points: usize,
    bands: Vec<Band>,
    /// The first source of each cell, and the number of sources.
    starts: Vec<usize>,
    /// The sources in the order of cells.
    sources: Vec<Source>,
}

#[derive(Clone, Copy, Debug)]
struct Band {
    first_cell: usize,
    n_sectors: usize,
}

#[derive(Clone, Copy, Debug)]
struct Source {
    place: DVec3,
    /// The index of the point; of an antipode the number of points or more.
    index: usize,
}

impl NearField {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive")]
    pub(super) fn new(cutoff: f64, points: &[DVec3], antipodal: bool) -> Self {
        let side = CELL_SIDE * cutoff;
        let n_bands = ((PI / side) as usize).max(1);
        let mut n_cells = 0;
        let bands: Vec<_> = (0..n_bands)
            .map(|band| {
                let middle = PI * (band as f64 + 0.5) / n_bands as f64;
                let n_sectors = ((TAU * middle.sin() / side) as usize).max(1);
                let first_cell = n_cells;
                n_cells += n_sectors;
                Band { first_cell, n_sectors }
            })
            .collect();
        let antipodes = if antipodal { points } else { &[] };
        let places = || points.iter().copied().chain(antipodes.iter().map(|p| -*p));
        let cell = |p: DVec3| {
            let theta = libm::atan2(p.x.hypot(p.y), p.z);
            let band = ((theta / PI * n_bands as f64) as usize).min(n_bands - 1);
            let Band { first_cell, n_sectors } = bands[band];
            let turn = (libm::atan2(p.y, p.x) + PI) / TAU;
            first_cell + ((turn * n_sectors as f64) as usize).min(n_sectors - 1)
        };
        let cells: Vec<usize> = places().map(cell).collect();
        let mut starts = vec![0; n_cells + 1];
        for &cell in &cells {
            starts[cell + 1] += 1;
        }
        for cell in 0..n_cells {
            starts[cell + 1] += starts[cell];
        }
        let mut next = starts.clone();
        let mut sources = vec![Source { place: DVec3::ZERO, index: 0 }; cells.len()];
        for ((index, place), cell) in places().enumerate().zip(cells) {
            sources[next[cell]] = Source { place, index };
            next[cell] += 1;
        }
        Self { cutoff, n_points: points.len(), bands, starts, sources }
    }

    fn n_cells(&self) -> usize {
        self.starts.len() - 1
    }

    /// Returns the number of pairs of a point and a source that may be near.
    pub(super) fn n_pairs(&self) -> f64 {
        let mut near = Vec::new();
        let mut pairs = 0.0;
        self.for_each_cell(0..self.n_cells(), |own, place| {
            if !own.is_empty() {
                self.near_cells(place, &mut near);
                let sources: usize = near.iter().map(Range::len).sum();
                pairs += own.len() as f64 * sources as f64;
            }
        });
        pairs
    }

    /// Calls a function with the sources of each cell and its band and sector.
    fn for_each_cell(&self, cells: Range<usize>, mut f: impl FnMut(Range<usize>, (usize, usize))) {
        let mut band = self.bands.partition_point(|band| band.first_cell <= cells.start) - 1;
        for cell in cells {
            while cell >= self.bands[band].first_cell + self.bands[band].n_sectors {
                band += 1;
            }
            let sector = cell - self.bands[band].first_cell;
            f(self.starts[cell]..self.starts[cell + 1], (band, sector));
        }
    }

    /// Replaces the content of `near` by ranges of sources that include all within the cut-off of a
    /// cell.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative")]
    fn near_cells(&self, (band, sector): (usize, usize), near: &mut Vec<Range<usize>>) {
        near.clear();
        // Rounding of angles may move a point across an edge.
        let reach = angle_of(self.cutoff) + 1e-9;
        let height = PI / self.bands.len() as f64;
        let (top, bottom) = (band as f64 * height, (band + 1) as f64 * height);
        let first = ((top - reach) / height).max(0.0) as usize;
        let last = (((bottom + reach) / height) as usize).min(self.bands.len() - 1);
        // A cap that does not contain a pole has this half-width in longitude.
        let ratio = reach.sin() / top.sin().min(bottom.sin());
        let encloses_pole = top <= reach || bottom >= PI - reach || reach >= 0.5 * PI;
        let half_width = if encloses_pole || ratio >= 1.0 { TAU } else { ratio.asin() };
        let width = TAU / self.bands[band].n_sectors as f64;
        let (west, east) =
            (sector as f64 * width - half_width, (sector + 1) as f64 * width + half_width);
        for &Band { first_cell, n_sectors } in &self.bands[first..=last] {
            let width = TAU / n_sectors as f64;
            let sources = |sectors: Range<usize>| {
                self.starts[first_cell + sectors.start]..self.starts[first_cell + sectors.end]
            };
            let (west, east) = ((west / width).floor(), (east / width).floor());
            if east - west + 1.0 >= n_sectors as f64 {
                near.push(sources(0..n_sectors));
                continue;
            }
            let n = n_sectors as f64;
            let (from, to) = (west.rem_euclid(n) as usize, east.rem_euclid(n) as usize);
            if from <= to {
                near.push(sources(from..to + 1));
            } else {
                near.push(sources(from..n_sectors));
                near.push(sources(0..to + 1));
            }
        }
    }

    /// Returns twice the near part of the energy, and replaces `forces` by the sums of weight times
    /// difference over the near sources of each point. The result does not depend on the number of
    /// threads.
    pub(super) fn sum<K: Kernel>(
        &self,
        kernel: K,
        splitting: &Splitting,
        forces: &mut Vec<DVec3>,
    ) -> f64 {
        let tasks: Vec<_> = (0..self.n_cells().div_ceil(CELLS_PER_TASK))
            .into_par_iter()
            .map(|task| {
                let cells = task * CELLS_PER_TASK;
                let cells = cells..(cells + CELLS_PER_TASK).min(self.n_cells());
                self.sum_at(cells, kernel, splitting)
            })
            .collect();
        forces.clear();
        forces.resize(self.n_points, DVec3::ZERO);
        let mut twice = 0.0;
        for (energy, on_points) in tasks {
            twice += energy;
            for (point, force) in on_points {
                forces[point] = force;
            }
        }
        twice
    }

    /// Returns the sum of the energies of the points in cells, and the force on each.
    fn sum_at<K: Kernel>(
        &self,
        cells: Range<usize>,
        kernel: K,
        splitting: &Splitting,
    ) -> (f64, Vec<(usize, DVec3)>) {
        let arch = pulp::Arch::new();
        let (mut ranges, mut targets, mut near) = (Vec::new(), Vec::new(), Coordinates::default());
        let (mut twice, mut forces) = (0.0, Vec::new());
        self.for_each_cell(cells, |own, place| {
            targets.clear();
            let all = self.sources[own.clone()].iter();
            targets.extend(all.filter(|source| source.index < self.n_points));
            if targets.is_empty() {
                return;
            }
            let centre = targets.iter().map(|t: &Source| t.place).sum::<DVec3>();
            let centre = centre / targets.len() as f64;
            let radius = targets.iter().map(|t| t.place.distance(centre)).fold(0.0, f64::max);
            let reach = (self.cutoff + radius) * (1.0 + 4.0 * f64::EPSILON);
            self.near_cells(place, &mut ranges);
            // The targets come first, so that their positions in the list are known.
            near.clear();
            targets.iter().for_each(|t| near.push(t.place));
            for range in ranges.drain(..) {
                for (at, source) in range.clone().zip(&self.sources[range]) {
                    let is_first = own.contains(&at) && source.index < self.n_points;
                    if !is_first && source.place.distance_squared(centre) <= reach * reach {
                        near.push(source.place);
                    }
                }
            }
            near.pad();
            let (near, forces, targets) = (&mut near, &mut forces, targets.as_slice());
            twice += arch.dispatch(NearPairs { kernel, splitting, targets, near, forces });
        });
        (twice, forces)
    }
}

/// The arguments of the sums over the near sources of several points, which are the first of
/// `near`.
struct NearPairs<'a, K> {
    kernel: K,
    splitting: &'a Splitting,
    targets: &'a [Source],
    near: &'a mut Coordinates,
    forces: &'a mut Vec<(usize, DVec3)>,
}

impl<K: Kernel> NullaryFnOnce for NearPairs<'_, K> {
    type Output = f64;

    // Inlined so that it is compiled for the dispatched instruction set.
    #[inline(always)]
    fn call(self) -> f64 {
        let Self { kernel, splitting, targets, near, forces } = self;
        let mut twice = 0.0;
        for (k, target) in targets.iter().enumerate() {
            // The point itself is not a source.
            let x = std::mem::replace(&mut near.x[k], OUTSIDE);
            let (energy, force) = near_sum(kernel, splitting, target.place, near);
            near.x[k] = x;
            twice += energy;
            forces.push((target.index, force));
        }
        twice
    }
}

/// Points by coordinate, their number a multiple of `LANES`.
#[derive(Default)]
struct Coordinates {
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
}

impl Coordinates {
    fn clear(&mut self) {
        self.x.clear();
        self.y.clear();
        self.z.clear();
    }

    fn push(&mut self, p: DVec3) {
        self.x.push(p.x);
        self.y.push(p.y);
        self.z.push(p.z);
    }

    /// Adds points outside the sphere.
    fn pad(&mut self) {
        while !self.x.len().is_multiple_of(LANES) {
            self.push(DVec3::splat(OUTSIDE));
        }
    }
}

/// Returns the near part of the energy of `p` among `others` and the sum of weight times
/// (p - other).
#[inline(always)]
fn near_sum<K: Kernel>(
    kernel: K,
    splitting: &Splitting,
    p: DVec3,
    others: &Coordinates,
) -> (f64, DVec3) {
    let [xs, ys, zs] = [&others.x, &others.y, &others.z].map(|c| c.as_chunks::<LANES>().0);
    let cutoff_squared = splitting.cutoff_squared;
    let scale = 2.0 / cutoff_squared;
    let [mut energy, mut fx, mut fy, mut fz] = [[0.0; LANES]; 4];
    for ((x, y), z) in xs.iter().zip(ys).zip(zs) {
        // Loops over arrays, because `array::map` is a call where it is not inlined.
        let [mut dx, mut dy, mut dz, mut near, mut u] = [[0.0; LANES]; 5];
        let mut is_near = [false; LANES];
        for k in 0..LANES {
            (dx[k], dy[k], dz[k]) = (p.x - x[k], p.y - y[k], p.z - z[k]);
            let d2 = dx[k] * dx[k] + dy[k] * dy[k] + dz[k] * dz[k];
            is_near[k] = d2 < cutoff_squared;
            // Beyond the cut-off: a distance of which no kernel is infinite, log 0.
            near[k] = if is_near[k] { d2 } else { 1.0 };
            u[k] = if is_near[k] { d2 * scale - 1.0 } else { 1.0 };
        }
        let [mut far_energy, mut far_weight] = [[0.0; LANES]; 2];
        for i in 0..TERMS {
            for k in 0..LANES {
                far_energy[k] = far_energy[k] * u[k] + splitting.energy[i];
                far_weight[k] = far_weight[k] * u[k] + splitting.weight[i];
            }
        }
        let mut weights = [0.0; LANES];
        for k in 0..LANES {
            let weight = kernel.weight(near[k]);
            weights[k] = if is_near[k] { weight } else { 0.0 };
        }
        let energies = kernel.energies(near, weights);
        for k in 0..LANES {
            let (far, weight) =
                if is_near[k] { (far_energy[k], weights[k] - far_weight[k]) } else { (0.0, 0.0) };
            energy[k] += energies[k] - far;
            fx[k] += weight * dx[k];
            fy[k] += weight * dy[k];
            fz[k] += weight * dz[k];
        }
    }
    let [energy, fx, fy, fz] = [energy, fx, fy, fz].map(|lanes| lanes.iter().sum::<f64>());
    (energy, DVec3::new(fx, fy, fz))
}
