use glam::DVec3;
use sphvar_integrands::VectorIntegrand;
use sphvar_samplers::{PointSet, Progress};
use sphvar_sh::CompensatedSum;

use crate::Error;
use crate::estimates::evaluation_work;

/// The number of directions that are evaluated between two ticks of the progress.
const BATCH: usize = 4096;

/// Sums over the values v of one component at the points of one copy. All are relative to a scale,
/// so that neither sums nor squares overflow or underflow.
#[derive(Clone, Copy, Debug)]
pub(super) struct CopySums {
    /// The smallest and the largest v.
    pub(super) range: Range,
    /// `sum w v/sum w`, relative to the largest `|v|`.
    pub(super) mean: f64,
    /// `sum |w v|/|sum w|`, relative to the largest `|v|`.
    pub(super) mean_magnitude: f64,
    /// The largest difference of a value from their mean.
    pub(super) max_deviation: f64,
    /// The sum of the squares of these differences, relative to that of the largest.
    pub(super) squares: f64,
    /// The sum of their fourth powers, relative to that of the largest.
    pub(super) fourths: f64,
}

/// The range of the values of a component.
#[derive(Clone, Copy, Debug)]
pub(super) struct Range {
    min: f64,
    max: f64,
}

impl Range {
    /// The range of no values.
    pub(super) const EMPTY: Self = Self { min: f64::INFINITY, max: f64::NEG_INFINITY };

    fn of(values: impl Iterator<Item = f64>) -> Self {
        values.fold(Self::EMPTY, |range, v| range.union(Self { min: v, max: v }))
    }

    pub(super) fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Returns the largest magnitude, 0 without values.
    pub(super) fn largest(self) -> f64 {
        self.max.max(-self.min).max(0.0)
    }

    /// Returns half the difference of the largest and the smallest value, 0 without values. All of
    /// it may exceed the range of numbers.
    pub(super) fn half_width(self) -> f64 {
        (self.max / 2.0 - self.min / 2.0).max(0.0)
    }
}

/// Returns the sums of each component over one copy. Ticks [`evaluation_work`] for each component.
pub(super) fn copy_sums(
    f: &dyn VectorIntegrand,
    set: &PointSet,
    values: &mut Vec<f64>,
    progress: &dyn Progress,
) -> Result<Vec<CopySums>, Error> {
    let components = f.components();
    values.clear();
    values.resize(set.len() * components, 0.0);
    for (dirs, values) in set.points.chunks(BATCH).zip(values.chunks_mut(BATCH * components)) {
        f.eval_into(dirs, values)?;
        if let Some(k) = values.iter().position(|v| !v.is_finite()) {
            return Err(invalid(dirs[k / components], k % components, components, values[k]));
        }
        progress.tick(evaluation_work(values.len()))?;
    }
    Ok((0..components)
        .map(|c| sums(values.iter().skip(c).step_by(components).copied(), &set.weights))
        .collect())
}

fn invalid(dir: DVec3, component: usize, components: usize, value: f64) -> Error {
    let of = if components == 1 {
        String::new()
    } else {
        format!(" of component {component} (0-based)")
    };
    let [x, y, z] = dir.to_array();
    let reason = format!("its value{of} at the direction ({x}, {y}, {z}) is {value}");
    sphvar_integrands::Error::Evaluation { reason }.into()
}

/// Returns the sums of values with weights, which are empty if all are equal.
fn sums(values: impl Iterator<Item = f64> + Clone, weights: &[f64]) -> CopySums {
    let range = Range::of(values.clone());
    let largest = range.largest();
    if largest <= 0.0 {
        let (mean, mean_magnitude) = (0.0, 0.0);
        let (max_deviation, squares, fourths) = (0.0, 0.0, 0.0);
        return CopySums { range, mean, mean_magnitude, max_deviation, squares, fourths };
    }
    let heaviest = weights.iter().fold(0.0, |max: f64, w| max.max(w.abs()));
    // Weights of equal points are 1.
    let weight = |k: usize| weights.get(k).map_or(1.0, |w| w / heaviest);
    let (mut sum, mut magnitude, mut total) = <(CompensatedSum, f64, CompensatedSum)>::default();
    let mut count = 0.0;
    let mut plain = CompensatedSum::default();
    for (k, value) in values.clone().enumerate() {
        let (v, w) = (value / largest, weight(k));
        sum.add(w * v);
        magnitude += (w * v).abs();
        total.add(w);
        plain.add(v);
        count += 1.0;
    }
    let centre = plain.value() / count;
    let max_deviation =
        values.clone().fold(0.0, |max: f64, v| max.max((v / largest - centre).abs()));
    let (mut squares, mut fourths) = (0.0, 0.0);
    if max_deviation > 0.0 {
        for value in values {
            let square = ((value / largest - centre) / max_deviation).powi(2);
            squares += square;
            fourths += square * square;
        }
    }
    let total = total.value();
    CopySums {
        range,
        mean: sum.value() / total,
        mean_magnitude: magnitude / total.abs(),
        max_deviation: max_deviation * largest,
        squares,
        fourths,
    }
}
