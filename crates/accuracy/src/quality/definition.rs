use std::f64::consts::PI;

use sphvar_samplers::PointSet;
use sphvar_sh::legendre_p_into;
use sphvar_spectrum::quality::{PairSums, WORST_CASE_SMOOTHNESS};

use crate::reference::DoubleDouble;
use crate::spectra::{dot, legendre, unit};

/// The last degree of the series of worst-case errors.
const LAST: usize = 30_000;

/// The degree below which power is summed in twice the precision: there it almost cancels.
const LOW: usize = 100;

/// Returns the measures in the order of [`PairSums`]; energies of sets with identical points are
/// `None`.
pub(super) fn values(sums: Option<&PairSums>) -> Vec<Option<f64>> {
    let Some(sums) = sums else { return Vec::new() };
    let mut all = vec![Some(sums.cap_discrepancy_l2), Some(sums.generalized_discrepancy)];
    all.extend(sums.worst_case_error.map(Some));
    all.extend(sums.riesz_energy);
    all
}

/// Returns the measures of a set by their definitions: closed forms with distances and sums in
/// twice the working precision, and series over degrees. Sets of some hundred points are
/// affordable.
pub(super) fn measures(set: &PointSet) -> Vec<Option<f64>> {
    let number = |x: f64| DoubleDouble::from(x);
    let n = set.len();
    let weights = || (0..n).map(|k| number(set.weights.get(k).copied().unwrap_or(1.0)));
    let total = weights().fold(DoubleDouble::ZERO, |sum, w| sum + w);
    let w: Vec<_> = weights().map(|w| w / total).collect();
    let units: Vec<_> = set.points.iter().map(|p| unit(*p)).collect();
    let mut squares = w.iter().fold(DoubleDouble::ZERO, |sum, w| sum + *w * *w);
    let n_effective = DoubleDouble::ONE / squares;
    let (mut cap, mut cui_freeden) = (squares / number(3.0), squares);
    let mut energies = [DoubleDouble::ZERO; 3];
    let mut is_distinct = true;
    // The weight of pairs whose distance is below the resolution of the series.
    let mut near = 0.0;
    // The power by degree but for the pairs of a point with itself.
    let mut power = vec![0.0; LAST + 1];
    let mut values = vec![0.0; LAST + 1];
    let mut low = [DoubleDouble::ZERO; LOW];
    for j in 0..n {
        for k in 0..j {
            let pair = w[j] * w[k];
            let twice = number(2.0) * pair;
            let difference = [0, 1, 2].map(|i: usize| units[j][i] - units[k][i]);
            let square = dot(difference, difference);
            let r = square.sqrt();
            cap += twice * (DoubleDouble::ONE / number(3.0) - r / number(4.0));
            cui_freeden += twice * number(1.0 - 2.0 * (0.5 * r.value()).ln_1p());
            if set.points[j] == set.points[k] {
                is_distinct = false;
                squares += twice;
                continue;
            }
            energies[0] += pair * number(-0.5 * square.value().ln());
            energies[1] += pair / r;
            energies[2] += pair / square;
            if r.value() * (LAST as f64) < 0.1 {
                near += twice.value();
            }
            for (sum, value) in low.iter_mut().zip(legendre(dot(units[j], units[k]))) {
                *sum += twice * value;
            }
            let cosine = dot(units[j], units[k]).value().clamp(-1.0, 1.0);
            legendre_p_into(cosine, &mut values).expect("a cosine");
            power.iter_mut().zip(&values).for_each(|(sum, p)| *sum += twice.value() * p);
        }
    }
    // The power of all pairs.
    let low = low.map(|sum| (sum + squares).value());
    let squares = squares.value();
    let mut all = vec![cap.value().sqrt(), (cui_freeden.value() / (4.0 * PI)).sqrt()];
    all.extend(WORST_CASE_SMOOTHNESS.map(|s| {
        let is_singular = s < 2.0;
        let term = |l: usize| {
            let eigenvalue = (l * (l + 1)) as f64;
            let cap = if is_singular { 8.0 / (4.0 * eigenvalue - 3.0) } else { 0.0 };
            (2 * l + 1) as f64 * (1.0 + eigenvalue).powf(-s) - cap
        };
        let all_pairs = |l: usize| if l < LOW { low[l] } else { power[l] + squares };
        let sum: f64 = (1..=LAST).rev().map(|l| term(l) * all_pairs(l)).sum();
        // Half of the last term: the mean of the last two partial sums of an alternating series.
        let sum = sum - 0.5 * term(LAST) * power[LAST];
        if is_singular {
            // The series converges slowly at s = 3/2; less that of 8 times the cap kernel, which
            // has the same singularity, its rest is 1e-13.
            return (8.0 * cap.value() + sum).sqrt();
        }
        // The integral over mu = (l + 1/2)^2 from the middle of two degrees, for pairs that do not
        // oscillate up to there.
        let rest = ((LAST as f64 + 1.0).powi(2) + 0.75).powf(1.0 - s) / (s - 1.0);
        (sum + (squares + near) * rest).sqrt()
    }));
    let scale = n_effective * n_effective;
    let mut all: Vec<_> = all.into_iter().map(Some).collect();
    all.extend(energies.map(|energy| is_distinct.then(|| (scale * energy).value())));
    all
}
