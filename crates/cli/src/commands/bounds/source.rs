//! The source of the spectrum to be bounded.

use std::path::Path;

use sphvar_bounds::MeasuredSpectrum;
use sphvar_samplers::{
    Domain, Pattern, PointSet, Purpose, Realizations, Sampler, SetDistribution, Streams,
};
use sphvar_spectrum::{
    ExactSpectrum, Method, Resolution, Spectrum, SpectrumAccumulator, accumulate, estimate,
};
use sphvar_variance::{Prediction, PredictionBudget, Predictor, SpectrumOptions};

use super::BoundsArgs;
use crate::error::CliError;
use crate::files::SpectrumRow;
use crate::flags::LATTICE_FACTOR;
use crate::global::Global;
use crate::integrands::NamedIntegrand;
use crate::memory::{check_degree, check_memory, check_transform};
use crate::patterns;
use crate::patterns::n_effective;
use crate::progress::Progress;

/// The maximum nominal work of a closed-form spectrum; a spectrum that exceeds it is sampled.
const MAX_CLOSED_FORM_WORK: f64 = 3.3e8;
/// The number of realizations of a pattern whose spectrum has to be sampled.
pub(super) const REALIZATIONS: u64 = 300;

/// A mean spectrum, index l.
pub(super) struct Measured {
    /// The sampler with its parameters, or the file.
    pub(super) label: String,
    /// The name of the sampler alone, under which the thesis may state bounds for it.
    pub(super) sampler: Option<&'static str>,
    pub(super) n_points: usize,
    /// The effective number of points; that of points without weights.
    pub(super) n_effective: f64,
    /// The sampler, unless the spectrum is from a file.
    source: Option<Box<dyn Sampler>>,
    domain: Domain,
    power: Vec<f64>,
    stderr: Vec<f64>,
    /// 0 where the number is unknown or the spectrum is exact.
    realizations: u64,
}

impl Measured {
    /// Returns the spectrum that the arguments name, if they name one.
    pub(super) fn of_args(
        args: &BoundsArgs,
        domain: Domain,
        global: &Global,
    ) -> Result<Option<Self>, CliError> {
        match (&args.spectrum, &args.sampler.sampler) {
            (Some(path), _) => {
                let rows = global.session.read_spectrum(path)?;
                Self::from_rows(path, rows, args.count.count, domain).map(Some)
            }
            (None, Some(name)) => Self::from_sampler(name, args, domain, global).map(Some),
            (None, None) => Ok(None),
        }
    }

    fn from_sampler(
        name: &str,
        args: &BoundsArgs,
        domain: Domain,
        global: &Global,
    ) -> Result<Self, CliError> {
        let (n, nearest) = (args.count.count, args.nearest.nearest);
        let (pattern, sampler) = patterns::sampler_of(name, n, domain, nearest, &global.session)?;
        let n_points = sampler.n_points();
        let natural = Resolution::natural_degree(n_points);
        let natural =
            if sampler.is_random() { natural } else { natural.saturating_mul(LATTICE_FACTOR) };
        let lmax = args.lmax.lmax.unwrap_or(natural);
        check_degree("--lmax", lmax)?;
        let given = match sampler.distribution() {
            SetDistribution::OneOf(sets) if sets.len() > 1 && args.realizations.is_none() => {
                Some(sets)
            }
            _ => None,
        };
        let exact = ExactSpectrum::of(&*sampler).filter(|exact| {
            args.realizations.is_none() && exact.work(lmax) <= MAX_CLOSED_FORM_WORK
        });
        let spectrum = if let Some(sets) = given {
            of_realizations(&pattern, &*sampler, sets, lmax, global)?
        } else if let Some(exact) = exact {
            let bytes = exact.bytes(lmax, rayon::current_num_threads());
            check_memory(&format!("a spectrum to degree {lmax} (--lmax)"), bytes)?;
            let progress = Progress::new(exact.work(lmax), &global.session);
            progress.stage(&pattern.label());
            exact.to(lmax, &progress)?
        } else {
            let count = args.realizations.unwrap_or(REALIZATIONS);
            sampled(&pattern, &*sampler, lmax, count, global)?
        };
        Ok(Self {
            label: pattern.label(),
            sampler: Some(pattern.name()),
            n_points,
            n_effective: n_effective::<Pattern>(&*sampler, &spectrum).unwrap_or(n_points as f64),
            source: Some(sampler),
            domain,
            power: spectrum.power().to_vec(),
            stderr: spectrum.stderr().to_vec(),
            realizations: spectrum.realizations(),
        })
    }

