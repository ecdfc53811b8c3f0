use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use glam::DVec3;
use sphvar_grammar::Choice;
use sphvar_warps::{Measure, Warp, WarpSample};

use crate::{Domain, Error, Integrand, SquareIntegrand};

/// One of the densities from which an integral is sampled, with its share of the points.
#[derive(Clone, Debug)]
pub struct Strategy {
    /// The map from the square to directions.
    pub warp: Arc<dyn Warp>,
    /// The share of the points, relative to the other strategies; above 0.
    pub share: f64,
}

/// The weights of strategies that are sampled by independent point sets (multiple importance
/// sampling).
///
/// With the densities p and the shares c of the points, strategy i estimates the integral of `w_i
/// f`, where
///
/// ```text
/// w_i = (c_i p_i)^b/sum_k (c_k p_k)^b
/// ```
///
/// Shares are nominal, not the rounded numbers of points, so the functions do not depend on N.
///
/// # References
///
/// Veach 1997, section 9.2.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Heuristic {
    /// b = 1, which bounds all ratios by those of the mixture of the densities.
    #[default]
    Balance,
    /// b = 2, which has a lower variance where one density is nearly proportional to f.
    Power,
}

impl Heuristic {
    /// Returns the weight of a strategy from the products `c_k p_k` of all shares and densities;
    /// they may have a common factor.
    ///
    /// # Examples
    ///
    /// ```
    /// use sphvar_integrands::Heuristic;
    ///
    /// assert_eq!(Heuristic::Balance.weight(0, &[3.0, 1.0]), 0.75);
    /// assert!((Heuristic::Power.weight(0, &[3.0, 1.0]) - 0.9).abs() < 1e-15);
    /// ```
    ///
    /// # Panics
    ///
    /// Panics if `own` is not below the number of products.
    #[must_use]
    pub fn weight(self, own: usize, scaled: &[f64]) -> f64 {
        let exponent = match self {
            Self::Balance => 1,
            Self::Power => 2,
        };
        // Relative to the largest, so that no power overflows or underflows to 0/0.
        let largest = scaled.iter().copied().fold(0.0, f64::max);
        let power = |x: f64| (x / largest).powi(exponent);
        power(scaled[own]) / scaled.iter().map(|x| power(*x)).sum::<f64>()
    }

    /// Returns `w/p` of a strategy at one of its samples, the factor of the integrand; shares of
    /// strategies may have a common factor. It is infinite where the density is 0.
    ///
    /// # Panics
    ///
    /// Panics if `own` is not below the number of strategies.
    #[must_use]
    pub fn weighted(self, strategies: &[Strategy], own: usize, sample: WarpSample) -> f64 {
        let WarpSample { point, density } = sample;
        if strategies.len() == 1 {
            return density.recip();
        }
        let scaled = |(k, Strategy { warp, share }): (usize, &Strategy)| {
            share * if k == own { density } else { warp.density(point) }
        };
        let scaled: Vec<f64> = strategies.iter().enumerate().map(scaled).collect();
        let weight = self.weight(own, &scaled);
        if weight == 0.0 { 0.0 } else { weight / density }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Balance => "balance",
            Self::Power => "power",
        }
    }
}

impl Choice for Heuristic {
    const CHOICES: &'static [(&'static str, Self)] =
        &[("balance", Self::Balance), ("power", Self::Power)];
}

impl fmt::Display for Heuristic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Heuristic {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let names: Vec<&str> = Self::CHOICES.iter().map(|(name, _)| *name).collect();
        let known = Self::CHOICES.iter().find(|(name, _)| *name == text);
        let unknown = || sphvar_grammar::Error::unknown_name("heuristic", text, &names);
        Ok(known.ok_or_else(unknown)?.1)
    }
}

/// A function of direction divided by the density of one of several strategies, weighted by a
/// heuristic.
#[derive(Clone)]
pub(super) struct Ratio<'a> {
    pub(super) integrand: &'a dyn Integrand,
    pub(super) domain: Domain,
    strategies: Arc<[Strategy]>,
    own: usize,
    heuristic: Heuristic,
}

