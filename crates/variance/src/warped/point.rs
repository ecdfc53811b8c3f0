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
pub(crate) fn sum(predictions: &[Prediction]) -> Prediction {
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

#[cfg(test)]
mod tests {
    use super::sum;
    use crate::Prediction;

    /// Equal independent errors add in squares and have twice the degrees of freedom; those of
    /// energies and tails add. One prediction stays bit-identical.
    #[test]
    fn errors_of_sums_are_those_of_independent_spectra() {
        let one = Prediction {
            variance: 2.0,
            stderr: 0.3,
            energy_stderr: 0.0,
            tail: 0.5,
            tail_error: 0.1,
            dof: 10.0,
        };
        let two = sum(&[one, one]);
        assert!((two.stderr / (0.3 * 2f64.sqrt()) - 1.0).abs() < 1e-14, "{two:?}");
        assert!((two.dof - 20.0).abs() < 1e-12 && (two.variance - 4.0).abs() < 1e-15, "{two:?}");
        assert!((two.tail_error - 0.2).abs() < 1e-15 && (two.tail - 1.0).abs() < 1e-15, "{two:?}");
        let energies = Prediction { stderr: 0.3, energy_stderr: 0.3, dof: f64::INFINITY, ..one };
        let two = sum(&[energies, energies]);
        assert!((two.stderr - 0.6).abs() < 1e-15 && two.dof.is_infinite(), "{two:?}");
        let exact = Prediction { stderr: 0.0, energy_stderr: 0.0, ..energies };
        assert!((sum(&[exact, one]).dof - 10.0).abs() < 1e-12);
        assert!(sum(&[exact, exact]).dof.is_infinite());
        let unknown = Prediction { stderr: f64::NAN, ..one };
        assert!(sum(&[unknown, one]).stderr.is_nan());
        assert_eq!(sum(&[one]), one);
    }
}
