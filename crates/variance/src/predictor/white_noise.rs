//! White noise needs no spectrum: its variance is known in closed form.

use sphvar_sh::Bands;

use super::PredictorOn;
use crate::space::IntegrationSpace;

/// A generous bound of the relative rounding errors of predicted and requested variances: if both are
/// equal by their formulas, either may be computed as the larger one.
pub(crate) const ROUNDING: f64 = 1e-12;

impl<S: IntegrationSpace> PredictorOn<'_, S> {
    /// Returns the exact variance with white noise of `n_points`: `k sum_{l >= 1} E(l)`.
    #[must_use]
    pub fn white_variance(&self, n_points: usize) -> f64 {
        self.outline.bands().factor(n_points) * self.outline.beyond(0)
    }

    /// Returns the number of points with which white noise has the requested variance or less, in closed
    /// form; infinite or NaN where no finite number has.
    ///
    /// As in [`required_points`](crate::required_points), a variance that exceeds the requested one by rounding
    /// suffices.
    #[must_use]
    pub fn white_points(&self, variance: f64) -> f64 {
        (self.white_variance(1) / (variance * (1.0 + ROUNDING))).ceil().max(1.0)
    }
}
