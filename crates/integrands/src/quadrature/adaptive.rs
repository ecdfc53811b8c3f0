use glam::DVec3;
use sphvar_sh::{CompensatedSum, GaussLegendre};

use super::node_count;
use crate::Error;

/// A part of the sphere with coordinates, and the function on it.
///
/// Coordinates are chosen so that value and area element are analytic in them; the function may
/// vary over many orders of magnitude of lengths.
pub(crate) trait Patch {
    /// Returns the node at the coordinates (u, v) of a panel.
    fn node(&self, panel: usize, u: f64, v: f64) -> PatchNode;
}

/// A point of a [`Patch`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct PatchNode {
    pub(crate) dir: DVec3,
    /// The area of the sphere per unit of u and v.
    pub(crate) area: f64,
    pub(crate) value: f64,
}

/// A rectangle of coordinates on which a product rule integrates the function and its square.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    pub(crate) panel: usize,
    pub(crate) u: [f64; 2],
    pub(crate) v: [f64; 2],
}

/// Nodes of a cell in each coordinate.
const NODES: usize = 10;
/// The largest difference between a cell and its halves, relative to the integral of the whole:
/// halves are more accurate by a factor of 2^20, so the error is of the order of rounding.
const TOLERANCE: f64 = 1e-14;
/// The number of bisections from a first cell, which reaches the rounding of its coordinates.
const MAX_DEPTH: u32 = 40;
/// The number of cells at which bisection stops; functions of this crate take some hundreds.
const MAX_CELLS: usize = 50_000;
/// Maximum number of nodes of a transform, some minutes of work.
const MAX_NODES: f64 = 2e8;

/// The integrals of 1, f and f^2.
type Moments = [f64; 3];

impl Cell {
    /// Returns the halves in u or in v.
    fn halves(self, in_u: bool) -> [Self; 2] {
        let middle = |[a, b]: [f64; 2]| 0.5 * (a + b);
        if in_u {
            let m = middle(self.u);
            [Self { u: [self.u[0], m], ..self }, Self { u: [m, self.u[1]], ..self }]
        } else {
            let m = middle(self.v);
            [Self { v: [self.v[0], m], ..self }, Self { v: [m, self.v[1]], ..self }]
        }
    }

    /// Calls `f` with the nodes of a product rule and their areas.
    fn for_each(
        self,
        patch: &impl Patch,
        rules: [&GaussLegendre; 2],
        f: &mut impl FnMut(PatchNode),
    ) {
        let scaled = |rule: &GaussLegendre, [a, b]: [f64; 2]| -> Vec<(f64, f64)> {
            let half = 0.5 * (b - a);
            let nodes = rule.nodes().iter().zip(rule.weights());
            nodes.map(|(x, w)| (a + half * (1.0 + x), half * w)).collect()
        };
        let (us, vs) = (scaled(rules[0], self.u), scaled(rules[1], self.v));
        for &(u, wu) in &us {
            for &(v, wv) in &vs {
                let node = patch.node(self.panel, u, v);
                f(PatchNode { area: node.area * wu * wv, ..node });
            }
        }
    }

    fn moments(self, patch: &impl Patch, rule: &GaussLegendre) -> Moments {
        let mut sums = [0.0; 3];
        self.for_each(patch, [rule, rule], &mut |node| {
            let first = node.area * node.value;
            let terms = [node.area, first, first * node.value];
            sums.iter_mut().zip(terms).for_each(|(s, term)| *s += term);
        });
        sums
    }

    /// Returns the phases over the cell, in u and in v, of functions of unit degree.
    fn phases(self, patch: &impl Patch) -> [f64; 2] {
        let at = |x: f64, y: f64| {
            let place = |[a, b]: [f64; 2], t: f64| a + t * (b - a);
            patch.node(self.panel, place(self.u, x), place(self.v, y)).dir
        };
        // Twice the longer half, because coordinates are not proportional to lengths.
        let longest = |along: &dyn Fn(f64, f64) -> DVec3| {
            let across = [0.0, 0.5, 1.0].into_iter();
            let lengths =
                across.flat_map(|y| [0.0, 0.5].map(|x| (along(x, y) - along(x + 0.5, y)).length()));
            2.0 * lengths.fold(0.0, f64::max)
        };
        [longest(&|x, y| at(x, y)), longest(&|x, y| at(y, x))]
    }
}

