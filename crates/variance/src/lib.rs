//! Predicts the variance of Monte Carlo integration over patterns of directions, and measures it.
//!
//! ```
//! use sphvar_samplers::{Domain, Pattern, Purpose, Realizations, Streams};
//! use sphvar_integrands::{Harmonic, Integrand};
//! use sphvar_variance::{measure, predict};
//!
//! let jittered = Pattern::Jittered.build(192, Domain::Sphere)?;
//! let integrand = Harmonic::new(4, 0)?;
//!
//! // Predicted: the product of two spectra.
//! let sets = Realizations::rotated(&*jittered, Streams::new(0, Purpose::Pattern, 192));
//! let spectrum = sphvar_spectrum::estimate(&sets, 8, 400, &())?;
//! let predicted = predict(&spectrum, &integrand.energy(Domain::Sphere, 8)?);
//!
//! // Measured, on independent realizations.
//! let trials = Realizations::rotated(&*jittered, Streams::new(0, Purpose::Trial, 192));
//! let measured = measure(&trials, &integrand, 400, &())?;
//! assert!((measured.variance() / predicted.variance - 1.0).abs() < 0.3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The variance is `Var(I_N) = (4 pi / N) sum_{l >= 1} (2l+1) <P_S(l)> P_F(l)` (Singh 2015,
//! corrected). The part of the integrand's energy beyond the largest degree of the spectrum is
//! included. A [`Predictor`] predicts the variance for any sampler; [`Candidate`] and [`rank`]
//! compare patterns. [`FixedOrientation`] has the errors of patterns that are not rotated.
//! A [`WarpedPredictor`] predicts importance sampling: patterns of the square that are mapped to
//! directions of known densities. A [`ProgressivePredictor`] has the errors of all prefixes of a
//! sequence. [`integrate`] doubles the number of points until a tolerance is met.

mod adapted;
mod candidate;
mod comparison;
mod crossover;
mod curve_predictor;
mod degree;
mod designs;
mod energy_levels;
mod error;
mod error_moments;
mod estimates;
mod fixed_orientation;
mod integration;
mod joint_trials;
mod known_moments;
mod measurement;
mod over_rotations;
mod predicted_curve;
mod predicted_point;
mod prediction;
mod prediction_budget;
mod predictor;
mod progressive;
mod rate;
mod relative_error;
mod required_points;
mod route;
mod space;
mod stopping;
mod student;
mod trials;
mod visible_half;
mod warped;

pub use adapted::AdaptedPattern;
pub use candidate::{Candidate, Goal, rank};
pub use comparison::Comparison;
pub use crossover::{Crossover, crossover, crossovers};
pub use curve_predictor::CurvePredictor;
pub use degree::{check_degree, prediction_degree, settled_degree, settled_degree_of};
pub use designs::{BestDesign, best_design};
pub use error::Error;
pub use estimates::{measure, measure_components, trial_work};
pub use fixed_orientation::{
    FixedOrientation, FixedOrientationPrediction, UnrotatedMethod, UnrotatedPrediction,
};
pub use integration::{
    Estimate, Integral, IntegrationOptions, StopReason, integrate, integrate_vector,
};
pub use joint_trials::JointTrials;
pub use measurement::{BiasTest, Measurement};
pub use over_rotations::OverRotations;
pub use predicted_curve::{PredictedCurve, interpolate_variance};
pub use predicted_point::{PredictedPoint, PredictedVariance};
pub use prediction::{Prediction, PredictionAccumulator, predict};
pub use prediction_budget::{PredictionBudget, SpectrumOptions};
pub use predictor::{PredictionSums, Predictor, PredictorOn};
pub use progressive::{
    Factors, PrefixMeasurement, PrefixVariances, ProgressiveCurve, ProgressivePoint,
    ProgressivePredictor, ProgressiveSpace, Randomized,
};
pub use rate::{RateFit, VariancePoint, fit_exact_rate, fit_rate, fit_rate_of_few};
pub use relative_error::{RelativeError, rarest_seen};
pub use required_points::{
    RequiredPoints, needs_more_points, required_points, required_points_within, valid_between,
};
pub use space::{Distribution, IntegrationSpace, SquarePredictor};
pub use sphvar_integrands::{Energy, Integrand, VectorIntegrand};
pub use sphvar_samplers::Square;
pub use sphvar_sh::Domain;
pub use sphvar_spectrum::{Method, Spectrum};
pub use stopping::{Precision, measure_until};
pub use student::student_quantile;
pub use trials::{Experiment, Trials};
pub use visible_half::{
    CutAxis, VisibleHalfMeasurement, measure_visible_half, visible_half_estimates,
};
pub use warped::{
    LargestSeen, WarpedComparison, WarpedEstimates, WarpedExperiment, WarpedPattern, WarpedPoint,
    WarpedPredictor, WarpedRealizations, WarpedText, best_shares,
};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
