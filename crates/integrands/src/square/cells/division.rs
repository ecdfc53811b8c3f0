//! Division of cells where the function is not smooth, or has features of a known place.

use std::collections::BTreeMap;

use super::{Cells, Feature, Place};
use crate::Error;

/// Cells are not divided further than this fraction of the square.
const MIN_AREA: f64 = 1e-15;
/// The points around the direction of a feature that are examined.
const FEATURE_POINTS: u32 = 200;
/// The angle that divides a turn by the golden section.
const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;
/// The rounds of division.
const MAX_ROUNDS: usize = 100;

/// What decides whether a cell that is not divided is. Cells are large, and all are examined in each
/// round.
struct Live {
    index: usize,
    error: f64,
    moments: [f64; 2],
    is_divisible: bool,
}

impl Cells<'_> {
    /// Divides the cells of the largest misfits.
    pub(super) fn divide(&mut self, relative: f64, max: usize) -> Result<(), Error> {
        let (mut live, mut n_seen) = (Vec::new(), 0);
        for _ in 0..MAX_ROUNDS {
            live.extend(self.live_from(n_seen));
            n_seen = self.list.len();
            // In the order of the list, so that rounding does not depend on the rounds.
            let (first, second) = live
                .iter()
                .fold((0.0, 0.0), |(a, b), cell: &Live| (a + cell.moments[0], b + cell.moments[1]));
            let variance = second - first * first;
            let error: f64 = live.iter().map(|cell| cell.error).sum();
            if error <= relative * variance || error <= f64::EPSILON * f64::EPSILON * second {
                break;
            }
            let divisible = || live.iter().filter(|cell| cell.is_divisible);
            let largest = divisible().map(|cell| cell.error).fold(0.0, f64::max);
            let mut chosen: Vec<usize> =
                divisible().filter(|c| c.error > 0.25 * largest).map(|cell| cell.index).collect();
            // Halves have fewer nodes than their cell each.
            let mut remaining = max.saturating_sub(self.nodes.len());
            chosen.retain(|i| {
                let len = 2 * self.list[*i].len();
                let fits = len <= remaining;
                remaining -= if fits { len } else { remaining };
                fits
            });
            if chosen.is_empty() {
                break;
            }
            self.halve(&chosen)?;
            let mut divided = chosen.iter().peekable();
            live.retain(|cell| divided.next_if_eq(&&cell.index).is_none());
        }
        Ok(())
    }

    /// Returns the cells that are not divided from a place in the list on.
    fn live_from(&self, first: usize) -> impl Iterator<Item = Live> {
        let cells = self.list.iter().enumerate().skip(first);
        cells.filter(|(_, cell)| !cell.is_divided).map(|(index, cell)| Live {
            index,
            error: cell.error(),
            moments: cell.moments,
            is_divisible: cell.area > MIN_AREA,
        })
    }

    /// Divides cells along the coordinate of their larger misfit.
    fn halve(&mut self, cells: &[usize]) -> Result<(), Error> {
        let along: Vec<(usize, usize)> = cells
            .iter()
            .map(|i| (*i, usize::from(self.list[*i].misfit[1] > self.list[*i].misfit[0])))
            .collect();
        self.halve_along(&along)
    }

    fn halve_along(&mut self, cells: &[(usize, usize)]) -> Result<(), Error> {
        let mut groups: BTreeMap<(usize, usize), Vec<Place>> = BTreeMap::new();
        for &(i, coordinate) in cells {
            let cell = &mut self.list[i];
            cell.is_divided = true;
            let (place, u, panel) = (cell.place, cell.u, cell.panel);
            if coordinate == 0 {
                for half in self.u_intervals.halves(u) {
                    groups.entry((half, panel)).or_default().push(place);
                }
                continue;
            }
            let middle = f64::midpoint(place.share[0], place.share[1]);
            let halves = self.v_intervals.as_mut().map_or([0; 2], |all| all.halves(place.v));
            let shares = [[place.share[0], middle], [middle, place.share[1]]];
            let both = shares.into_iter().zip(halves);
            let both = both.map(|(share, v)| Place { piece: place.piece, share, v });
            groups.entry((u, panel)).or_default().extend(both);
        }
        groups.into_iter().try_for_each(|((u, panel), places)| self.add_cells(u, panel, &places))
    }

    /// Divides the cells around a direction until they are no larger than a feature there.
    pub(super) fn divide_at(&mut self, feature: &Feature) -> Result<(), Error> {
        // A Fibonacci spiral over the disk around the direction, because a pole of the warp is the
        // side of many cells.
        let (x, y) = feature.dir.any_orthonormal_pair();
        let dirs = (0..FEATURE_POINTS).map(|i| {
            let radius = feature.size * ((f64::from(i) + 0.5) / f64::from(FEATURE_POINTS)).sqrt();
            let (sin, cos) = (GOLDEN_ANGLE * f64::from(i)).sin_cos();
            (feature.dir + radius * (cos * x + sin * y)).normalize()
        });
        let warp = self.warp;
        for [u, v] in dirs.filter_map(|dir| warp.inverse(dir)) {
            for _ in 0..MAX_ROUNDS {
                let Some(i) = self.cell_of([u, v]) else { break };
                let cell = &self.list[i];
                let nodes = &self.nodes[cell.first..cell.first + cell.len()];
                let map = |k: usize| self.warp.map(nodes[k].point);
                let (first, last) = (map(0), cell.len() - 1);
                let extents = [map(last - (cell.orders[1] - 1)), map(cell.orders[1] - 1)]
                    .map(|dir| dir.distance(first));
                if cell.area <= MIN_AREA || extents[0].max(extents[1]) <= 0.5 * feature.size {
                    break;
                }
                self.halve_along(&[(i, usize::from(extents[1] > extents[0]))])?;
            }
        }
        Ok(())
    }

    /// Returns the cell that contains a point.
    fn cell_of(&self, [u, v]: [f64; 2]) -> Option<usize> {
        let mut edges: Option<(usize, Vec<f64>)> = None;
        self.list.iter().position(|cell| {
            let [low, high] = self.u_intervals.ends(cell.u);
            if cell.is_divided || !(low..high).contains(&u) {
                return false;
            }
            if edges.as_ref().is_none_or(|(panel, _)| *panel != cell.panel) {
                edges = Some((cell.panel, self.edges(cell.panel, u)));
            }
            let Place { piece, share, .. } = cell.place;
            edges.as_ref().and_then(|(_, edges)| edges.get(piece..piece + 2)).is_some_and(|pair| {
                let place = (v - pair[0]) / (pair[1] - pair[0]);
                (share[0]..share[1]).contains(&place)
            })
        })
    }
}
