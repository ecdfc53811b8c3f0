use std::sync::{Arc, OnceLock};

use crate::reference::DoubleDouble;
use glam::DVec3;
use sphvar_samplers::{Domain, Pattern, Purpose, Realizations, Sampler, Streams};
use sphvar_spectrum::{
    ExactSpectrum, Method, Resolution, Spectrum, SpectrumAccumulator, accumulate,
};

use super::{legendre_sums, zones};
use crate::{Errors, Subject};

/// The seed of every set.
const SEED: u64 = 7;

/// Several realizations of a pattern, with their mean power in twice the working precision.
#[derive(Debug)]
pub(super) struct Sets {
    pattern: Pattern,
    sampler: Box<dyn Sampler>,
    lmax: usize,
    count: u64,
    power: OnceLock<Vec<f64>>,
}

impl Sets {
    pub(super) fn new(pattern: Pattern, n: usize, lmax: usize, count: u64) -> Self {
        let sampler = pattern.build(n, Domain::Sphere).expect("the number of points is valid");
        Self { pattern, sampler, lmax, count, power: OnceLock::new() }
    }

    pub(super) fn name(&self) -> String {
        let Self { pattern, sampler, lmax, count, .. } = self;
        format!("{count} sets of {} {}, lmax = {lmax}", sampler.n_points(), pattern.name())
    }

    pub(super) fn n_points_in_all(&self) -> u64 {
        self.count * self.sampler.n_points() as u64
    }

    /// Returns the error bound `12 epsilon sqrt(1 + N/(lmax + 1)^2)/sqrt(lmax n_sets)`, plus the
    /// roundings of sums over orders. It is six times the error in the middle degree for evenly
    /// spread errors, since those of windows are largest at the last degree. The exact transform's
    /// epsilon is `EPSILON (lmax + 32)`.
    pub(super) fn bound(&self, epsilon: Option<f64>) -> f64 {
        let degrees = self.lmax as f64 + 1.0;
        let epsilon = epsilon.unwrap_or(f64::EPSILON * (degrees + 31.0));
        let share = (1.0 + self.sampler.n_points() as f64 / (degrees * degrees)).sqrt();
        let coefficients = self.lmax as f64 * self.count as f64;
        12.0 * epsilon * share / coefficients.sqrt() + 2.0 * f64::EPSILON * degrees.sqrt()
    }

    fn realizations(&self) -> Realizations<'_> {
        let streams = Streams::new(SEED, Purpose::Pattern, self.sampler.n_points());
        Realizations::rotated(&*self.sampler, streams)
    }

    fn power(&self) -> &[f64] {
        self.power.get_or_init(|| {
            let mut mean = vec![DoubleDouble::ZERO; self.lmax + 1];
            for index in 0..self.count {
                let points = self.realizations().realize(index).expect("a feasible pattern").points;
                for (mean, power) in mean.iter_mut().zip(legendre_sums(&points, self.lmax)) {
                    *mean += power / DoubleDouble::from(self.count);
                }
            }
            mean.into_iter().map(DoubleDouble::value).collect()
        })
    }
}

/// The mean spectrum of sets, computed by one method.
#[derive(Debug)]
pub(super) struct OfSets {
    sets: Arc<Sets>,
    epsilon: Option<f64>,
    spectrum: Option<Spectrum>,
}

impl OfSets {
    pub(super) fn new(sets: Arc<Sets>, epsilon: Option<f64>) -> Self {
        Self { sets, epsilon, spectrum: None }
    }
}

impl Subject for OfSets {
    fn run(&mut self) {
        let Sets { sampler, lmax, count, .. } = &*self.sets;
        let n_points = sampler.n_points();
        let resolution = Resolution {
            lmax: *lmax,
            n_points,
            method: if self.epsilon.is_some() { Method::Fast } else { Method::Exact },
            epsilon: self.epsilon.unwrap_or(Resolution::EPSILON),
        };
        let empty = SpectrumAccumulator::new(Domain::Sphere, n_points, *lmax);
        let sets = self.sets.realizations();
        let sum = accumulate(&sets, resolution, 0..*count, &empty, &());
        self.spectrum = sum.and_then(|sum| sum.finish()).ok();
    }

    fn errors(&mut self) -> Errors {
        let power = self.spectrum.as_ref().map(Spectrum::power);
        errors_from(power.unwrap_or_default(), self.sets.power(), |_| 1.0)
    }
}

/// Returns the errors of a spectrum's degrees from 1 on.
fn errors_from(got: &[f64], exact: &[f64], scale: impl Fn(f64) -> f64) -> Errors {
    let mut errors = Errors::default();
    errors.push_length(got.len(), exact.len());
    for (l, (got, &exact)) in got.iter().zip(exact).enumerate().skip(1) {
        errors.push((got - exact) / scale(exact), || format!("l = {l}"));
    }
    errors
}

/// A spectrum computed without sampling.
#[derive(Debug)]
pub(super) struct Known {
    pattern: Pattern,
    n: usize,
    lmax: usize,
    spectrum: Option<Spectrum>,
}

impl Known {
    pub(super) fn new(pattern: Pattern, n: usize, lmax: usize) -> Self {
        Self { pattern, n, lmax, spectrum: None }
    }

    pub(super) fn name(&self) -> String {
        format!("{} {}, lmax = {}", self.n, self.pattern.name(), self.lmax)
    }

    fn is_lattice(&self) -> bool {
        !matches!(self.pattern, Pattern::EqualArea { .. })
    }

    pub(super) fn relative_to(&self) -> &'static str {
        if self.is_lattice() { "the largest power" } else { "the power" }
    }

    pub(super) fn reference(&self) -> &'static str {
        if self.is_lattice() {
            "Legendre polynomials of all pairs in twice the precision"
        } else {
            "closed forms in twice the precision"
        }
    }

    /// See [`trials`](super::trials).
    pub(super) fn bound(&self) -> f64 {
        if self.is_lattice() {
            f64::EPSILON * (self.lmax as f64 + 32.0)
        } else {
            16.0 * f64::EPSILON
        }
    }

    fn power(&self) -> Vec<f64> {
        let power = if self.is_lattice() {
            let sampler = self.pattern.build(self.n, Domain::Sphere).expect("the lattice exists");
            let mut rng = Streams::new(0, Purpose::Pattern, 0).realization(0);
            let points: Vec<DVec3> =
                sampler.sample(&mut rng).expect("a lattice is feasible").points;
            legendre_sums(&points, self.lmax)
        } else {
            zones::power(self.n, self.lmax)
        };
        power.into_iter().map(DoubleDouble::value).collect()
    }
}

impl Subject for Known {
    fn run(&mut self) {
        let Self { pattern, n, lmax, .. } = self;
        let sampler = pattern.build(*n, Domain::Sphere).ok();
        let exact = sampler.as_deref().and_then(ExactSpectrum::of);
        self.spectrum = exact.and_then(|exact| exact.to(*lmax, &()).ok());
    }

    fn errors(&mut self) -> Errors {
        let power = self.spectrum.as_ref().map(Spectrum::power);
        let exact = self.power();
        let largest = exact[1..].iter().copied().fold(0.0, f64::max);
        let scale = |exact: f64| if self.is_lattice() { largest } else { exact };
        errors_from(power.unwrap_or_default(), &exact, scale)
    }
}
