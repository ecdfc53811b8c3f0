use sphvar_sh::Alm;

use super::covariance::Covariance;
use super::inverse::Inverse;
use super::traces::{FIRST_TOLERANCE, Signs, Traces};
use crate::normal_equations::{SolveError, Watch};

/// The largest number of harmonics for which the covariance is exact, those up to degree 30. It takes
/// 0.4 s; random vectors take 0.1 to 1 s, depending on the condition number.
const MAX_EXACT: usize = 961;

/// The noise of the coefficients.
pub(super) enum Noise {
    Exact(Covariance),
    Estimated(Traces),
}

/// The energy of the noise of a degree.
#[derive(Clone, Copy)]
pub(super) struct NoiseEnergy {
    pub(super) mean: f64,
    /// The standard error of the energy from which the mean is subtracted.
    pub(super) stderr: f64,
}

impl Noise {
    /// Returns the noise, or `None` if a system was not solved. `inverse` then knows the extreme
    /// eigenvalues.
    pub(super) fn of(
        inverse: &mut Inverse<'_>,
        n_harmonics: usize,
        watch: Watch<'_>,
    ) -> Result<Option<Self>, SolveError> {
        if n_harmonics > MAX_EXACT {
            return Ok(Traces::estimate(inverse, n_harmonics, Signs::default(), watch)?
                .map(Self::Estimated));
        }
        // The right-hand side has components in all directions.
        let z = Signs::default().coefficients(inverse)?;
        if inverse.solve(&z, FIRST_TOLERANCE, watch)?.residual > FIRST_TOLERANCE {
            return Ok(None);
        }
        Ok(Covariance::of(inverse, watch)?.map(Self::Exact))
    }

    /// Returns `tr M^-2`.
    pub(super) fn square_trace(&self) -> f64 {
        match self {
            Self::Exact(covariance) => covariance.square_trace,
            Self::Estimated(traces) => traces.square_trace(),
        }
    }

    /// Returns the energy of the noise of degree `l` in fitted coefficients, for noise of this
    /// variance, which is known from a number of degrees of freedom.
    pub(super) fn energy(
        &self,
        l: usize,
        variance: f64,
        freedom: f64,
        fitted: &Alm,
    ) -> NoiseEnergy {
        match self {
            Self::Exact(covariance) => covariance.noise(l, variance, freedom, fitted),
            Self::Estimated(traces) => traces.noise(l, variance, freedom, fitted),
        }
    }
}
