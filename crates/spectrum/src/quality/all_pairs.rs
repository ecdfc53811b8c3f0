use pulp::NullaryFnOnce;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use sphvar_samplers::Progress;
use sphvar_sh::CompensatedSum;

use super::nodes::Nodes;
use crate::Error;

/// Points whose pairs with later points are summed together.
const ROWS: usize = 16;

/// Pairs between compensated additions: few enough that plain sums round below 1e-15.
const BLOCK: usize = 256;

/// Pairs that share a logarithm if their weights are equal.
const LANES: usize = 8;

/// Nominal work of one pair, from its 5 ns.
const PAIR: f64 = 0.1;

/// The number of kernels with closed forms.
const KERNELS: usize = 5;

/// Returns `sum_(j<k) w_j w_k K(r)` over all pairs for the kernels `1 - 3 r/4`, `1 - 2 ln(1 +
/// r/2)`, `-ln r`, `1/r` and `1/r^2`, from their closed forms.
///
/// The first two have mean 0 and cancel almost completely; constants that are not exact would be
/// errors of every term.
pub(super) fn all_pairs(nodes: &Nodes, progress: &dyn Progress) -> Result<[f64; KERNELS], Error> {
    let n = nodes.len();
    let parts = (0..n.div_ceil(ROWS)).into_par_iter().map(|chunk| {
        let mut sums = [CompensatedSum::default(); KERNELS];
        let mut pairs = 0;
        for k in chunk * ROWS..((chunk + 1) * ROWS).min(n) {
            for begin in (k + 1..n).step_by(BLOCK) {
                let end = (begin + BLOCK).min(n);
                let block = pulp::Arch::new().dispatch(Block { nodes, k, begin, end });
                for (sum, value) in sums.iter_mut().zip(block) {
                    sum.add(nodes.w[k] * value);
                }
                pairs += end - begin;
            }
        }
        progress.tick(PAIR * pairs as f64)?;
        Ok(sums.map(CompensatedSum::value))
    });
    let parts = parts.collect::<Result<Vec<_>, Error>>()?;
    let sum = |i: usize| parts.iter().map(|part| part[i]).collect::<CompensatedSum>().value();
    Ok(std::array::from_fn(sum))
}

/// Returns the nominal work of [`all_pairs`].
pub(super) fn nominal_work(n: usize) -> f64 {
    0.5 * PAIR * (n as f64).powi(2)
}

/// The arguments of `sum_j w_j K(x_k, x_j)` for j in `begin..end`.
struct Block<'a> {
    nodes: &'a Nodes,
    k: usize,
    begin: usize,
    end: usize,
}

impl NullaryFnOnce for Block<'_> {
    type Output = [f64; KERNELS];

    // Inlined so that it is compiled for the dispatched instruction set.
    #[inline(always)]
    fn call(self) -> [f64; KERNELS] {
        let Self { nodes, k, begin, end } = self;
        let p = nodes.point(k);
        let [xs, ys, zs, ws] =
            [&nodes.x, &nodes.y, &nodes.z, &nodes.w].map(|values| &values[begin..end]);
        let mut sums = [0.0; KERNELS];
        let chunks = xs.chunks(LANES).zip(ys.chunks(LANES)).zip(zs.chunks(LANES));
        for (((xs, ys), zs), ws) in chunks.zip(ws.chunks(LANES)) {
            // Lanes that are not filled have weight 0 and distance 1.
            let (mut squares, mut weights) = ([1.0; LANES], [0.0; LANES]);
            for (i, w) in ws.iter().enumerate() {
                let (dx, dy, dz) = (p.x - xs[i], p.y - ys[i], p.z - zs[i]);
                squares[i] = dx * dx + dy * dy + dz * dz;
                weights[i] = *w;
            }
            let r = squares.map(f64::sqrt);
            for i in 0..LANES {
                sums[0] += weights[i] * (1.0 - 0.75 * r[i]);
                sums[3] += weights[i] / r[i];
                sums[4] += weights[i] / squares[i];
            }
            let halves = r.map(|r| 1.0 + 0.5 * r);
            if weights.iter().all(|w| w.to_bits() == weights[0].to_bits()) {
                // One logarithm of a product; it neither overflows nor underflows.
                let w = weights[0];
                sums[1] += w * (LANES as f64 - 2.0 * halves.iter().product::<f64>().ln());
                sums[2] -= 0.5 * w * squares.iter().product::<f64>().ln();
            } else {
                for i in 0..LANES {
                    sums[1] += weights[i] * (1.0 - 2.0 * halves[i].ln());
                    sums[2] -= 0.5 * weights[i] * squares[i].ln();
                }
            }
        }
        sums
    }
}
