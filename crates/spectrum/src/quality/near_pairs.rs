use std::ops::Range;

use pulp::{Simd, WithSimd};
use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use sphvar_samplers::Progress;
use sphvar_sh::CompensatedSum;

use super::kernel::Kernel;
use super::nodes::Nodes;
use super::table::{LANES, Table};
use crate::Error;

/// Points whose pairs with later points are summed together.
const ROWS: usize = 64;

/// Nominal work of one pair, from its 10 ns.
const PAIR: f64 = 0.2;

/// The two ways to compute a split sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Effort {
    /// The transform by its definition, a search through all pairs.
    Definition,
    /// The fast transform, the pairs that [`Nodes::later_neighbours`] finds.
    Fast,
}

/// Sums over pairs of different points within the range of a table.
#[derive(Clone, Debug)]
pub(super) struct NearPairs {
    /// `sum_(j<k) w_j w_k K(x_j, x_k)` of each kernel.
    pub(super) sums: [f64; Kernel::ALL.len()],
    /// Whether two points coincide up to rounding.
    pub(super) has_coincident: bool,
}

impl NearPairs {
    /// Returns the sums, which do not depend on the number of threads.
    pub(super) fn new(
        nodes: &Nodes,
        table: &Table,
        effort: Effort,
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
        let radius = 2.0 * table.range().sqrt().asin();
        let n = nodes.len();
        let parts = (0..n.div_ceil(ROWS)).into_par_iter().map(|chunk| {
            let rows = chunk * ROWS..((chunk + 1) * ROWS).min(n);
            let part = pulp::Arch::new().dispatch(Rows { nodes, table, effort, radius, rows });
            progress.tick(PAIR * part.pairs as f64)?;
            Ok(part)
        });
        let parts = parts.collect::<Result<Vec<Part>, Error>>()?;
        let sum = |i: usize| parts.iter().map(|part| part.sums[i]).collect::<CompensatedSum>();
        Ok(Self {
            sums: std::array::from_fn(|i| sum(i).value()),
            has_coincident: parts.iter().any(|part| part.has_coincident),
        })
    }

    /// Returns the nominal work of summing about that number of pairs.
    pub(super) fn nominal_work(pairs: f64) -> f64 {
        PAIR * pairs
    }
}

/// The sums of some rows.
struct Part {
    sums: [f64; LANES],
    has_coincident: bool,
    pairs: usize,
}

/// The arguments of the sums of some rows.
struct Rows<'a> {
    nodes: &'a Nodes,
    table: &'a Table,
    effort: Effort,
    radius: f64,
    rows: Range<usize>,
}

impl WithSimd for Rows<'_> {
    type Output = Part;

    // Inlined so that it is compiled for the dispatched instruction set; closures would not be.
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Part {
        let Self { nodes, table, effort, radius, rows } = self;
        let mut part = Part { sums: [0.0; LANES], has_coincident: false, pairs: 0 };
        let mut ranges = Vec::new();
        for k in rows {
            ranges.clear();
            match effort {
                Effort::Definition => ranges.push(k + 1..nodes.len()),
                Effort::Fast => nodes.later_neighbours(k, radius, &mut ranges),
            }
            let mut row = [0.0; LANES];
            for range in ranges.drain(..) {
                part.pairs += range.len();
                part.has_coincident |= add_pairs(simd, nodes, table, k, range, &mut row);
            }
            for (sum, row) in part.sums.iter_mut().zip(row) {
                *sum += nodes.w[k] * row;
            }
        }
        part
    }
}

/// Adds `w_j K(x_k, x_j)` for j in `range`, and returns whether one of them coincides with k.
#[inline(always)]
fn add_pairs<S: Simd>(
    simd: S,
    nodes: &Nodes,
    table: &Table,
    k: usize,
    range: Range<usize>,
    row: &mut [f64; LANES],
) -> bool {
    let p = nodes.point(k);
    let (xs, ys) = (&nodes.x[range.clone()], &nodes.y[range.clone()]);
    let (zs, ws) = (&nodes.z[range.clone()], &nodes.w[range]);
    let mut has_coincident = false;
    for (((x, y), z), w) in xs.iter().zip(ys).zip(zs).zip(ws) {
        let (dx, dy, dz) = (p.x - x, p.y - y, p.z - z);
        let v = 0.25 * (dx * dx + dy * dy + dz * dz);
        if v <= table.range() {
            has_coincident |= Table::is_coincident(v);
            table.add_multiple(simd, v, *w, row);
        }
    }
    has_coincident
}
