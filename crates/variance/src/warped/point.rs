use sphvar_sh::Frequencies;

use crate::{PredictedPoint, PredictedVariance, Prediction};

/// The predicted variance of a [`WarpedPattern`](crate::WarpedPattern) at one number of points.
#[derive(Clone, Debug, PartialEq)]
pub struct WarpedPoint {
    /// The predictions of the strategies, each with its own number of points and its spectrum on the
    /// square.
    pub strategies: Vec<PredictedPoint<Frequencies>>,
    /// Their sum, since their points are independent.
    pub prediction: Prediction,
}

impl WarpedPoint {
    pub(super) fn new(strategies: Vec<PredictedPoint<Frequencies>>) -> Self {
        let predictions: Vec<Prediction> =
            strategies.iter().map(|point| point.prediction).collect();
        Self { prediction: sum(&predictions), strategies }
    }

    /// Returns the number of points of all strategies.
    #[must_use]
    pub fn n_points(&self) -> usize {
        self.strategies.iter().map(PredictedPoint::n_points).sum()
    }
}

impl PredictedVariance for WarpedPoint {
    fn n_points(&self) -> usize {
        self.n_points()
    }

    fn prediction(&self) -> &Prediction {
        &self.prediction
    }
}

/// Returns the sum of variances. Errors of spectra are independent, as their realizations are. Those
/// of energies and tails, which follow from the same function, are added.
fn sum(predictions: &[Prediction]) -> Prediction {
    if let [single] = predictions {
        return *single;
    }
    let total = |part: fn(&Prediction) -> f64| predictions.iter().map(part).sum::<f64>();
    let energy_stderr = total(|p| p.energy_stderr);
    let of_spectra = total(|p| (p.stderr.powi(2) - p.energy_stderr.powi(2)).max(0.0));
    let stderr = of_spectra.sqrt().hypot(energy_stderr);
    // Welch 1947: the variance of each squared error is 2 s^4/dof.
    let spread = total(|p| if p.stderr > 0.0 { p.stderr.powi(4) / p.dof } else { 0.0 });
    Prediction {
        variance: total(|p| p.variance),
        stderr: if predictions.iter().any(|p| p.stderr.is_nan()) { f64::NAN } else { stderr },
        energy_stderr,
        tail: total(|p| p.tail),
        tail_error: total(|p| p.tail_error),
        dof: if spread > 0.0 { stderr.powi(4) / spread } else { f64::INFINITY },
    }
}
