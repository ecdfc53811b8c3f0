use glam::DVec3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use sphvar_healpix::{Cell, Nside};

use super::quarters::{ALL_CHILDREN, Quarters};
use crate::ensemble::progress::Tick;
use crate::search::Grid;
use crate::{Domain, Stopped};

/// Candidates per cell of the grid before the first subdivision: enough for two thirds of the
/// points.
const FIRST_RATE: f64 = 4.0;

/// Candidates per child. Rates from 0.5 to 2 cost the same within 10 %.
const RATE: f64 = 1.0;

/// The cells at which subdivision ends: those of the finest resolution from which a step to twice
/// the resolution exists.
const FINEST: u32 = Nside::MAX / 2;

const FOUR_PI: f64 = 4.0 * std::f64::consts::PI;

/// One run of random sequential addition: disks are placed one after the other, each with its
/// centre uniform in the region that the previous disks leave free.
///
/// The method is that of hierarchical dart throwing (White, Cline and Egbert 2007; Gamito and
/// Maddock 2009), with candidates from a Poisson process instead of a fixed number. A front of
/// equal-area cells that together contain the free region receives candidates at a constant rate
/// per area, each with a uniform time. In the order of their times the candidates are uniform on
/// the front, so those in the free region, a subset of the front, are uniform there; the method is
/// exact. Each cell is then divided in four, children within one disk are dropped, and the next
/// phase begins. Candidates of different cells are independent, so a phase visits the cells in
/// memory order: division, dropping, sampling and the test against the disks of earlier phases are
/// one pass with one list of near points. Only the few remaining candidates are processed in the
/// order of time.
///
/// Dropping children that two or three disks cover together (by clipping) was tried: it saves a
/// quarter of the cells at the same total cost.
#[derive(Debug)]
pub(crate) struct SequentialAddition<'a> {
    rng: &'a mut ChaCha8Rng,
    domain: Domain,
    chord: f64,
    grid: Grid,
    front: Vec<Place>,
    candidates: Vec<Candidate>,
    order: Vec<u64>,
}

/// The outcome of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum End {
    /// The limit was reached.
    Full,
    /// Nothing is free outside cells of the finest resolution with a total area of `unresolved`
    /// steradian: each at most 1.5e-17, with about 20 left at a million points.
    Saturated {
        /// The area not known to be covered when subdivision ended.
        unresolved: f64,
    },
}

/// A candidate outside all disks of earlier phases.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    dir: DVec3,
    /// The cell of the grid that it lies in.
    place: u32,
}

impl<'a> SequentialAddition<'a> {
    /// Returns a run with disks of radius `chord`, any positive number, of which about `n_points`
    /// are expected.
    pub(crate) fn new(domain: Domain, chord: f64, n_points: f64, rng: &'a mut ChaCha8Rng) -> Self {
        Self {
            rng,
            domain,
            chord,
            grid: Grid::new(domain, chord, n_points),
            front: Vec::new(),
            candidates: Vec::new(),
            order: Vec::new(),
        }
    }

    /// Appends to `points` until there are `limit` of them or nothing is free; `tick` is called at
    /// each level and can stop the run.
    pub(crate) fn run(
        mut self,
        limit: usize,
        points: &mut Vec<DVec3>,
        tick: Tick<'_>,
    ) -> Result<End, Stopped> {
        self.start();
        let base = self.grid.nside().value();
        let mut level = 0;
        loop {
            tick()?;
            self.settle(limit, points);
            if points.len() == limit {
                return Ok(End::Full);
            }
            if self.front.is_empty() {
                return Ok(End::Saturated { unresolved: 0.0 });
            }
            if base << level > FINEST {
                let cell = FOUR_PI / (12.0 * f64::from(base << level).powi(2));
                return Ok(End::Saturated { unresolved: self.front.len() as f64 * cell });
            }
            self.refine(level);
            level += 1;
        }
    }

    /// Runs the first phase: the whole domain is free, and the cells are those of the grid.
    fn start(&mut self) {
        let nside = self.grid.nside();
        // The northern faces and the first two of the equator hold one cell of every antipodal
        // pair, which has the area of a hemisphere and represents all antipodal pairs.
        let faces = match self.domain {
            Domain::Sphere => 12,
            Domain::Hemisphere => 6,
        };
        let count = PoissonCount::new(FIRST_RATE);
        let side = 0..nside.value();
        for face in 0..faces {
            for iy in side.clone() {
                for cell in side.clone().filter_map(|ix| Cell::new(nside, face, ix, iy).ok()) {
                    self.front.push(Place::of(cell));
                    let place = self.grid.place(cell);
                    for _ in 0..count.draw(self.rng) {
                        let (u, v) = (self.rng.random(), self.rng.random());
                        self.candidates.push(Candidate { dir: cell.uniform_point(u, v), place });
                    }
                }
            }
        }
    }

