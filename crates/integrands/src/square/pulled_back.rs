//! Functions of direction as functions on the square, divided by the density of a map.

mod known;
mod strategy;
mod support;

use std::fmt;
use std::sync::Arc;

use glam::DVec3;
use sphvar_sh::{ByAxis, Frequencies};
use sphvar_warps::Warp;

use super::cells::{CellSpectrum, Cells, Variance};
use super::doubling::{SquareEstimate, values_into};
use super::energy::{check_values, zeros};
use crate::{Domain, Energy, Error, Integrand, SquareIntegrand, Tolerance};
use known::known;
use strategy::Ratio;
use support::UniformDirections;

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
/// use sphvar_integrands::{ClampedCosine, Domain, PulledBack, SquareIntegrand, Tolerance};
/// use sphvar_sh::TailClasses;
/// use sphvar_warps::{CosineHemisphere, UniformCap};
///
/// // Points of density cos(theta)/pi integrate the cosine without any error.
/// let (domain, tolerance) = (Domain::Hemisphere, Tolerance::default());
/// let constant = PulledBack::new(&ClampedCosine, domain, Arc::new(CosineHemisphere), tolerance)?;
/// assert!((constant.eval([0.3, 0.8]) - std::f64::consts::PI).abs() < 1e-14);
/// // Uniform ones have the variance of 2 pi u, which is pi^2/3.
/// let uniform = PulledBack::new(&ClampedCosine, domain, Arc::new(UniformCap::HEMISPHERE), tolerance)?;
/// let energy = uniform.energy(&sphvar_sh::Frequencies::new(8)?)?;
/// assert!((energy.centred().sum() - std::f64::consts::PI.powi(2) / 3.0).abs() < 1e-12);
/// # Ok::<(), sphvar_integrands::Error>(())
/// ```
#[derive(Clone)]
pub struct PulledBack<'a> {
    ratio: Ratio<'a>,
    exact: Option<f64>,
    estimate: Estimate,
    largest: LargestRatio,
}

