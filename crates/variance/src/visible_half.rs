use std::f64::consts::PI;
use std::ops::Range;

use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use sphvar_samplers::{
    Domain, PointSet, Progress, Realizations, Streams, rotate, uniform_rotation,
};

use crate::estimates::evaluation_work;
use crate::{Error, Measurement};
use sphvar_integrands::Integrand;

/// The orientation of the cut relative to the integrand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CutAxis {
    /// At the equator, as in a renderer that keeps the visible half.
    Equator,
    /// Rotated randomly, by rotations from these streams. This requires an antipodal integrand,
    /// to which all halves are equivalent, and is comparable with an antipodal (projective) pattern,
    /// which has no preferred half.
    Random(Streams),
}

/// Estimates of an integral over the hemisphere from the visible half of sphere sets.
///
/// A set has M points on the sphere, n of them in the visible half. n is random, and the pattern is
/// not adapted to the cut.
#[derive(Clone, Debug, PartialEq)]
pub struct VisibleHalfMeasurement {
    /// `(4 pi/M) sum f`: unbiased, with the variance of f set to 0 beyond the cut.
    pub unbiased: Measurement,
    /// `(2 pi/n) sum f`: a ratio estimate with a bias of order 1/M. It is 0 for n = 0, which occurs
    /// for small M.
    pub ratio: Measurement,
    /// The numbers n.
    pub n_visible: Measurement,
}

/// Returns estimates of the integral of `integrand` over the hemisphere from the visible half of
/// `trials` realizations of an ensemble on the sphere. Ticks [`trial_work`](crate::trial_work) for
/// each trial.
///
/// # Errors
///
/// Returns the errors of [`measure`](crate::measure).
///
/// # Panics
///
/// Panics if the ensemble is not on the sphere.
pub fn measure_visible_half(
    ensemble: &Realizations<'_>,
    integrand: &dyn Integrand,
    axis: CutAxis,
    trials: u64,
    progress: &dyn Progress,
) -> Result<VisibleHalfMeasurement, Error> {
    let estimates = visible_half_estimates(ensemble, integrand, axis, 0..trials, progress)?;
    Ok(VisibleHalfMeasurement::new(&estimates))
}

impl VisibleHalfMeasurement {
    /// Returns the measurement from the numbers of each trial: the unbiased and the ratio estimate,
    /// and n.
    #[must_use]
    pub fn new(rows: &[[f64; 3]]) -> Self {
        let column = |i: usize| Measurement::new(rows.iter().map(|row| row[i]).collect());
        Self { unbiased: column(0), ratio: column(1), n_visible: column(2) }
    }
}

/// Returns the numbers of the given trials of [`measure_visible_half`], in their order: the unbiased
/// and the ratio estimate, and n.
///
/// # Errors
///
/// Returns the errors of [`measure_visible_half`].
///
/// # Panics
///
/// Panics if the ensemble is not on the sphere.
pub fn visible_half_estimates(
    ensemble: &Realizations<'_>,
    integrand: &dyn Integrand,
    axis: CutAxis,
    trials: Range<u64>,
    progress: &dyn Progress,
) -> Result<Vec<[f64; 3]>, Error> {
    assert_eq!(ensemble.sampler().domain(), Domain::Sphere, "the ensemble must be on the sphere");
    let trial = |set: &mut PointSet, index| {
        ensemble.realize_into(index, set, progress).map_err(sphvar_spectrum::Error::from)?;
        set.normalize_weights();
        let whole = weight_sum(set);
        keep_upper_half(set);
        if let CutAxis::Random(streams) = axis {
            let rotation = uniform_rotation(&mut streams.realization(index));
            rotate(rotation, Domain::Hemisphere, &mut set.points);
        }
        let kept = weight_sum(set);
        let mut values = vec![0.0; set.len()];
        integrand.eval_into(&set.points, &mut values)?;
        let sum: f64 = if set.weights.is_empty() {
            values.iter().sum()
        } else {
            set.weights.iter().zip(&values).map(|(w, v)| w * v).sum()
        };
        progress.tick(evaluation_work(set.len()))?;
        let ratio = if set.is_empty() { 0.0 } else { 2.0 * PI / kept * sum };
        Ok([4.0 * PI / whole * sum, ratio, set.len() as f64])
    };
    // Collected in the order of the trials, so the result does not depend on threads.
    trials.into_par_iter().map_init(PointSet::default, trial).collect()
}

/// Returns the sum of the weights of a set, which are 1 each if the set has none.
fn weight_sum(set: &PointSet) -> f64 {
    if set.weights.is_empty() { set.len() as f64 } else { set.weights.iter().sum() }
}

/// Removes the points at z <= 0 with their weights.
fn keep_upper_half(set: &mut PointSet) {
    let mut above = set.points.iter().map(|p| p.z > 0.0);
    set.weights.retain(|_| above.next().unwrap_or(false));
    set.points.retain(|p| p.z > 0.0);
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use sphvar_samplers::{Domain, Pattern, Purpose, Realizations, Streams};

    use super::{CutAxis, measure_visible_half};

    /// Half of the sets of one point are empty: the constant 1 then has the estimate 0, otherwise 4
    /// pi or 2 pi.
    #[test]
    fn an_empty_half_gives_0() {
        let sampler = Pattern::WhiteNoise.build(1, Domain::Sphere).unwrap();
        let sets = Realizations::rotated(&*sampler, Streams::new(0, Purpose::Trial, 1));
        for axis in [CutAxis::Equator, CutAxis::Random(Streams::new(1, Purpose::Trial, 1))] {
            let got = measure_visible_half(&sets, &|_| 1.0, axis, 200, &()).unwrap();
            for i in 0..200 {
                let [a, b, n] =
                    [&got.unbiased, &got.ratio, &got.n_visible].map(|m| m.estimates()[i]);
                assert!((a - 4.0 * PI * n).abs() < 1e-14 && (b - 2.0 * PI * n).abs() < 1e-14);
            }
            // Binomial with 1/2: six standard errors of 0.035.
            assert!((got.n_visible.mean() - 0.5).abs() < 0.21, "{}", got.n_visible.mean());
        }
    }
}
