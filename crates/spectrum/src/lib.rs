//! Angular power spectra of ensembles of sampling patterns, with error bars that merge exactly.
//!
//! ```
//! use sphvar_samplers::{Domain, Pattern, Purpose, Realizations, Streams};
//! use sphvar_spectrum::estimate;
//!
//! let white = Pattern::WhiteNoise.build(64, Domain::Sphere)?;
//! let ensemble = Realizations::rotated(&*white, Streams::new(0, Purpose::Pattern, 64));
//! let spectrum = estimate(&ensemble, 16, 200, &())?;
//! // White noise has P(l) = 1 for every l >= 1; P(0) = N for every set.
//! let (power, stderr) = (spectrum.power()[4], spectrum.stderr()[4]);
//! assert!((power - 1.0).abs() < 5.0 * stderr);
//! assert!((spectrum.power()[0] - 64.0).abs() < 1e-10);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The data's way: point sets (an [`Ensemble`], such as the realizations of a sampler) go through
//! the transform of `sphvar-sht` into an [`Accumulator`], which keeps what is wanted of the
//! coefficients: their power per degree ([`SpectrumAccumulator`]), per degree and order
//! ([`OrderAccumulator`]), or single coefficients ([`CoefficientSamples`]). Whether an ensemble is
//! homogeneous, so that variances follow from its spectrum, is judged from its low coefficients
//! ([`HomogeneityAccumulator`], [`HomogeneityAudit`]). Accumulators sum exactly ([`ExactSum`]), so any split over threads, or over machines of one kind, merges to the
//! same bits.
//!
//! Some patterns need no ensemble: [`ExactSpectrum`] evaluates the mean itself. Spectra and their sums are written for
//! [`Bands`](sphvar_sh::Bands), of which the degrees of the sphere are one set.

mod accumulate;
mod accumulator;
mod anisotropy;
mod coefficients;
mod coincidence;
mod error;
mod estimate;
mod exact;
mod exact_sum;
mod homogeneity;
mod moments;
mod orders;
mod realization;
mod spectrum;

pub use accumulate::{Resolution, accumulate};
pub use accumulator::Accumulator;
pub use anisotropy::Anisotropy;
pub use coefficients::CoefficientSamples;
pub use coincidence::tail_power;
pub use error::Error;
pub use estimate::estimate;
pub use exact::ExactSpectrum;
pub use exact_sum::ExactSum;
pub use homogeneity::{
    AuditFamily, AuditSettings, AuditVerdict, Finding, HomogeneityAccumulator, HomogeneityAudit,
    MeanBias, OrderRatio,
};
pub use moments::Moments;
pub use orders::{OrderAccumulator, OrderPower};
pub use realization::Realization;
pub use spectrum::{Spectrum, SpectrumAccumulator};
pub use sphvar_samplers::Ensemble;
pub use sphvar_sht::Method;
