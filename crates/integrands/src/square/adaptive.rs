use std::fmt;

use sphvar_sh::Frequencies;

use super::doubling::SquareEstimate;
use crate::{Energy, Error, SquareIntegrand, Tolerance};

/// A function on the square of which nothing but values is known, with energies from growing numbers
/// of values; the error that remains is part of every prediction.
///
/// - A smooth function, periodic or not, is resolved to rounding by product rules of 16, 32, ... 256
///   Gauss-Legendre nodes along a side: it then equals a polynomial, whose integral and energies of
///   any frequency are exact.
/// - For other functions, grids of 24, 34, 48, ... points along a side follow, until the sum of the
///   errors of all energies is within the [`Tolerance`] or the next grid would exceed its number of
///   values. [`energy`](SquareIntegrand::energy) then ends at the frequency of some eighth of
///   the points along a side, and has errors: results of a grid are compared with those of the three
///   before, and the largest difference is the error, also of every sum of energies.
/// - A feature that no point hits is missed, without a sign of it: of a width below about
///   2/sqrt([`Tolerance::min_evaluations`]).
///
/// # Examples
///
/// ```
/// use sphvar_integrands::{AdaptiveSquareFunction, SquareIntegrand, Tolerance};
/// use sphvar_sh::Frequencies;
///
/// let smooth = |[u, v]: [f64; 2]| (u + 2.0 * u * v).exp();
/// let f = AdaptiveSquareFunction::new(smooth, Tolerance::default())?;
/// assert!(f.relative_error() < 1e-12 && f.exact().is_some());
///
/// // Jumps, of which 200 000 values are not enough for more than some digits.
/// let jump = |[u, v]: [f64; 2]| f64::from(u * v > 0.3);
/// let tolerance = Tolerance { max_evaluations: 200_000, ..Tolerance::default() };
/// let f = AdaptiveSquareFunction::new(jump, tolerance)?;
/// let energy = f.energy(&Frequencies::new(30)?)?;
/// let (total, error) = (energy.total(), energy.centred_stderr());
/// assert!(error.off > 1e-6 * total && error.off < 1e-2 * total);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct AdaptiveSquareFunction<F> {
    function: F,
    estimate: SquareEstimate,
}

impl<F> fmt::Debug for AdaptiveSquareFunction<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("AdaptiveSquareFunction")
            .field("n_evaluations", &self.estimate.n_evaluations)
            .field("relative_error", &self.estimate.relative_error)
            .finish_non_exhaustive()
    }
}

impl<F: SquareIntegrand> AdaptiveSquareFunction<F> {
    /// Returns the function with its energies; a closure `Fn([f64; 2]) -> f64` is a
    /// [`SquareIntegrand`].
    ///
    /// A tolerance that is not reached is not an error, see
    /// [`relative_error`](Self::relative_error).
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] for a tolerance out of range, [`Error::Evaluation`] with the point for a
    /// value that is NaN or infinite or whose evaluation panics, [`Error::Magnitude`] for values
    /// whose squares overflow or underflow, and those of [`SquareIntegrand::eval_into`].
    pub fn new(function: F, tolerance: Tolerance) -> Result<Self, Error> {
        let Tolerance { relative, min_evaluations, max_evaluations } = tolerance.checked()?;
        let evaluations = [min_evaluations, max_evaluations];
        let estimate = SquareEstimate::new(&function, relative, evaluations)?;
        Ok(Self { function, estimate })
    }

    /// Returns the error of the energies, summed over all known bands and totals and relative to
    /// their total without the mean; 0 within rounding.
    ///
    /// Values far from 0 beside their deviations are rounded by more than 1e-10 of these: that is
    /// part of the error, also of the energies and of the integral.
    #[must_use]
    pub fn relative_error(&self) -> f64 {
        self.estimate.relative_error
    }

    /// Returns the number of values taken.
    #[must_use]
    pub fn n_evaluations(&self) -> usize {
        self.estimate.n_evaluations
    }
}

impl<F: SquareIntegrand> SquareIntegrand for AdaptiveSquareFunction<F> {
    fn eval(&self, point: [f64; 2]) -> f64 {
        self.function.eval(point)
    }

    fn eval_into(&self, points: &[[f64; 2]], values: &mut [f64]) -> Result<(), Error> {
        self.function.eval_into(points, values)
    }

    /// Returns the integral if the function is resolved.
    fn exact(&self) -> Option<f64> {
        self.function
            .exact()
            .or_else(|| self.estimate.is_exact().then_some(self.estimate.integral.0))
    }

    fn integral_estimate(&self) -> Option<(f64, f64)> {
        self.exact().map(|exact| (exact, 0.0)).or(Some(self.estimate.integral))
    }

    fn energy(&self, frequencies: &Frequencies) -> Result<Energy<Frequencies>, Error> {
        self.estimate.energy(frequencies)
    }

    fn feature_size(&self) -> Option<f64> {
        self.function.feature_size()
    }

    /// Returns the estimate of the last rule.
    fn kurtosis(&self) -> Option<f64> {
        self.estimate.kurtosis
    }

    fn variation(&self) -> Option<f64> {
        self.function.variation()
    }
}
