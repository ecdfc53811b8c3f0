//! The integrand at directions that do not follow its density.

use std::f64::consts::TAU;

use glam::DVec3;
use sphvar_warps::{Support, Warp, WarpSample, archimedes};

use super::PulledBack;
use super::strategy::{Heuristic, Ratio, Strategy};
use crate::quadrature::finite_values;
use crate::{Domain, Error, Integrand};

/// The numbers of directions at which densities are examined.
const DIRECTIONS: [usize; 2] = [1 << 13, 1 << 17];
/// The values on the square for each direction.
const VALUES_PER_DIRECTION: usize = 8;

impl PulledBack<'_> {
    /// The density relative to the uniform one below which no point of 53 bits reaches a direction.
    pub const UNREACHED: f64 = 1e-16;
    /// The share of an integral that may be lost where no point is, as by rounding.
    pub const NEGLIGIBLE: f64 = 1e-12;

    /// Checks that some density is positive where the function is not 0, at 131072 directions.
    ///
    /// # Errors
    ///
    /// [`Error::ZeroDensity`] with the direction of the largest value that is lost and the lost share
    /// of the integral; [`Error::Parameter`] for the strategies, and [`Error::Evaluation`] for the
    /// values, as [`of_strategies`](Self::of_strategies).
    pub fn check_support(
        integrand: &dyn Integrand,
        domain: Domain,
        strategies: &[Strategy],
    ) -> Result<(), Error> {
        let ratios = Ratio::of_all(integrand, domain, strategies, Heuristic::default())?;
        // All strategies together support the integral, so one ratio suffices.
        let Some(ratio) = ratios.first() else { return Ok(()) };
        UniformDirections::new(ratio, usize::MAX).map(drop)
    }
}

/// The function and the density at directions that are uniform on the domain, which shows what
/// samples of the density seldom reach.
pub(super) struct UniformDirections {
    dirs: Vec<DVec3>,
    values: Vec<f64>,
}

impl UniformDirections {
    /// Evaluates the function at directions whose number is proportional to that of the values on the
    /// square, and checks that some density is positive where it is not 0.
    ///
    /// # Errors
    ///
    /// [`Error::ZeroDensity`] with the direction of the largest value that is lost, and those of
    /// [`Integrand::eval_into`](crate::Integrand::eval_into).
    pub(super) fn new(ratio: &Ratio<'_>, max_evaluations: usize) -> Result<Self, Error> {
        let [min, max] = DIRECTIONS;
        let n = (max_evaluations / VALUES_PER_DIRECTION).clamp(min, max);
        // Points of the plastic lattice (Roberts 2018).
        let height = ratio.domain.area() / TAU;
        let place = |i: usize, step: f64| (0.5 + i as f64 * step).fract();
        let dirs: Vec<DVec3> = (0..n)
            .map(|i| {
                let (u, v) = (place(i, 0.754_877_666_246_692_8), place(i, 0.569_840_290_998_053_2));
                archimedes(height * u, TAU * v)
            })
            .collect();
        let mut values = vec![0.0; dirs.len()];
        let eval_into = |dirs: &[DVec3], values: &mut [f64]| ratio.function_into(dirs, values);
        finite_values(&dirs, &mut values, eval_into, |dir| format!("direction {dir}"))?;
        let directions = Self { dirs, values };
        directions.check_support(ratio)?;
        Ok(directions)
    }

    fn check_support(&self, ratio: &Ratio<'_>) -> Result<(), Error> {
        if ratio.strategies().iter().any(|s| is_positive(&*s.warp, ratio.domain)) {
            return Ok(());
        }
        let (mut lost, mut total, mut largest) = (0.0, 0.0, (0.0, DVec3::Z));
        for (dir, value) in self.dirs.iter().zip(&self.values) {
            let size = value.abs();
            total += size;
            if size > 0.0 && ratio.max_density(*dir) * ratio.domain.area() <= PulledBack::UNREACHED
            {
                lost += size;
                if size > largest.0 {
                    largest = (size, *dir);
                }
            }
        }
        if lost <= PulledBack::NEGLIGIBLE * total {
            return Ok(());
        }
        let dir = largest.1;
        Err(Error::ZeroDensity {
            theta: dir.x.hypot(dir.y).atan2(dir.z).to_degrees(),
            phi: dir.y.atan2(dir.x).to_degrees().rem_euclid(360.0),
            share: lost / total,
        })
    }

    /// Returns an estimate of `int G^2 du = int G^2 p d omega` with its standard error.
    pub(super) fn second_moment(&self, ratio: &Ratio<'_>) -> (f64, f64) {
        let (mut sum, mut squares) = (0.0, 0.0);
        for (dir, value) in self.dirs.iter().zip(&self.values) {
            let density = ratio.warp().density(*dir);
            if density > 0.0 {
                let sample = WarpSample { point: *dir, density };
                let term = ratio.weighted(*value, sample).powi(2) * density;
                sum += term;
                squares += term * term;
            }
        }
        let n = self.dirs.len() as f64;
        let mean = sum / n;
        let variance = (squares / n - mean * mean).max(0.0) / n;
        (ratio.domain.area() * mean, ratio.domain.area() * variance.sqrt())
    }
}

/// Returns whether a density is positive on the domain.
fn is_positive(warp: &dyn Warp, domain: Domain) -> bool {
    let is_complete = match warp.support() {
        Support::Sphere => true,
        Support::UpperHemisphere => domain == Domain::Hemisphere,
        _ => false,
    };
    is_complete && warp.min_density() * domain.area() > PulledBack::UNREACHED
}
