use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::free_region::FreeRegion;
use super::poisson_count::PoissonCount;
use super::subdivision::Subdivision;
use crate::Stopped;
use crate::ensemble::progress::Tick;

/// Candidates per cell of the grid before the first subdivision: enough for two thirds of the
/// points.
const FIRST_RATE: f64 = 4.0;

/// Candidates per child. Rates from 0.5 to 2 cost the same within 10 %.
const RATE: f64 = 1.0;

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
pub(crate) struct SequentialAddition<'a, S: Subdivision> {
    rng: &'a mut ChaCha8Rng,
    free: FreeRegion<S>,
    candidates: Vec<Candidate<S::Point>>,
    order: Vec<u64>,
}

/// Replaces the content of `points` by exactly `n_points` disks on an empty domain, which `space`
/// returns. A set that is full earlier is discarded and restarted with the next random numbers.
///
/// Returns the largest number of disks of all attempts, `n_points` if one succeeded; otherwise
/// `points` is empty.
pub(crate) fn exact_into<S: Subdivision>(
    n_points: usize,
    space: impl Fn() -> S,
    rng: &mut ChaCha8Rng,
    points: &mut Vec<S::Output>,
    tick: Tick<'_>,
) -> Result<usize, Stopped> {
    let mut placed = 0;
    for _ in 0..attempts(n_points) {
        points.clear();
        if SequentialAddition::new(space(), rng).run(n_points, points, tick)? == End::Full {
            return Ok(n_points);
        }
        placed = placed.max(points.len());
    }
    points.clear();
    Ok(placed)
}

/// Returns the maximum number of attempts for an exact set. Above some hundred points nearly all
/// sets of one radius succeed, or nearly none; with few points a large fraction may fail.
pub(crate) fn attempts(n_points: usize) -> usize {
    16 + 100_000 / n_points
}

/// The outcome of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum End {
    /// The limit was reached.
    Full,
    /// Nothing is free outside cells of the finest resolution with a total area of `unresolved`: on
    /// the sphere each at most 1.5e-17 steradian, with about 20 left at a million points.
    Saturated {
        /// The area not known to be covered when subdivision ended.
        unresolved: f64,
    },
}

/// A candidate outside all disks of earlier phases.
#[derive(Clone, Copy, Debug)]
struct Candidate<P> {
    point: P,
    /// The cell of the grid that it lies in.
    place: u32,
}

impl<'a, S: Subdivision> SequentialAddition<'a, S> {
    /// Returns a run on the domain, which may have disks already.
    pub(crate) fn new(space: S, rng: &'a mut ChaCha8Rng) -> Self {
        Self { rng, free: FreeRegion::whole(space), candidates: Vec::new(), order: Vec::new() }
    }

    /// Appends to `points`, which are those of the disks on the domain, until there are `limit` of
    /// them or nothing is free; `tick` is called at each level and can stop the run.
    pub(crate) fn run(
        mut self,
        limit: usize,
        points: &mut Vec<S::Output>,
        tick: Tick<'_>,
    ) -> Result<End, Stopped> {
        // With disks almost everywhere, candidates before the first subdivision would be wasted.
        if points.is_empty() {
            self.start();
        }
        loop {
            tick()?;
            self.settle(limit, points);
            if points.len() == limit {
                return Ok(End::Full);
            }
            if self.free.is_empty() || self.free.is_finest() {
                return Ok(End::Saturated { unresolved: self.free.area() });
            }
            self.refine();
        }
    }

    /// Runs the first phase: the whole domain is free, and the cells are those of the grid.
    fn start(&mut self) {
        let Self { rng, free: FreeRegion { space, .. }, candidates, .. } = self;
        let Some(resolution) = space.resolution(0) else { return };
        let count = PoissonCount::new(FIRST_RATE);
        for (place, grid_place) in space.grid_cells() {
            for _ in 0..count.draw(rng) {
                let (u, v) = (rng.random(), rng.random());
                if let Some(point) = space.point_in(place, resolution, u, v) {
                    candidates.push(Candidate { point, place: grid_place });
                }
            }
        }
    }

    /// Divides the cells of the front, drops covered children and generates the next candidates.
    fn refine(&mut self) {
        let Self { rng, free, candidates, .. } = self;
        let counts = [1.0, 2.0, 3.0, 4.0].map(|n_live| PoissonCount::new(RATE * n_live));
        candidates.clear();
        free.refine(|space, live| {
            let n_live = live.children.len();
            for _ in 0..counts[n_live - 1].draw(rng) {
                // The integer part of one number selects the child, and the fractional part the
                // position in it.
                let across = n_live as f64 * rng.random::<f64>();
                let index = [1.0, 2.0, 3.0].map(|i| usize::from(across >= i)).iter().sum::<usize>();
                let (child, v) = (live.children[index], rng.random());
                let Some(point) = space.point_in(child, live.resolution, across.fract(), v) else {
                    continue;
                };
                if live.near.iter().all(|&q| !space.overlap(q, point)) {
                    candidates.push(Candidate { point, place: live.grid_place });
                }
            }
        });
    }

    /// Processes the candidates of a phase in the order of their times.
    fn settle(&mut self, limit: usize, points: &mut Vec<S::Output>) {
        // The time is in the upper half and the index in the lower, so candidates of equal times,
        // one in 2^32 pairs, are ordered by index.
        self.order.clear();
        let rng = &mut *self.rng;
        self.order.extend(
            (0..self.candidates.len() as u64).map(|i| u64::from(rng.random::<u32>()) << 32 | i),
        );
        self.order.sort_unstable();
        let space = &mut self.free.space;
        for &key in &self.order {
            #[expect(clippy::cast_possible_truncation, reason = "the lower half is the index")]
            let Candidate { point, place } = self.candidates[key as u32 as usize];
            if !space.is_covered(place, point) {
                space.insert(place, point);
                points.push(space.output(point));
                if points.len() == limit {
                    return;
                }
            }
        }
    }
}