/// Cells of coordinates on which products of a rule of few nodes give the integrals of a function
/// and of its square to rounding.
#[derive(Clone, Debug)]
pub(crate) struct AdaptiveCells(Vec<Cell>);

impl AdaptiveCells {
    /// Bisects cells, in the coordinate in which the rule is less accurate, until the integrals of
    /// 1, f and f^2 over a cell agree with those over its halves.
    ///
    /// Cost: 500 values per bisection; a few hundred bisections for a lobe.
    pub(crate) fn new(patch: &impl Patch, first: Vec<Cell>) -> Result<Self, Error> {
        let rule = GaussLegendre::new(NODES)?;
        let mut total = [0.0; 3];
        let mut pending = Vec::new();
        for cell in first {
            let moments = cell.moments(patch, &rule);
            total.iter_mut().zip(moments).for_each(|(t, m)| *t += m);
            pending.push((cell, moments, 0));
        }
        let mut cells = Vec::new();
        while let Some((cell, whole, depth)) = pending.pop() {
            let split = [true, false].map(|in_u| {
                let halves = cell.halves(in_u).map(|half| (half, half.moments(patch, &rule)));
                let difference =
                    |k: usize| (halves[0].1[k] + halves[1].1[k] - whole[k]).abs() / total[k];
                ((0..3).map(difference).fold(0.0, f64::max), halves)
            });
            let [in_u, in_v] = split;
            let (error, halves) = if in_u.0 >= in_v.0 { in_u } else { in_v };
            if error <= TOLERANCE || depth == MAX_DEPTH || cells.len() >= MAX_CELLS {
                cells.push(cell);
                continue;
            }
            // A peak between the nodes of the first cells shows itself in their parts.
            for k in 0..3 {
                total[k] += halves[0].1[k] + halves[1].1[k] - whole[k];
            }
            pending.extend(halves.map(|(half, moments)| (half, moments, depth + 1)));
        }
        Ok(Self(cells))
    }

    /// Returns the integral of a function of the nodes.
    pub(crate) fn sum(
        &self,
        patch: &impl Patch,
        of: impl Fn(PatchNode) -> f64,
    ) -> Result<f64, Error> {
        let rule = GaussLegendre::new(NODES)?;
        let mut sum = CompensatedSum::default();
        for cell in &self.0 {
            cell.for_each(patch, [&rule, &rule], &mut |node| sum.add(node.area * of(node)));
        }
        Ok(sum.value())
    }

    /// Calls `f` with nodes for the function times polynomials of a degree; if the function does
    /// not depend on v, with one node in v.
    pub(crate) fn for_each(
        &self,
        patch: &impl Patch,
        degree: usize,
        depends_on_v: bool,
        mut f: impl FnMut(PatchNode),
    ) -> Result<(), Error> {
        let count = |phase: f64| node_count(0.5 * degree as f64 * phase) + NODES;
        let mut plan = Vec::with_capacity(self.0.len());
        for &cell in &self.0 {
            let [u, v] = cell.phases(patch).map(count);
            plan.push((cell, [u, if depends_on_v { v } else { 1 }]));
        }
        if plan.iter().map(|(_, [u, v])| (u * v) as f64).sum::<f64>() > MAX_NODES {
            let reason = "its values would have to be taken at more than 2e8 places; take lower \
                          degrees";
            return Err(Error::NoEnergy { reason });
        }
        // Cells of equal counts are consecutive, and share their rules.
        plan.sort_by_key(|&(_, counts)| counts);
        for same in plan.chunk_by(|a, b| a.1 == b.1) {
            let [u, v] = same[0].1;
            let rules = [GaussLegendre::new(u)?, GaussLegendre::new(v)?];
            for (cell, _) in same {
                cell.for_each(patch, [&rules[0], &rules[1]], &mut f);
            }
        }
        Ok(())
    }
}
