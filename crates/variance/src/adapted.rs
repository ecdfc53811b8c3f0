use std::fmt;
use std::ops::Range;
use std::str::FromStr;
use std::sync::Arc;

use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use sphvar_integrands::grammar::{Spec, quote};
use sphvar_integrands::{PulledBack, Strategy, WarpExpression};
use sphvar_samplers::{AdaptedCcvt, Domain, Progress, Purpose, Streams};
use sphvar_warps::Warp;

use crate::estimates::evaluation_work;
use crate::known_moments::KnownMoments;
use crate::{Comparison, Error, Experiment, Prediction, Predictor, Trials};

/// Tessellations for a density of directions, [`AdaptedCcvt`], as an estimator of integrals with the
/// weights 1/(N p): `ccvt:density="env:sky.exr",capacity=64`.
///
/// The sites are neither homogeneous nor the image of a pattern of the square, so no spectrum
/// predicts the variance, which is [`Prediction::UNKNOWN`]. Their density is p only in the limit of
/// many sites: the mean estimate has a bias, which [`Comparison::bias`] tests.
///
/// # Examples
///
/// ```
/// let pattern: sphvar_variance::AdaptedPattern = "ccvt:density=vmf:kappa=5,capacity=16".parse()?;
/// assert_eq!((pattern.capacity, &*pattern.density.to_string()), (16, "vmf:kappa=5"));
/// assert_eq!(pattern.to_string(), "ccvt:density=vmf:kappa=5,capacity=16");
/// # Ok::<(), sphvar_variance::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct AdaptedPattern {
    /// The density, that of a single warp.
    pub density: WarpExpression,
    /// The mass points of a site.
    pub capacity: usize,
}

/// The name of tessellations in specifications.
const NAME: &str = "ccvt";
/// The key of the density.
const DENSITY: &str = "density";
/// The key of the capacity.
const CAPACITY: &str = "capacity";

impl AdaptedPattern {
    /// The capacity without `capacity=`.
    pub const DEFAULT_CAPACITY: usize = 64;

    /// Returns whether a text has the name and the key `density`.
    #[must_use]
    pub fn is_adapted(text: &str) -> bool {
        let has_density = |mut spec: Spec| spec.name == NAME && spec.take(DENSITY).is_some();
        Spec::parse(text).is_ok_and(has_density)
    }

    /// Returns the nominal work of a trial with `n` points.
    #[must_use]
    pub fn trial_work(&self, n: usize) -> f64 {
        // The nominal work does not depend on the density.
        let any = Arc::new(sphvar_warps::UniformCap::SPHERE);
        let tessellation = AdaptedCcvt::new(n, self.capacity, any);
        tessellation.map_or(0.0, |ccvt| ccvt.nominal_work()) + evaluation_work(n)
    }

    /// Returns the default number of trials with `n` points, as [`Trials::default_of`] does.
    #[must_use]
    pub fn default_trials(&self, n: usize) -> Trials {
        Trials::default_of_work(self.trial_work(n))
    }
}

impl FromStr for AdaptedPattern {
    type Err = Error;

    /// # Errors
    ///
    /// [`Error::Integrand`] for a text that is no specification, for the errors of the density and
    /// for several warps; [`Error::Parameter`] for a capacity of 0.
    fn from_str(text: &str) -> Result<Self, Error> {
        let of_grammar = sphvar_integrands::Error::from;
        let mut spec = Spec::parse(text).map_err(of_grammar)?;
        let density: WarpExpression = spec.take(DENSITY).unwrap_or_default().parse()?;
        let mut capacity = Self::DEFAULT_CAPACITY;
        spec.replace_number(CAPACITY, &mut capacity).map_err(of_grammar)?;
        spec.finish(&[DENSITY, CAPACITY]).map_err(of_grammar)?;
        let wrong = |name, range, got: usize| Error::Parameter { name, range, got: got as f64 };
        match (density.n_strategies(), capacity) {
            (1, 1..) => Ok(Self { density, capacity }),
            (1, _) => Err(wrong("capacity", "at least 1", capacity)),
            (n, _) => Err(wrong("the number of warps of a density of sites", "1", n)),
        }
    }
}

/// Writes the form that is read.
impl fmt::Display for AdaptedPattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{NAME}:{DENSITY}={}", quote(&self.density.to_string()))?;
        if self.capacity == Self::DEFAULT_CAPACITY {
            return Ok(());
        }
        write!(f, ",{CAPACITY}={}", self.capacity)
    }
}

impl Predictor<'_> {
    /// Returns the variance of estimates by `n_points` sites of tessellations for a density, measured
    /// on independent realizations, without a prediction. Ticks the work of the trials.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`PulledBack::check_support`], of [`AdaptedCcvt`] and of the integrand.
    pub fn measure_adapted(
        &self,
        pattern: &AdaptedPattern,
        strategy: &Strategy,
        n_points: usize,
        trials: Trials,
        progress: &dyn Progress,
    ) -> Result<Comparison, Error> {
        let mut source =
            |range| self.adapted_estimates(pattern, strategy, n_points, range, progress);
        let experiment = self.adapted_experiment(pattern, n_points);
        experiment.measure(&mut source, Prediction::UNKNOWN, trials, progress)
    }

    /// Returns the estimates of the given trials of [`Self::measure_adapted`], in their order.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::measure_adapted`].
    pub fn adapted_estimates(
        &self,
        pattern: &AdaptedPattern,
        strategy: &Strategy,
        n_points: usize,
        trials: Range<u64>,
        progress: &dyn Progress,
    ) -> Result<Vec<f64>, Error> {
        let (domain, integrand) = (self.space(), self.integrand());
        PulledBack::check_support(integrand, domain, std::slice::from_ref(strategy))?;
        let warp: &Arc<dyn Warp> = &strategy.warp;
        let ccvt = AdaptedCcvt::new(n_points, pattern.capacity, warp.clone())?;
        let streams = Streams::new(self.seed(), Purpose::Trial, n_points);
        let estimate = |index: u64| -> Result<f64, Error> {
            let tessellation = ccvt.tessellate(&mut streams.realization(index), progress)?;
            let sites = tessellation.sites();
            let mut values = vec![0.0; sites.len()];
            integrand.eval_into(&sites, &mut values)?;
            progress.tick(evaluation_work(n_points))?;
            let weighted = sites.iter().zip(values).map(|(site, value)| {
                let is_inside = domain == Domain::Sphere || site.z >= 0.0;
                if is_inside { value / warp.density(*site) } else { 0.0 }
            });
            Ok(weighted.sum::<f64>() / n_points as f64)
        };
        trials.into_par_iter().map(estimate).collect()
    }

    /// Returns what is known of the trials of [`Self::measure_adapted`].
    #[must_use]
    pub fn adapted_experiment(&self, pattern: &AdaptedPattern, n_points: usize) -> Experiment {
        Experiment {
            n_points,
            work: pattern.trial_work(n_points),
            exact: self.integrand().exact(self.space()),
            rounding: self.estimate_rounding(),
            prediction_rounding: 0.0,
            known: KnownMoments {
                n_points: n_points as f64,
                independent_variance: f64::INFINITY,
                one_point_variance: f64::INFINITY,
                kurtosis: None,
                one_point_kurtosis: None,
                is_independent: false,
            },
        }
    }
}