    /// Returns the spectrum of the input with these degrees.
    fn from_rows(
        path: &Path,
        rows: Vec<SpectrumRow>,
        points: Option<usize>,
        domain: Domain,
    ) -> Result<Self, CliError> {
        let lmax = rows.iter().map(|r| r.l).max().unwrap_or(0);
        let realizations = rows.iter().map(|r| r.realizations).min().unwrap_or(0);
        let (mut power, mut stderr) = (vec![f64::NAN; lmax + 1], vec![0.0; lmax + 1]);
        for row in rows {
            power[row.l] = row.value;
            stderr[row.l] = row.stderr;
        }
        // P(0) = N for every set, and files often omit it.
        let n_points = points.or_else(|| whole(power[0])).ok_or_else(|| {
            CliError::Usage(format!(
                "{}: the number of points is not known: give -n N, or a row of degree 0, whose power is N",
                path.display()
            ))
        })?;
        power[0] = n_points as f64;
        let label = path.display().to_string();
        let (n_effective, source) = (n_points as f64, None);
        Ok(Self {
            label,
            sampler: None,
            n_points,
            n_effective,
            source,
            domain,
            power,
            stderr,
            realizations,
        })
    }

    /// Returns the spectrum in the form that fits and checks take.
    pub(super) fn spectrum(&self) -> Result<MeasuredSpectrum<'_>, CliError> {
        MeasuredSpectrum::new(self.n_points, self.domain, &self.power, &self.stderr)
            .map(|measured| match self.realizations {
                0 => measured.with_inferred_realizations(),
                known => measured.with_realizations(known),
            })
            .map_err(CliError::failed)
    }

    /// Returns the mean power of a degree.
    pub(super) fn power(&self, l: usize) -> f64 {
        self.power[l]
    }

    /// Returns the standard error of a degree.
    pub(super) fn stderr(&self, l: usize) -> f64 {
        self.stderr[l]
    }

    /// Returns the largest degree.
    pub(super) fn lmax(&self) -> usize {
        self.power.len() - 1
    }
}

/// Returns the spectrum estimated from given sets, each a realization of an unknown ensemble.
fn of_realizations(
    pattern: &Pattern,
    sampler: &dyn Sampler,
    sets: &[PointSet],
    lmax: usize,
    global: &Global,
) -> Result<Spectrum, CliError> {
    let (n_points, count) = (sampler.n_points(), sets.len() as u64);
    let resolution = Resolution::new(lmax, n_points);
    check_transform(resolution, count)?;
    let work = count as f64 * Method::Auto.nominal_work(n_points, lmax);
    let progress = Progress::new(work, &global.session);
    progress.stage(&pattern.label());
    let empty = SpectrumAccumulator::new(sampler.domain(), n_points, lmax);
    Ok(accumulate(&sets, resolution, 0..count, &empty, &progress)?.finish()?)
}

/// Returns the spectrum estimated from `realizations` sets.
fn sampled(
    pattern: &Pattern,
    sampler: &dyn Sampler,
    lmax: usize,
    realizations: u64,
    global: &Global,
) -> Result<Spectrum, CliError> {
    let n_points = sampler.n_points();
    let count = if sampler.is_random() { realizations } else { realizations.min(1) };
    check_transform(Resolution::new(lmax, n_points), count)?;
    if sampler.is_random() && realizations == 1 {
        let message = "-m must be at least 2 for an error of the spectrum, got 1";
        return Err(CliError::Usage(message.to_owned()));
    }
    let streams = Streams::new(global.seed, Purpose::Pattern, sampler.stream_group());
    let work = sampler.nominal_work() + Method::Auto.nominal_work(n_points, lmax);
    let progress = Progress::new(count as f64 * work, &global.session);
    progress.stage(&pattern.to_string());
    let ensemble = Realizations::rotated(sampler, streams);
    Ok(estimate(&ensemble, lmax, realizations, &progress)?)
}

/// Returns the variance that the sampler's spectrum predicts for an integrand, by the prediction
/// that all commands share, or `None` for a spectrum from a file.
pub(super) fn predicted(
    measured: Option<&Measured>,
    args: &BoundsArgs,
    integrand: &NamedIntegrand<'_>,
    domain: Domain,
    global: &Global,
) -> Result<Option<Prediction>, CliError> {
    let Some(sampler) = measured.and_then(|measured| measured.source.as_ref()) else {
        return Ok(None);
    };
    let options = SpectrumOptions { lmax: args.lmax.lmax, ..SpectrumOptions::default() };
    let budget = PredictionBudget::DEFAULT;
    let predictor = Predictor::new(&*integrand.function, domain, global.seed, budget)?;
    Ok(Some(predictor.with_options(options).predict(&**sampler, &())?.prediction))
}

/// Returns the nearest integer, at least 1; the mean of a random number of points has a fraction.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "between 1 and 2^53, where every number is whole"
)]
fn whole(x: f64) -> Option<usize> {
    let nearest = x.round();
    (1.0..9.0e15).contains(&nearest).then_some(nearest as usize)
}
