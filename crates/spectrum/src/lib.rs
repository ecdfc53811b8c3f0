//! Angular power spectra of ensembles of sampling patterns, with error bars that merge exactly.
//!
//! The transform of `sphvar-sht` converts the point sets of an [`Ensemble`], such as the
//! realizations of a sampler, into spherical-harmonic coefficients. An [`Accumulator`] collects
//! statistics of the coefficients: the power per degree ([`SpectrumAccumulator`]), the power per
//! degree and order ([`OrderAccumulator`]), or single coefficients ([`CoefficientSamples`]).
//! [`HomogeneityAccumulator`] and [`HomogeneityAudit`] test the low coefficients for homogeneity,
//! the assumption under which variances follow from the spectrum.
//!
//! [`PairCorrelationAccumulator`] collects pair correlations and Ripley's functions,
//! [`DifferentialAccumulator`] the differentials of points whose density varies.
//!
//! Accumulators sum exactly ([`ExactSum`]). Any split of the realizations over threads, or over
//! machines of one instruction-set class, merges to a bit-identical result.
//!
//! [`ExactSpectrum`] evaluates the mean spectrum of some patterns in closed form, without an
//! ensemble. Spectra and their sums are generic over [`Bands`](sphvar_sh::Bands); the degrees of
//! the sphere are one kind of bands.
//!
//! # Examples
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
//! # Features
//!
//! - `serde`: serialization of the accumulators with serde, with which machines share an ensemble. Off by default.

mod accumulate;
mod accumulator;
mod anisotropy;
mod blocks;
mod class_moments;
#[cfg(feature = "serde")]
mod class_values;
mod coefficients;
mod coincidence;
mod error;
mod estimate;
mod exact;
mod exact_sum;
mod homogeneity;
mod moments;
mod orders;
mod pair_correlation;
pub mod quality;
mod realization;
mod rotations;
mod spectral_bands;
mod spectrum;
mod square;
mod workspaces;

pub use accumulate::{Resolution, accumulate, accumulate_with};
pub use accumulator::Accumulator;
pub use anisotropy::Anisotropy;
pub use blocks::{BlockSums, BlockTotal, BlockTransform};
pub use class_moments::ClassMoments;
pub use coefficients::CoefficientSamples;
pub use coincidence::tail_power;
pub use error::Error;
pub use estimate::estimate;
pub use exact::{ExactSpectrum, StrataQuadrature};
pub use exact_sum::ExactSum;
pub use homogeneity::{
    AuditFamily, AuditSettings, AuditVerdict, Finding, HomogeneityAccumulator, HomogeneityAudit,
    MeanBias, OrderRatio,
};
pub use moments::Moments;
pub use orders::{OrderAccumulator, OrderPower};
pub use pair_correlation::{
    AngleBins, DifferentialAccumulator, Differentials, HeatSmoothing, LocalDensity,
    PairCorrelation, PairCorrelationAccumulator,
};
pub use realization::Realization;
pub use rotations::{
    RotationQuality, matrix_fisher_coefficients, rotation_exact_degree, rotation_power,
};
pub use spectral_bands::SpectralBands;
pub use spectrum::{Spectrum, SpectrumAccumulator};
pub use sphvar_samplers::Ensemble;
pub use sphvar_sht::{
    Fit, FitError, FittedEnergy, LeastSquares, Method, QuadratureError, QuadratureProblem,
    QuadratureWeights, TransformWorkspace, WeightSigns, exact_degree,
};
pub use square::{
    AxisRatio, AxisRatioAccumulator, ExactSquareSpectrum, RadialAccumulator, RadialSpectrum,
    SquareResolution, accumulate_square, accumulate_square_with, estimate_square, frequency_grid,
    square_tail_power,
};
pub use workspaces::Workspaces;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
