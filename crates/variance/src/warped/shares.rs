use std::collections::BTreeMap;

use super::WarpedPattern;
use crate::Error;

/// The number of units of which shares consist, and that for more than this number of warps.
const UNITS: (usize, usize) = (20, 100);
const MAX_COARSE: usize = 10;
/// The units that the search moves from one warp to another, in turn.
const STEPS: [usize; 3] = [4, 2, 1];

/// Returns the pattern with the shares of its warps for which `merit`, such as the predicted variance,
/// is smallest, with that merit.
///
/// Shares are multiples of 0.05, of 0.01 for more than 10 warps, and no share is 0: a warp without
/// points is another estimator. The merit may have several local minima, because a density that suits
/// the integrand alone and one that covers its tails are both good with few points of the other. For
/// two warps the result is the best of all shares, with 19 calls of `merit`. For more, the search
/// starts from the best among the pattern's own shares, rounded, and, up to 10 warps, those with the
/// least shares for all warps but one; it moves parts of 0.2, 0.1 and 0.05 between two warps while
/// that improves the merit, so the result is a minimum with respect to all such moves. `merit` must
/// pull the integrand back anew, since the weights depend on the shares.
///
/// # Errors
///
/// Returns the errors of `merit`.
///
/// # Examples
///
/// ```
/// use sphvar_variance::{WarpedPattern, best_shares};
///
/// let pattern: WarpedPattern = "sobol:warp=\"cosine + cylinder\"".parse()?;
/// let mut merit = |pattern: &WarpedPattern| Ok((pattern.warp.shares()[0] - 0.68).abs());
/// let (best, _) = best_shares(&pattern, &mut merit)?;
/// assert_eq!(best.to_string(), "sobol:warp=\"0.7 * cosine + 0.3 * cylinder\"");
/// # Ok::<(), sphvar_variance::Error>(())
/// ```
pub fn best_shares(
    pattern: &WarpedPattern,
    merit: &mut dyn FnMut(&WarpedPattern) -> Result<f64, Error>,
) -> Result<(WarpedPattern, f64), Error> {
    let n_warps = pattern.n_strategies();
    let units = if n_warps > MAX_COARSE { UNITS.1 } else { UNITS.0 };
    let with_parts = |parts: &[usize]| {
        let shares: Vec<f64> = parts.iter().map(|part| *part as f64 / units as f64).collect();
        Ok::<_, Error>(WarpedPattern {
            warp: pattern.warp.with_shares(&shares)?,
            ..pattern.clone()
        })
    };
    let mut known = BTreeMap::<Vec<usize>, f64>::new();
    let mut merit_of = |parts: &[usize]| {
        if let Some(known) = known.get(parts) {
            return Ok::<_, Error>(*known);
        }
        let found = merit(&with_parts(parts)?)?;
        known.insert(parts.to_vec(), found);
        Ok(found)
    };
    let mut best = rounded(&pattern.warp.shares(), units);
    let mut min_merit = merit_of(&best)?;
    for start in starts(n_warps, units) {
        let merit = merit_of(&start)?;
        if merit < min_merit {
            (best, min_merit) = (start, merit);
        }
    }
    let pairs = || (0..n_warps).flat_map(|from| (0..n_warps).map(move |to| (from, to)));
    for step in STEPS {
        let mut is_improved = true;
        while is_improved {
            is_improved = false;
            for (from, to) in pairs().filter(|(from, to)| from != to) {
                if best[from] <= step {
                    continue;
                }
                let mut moved = best.clone();
                moved[from] -= step;
                moved[to] += step;
                let merit = merit_of(&moved)?;
                if merit < min_merit {
                    (best, min_merit, is_improved) = (moved, merit, true);
                }
            }
        }
    }
    Ok((with_parts(&best)?, min_merit))
}

/// Returns all parts of two warps and, of up to [`MAX_COARSE`], those of 1 for all warps but one.
fn starts(n_warps: usize, units: usize) -> Vec<Vec<usize>> {
    match n_warps {
        2 => (1..units).map(|part| vec![part, units - part]).collect(),
        3..=MAX_COARSE => (0..n_warps)
            .map(|main| {
                let mut parts = vec![1; n_warps];
                parts[main] = units + 1 - n_warps;
                parts
            })
            .collect(),
        _ => Vec::new(),
    }
}

/// Returns whole numbers of at least 1 and of sum `units`, near the shares of it.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most `units`")]
fn rounded(shares: &[f64], units: usize) -> Vec<usize> {
    let mut parts: Vec<usize> =
        shares.iter().map(|share| ((share * units as f64).round() as usize).max(1)).collect();
    loop {
        let sum: usize = parts.iter().sum();
        // The largest part changes least, relative to its size.
        let Some(largest) = parts.iter_mut().max() else { return parts };
        match sum.cmp(&units) {
            std::cmp::Ordering::Less => *largest += 1,
            std::cmp::Ordering::Greater => *largest -= 1,
            std::cmp::Ordering::Equal => return parts,
        }
    }
}
