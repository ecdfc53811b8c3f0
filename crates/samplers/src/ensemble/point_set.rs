use glam::DVec3;
use sphvar_sh::CompensatedSum;

use crate::Point;

/// A set of directions or of points `[u, v]` of the square, with or without weights.
///
/// An integral is estimated by `area sum_k w_k f(s_k)/sum_k w_k`, so that only ratios of weights
/// matter.
///
/// # Examples
///
/// ```
/// use glam::DVec3;
/// use sphvar_samplers::PointSet;
///
/// let set = PointSet { points: vec![DVec3::X, DVec3::Z], weights: vec![1.0, 3.0] };
/// assert_eq!(set.mean(&[0.0, 1.0]), 0.75);
/// assert_eq!(set.n_effective(), 1.6);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointSet<P = DVec3> {
    /// Unit vectors, or points of `[0, 1)^2`.
    pub points: Vec<P>,
    /// One finite weight for each point, of any sign and scale; empty if all are equal.
    pub weights: Vec<f64>,
}

impl<P> PointSet<P> {
    /// Returns a set of equal weights.
    #[must_use]
    pub fn new(points: Vec<P>) -> Self {
        Self { points, weights: Vec::new() }
    }

    /// Clears points and weights and returns the points to be filled; capacity is kept.
    pub fn start(&mut self) -> &mut Vec<P> {
        self.points.clear();
        self.weights.clear();
        &mut self.points
    }

    /// Returns the number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Returns whether there are no points.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Rejects empty sets and sets whose number of weights differs from the number of points; the
    /// reason is a phrase without its subject.
    pub(crate) fn check_lengths(&self) -> Result<(), String> {
        match (self.points.len(), self.weights.len()) {
            (0, _) => Err("has no points".to_owned()),
            (n, n_weights) if n_weights == 0 || n_weights == n => Ok(()),
            (n, n_weights) => Err(format!("has {n} points and {n_weights} weights")),
        }
    }

    /// Rejects weights that are not finite; the reason is a phrase without its subject.
    pub(crate) fn check_weights(&self) -> Result<(), String> {
        match self.weights.iter().position(|w| !w.is_finite()) {
            Some(k) => Err(format!(
                "has a weight that is not finite at point {k} (0-based): {}",
                self.weights[k]
            )),
            None => Ok(()),
        }
    }

    /// Returns `(sum w)^2/sum w^2`, the number of equally weighted points with the same noise: N
    /// for equal weights, 0 if the weights sum to 0 within the rounding of each,
    /// `|sum w| <= EPSILON sum |w|`.
    ///
    /// The result does not depend on the scale of the weights, whatever their magnitude.
    #[must_use]
    pub fn n_effective(&self) -> f64 {
        if self.weights.is_empty() {
            return self.points.len() as f64;
        }
        let scale = weight_scale(&self.weights);
        let scaled = || self.weights.iter().map(|w| scale.apply(*w));
        let squares = compensated_sum(scaled().map(|w| w * w));
        let (sum, magnitude) = (compensated_sum(scaled()), compensated_sum(scaled().map(f64::abs)));
        if sum.abs() > f64::EPSILON * magnitude { sum.powi(2) / squares } else { 0.0 }
    }

    /// Returns `sum w` and `sum w^2`, with w = 1 for equal weights. They overflow or underflow for
    /// weights beyond about 1e154 or below 1e-154.
    #[must_use]
    pub fn weight_sums(&self) -> (f64, f64) {
        if self.weights.is_empty() {
            return (self.points.len() as f64, self.points.len() as f64);
        }
        let scale = weight_scale(&self.weights);
        let scaled = || self.weights.iter().map(|w| scale.apply(*w));
        let (sum, squares) = (compensated_sum(scaled()), compensated_sum(scaled().map(|w| w * w)));
        (scale.undo(sum), scale.undo(scale.undo(squares)))
    }

    /// Returns the weighted mean of one value for each point, `sum w v/sum w`.
    #[must_use]
    pub fn mean(&self, values: &[f64]) -> f64 {
        if self.weights.is_empty() {
            return values.iter().sum::<f64>() / values.len() as f64;
        }
        let scale = weight_scale(&self.weights);
        let pairs = || self.weights.iter().map(|w| scale.apply(*w)).zip(values);
        pairs().map(|(w, v)| w * v).sum::<f64>() / pairs().map(|(w, _)| w).sum::<f64>()
    }

    /// Scales the weights by a power of two so that the largest magnitude is in [1/2, 1). No result
    /// depends on their scale, and neither squares nor sums overflow or underflow.
    ///
    /// Exact except for weights at most 1e-300 times the largest.
    pub fn normalize_weights(&mut self) {
        let scale = weight_scale(&self.weights);
        self.weights.iter_mut().for_each(|w| *w = scale.apply(*w));
    }
}