    /// Divides the cells of the front, which is at `level` below the grid, drops covered children
    /// and generates the next candidates.
    fn refine(&mut self, level: u32) {
        let base = self.grid.nside().value();
        let (Ok(nside), Ok(fine)) = (Nside::new(base << level), Nside::new(base << (level + 1)))
        else {
            return;
        };
        let chord_squared = self.chord * self.chord;
        let counts = [1.0, 2.0, 3.0, 4.0].map(|n_live| PoissonCount::new(RATE * n_live));
        let mut children = Vec::with_capacity(2 * self.front.len());
        let (mut around, mut near, mut near_place) = (Vec::new(), Vec::new(), None);
        self.candidates.clear();
        for &place in &self.front {
            let Some(parent) = place.cell(nside) else { continue };
            let grid_place = self.grid.place_above(parent, level);
            // Cells of one grid cell are consecutive.
            if near_place != Some(grid_place) {
                near_place = Some(grid_place);
                self.grid.gather(grid_place, &mut around);
                near.resize(around.len(), DVec3::ZERO);
            }
            let quarters = Quarters::new(parent, self.chord);
            let len = quarters.select(&around, self.chord, &mut near);
            let near = &near[..len];
            let live = ALL_CHILDREN & !quarters.covered(near, self.chord);
            if live == 0 {
                continue;
            }
            let n_live = live.count_ones();
            let (mut live_children, mut rest) = ([place; 4], live);
            for child in &mut live_children[..n_live as usize] {
                *child = place.child(rest.trailing_zeros());
                rest &= rest - 1;
            }
            let live_children = &live_children[..n_live as usize];
            children.extend_from_slice(live_children);
            for _ in 0..counts[live_children.len() - 1].draw(self.rng) {
                // The integer part of one number selects the child, and the fractional part the
                // position in it.
                let across = f64::from(n_live) * self.rng.random::<f64>();
                let index = [1.0, 2.0, 3.0].map(|i| usize::from(across >= i)).iter().sum::<usize>();
                let child = live_children[index];
                let Some(cell) = child.cell(fine) else { continue };
                let dir = cell.uniform_point(across.fract(), self.rng.random());
                if near.iter().all(|q| q.distance_squared(dir) >= chord_squared) {
                    self.candidates.push(Candidate { dir, place: grid_place });
                }
            }
        }
        self.front = children;
    }

    /// Processes the candidates of a phase in the order of their times.
    fn settle(&mut self, limit: usize, points: &mut Vec<DVec3>) {
        let chord_squared = self.chord * self.chord;
        // The time is in the upper half and the index in the lower, so candidates of equal times,
        // one in 2^32 pairs, are ordered by index.
        self.order.clear();
        let rng = &mut *self.rng;
        self.order.extend(
            (0..self.candidates.len() as u64).map(|i| u64::from(rng.random::<u32>()) << 32 | i),
        );
        self.order.sort_unstable();
        for &key in &self.order {
            #[expect(clippy::cast_possible_truncation, reason = "the lower half is the index")]
            let candidate = self.candidates[key as u32 as usize];
            if !self.grid.has_near(candidate.place, candidate.dir, chord_squared) {
                self.grid.insert(candidate.place, candidate.dir);
                points.push(self.domain.representative(candidate.dir));
                if points.len() == limit {
                    return;
                }
            }
        }
    }
}

/// Face and coordinates of a cell in 64 bits: 4 for the face, 29 for each coordinate.
#[derive(Clone, Copy, Debug)]
struct Place(u64);

impl Place {
    const BITS: u32 = 29;
    const MASK: u64 = (1 << Self::BITS) - 1;

    fn of(cell: Cell) -> Self {
        let (ix, iy) = (u64::from(cell.ix()), u64::from(cell.iy()));
        Self(u64::from(cell.face()) << (2 * Self::BITS) | ix << Self::BITS | iy)
    }

    #[inline]
    fn cell(self, nside: Nside) -> Option<Cell> {
        let field = |shift: u32| u32::try_from(self.0 >> shift & Self::MASK).ok();
        let face = u8::try_from(field(2 * Self::BITS)?).ok()?;
        Cell::new(nside, face, field(Self::BITS)?, field(0)?).ok()
    }

    /// Child 0 to 3 at twice the resolution, at most 2^29, so that no field overflows.
    #[inline]
    fn child(self, child: u32) -> Self {
        let child = u64::from(child);
        let below_face = (1 << (2 * Self::BITS)) - 1;
        let doubled = (self.0 & below_face) << 1;
        Self(self.0 & !below_face | doubled | (child & 1) << Self::BITS | child >> 1)
    }
}

/// Poisson-distributed numbers, by summation of probabilities.
#[derive(Clone, Copy, Debug)]
struct PoissonCount {
    mean: f64,
    none: f64,
}

impl PoissonCount {
    /// The largest number: for means up to 4, larger numbers have probability below 1e-25.
    const MAX: u32 = 40;

    fn new(mean: f64) -> Self {
        Self { mean, none: (-mean).exp() }
    }

    #[inline]
    fn draw(&self, rng: &mut ChaCha8Rng) -> u32 {
        let mut left: f64 = rng.random();
        let (mut k, mut probability) = (0, self.none);
        while left >= probability && k < Self::MAX {
            left -= probability;
            k += 1;
            probability *= self.mean / f64::from(k);
        }
        k
    }
}
