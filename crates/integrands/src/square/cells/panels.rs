//! The first cells, between the breaks of a warp.

use super::line::Intervals;
use super::rules::{MAX_WAVELENGTHS, Rules};
use super::{Cells, Panel, Place};
use crate::Error;

/// The largest frequencies that are tried for the first cells, with the lowest order of the rules. Of
/// order 2, the misfit does not show a kink at the centre of a cell, so that is a last resort.
const RESOLUTIONS: [(usize, usize); 5] = [(256, 3), (128, 3), (64, 3), (64, 2), (32, 2)];

impl Cells<'_> {
    /// Chooses the largest frequency and the breaks that are kept for the first cells.
    pub(super) fn choose_resolution(&mut self, max: usize) {
        let len = |edges: &[f64], (kmax, order): (usize, usize)| -> usize {
            let panels = edges.windows(2).map(|pair| {
                let (parts, wavelengths) = parts(pair[1] - pair[0], kmax);
                parts * Rules::order(wavelengths, order)
            });
            panels.sum()
        };
        for stride in (0..).map(|i| 1usize << i) {
            self.stride = stride;
            let u = self.edges_in_u();
            let v = [0.2, 0.5, 0.8].map(|u| self.edges_in_v(u));
            for resolution in RESOLUTIONS {
                (self.kmax, self.min_order) = resolution;
                let along_v = v.iter().map(|edges| len(edges, resolution)).max().unwrap_or(1);
                if len(&u, resolution).saturating_mul(along_v) <= max {
                    return;
                }
            }
            // Without breaks there is nothing to thin.
            if stride > self.warp.breaks_in_u().len() + self.warp.breaks_in_v(0.5).len() {
                return;
            }
        }
    }

    /// Returns the breaks of the warp that are kept and some that are given, with both ends of [0, 1].
    fn thinned(&self, breaks: &[f64], given: &[f64]) -> Vec<f64> {
        let mut edges = Vec::with_capacity(breaks.len() + given.len() + 2);
        edges.push(0.0);
        edges.extend(breaks.iter().skip(self.stride - 1).step_by(self.stride));
        edges.push(1.0);
        if !given.is_empty() {
            edges.extend(given);
            edges.sort_by(f64::total_cmp);
            edges.dedup();
        }
        edges
    }

    /// Returns the edges of panels in u.
    fn edges_in_u(&self) -> Vec<f64> {
        self.thinned(&self.warp.breaks_in_u(), &self.lines[0])
    }

    /// Returns the edges of cells in v where these follow u.
    fn edges_in_v(&self, u: f64) -> Vec<f64> {
        let breaks = self.warp.breaks_in_v(u);
        // Lines at constant v would cross the breaks.
        let lines: &[f64] = if breaks.is_empty() { &self.lines[1] } else { &[] };
        self.thinned(&breaks, lines)
    }

    /// Adds the first cells.
    pub(super) fn add_panels(&mut self) -> Result<(), Error> {
        let has_breaks = |u: f64| !self.warp.breaks_in_v(u).is_empty();
        let is_rectangular = ![0.1, 0.3, 0.5, 0.7, 0.9].into_iter().any(has_breaks);
        let mut intervals = is_rectangular.then(Intervals::default);
        let edges = self.edges_in_u();
        for pair in edges.windows(2) {
            let (parts_of_u, _) = parts(pair[1] - pair[0], self.kmax);
            for [low, high] in divided([pair[0], pair[1]], parts_of_u) {
                let u = self.u_intervals.push([low, high]);
                let (places, lines) = self.first_places([low, high], intervals.as_mut());
                self.add_on_lines(u, self.panels.len() - 1, &places, &lines)?;
            }
        }
        self.v_intervals = intervals;
        Ok(())
    }

    /// Adds a panel in u, and returns the places of its cells and the edges in v at its nodes.
    fn first_places(
        &mut self,
        u: [f64; 2],
        intervals: Option<&mut Intervals>,
    ) -> (Vec<Place>, Vec<Vec<f64>>) {
        let order = self.order_of_interval(u);
        let at = |x: f64| self.edges_in_v(u[0] + x * (u[1] - u[0]));
        let lines: Vec<Vec<f64>> =
            self.rules.of_order(order).nodes.iter().map(|x| at(*x)).collect();
        let is_consistent = lines.iter().all(|line| line.len() == lines[0].len());
        let middle = &lines[order / 2];
        let widest = |piece: usize| {
            let width = |line: &Vec<f64>| line.get(piece + 1).map_or(0.0, |v| v - line[piece]);
            if is_consistent { lines.iter().map(width).fold(0.0, f64::max) } else { width(middle) }
        };
        let mut places = Vec::new();
        for piece in 0..middle.len() - 1 {
            let n = parts(widest(piece), self.kmax).0;
            places.extend(divided([0.0, 1.0], n).map(|share| Place { piece, share, v: 0 }));
        }
        if let Some(intervals) = intervals {
            // The edges are those of all panels, so all have the same places.
            let is_first = intervals.len() == 0;
            for (i, place) in places.iter_mut().enumerate() {
                let (start, end) = (middle[place.piece], middle[place.piece + 1]);
                let ends = place.share.map(|share| start + share * (end - start));
                place.v = if is_first { intervals.push(ends) } else { i };
            }
        }
        if is_consistent {
            self.panels.push(Panel { edges: None });
            return (places, lines);
        }
        let middle = middle.clone();
        self.panels.push(Panel { edges: Some(middle.clone()) });
        (places, vec![middle; order])
    }

    /// Returns the edges in v at a value of u in a panel.
    pub(super) fn edges(&self, panel: usize, u: f64) -> Vec<f64> {
        let edges = self.panels[panel].edges.clone();
        edges.unwrap_or_else(|| self.edges_in_v(u))
    }
}

/// Returns the number of parts of a panel of this width, and the wavelengths in each.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a positive number of some hundred"
)]
fn parts(width: f64, kmax: usize) -> (usize, f64) {
    let wavelengths = width * kmax as f64;
    let parts = (wavelengths / MAX_WAVELENGTHS).ceil().max(1.0);
    (parts as usize, wavelengths / parts)
}

/// Returns equal parts of an interval.
fn divided([low, high]: [f64; 2], n: usize) -> impl Iterator<Item = [f64; 2]> {
    let edge = move |i: usize| if i == n { high } else { low + (high - low) * i as f64 / n as f64 };
    (0..n).map(move |i| [edge(i), edge(i + 1)])
}