impl<P: Point> PointSet<P> {
    /// Rejects invalid realizations: mismatched lengths, points off the unit sphere by more than
    /// 1e-9 or outside the unit square, and weights that are not finite or sum to 0; the reason is
    /// a phrase without its subject.
    pub(crate) fn check_realization(&self) -> Result<(), String> {
        self.check_points()?;
        let estimates = self.n_effective() > 0.0;
        if estimates { Ok(()) } else { Err("has weights whose sum is 0".to_owned()) }
    }

    /// Does the same checks except that of the sum of the weights, which spectra do not need.
    pub(crate) fn check_points(&self) -> Result<(), String> {
        self.check_lengths()?;
        // An early exit would prevent vectorization of the loop.
        if !self.points.iter().fold(true, |all, p| all & p.is_valid()) {
            let k = self.points.iter().position(|p| !p.is_valid()).unwrap_or(0);
            return Err(format!("has {} at point {k} (0-based): {:?}", P::INVALID, self.points[k]));
        }
        self.check_weights()
    }
}

/// A power of two, applied in steps that neither overflow nor underflow.
#[derive(Clone, Copy)]
struct Scale {
    step: f64,
    power: f64,
}

impl Scale {
    fn apply(self, w: f64) -> f64 {
        w * self.step / self.power * 0.5
    }

    fn undo(self, w: f64) -> f64 {
        w * 2.0 * self.power / self.step
    }
}

/// Returns the power of two that brings the largest magnitude to [1/2, 1), or 1 if there is none.
fn weight_scale(weights: &[f64]) -> Scale {
    let largest = weights.iter().fold(0.0, |max: f64, w| max.max(w.abs()));
    if !(largest > 0.0 && largest.is_finite()) {
        return Scale { step: 1.0, power: 0.5 };
    }
    // The power of two of a subnormal number is out of range, so scaling takes two steps.
    let (step, scaled) = if largest < f64::MIN_POSITIVE {
        (2f64.powi(100), largest * 2f64.powi(100))
    } else {
        (1.0, largest)
    };
    // The exponent field with a mantissa of 0: the power of two not above the number.
    Scale { step, power: f64::from_bits(scaled.to_bits() & (0x7ff << 52)) }
}

fn compensated_sum(terms: impl Iterator<Item = f64>) -> f64 {
    terms.collect::<CompensatedSum>().value()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::PointSet;

    fn weighted(weights: Vec<f64>) -> PointSet {
        PointSet { points: vec![DVec3::Z; weights.len()], weights }
    }

    #[test]
    fn weights_of_any_magnitude_are_brought_to_1() {
        let base = [1.0, -0.3, 0.75, 1e-3];
        for exponent in [-1074, -1060, -1022, -900, -533, -1, 0, 1, 600, 1023] {
            // 2^-1074 has no power of two of its own in range.
            let scale = 2f64.powi(exponent / 2) * 2f64.powi(exponent - exponent / 2);
            let mut set = weighted(base.map(|w| w * scale).to_vec());
            let before: Vec<f64> = set.weights.iter().map(|w| w / scale).collect();
            set.normalize_weights();
            for (w, b) in set.weights.iter().zip(before) {
                // Subnormal weights have lost digits before they are scaled.
                assert!((w - 0.5 * b).abs() <= f64::EPSILON * b.abs(), "2^{exponent}: {w}, {b}");
            }
        }
        for weights in [vec![], vec![0.0, -0.0]] {
            let mut set = weighted(weights.clone());
            set.normalize_weights();
            assert_eq!(set.weights, weights);
        }
    }

    #[test]
    fn means_and_effective_numbers_do_not_depend_on_the_scale() {
        for scale in [1.0, 1e-160, 1e154, 1e-320, 1e300] {
            let set = weighted(vec![scale, 2.0 * scale, -0.5 * scale]);
            // (1 + 2 - 1/2)^2/(1 + 4 + 1/4); 1e-320 has four digits.
            let tolerance = if scale < 1e-300 { 1e-3 } else { 1e-15 };
            assert!((set.n_effective() - 6.25 / 5.25).abs() < tolerance, "{scale}");
            // (3 + 10 - 1)/2.5.
            assert!((set.mean(&[3.0, 5.0, 2.0]) - 4.8).abs() < 10.0 * tolerance, "{scale}");
        }
        // A tenth cannot be represented; plain sums of a million of them are off by 1e-11.
        let tenths = weighted(vec![0.1; 1_000_000]);
        assert!((tenths.n_effective() - 1e6).abs() < 1e-9, "{}", tenths.n_effective());
        let (sum, squares) = tenths.weight_sums();
        assert!((sum - 1e5).abs() < 1e-10 && (squares - 1e4).abs() < 1e-11, "{sum}, {squares}");
        for zero in [vec![0.0; 3], vec![0.1, 0.2, -0.3], vec![0.1, 0.7, -0.8], vec![1e300, -1e300]]
        {
            assert!(weighted(zero.clone()).n_effective().abs() <= 0.0, "{zero:?}");
        }
        assert!(weighted(vec![1.0, -1.0 + 4.0 * f64::EPSILON]).n_effective() > 0.0);
        assert!(weighted(vec![]).mean(&[]).is_nan());
    }
}