impl<'a> Ratio<'a> {
    /// Returns the ratio of the only strategy.
    pub(super) fn of_one(
        integrand: &'a dyn Integrand,
        domain: Domain,
        warp: Arc<dyn Warp>,
    ) -> Result<Self, Error> {
        check_measure(&*warp)?;
        let strategies = Arc::new([Strategy { warp, share: 1.0 }]);
        Ok(Self { integrand, domain, strategies, own: 0, heuristic: Heuristic::Balance })
    }

    /// Returns the ratios of all strategies, whose shares are normalized.
    ///
    /// # Errors
    ///
    /// [`Error::Parameter`] without strategies, for a share that is not positive and finite, and for
    /// densities that are not those of directions.
    pub(super) fn of_all(
        integrand: &'a dyn Integrand,
        domain: Domain,
        strategies: &[Strategy],
        heuristic: Heuristic,
    ) -> Result<Vec<Self>, Error> {
        let invalid = |name, range, got| Error::Parameter { name, range, got };
        if strategies.is_empty() {
            return Err(invalid("the number of strategies", "at least 1", 0.0));
        }
        let mut total = 0.0;
        for Strategy { warp, share } in strategies {
            if !(*share > 0.0 && share.is_finite()) {
                return Err(invalid("the share of a strategy", "above 0 and finite", *share));
            }
            check_measure(&**warp)?;
            total += share;
        }
        let normalized = |s: &Strategy| Strategy { warp: s.warp.clone(), share: s.share / total };
        let strategies: Arc<[Strategy]> = strategies.iter().map(normalized).collect();
        let of_strategy =
            |own| Self { integrand, domain, strategies: strategies.clone(), own, heuristic };
        Ok((0..strategies.len()).map(of_strategy).collect())
    }

    pub(super) fn warp(&self) -> &dyn Warp {
        &*self.strategies[self.own].warp
    }

    /// Returns the largest density of all strategies in a direction.
    pub(super) fn max_density(&self, dir: DVec3) -> f64 {
        self.strategies.iter().map(|s| s.warp.density(dir)).fold(0.0, f64::max)
    }

    /// Returns all strategies.
    pub(super) fn strategies(&self) -> &[Strategy] {
        &self.strategies
    }

    /// Writes the values of the function, which is 0 outside the domain.
    pub(super) fn function_into(&self, dirs: &[DVec3], values: &mut [f64]) -> Result<(), Error> {
        if self.domain == Domain::Sphere {
            return self.integrand.eval_into(dirs, values);
        }
        // Functions on the hemisphere need not have values below.
        let mirrored: Vec<DVec3> = dirs.iter().map(|d| DVec3::new(d.x, d.y, d.z.abs())).collect();
        self.integrand.eval_into(&mirrored, values)?;
        for (value, dir) in values.iter_mut().zip(dirs) {
            if dir.z < 0.0 {
                *value = 0.0;
            }
        }
        Ok(())
    }

    /// Returns `w f/p` from a value f. Where f and all densities are 0, so is the ratio.
    pub(super) fn weighted(&self, value: f64, sample: WarpSample) -> f64 {
        if value == 0.0 {
            return 0.0;
        }
        if self.strategies.len() == 1 {
            return value / sample.density;
        }
        value * self.heuristic.weighted(&self.strategies, self.own, sample)
    }
}

impl SquareIntegrand for Ratio<'_> {
    fn eval(&self, point: [f64; 2]) -> f64 {
        let sample = self.warp().sample(point);
        let is_outside = self.domain == Domain::Hemisphere && sample.point.z < 0.0;
        let value = if is_outside { 0.0 } else { self.integrand.eval(sample.point) };
        self.weighted(value, sample)
    }

    fn eval_into(&self, points: &[[f64; 2]], values: &mut [f64]) -> Result<(), Error> {
        let mut samples = Vec::new();
        self.warp().sample_into(points, &mut samples);
        let dirs: Vec<DVec3> = samples.iter().map(|sample| sample.point).collect();
        self.function_into(&dirs, values)?;
        for (value, sample) in values.iter_mut().zip(&samples) {
            *value = self.weighted(*value, *sample);
        }
        Ok(())
    }
}

/// Checks that a density is one of directions.
fn check_measure(warp: &dyn Warp) -> Result<(), Error> {
    if warp.measure() == Measure::SolidAngle {
        return Ok(());
    }
    let reason = "the warp maps the square to the disk, not to directions".to_owned();
    Err(Error::Evaluation { reason })
}
