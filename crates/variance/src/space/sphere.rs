//! Sphere and hemisphere.

use std::ops::Range;

use glam::DVec3;
use sphvar_integrands::{Energy, Integrand};
use sphvar_samplers::{
    Domain, Ensemble, PointSet, Progress, Realizations, Sampler, SetDistribution, Streams,
};
use sphvar_sh::{LmIndex, MAX_DEGREE};
use sphvar_spectrum::{
    ExactSpectrum, Resolution, Spectrum, SpectrumAccumulator, Workspaces, accumulate_with,
};

use super::{Distribution, IntegrationSpace, check_given};
use crate::energy_levels::{degrees_of, level};
use crate::prediction_budget::transform_work;
use crate::predictor::Sums;
use crate::{Error, PredictionBudget, Predictor, SpectrumOptions};

/// The minimum share of white noise's power that random patterns have beyond 4 sqrt(N), averaged
/// over many degrees.
const RANDOM_SHARE: f64 = 0.5;
/// The same share for lattices, at even degrees: there are gaps between their peaks, and antipodal
/// lattices have no power at odd degrees.
const LATTICE_SHARE: f64 = 0.01;

impl IntegrationSpace for Domain {
    type Bands = Self;
    type SamplerRef<'s> = &'s dyn Sampler;
    type Integrand<'a> = &'a dyn Integrand;
    type Extent = usize;
    type Level = usize;
    type Exact<'s> = ExactSpectrum<'s>;
    type Realizations<'s> = Realizations<'s>;

    fn area(self) -> f64 {
        Self::area(self)
    }

    fn sampler(owned: &dyn Sampler) -> &dyn Sampler {
        owned
    }

    fn check(self, sampler: &dyn Sampler) -> Result<(), Error> {
        if sampler.domain() != self {
            let (expected, got) = (self, sampler.domain());
            return Err(Error::OtherDomain { expected, got });
        }
        check_given(sampler.n_points(), Self::given_sets(sampler))
    }

    fn n_points(sampler: &dyn Sampler) -> usize {
        sampler.n_points()
    }

    fn nominal_work(sampler: &dyn Sampler) -> f64 {
        sampler.nominal_work()
    }

    fn stream_group(sampler: &dyn Sampler) -> usize {
        sampler.stream_group()
    }

    fn is_independent(sampler: &dyn Sampler) -> bool {
        sampler.is_independent()
    }

    fn given_sets(sampler: Self::SamplerRef<'_>) -> &[PointSet] {
        match sampler.distribution() {
            SetDistribution::OneOf(sets) => sets,
            _ => &[],
        }
    }

    fn coordinates(point: &DVec3) -> [f64; 3] {
        point.to_array()
    }

    fn distribution(sampler: Self::SamplerRef<'_>) -> Distribution<'_, DVec3> {
        match sampler.distribution() {
            SetDistribution::Independent => Distribution::Independent,
            SetDistribution::OneOf(sets) if sets.len() > 1 => Distribution::OneOf(sets),
            kind if kind.is_random() => Distribution::Random,
            _ => Distribution::Fixed,
        }
    }

    fn realizations(sampler: Self::SamplerRef<'_>, streams: Streams) -> Realizations<'_> {
        Realizations::rotated(sampler, streams)
    }

    fn extent(
        predictor: &mut Predictor<'_>,
        budget: PredictionBudget,
        sampler: &dyn Sampler,
    ) -> Result<usize, Error> {
        predictor.degree(budget, sampler)
    }

    fn bands(self, _: &usize) -> Self {
        self
    }

    fn last_band(lmax: &usize) -> usize {
        *lmax
    }

    fn last_of(spectrum: &Spectrum) -> usize {
        spectrum.lmax()
    }

    fn transform_work(n_points: usize, lmax: &usize) -> f64 {
        transform_work(n_points, *lmax)
    }

    fn ticked_work(options: &SpectrumOptions, n_points: usize, lmax: &usize) -> f64 {
        options.method.nominal_work(n_points, *lmax)
    }

    fn exact<'s>(
        options: &SpectrumOptions,
        budget: PredictionBudget,
        sampler: Self::SamplerRef<'s>,
        lmax: &usize,
    ) -> Option<ExactSpectrum<'s>> {
        let exact = ExactSpectrum::of(sampler)?;
        let is_chosen = if let SetDistribution::SphericalEnsemble = sampler.distribution() {
            // A product of l factors is free at any N, and realizations are expensive.
            options.realizations.is_none()
        } else if sampler.is_random() {
            let work = exact.work(*lmax);
            options.realizations.is_none() && budget.is_exact(sampler.n_points(), *lmax, work)
        } else {
            options.is_default_transform()
        };
        is_chosen.then_some(exact)
    }

