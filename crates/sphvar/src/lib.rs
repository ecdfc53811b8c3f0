//! Finds the pattern of N directions with the smallest integration error for an integrand, and
//! explains why.
//!
//! ```
//! use sphvar::prelude::*;
//!
//! // The indicator of a cap of 60 degrees, integrated over the sphere with 192 directions.
//! let cap = Cap::from_degrees(60.0)?;
//! let mut predictor = Predictor::new(&cap, Domain::Sphere, 0, PredictionBudget::DEFAULT)?;
//! let goal = Goal::Points(192);
//! let patterns = [Pattern::WhiteNoise, Pattern::Jittered, Pattern::FIBONACCI];
//! let candidates = Candidate::ranked(patterns, goal, &mut predictor, &())?;
//! assert_eq!(candidates[0].curve.pattern().to_string(), "fibonacci");
//! # Ok::<(), sphvar::variance::Error>(())
//! ```
//!
//! This crate re-exports all of sphvar under one name; its parts are also separate crates:
//!
//! - [`samplers`]: patterns, given point sets, random streams. [`warps`]: maps from the square.
//! - [`spectrum`]: angular power spectra with errors. [`sht`]: transforms of scattered points.
//! - [`integrands`]: functions with their energies. [`variance`]: predicted and measured variance, rates, ranks;
//!   integrals to a tolerance.
//! - The unit square with toroidal shifts instead of rotations:
//!   [`SquarePattern`](samplers::SquarePattern), [`SquareIntegrand`](integrands::SquareIntegrand),
//!   [`ExactSquareSpectrum`](spectrum::ExactSquareSpectrum) and
//!   [`SquarePredictor`](variance::SquarePredictor).
//! - Importance sampling: [`WarpExpression`](integrands::WarpExpression) names densities,
//!   [`PulledBack`](integrands::PulledBack) is an integrand divided by one, and
//!   [`WarpedPredictor`](variance::WarpedPredictor) predicts and measures its variance.
//! - [`bounds`]: closed-form bounds and rates. [`scene`]: ambient occlusion and direct light.
//! - [`grammar`]: specifications of patterns and integrands.
//! - [`sh`]: spherical harmonics. [`healpix`]: the HEALPix grid. [`nufft`]: nonuniform Fourier transforms on the torus.
//!
//! A pattern of your own is a closure ([`FnPattern`](samplers::FnPattern)) or an implementation of
//! [`Sampler`](samplers::Sampler), as in the example `own_pattern`; an integrand is a closure too
//! ([`AdaptiveFunction`](integrands::AdaptiveFunction), or
//! [`SampledFunction`](integrands::SampledFunction) where its degree or its edges are known). Expressions
//! can name functions of your own: see [`IntegrandResolver`](integrands::IntegrandResolver::function).
//!
//! # Features
//!
//! - `serde`: serialization of the accumulators of spectra and of pictures with serde. Off by default.

pub use glam;
pub use rand;
pub use sphvar_bounds as bounds;
pub use sphvar_grammar as grammar;
pub use sphvar_healpix as healpix;
pub use sphvar_integrands as integrands;
pub use sphvar_nufft as nufft;
pub use sphvar_samplers as samplers;
pub use sphvar_scene as scene;
pub use sphvar_sh as sh;
pub use sphvar_sht as sht;
pub use sphvar_spectrum as spectrum;
pub use sphvar_variance as variance;
pub use sphvar_warps as warps;

/// The commonly used items.
pub mod prelude {
    pub use glam::DVec3;
    pub use rand::RngExt;
    pub use sphvar_integrands::{
        AdaptiveFunction, Cap, Energy, EnvironmentMap, FittedFunction, Harmonic, Integrand,
        PhongLobe, Product, PulledBack, Rotated, SampledFunction, Sum, Tolerance, VectorIntegrand,
        VonMisesFisher, WarpExpression,
    };
    pub use sphvar_samplers::{
        Domain, FnPattern, Pattern, PointSet, PointSets, Progress, Purpose, Realizations, Sampler,
        SamplerFamily, Streams,
    };
    pub use sphvar_sht::LeastSquares;
    pub use sphvar_spectrum::{ExactSpectrum, Spectrum, estimate};
    pub use sphvar_variance::{
        Candidate, Comparison, Goal, Integral, IntegrationOptions, PredictedPoint, Prediction,
        PredictionBudget, Predictor, Trials, WarpedPattern, WarpedPredictor, fit_rate, integrate,
        integrate_vector, rank, required_points,
    };
    pub use sphvar_warps::Warp;
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