#[derive(Clone)]
enum Estimate {
    /// A constant, with the variance of rounding.
    Constant {
        mean: f64,
        variance: f64,
    },
    /// Of a polynomial that equals the function to rounding.
    Resolved(Box<SquareEstimate>),
    Cells(Box<CellSpectrum>),
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
    /// The tolerance of predictions, which takes some 0.1 to 1 s. The misfit of the values is at most
    /// 1e-3 of the variance where a million values are enough for it.
    pub const TOLERANCE: Tolerance =
        Tolerance { relative: 1e-3, min_evaluations: 1 << 14, max_evaluations: 1 << 20 };

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
        let tolerance = tolerance.checked()?;
        let directions = UniformDirections::new(&ratio, tolerance.max_evaluations)?;
        Self::of_ratio(ratio, &directions, tolerance)
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
        let tolerance = tolerance.checked()?;
        // All have the same integrand and the same densities.
        let directions = UniformDirections::new(&ratios[0], tolerance.max_evaluations)?;
        let of_ratio = |ratio| Self::of_ratio(ratio, &directions, tolerance);
        ratios.into_iter().map(of_ratio).collect()
    }

    fn of_ratio(
        ratio: Ratio<'a>,
        directions: &UniformDirections,
        tolerance: Tolerance,
    ) -> Result<Self, Error> {
        let Tolerance { relative, min_evaluations, max_evaluations } = tolerance;
        let exact = exact_integral(&ratio);
        let grid = GridValues::new(&ratio)?;
        if let Some(variance) = grid.variance_of_constant(exact) {
            let estimate = Estimate::Constant { mean: grid.mean, variance };
            return Ok(Self { exact, largest: grid.largest(ratio.warp()), ratio, estimate });
        }
        let known = known(ratio.integrand, ratio.warp());
        let max_nodes = if known.features.is_empty() { MAX_NODES } else { 0 };
        let evaluations = [min_evaluations, max_evaluations];
        let (resolved, n) = SquareEstimate::of_polynomial(&ratio, max_nodes, evaluations)?;
        let (estimate, largest) = if let Some(resolved) = resolved {
            (Estimate::Resolved(Box::new(resolved)), grid.largest(ratio.warp()))
        } else {
            let max = max_evaluations.saturating_sub(n);
            let limits = (relative, max);
            let cells = Cells::new(&ratio, ratio.warp(), known, grid.mean, limits)?;
            let integral = cells.integral();
            let variance = known_variance(&ratio).map_or_else(
                || {
                    let (second, error) = directions.second_moment(&ratio);
                    Variance::Estimate(second - integral * integral, error)
                },
                Variance::Exact,
            );
            let spectrum = CellSpectrum::new(&cells, variance)?;
            let (largest, at, area) = spectrum.largest;
            let direction = ratio.warp().map(at);
            (Estimate::Cells(Box::new(spectrum)), LargestRatio { ratio: largest, direction, area })
        };
        let pulled_back = Self { ratio, exact, estimate, largest };
        pulled_back.check_integral()?;
        Ok(pulled_back)
    }

    /// Checks the integral of the values against the exact one.
    fn check_integral(&self) -> Result<(), Error> {
        let (Some(exact), (found, error)) = (self.exact, self.own_integral()) else {
            return Ok(());
        };
        let size = self.energy(&Frequencies::new(0)?)?.total().sqrt();
        let allowed = MAX_ERRORS * error + MISSED * size;
        if (found - exact).abs() <= allowed {
            return Ok(());
        }
        let reason = format!(
            "the values give the integral {found:.6e} instead of {exact:.6e}: features narrower than the \
             distance of the points are missed, or hardly any point reaches a part of the integral"
        );
        Err(Error::Evaluation { reason })
    }

    /// Returns the integral of the values and its error.
    fn own_integral(&self) -> (f64, f64) {
        match &self.estimate {
            Estimate::Constant { mean, .. } => (*mean, 0.0),
            Estimate::Resolved(estimate) => estimate.integral,
            Estimate::Cells(spectrum) => spectrum.integral,
        }
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

/// The largest number of nodes along a side of rules that are to resolve the function everywhere.
const MAX_NODES: usize = 128;
/// The errors by which the integral of the values may differ from the exact one, and the difference
/// relative to the root mean square that is never an error.
const MAX_ERRORS: f64 = 8.0;
const MISSED: f64 = 1e-2;

/// Returns the integral of the integrand of the only strategy, if it is known.
fn exact_integral(ratio: &Ratio<'_>) -> Option<f64> {
    let is_only = ratio.strategies().len() == 1;
    is_only.then(|| ratio.integrand.exact(ratio.domain)).flatten()
}

/// Returns the variance of the ratio for a uniform density, if that of the integrand is known.
fn known_variance(ratio: &Ratio<'_>) -> Option<f64> {
    let Ratio { integrand, domain, .. } = *ratio;
    let [Strategy { warp, .. }] = ratio.strategies() else { return None };
    let is_uniform = (warp.min_density() * domain.area() - 1.0).abs() < 1e-12;
    let centred = is_uniform.then(|| integrand.centred_square(domain).ok()).flatten()?.sum();
    // The even extension has twice the integral over the hemisphere.
    let copies = if domain == Domain::Sphere { 1.0 } else { 2.0 };
    Some(domain.area() * centred / copies)
}

/// The values on a grid.
struct GridValues {
    points: Vec<[f64; 2]>,
    values: Vec<f64>,
    mean: f64,
}

impl GridValues {
    /// The points along a side.
    const SIDE: u32 = 128;
    /// The largest relative deviation of values that are equal but for rounding: maps have relative
    /// errors of up to 1e-13 in single directions.
    const ROUNDING: f64 = 1e-12;

    fn new(ratio: &Ratio<'_>) -> Result<Self, Error> {
        // The fractions of a golden section do not follow texels.
        let place = |i: u32, offset: f64| (f64::from(i) + offset) / f64::from(Self::SIDE);
        let all = 0..Self::SIDE;
        let points: Vec<[f64; 2]> = all
            .clone()
            .flat_map(|i| all.clone().map(move |j| [place(i, 0.618), place(j, 0.382)]))
            .collect();
        let mut values = vec![0.0; points.len()];
        values_into(ratio, &points, &mut values)?;
        check_values(&values)?;
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        Ok(Self { points, values, mean })
    }

    /// Returns the variance of the values if they and the integral are equal to rounding.
    fn variance_of_constant(&self, exact: Option<f64>) -> Option<f64> {
        let limit = Self::ROUNDING * self.mean.abs();
        let is_close = |x: f64| (x - self.mean).abs() <= limit;
        let is_constant = exact.is_none_or(is_close) && self.values.iter().all(|x| is_close(*x));
        let squares = self.values.iter().map(|x| (x - self.mean).powi(2));
        is_constant.then(|| squares.sum::<f64>() / self.values.len() as f64)
    }

    fn largest(&self, warp: &dyn Warp) -> LargestRatio {
        let (mut largest, mut at) = (0.0, [0.5; 2]);
        for (point, value) in self.points.iter().zip(&self.values) {
            if value.abs() > largest {
                (largest, at) = (value.abs(), *point);
            }
        }
        let exceeding = self.values.iter().filter(|value| value.abs() > 0.5 * largest).count();
        let area = exceeding as f64 / self.values.len() as f64;
        LargestRatio { ratio: largest, direction: warp.map(at), area }
    }
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
        if self.exact.is_some() {
            return self.exact;
        }
        match &self.estimate {
            Estimate::Resolved(estimate) => estimate.is_exact().then_some(estimate.integral.0),
            Estimate::Constant { .. } | Estimate::Cells(_) => None,
        }
    }

    fn integral_estimate(&self) -> Option<(f64, f64)> {
        self.exact().map(|exact| (exact, 0.0)).or(Some(self.own_integral()))
    }

    fn energy(&self, frequencies: &Frequencies) -> Result<Energy<Frequencies>, Error> {
        match &self.estimate {
            Estimate::Constant { mean, variance } => {
                let energy = |off: f64| -> Result<Energy<Frequencies>, Error> {
                    let mut per_band = zeros(frequencies.len())?;
                    per_band[0] = mean * mean;
                    let centred = ByAxis { off, ..ByAxis::default() };
                    Ok(Energy::new(frequencies.clone(), per_band, centred))
                };
                // A constant has no variance; that of rounding is its error.
                Ok(energy(0.0)?.with_estimates(&[energy(*variance)?]))
            }
            Estimate::Resolved(estimate) => estimate.energy(frequencies),
            Estimate::Cells(spectrum) => spectrum.energy(frequencies),
        }
    }

    fn kurtosis(&self) -> Option<f64> {
        match &self.estimate {
            Estimate::Constant { .. } => None,
            Estimate::Resolved(estimate) => estimate.kurtosis,
            Estimate::Cells(spectrum) => spectrum.kurtosis,
        }
    }
}
