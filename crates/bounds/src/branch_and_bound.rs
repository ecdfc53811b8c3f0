//! Branch-and-bound search over exponent and offset, with a proven optimality gap.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::Side;
use crate::envelope::{Candidate, Envelope};

/// The best profile found, and the relative gap to the best possible one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Found {
    pub(crate) best: Candidate,
    pub(crate) gap: f64,
}

/// The relative gap at which the search ends.
pub(crate) const GAP: f64 = 1e-4;
/// The maximum number of profiles evaluated, after which the search returns its current gap: a few
/// seconds for the longest spectra.
const EVALUATIONS: usize = 20_000;

/// Ranges of exponent and offset, with the profile of one corner and a bound on the value of all
/// profiles in the cell.
#[derive(Debug, Clone, Copy)]
struct Cell {
    exponent: (f64, f64),
    offset: (f64, f64),
    corner: Candidate,
    bound: f64,
    /// The sign of the priority: 1 if large bounds come first, -1 if small ones do.
    sign: f64,
}

/// Returns the best of all profiles whose exponent and offset lie in these closed ranges; `None` if
/// none satisfies the limits.
///
/// For every cell [`Envelope::relaxed`] bounds the value of its profiles. Cells that cannot improve
/// on the best known profile are discarded; the most promising of the others is halved.
pub(crate) fn search(
    envelope: &Envelope,
    exponent: (f64, f64),
    offset: (f64, f64),
) -> Option<Found> {
    let sign = if envelope.side() == Side::Lower { 1.0 } else { -1.0 };
    let mut best: Option<Candidate> = None;
    let mut keep = |candidate: Candidate| {
        if best.is_none_or(|b| envelope.better(candidate.value, b.value)) {
            best = Some(candidate);
        }
        best
    };
    // The free family contains the named ones and must not be worse than they are.
    for b in [exponent.0, 1.0, 2.0, exponent.1] {
        for g in [offset.0, offset.1] {
            if (exponent.0..=exponent.1).contains(&b) {
                envelope.best(b, g).map(&mut keep);
            }
        }
    }
    let mut cells = BinaryHeap::new();
    cells.extend(Cell::new(envelope, exponent, offset, sign));
    let mut evaluations = 0;
    while let Some(cell) = cells.pop() {
        let best = keep(cell.corner)?;
        let gap = sign * (cell.bound - best.value);
        let done = gap <= GAP * best.value.abs() || cell.is_point();
        if done || evaluations >= EVALUATIONS {
            let gap = if best.value > 0.0 { (gap / best.value).max(0.0) } else { 0.0 };
            return Some(Found { best, gap });
        }
        evaluations += 2;
        for (exponent, offset) in cell.halves(envelope) {
            let half = Cell::new(envelope, exponent, offset, sign);
            if let Some(half) = half {
                keep(half.corner);
                cells.push(half);
            }
        }
    }
    // An upper step: if the corner with the largest offset fails, the whole range does.
    None
}

impl Cell {
    fn new(
        envelope: &Envelope,
        exponent: (f64, f64),
        offset: (f64, f64),
        sign: f64,
    ) -> Option<Self> {
        // The corner that satisfies the limits most easily: if it fails, all of the cell does.
        let corner = match envelope.side() {
            Side::Upper => envelope.best(exponent.0, offset.1)?,
            Side::Lower => envelope.best(exponent.1, offset.0)?,
        };
        let bound = envelope.relaxed(exponent, offset)?;
        Some(Self { exponent, offset, corner, bound, sign })
    }

    fn is_point(&self) -> bool {
        middle(self.exponent).is_none() && middle(self.offset).is_none()
    }

    /// Returns the halves across the side that contributes more to the uncertainty.
    fn halves(&self, envelope: &Envelope) -> Vec<((f64, f64), (f64, f64))> {
        let (exponent, offset) = (middle(self.exponent), middle(self.offset));
        let across_offset = (self.offset.1 - self.offset.0) * envelope.white();
        // The uncertainty that is not due to the offset is due to the exponent.
        let whole = (self.corner.value - self.bound).abs();
        match (exponent, offset) {
            (Some(b), _) if offset.is_none() || across_offset < 0.5 * whole => {
                vec![((self.exponent.0, b), self.offset), ((b, self.exponent.1), self.offset)]
            }
            (_, Some(g)) => {
                vec![(self.exponent, (self.offset.0, g)), (self.exponent, (g, self.offset.1))]
            }
            _ => Vec::new(),
        }
    }
}

/// Returns the middle of a range, or `None` if it coincides with an end.
fn middle(range: (f64, f64)) -> Option<f64> {
    let middle = 0.5 * (range.0 + range.1);
    (range.0 < middle && middle < range.1).then_some(middle)
}

impl Ord for Cell {
    fn cmp(&self, other: &Self) -> Ordering {
        (self.sign * self.bound).total_cmp(&(other.sign * other.bound))
    }
}

impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Cell {}
