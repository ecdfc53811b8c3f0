use std::f64::consts::TAU;

use crate::Verdict;

/// Below this probability a hypothesis is rejected, above [`DOUBT`] it is accepted.
const REJECT: f64 = 1e-4;
/// Between the two the verdict is undecided.
const DOUBT: f64 = 1e-2;

/// Returns the verdict on a hypothesis from its p-value; undecided for NaN.
pub(crate) fn verdict(p_value: f64) -> Verdict {
    if p_value < REJECT {
        Verdict::Wrong
    } else if p_value >= DOUBT {
        Verdict::Holds
    } else {
        Verdict::Undecided
    }
}

/// Returns an upper bound of the probability that one of `comparisons` normal variables exceeds `z`
/// standard deviations.
///
/// ```text
/// K 2 phi(z)/z,   phi the normal density (Mills' ratio is below 1/z)
/// ```
pub(crate) fn largest_of_normal(z: f64, comparisons: usize) -> f64 {
    let density = (-0.5 * z * z).exp() / TAU.sqrt();
    (comparisons as f64 * 2.0 * density / z).min(1.0)
}

/// Above this probability a p-value is reported as within chance.
const WITHIN_CHANCE: f64 = 0.5;

/// Smaller p-values are rounding errors of the tail.
const SMALLEST: f64 = 1e-16;

/// Returns an upper bound of a p-value in words: `p <= 0.23`, `p <= 5e-12`, `within chance`.
pub(crate) fn at_most(p_value: f64) -> String {
    in_words("<=", p_value)
}

/// Returns a p-value in words: `p = 0.23`, `p = 5e-12`, `within chance`.
pub(crate) fn equal_to(p_value: f64) -> String {
    in_words("=", p_value)
}

fn in_words(relation: &str, p_value: f64) -> String {
    if p_value > WITHIN_CHANCE {
        "within chance".to_owned()
    } else if p_value < SMALLEST {
        format!("p < {SMALLEST:e}")
    } else if p_value < DOUBT {
        format!("p {relation} {p_value:.0e}")
    } else {
        format!("p {relation} {p_value:.2}")
    }
}

/// Kuiper's test of uniform phases.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kuiper {
    /// The statistic `V = D+ + D-`, scaled so that its distribution does not depend on the number
    /// of phases; 1.747 is the 5 % point.
    pub(crate) statistic: f64,
    /// The probability that uniform phases are at least as uneven as these.
    pub(crate) p_value: f64,
}

/// Returns Kuiper's test of phases in radians (Stephens 1970, Journal of the Royal Statistical
/// Society B 32, 115: good for n >= 8).
pub(crate) fn kuiper(phases: &[f64]) -> Kuiper {
    let mut turns: Vec<f64> = phases.iter().map(|p| p.rem_euclid(TAU) / TAU).collect();
    turns.sort_by(f64::total_cmp);
    let n = turns.len() as f64;
    let (mut above, mut below) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
    for (i, turn) in turns.iter().enumerate() {
        above = above.max((i as f64 + 1.0) / n - turn);
        below = below.max(turn - i as f64 / n);
    }
    let statistic = (n.sqrt() + 0.155 + 0.24 / n.sqrt()) * (above + below);
    // The series is that of the far tail; near 0 it needs too many terms.
    if statistic < 0.4 {
        return Kuiper { statistic, p_value: 1.0 };
    }
    let term = |j: u32| {
        let x = 2.0 * (f64::from(j) * statistic).powi(2);
        (2.0 * x - 1.0) * (-x).exp()
    };
    Kuiper { statistic, p_value: (2.0 * (1..=100).map(term).sum::<f64>()).clamp(0.0, 1.0) }
}

/// Returns the probability that independent pairs of mean 0 have means as far from 0 as these:
/// `exp(-T/2)` with `T = R mean^T C^-1 mean`, C the covariance of a pair; chi-square of 2 for many
/// pairs. NaN if the covariance is singular.
pub(crate) fn mean_is_zero(pairs: &[[f64; 2]]) -> f64 {
    let n = pairs.len() as f64;
    let mean = |f: &dyn Fn(&[f64; 2]) -> f64| pairs.iter().map(f).sum::<f64>() / n;
    let (a, b) = (mean(&|p| p[0]), mean(&|p| p[1]));
    let aa = mean(&|p| (p[0] - a).powi(2));
    let bb = mean(&|p| (p[1] - b).powi(2));
    let ab = mean(&|p| (p[0] - a) * (p[1] - b));
    let determinant = aa * bb - ab * ab;
    let t = n * (bb * a * a - 2.0 * ab * a * b + aa * b * b) / determinant;
    (-0.5 * t).exp()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn kuiper_knows_even_and_uneven_phases() {
        // Golden-angle phases are more even than random ones.
        let even: Vec<f64> = (0..500).map(|k| 2.399_963 * f64::from(k)).collect();
        assert!(kuiper(&even).p_value > 0.99, "{:?}", kuiper(&even));
        let half: Vec<f64> = even.iter().map(|p| p.rem_euclid(TAU) / 2.0).collect();
        assert!(kuiper(&half).p_value < 1e-30, "{:?}", kuiper(&half));
        let two: Vec<f64> = (0..500).map(|k| if k % 2 == 0 { 0.0 } else { PI }).collect();
        assert!(kuiper(&two).p_value < 1e-30, "{:?}", kuiper(&two));
        // Critical value of 5 % for large n: lambda = 1.747 (Stephens 1970, table 1), by a shift
        // that makes V so.
        let n = 100_000_u32;
        let shift = 1.747 / f64::from(n).sqrt();
        let moved: Vec<f64> =
            (0..n).map(|k| TAU * ((f64::from(k) + 0.5) / f64::from(n) * (1.0 - shift))).collect();
        let got = kuiper(&moved);
        assert!((got.p_value - 0.05).abs() < 2e-3, "{got:?}");
        assert!((got.statistic - 1.747).abs() < 5e-3, "{got:?}");
    }

    #[test]
    fn means_are_judged_by_their_covariance() {
        let circle: Vec<[f64; 2]> = (0..64)
            .map(|k| {
                let (sin, cos) = (TAU * f64::from(k) / 64.0).sin_cos();
                [cos, sin]
            })
            .collect();
        assert!(mean_is_zero(&circle) > 1.0 - 1e-12);
        let moved: Vec<[f64; 2]> = circle.iter().map(|p| [p[0] + 1.0, p[1]]).collect();
        // T = 64 * 1/0.5.
        assert!((mean_is_zero(&moved) / (-64.0_f64).exp() - 1.0).abs() < 1e-9);
    }

    #[test]
    fn the_tail_bound_is_above_the_tail() {
        // Two-sided 1.96 is 5 %.
        assert!((0.05..0.07).contains(&largest_of_normal(1.96, 1)));
        assert!(verdict(0.5) == Verdict::Holds && verdict(1e-9) == Verdict::Wrong);
        assert_eq!([at_most(1.0), at_most(2.4e-7)], ["within chance", "p <= 2e-7"]);
        assert_eq!([equal_to(0.51), equal_to(0.5)], ["within chance", "p = 0.50"]);
        assert_eq!([at_most(0.0), equal_to(1e-20)], ["p < 1e-16", "p < 1e-16"]);
        assert!(verdict(1e-3) == Verdict::Undecided && verdict(f64::NAN) == Verdict::Undecided);
    }
}