    fn exact_spectrum(
        workspaces: &Workspaces,
        exact: &ExactSpectrum<'_>,
        lmax: &usize,
        progress: &dyn Progress,
    ) -> Result<Spectrum, Error> {
        Ok(exact.to_with(workspaces, *lmax, progress)?)
    }

    fn exact_work(exact: &ExactSpectrum<'_>, lmax: &usize) -> f64 {
        exact.work(*lmax)
    }

    fn flat_spectrum(self, n_points: usize, lmax: &usize) -> Result<Spectrum, Error> {
        Ok(Spectrum::exact(self, n_points, vec![1.0; (*lmax).min(MAX_DEGREE) + 1]))
    }

    fn empty_spectrum(self, n_points: usize, lmax: &usize) -> Result<SpectrumAccumulator, Error> {
        // Degrees for which no transform exists need no memory either.
        LmIndex::new(*lmax).map_err(sphvar_spectrum::Error::from)?;
        Ok(SpectrumAccumulator::new(self, n_points, *lmax))
    }

    fn accumulate(
        workspaces: &Workspaces,
        sets: &dyn Ensemble,
        options: &SpectrumOptions,
        (n_points, lmax): (usize, &usize),
        indices: Range<u64>,
        empty: &Sums<Self>,
        progress: &dyn Progress,
    ) -> Result<Sums<Self>, Error> {
        let SpectrumOptions { method, epsilon, .. } = *options;
        let resolution = Resolution { lmax: *lmax, n_points, method, epsilon };
        Ok(accumulate_with(workspaces, sets, resolution, indices, empty, progress)?)
    }

    fn outline(self, integrand: &dyn Integrand) -> Result<Energy, Error> {
        let outline = integrand.energy(self, 0)?;
        outline.check_magnitude()?;
        Ok(outline)
    }

    fn level(lmax: &usize) -> usize {
        // The steps are fixed because the rounding of an environment map's energies depends on
        // lmax.
        level(*lmax)
    }

    fn energy(
        self,
        integrand: &dyn Integrand,
        lmax: &usize,
        announce: &dyn Fn(usize),
    ) -> Result<Energy, Error> {
        let degrees = degrees_of(level(*lmax));
        announce(degrees);
        Ok(integrand.energy(self, degrees)?)
    }

    fn min_variance(
        predictor: &mut Predictor<'_>,
        n_points: usize,
        is_random: bool,
    ) -> Result<f64, Error> {
        let settled = Resolution::natural_degree(n_points);
        let broad = predictor.broad_variance(settled, n_points)?;
        Ok(if is_random { RANDOM_SHARE * broad.sum() } else { LATTICE_SHARE * broad.even })
    }

    fn integral(self, integrand: &dyn Integrand) -> Option<f64> {
        integrand.exact(self)
    }

    fn kurtosis(self, integrand: &dyn Integrand) -> Option<f64> {
        integrand.kurtosis(self)
    }

    fn eval_into(
        integrand: &dyn Integrand,
        dirs: &[DVec3],
        values: &mut [f64],
    ) -> Result<(), sphvar_integrands::Error> {
        integrand.eval_into(dirs, values)
    }
}
