//! Functions of direction as functions on the square, divided by the density of a map.

mod strategy;

use std::fmt;
use std::sync::Arc;

use glam::DVec3;
use sphvar_sh::Frequencies;
use sphvar_warps::Warp;

use super::doubling::SquareEstimate;
use crate::{Domain, Energy, Error, Integrand, SquareIntegrand, Tolerance};
use strategy::Ratio;

pub use strategy::{Heuristic, Strategy};

/// A function of direction divided by a density, as a function on the square:
///
/// ```text
/// G(u) = w(T(u)) f(T(u))/p(T(u)),   int f d omega = int_square G du   for w = 1
/// ```
///
/// T is a [`Warp`] of density p; w is 1 for one strategy, otherwise the [`Heuristic`] weight. An
/// integral by importance sampling is one of G by uniform points of the square, so the energies of
/// G predict its variance with any pattern of the square. On [`Domain::Hemisphere`] f counts as 0
/// for z < 0.
///
/// # Examples
///
/// ```
/// use std::sync::Arc;
///
/// use sphvar_integrands::{Cosine, Domain, PulledBack, SquareIntegrand, Tolerance};
/// use sphvar_warps::{CosineHemisphere, UniformCap};
///
/// // Points of density cos(theta)/pi integrate the cosine without any error.
/// let (domain, tolerance) = (Domain::Hemisphere, Tolerance::default());
/// let constant = PulledBack::new(&Cosine, domain, Arc::new(CosineHemisphere), tolerance)?;
/// assert!((constant.eval([0.3, 0.8]) - std::f64::consts::PI).abs() < 1e-14);
/// // Uniform ones have the variance of 2 pi u, which is pi^2/3.
/// let uniform = PulledBack::new(&Cosine, domain, Arc::new(UniformCap::HEMISPHERE), tolerance)?;
/// let energy = uniform.energy(&sphvar_sh::Frequencies::new(8)?)?;
/// assert!((energy.centred().sum() - std::f64::consts::PI.powi(2) / 3.0).abs() < 1e-12);
/// # Ok::<(), sphvar_integrands::Error>(())
/// ```
#[derive(Clone)]
pub struct PulledBack<'a> {
    ratio: Ratio<'a>,
    estimate: SquareEstimate,
    largest: LargestRatio,
}

/// The largest known ratio `|w f/p|` of an integrand and a density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LargestRatio {
    /// The ratio.
    pub ratio: f64,
    /// Its direction.
    pub direction: DVec3,
    /// The area of the square in which the ratio exceeds half of it.
    pub area: f64,
}

impl fmt::Debug for PulledBack<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PulledBack").field("warp", &self.warp()).finish_non_exhaustive()
    }
}

impl<'a> PulledBack<'a> {
    /// Returns the integrand pulled back by a map of directions.
    ///
    /// # Errors
    ///
    /// Those of [`of_strategies`](Self::of_strategies).
    pub fn new(
        integrand: &'a dyn Integrand,
        domain: Domain,
        warp: Arc<dyn Warp>,
        tolerance: Tolerance,
    ) -> Result<Self, Error> {
        let ratio = Ratio::of_one(integrand, domain, warp)?;
        Self::of_ratio(ratio, tolerance)
    }

    /// Returns the weighted integrand of every strategy; their integrals sum to that of f.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] without strategies, for shares that are not positive and finite, and for
    /// a tolerance out of range; [`Error::ZeroDensity`] if all densities are 0 where f is not;
    /// [`Error::Evaluation`] with the point where f/p is NaN or infinite; [`Error::Magnitude`] for
    /// values whose squares overflow or underflow; and those of [`Integrand::eval_into`].
    pub fn of_strategies(
        integrand: &'a dyn Integrand,
        domain: Domain,
        strategies: &[Strategy],
        heuristic: Heuristic,
        tolerance: Tolerance,
    ) -> Result<Vec<Self>, Error> {
        let ratios = Ratio::of_all(integrand, domain, strategies, heuristic)?;
        ratios.into_iter().map(|ratio| Self::of_ratio(ratio, tolerance)).collect()
    }

    fn of_ratio(ratio: Ratio<'a>, tolerance: Tolerance) -> Result<Self, Error> {
        let Tolerance { relative, min_evaluations, max_evaluations } = tolerance.checked()?;
        let estimate = SquareEstimate::new(&ratio, relative, [min_evaluations, max_evaluations])?;
        let largest = largest_on_grid(&ratio)?;
        Ok(Self { ratio, estimate, largest })
    }

    /// Returns the largest `|G|` that is known.
    #[must_use]
    pub fn largest_ratio(&self) -> LargestRatio {
        self.largest
    }

    /// Returns the map from the square to directions.
    #[must_use]
    pub fn warp(&self) -> &dyn Warp {
        self.ratio.warp()
    }
}

/// Returns the largest value on a grid of 128 x 128 points.
fn largest_on_grid(ratio: &Ratio<'_>) -> Result<LargestRatio, Error> {
    let n = 128;
    let place = |i: i32| (f64::from(i) + 0.5) / f64::from(n);
    let points: Vec<[f64; 2]> = (0..n * n).map(|k| [place(k % n), place(k / n)]).collect();
    let mut values = vec![0.0; points.len()];
    ratio.eval_into(&points, &mut values)?;
    let (mut largest, mut at) = (0.0, [0.5; 2]);
    for (point, value) in points.iter().zip(&values) {
        if value.abs() > largest {
            (largest, at) = (value.abs(), *point);
        }
    }
    let exceeding = values.iter().filter(|value| value.abs() > 0.5 * largest).count();
    let area = exceeding as f64 / values.len() as f64;
    Ok(LargestRatio { ratio: largest, direction: ratio.warp().map(at), area })
}

impl SquareIntegrand for PulledBack<'_> {
    fn eval(&self, point: [f64; 2]) -> f64 {
        self.ratio.eval(point)
    }

    fn eval_into(&self, points: &[[f64; 2]], values: &mut [f64]) -> Result<(), Error> {
        self.ratio.eval_into(points, values)
    }

    /// Returns the integral of f for one strategy.
    fn exact(&self) -> Option<f64> {
        let Ratio { integrand, domain, .. } = self.ratio;
        if self.ratio.strategies().len() == 1
            && let Some(exact) = integrand.exact(domain)
        {
            return Some(exact);
        }
        self.estimate.is_exact().then_some(self.estimate.integral.0)
    }

    fn integral_estimate(&self) -> Option<(f64, f64)> {
        self.exact().map(|exact| (exact, 0.0)).or(Some(self.estimate.integral))
    }

    fn energy(&self, frequencies: &Frequencies) -> Result<Energy<Frequencies>, Error> {
        self.estimate.energy(frequencies)
    }

    fn kurtosis(&self) -> Option<f64> {
        self.estimate.kurtosis
    }
}
