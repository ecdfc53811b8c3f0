use crate::reference::DoubleDouble;
use sphvar_integrands::{Cap, Energy, Harmonic, Integrand, VonMisesFisher};
use sphvar_samplers::{Domain, Pattern, Purpose, Realizations, Sampler, Streams};
use sphvar_spectrum::{Resolution, Spectrum, accumulate};
use sphvar_variance::{PredictionAccumulator, PredictionBudget, Predictor, predict};

use super::energies;
use super::lobe_pairs::variance;
use crate::spectra::legendre_sums;
use crate::{Errors, Subject};

const SEED: u64 = 7;
/// The degree of the harmonic.
const DEGREE: usize = 4;
/// The number of realizations of a random pattern.
const COUNT: u64 = 2;

/// The energies of a cap by degree.
#[derive(Debug)]
pub(super) struct CapEnergies {
    cap: Cap,
    degrees: f64,
    lmax: usize,
    energy: Option<Energy>,
}

impl CapEnergies {
    pub(super) fn new(cap: Cap, degrees: f64, lmax: usize) -> Self {
        Self { cap, degrees, lmax, energy: None }
    }
}

impl Subject for CapEnergies {
    fn run(&mut self) {
        self.energy = self.cap.energy(Domain::Sphere, self.lmax).ok();
    }

    fn errors(&mut self) -> Errors {
        let exact = energies::of_cap(self.degrees, self.lmax);
        self.energy.as_ref().map_or_else(Errors::default, |energy| {
            errors_of(energy, &exact, |l| exact[l].value().max(exact[l.max(1) - 1].value()))
        })
    }
}

/// The energies of a lobe by degree.
#[derive(Debug)]
pub(super) struct LobeEnergies {
    lobe: VonMisesFisher,
    kappa: f64,
    lmax: usize,
    energy: Option<Energy>,
}

impl LobeEnergies {
    pub(super) fn new(lobe: VonMisesFisher, kappa: f64, lmax: usize) -> Self {
        Self { lobe, kappa, lmax, energy: None }
    }
}

impl Subject for LobeEnergies {
    fn run(&mut self) {
        self.energy = self.lobe.energy(Domain::Sphere, self.lmax).ok();
    }

    fn errors(&mut self) -> Errors {
        let exact = energies::of_lobe(self.kappa, self.lmax);
        self.energy
            .as_ref()
            .map_or_else(Errors::default, |energy| errors_of(energy, &exact, |l| exact[l].value()))
    }
}

/// Returns the errors of energies relative to `(l + 1) scale(l)`.
pub(super) fn errors_of(
    energy: &Energy,
    exact: &[DoubleDouble],
    scale: impl Fn(usize) -> f64,
) -> Errors {
    let mut errors = Errors::default();
    errors.push_length(energy.per_band().len(), exact.len());
    for (l, (got, exact)) in energy.per_band().iter().zip(exact).enumerate() {
        let error = (DoubleDouble::from(*got) - *exact).value();
        errors.push(error / (scale(l) * (l as f64 + 1.0)), || format!("l = {l}"));
    }
    errors
}

/// White noise and a cap.
#[derive(Debug)]
pub(super) struct White {
    cap: Cap,
    n: usize,
    lmax: usize,
    variance: f64,
}

impl White {
    pub(super) fn new(cap: Cap, n: usize, lmax: usize) -> Self {
        Self { cap, n, lmax, variance: f64::NAN }
    }
}

impl Subject for White {
    fn run(&mut self) {
        let spectrum = Spectrum::exact(Domain::Sphere, self.n, vec![1.0; self.lmax + 1]);
        let energy = self.cap.energy(Domain::Sphere, self.lmax);
        self.variance = energy.map_or(f64::NAN, |energy| predict(&spectrum, &energy).variance);
    }

    /// Returns the reference is `(4 pi A - A^2)/N` with the area `A = 2 pi (1 - cos)`.
    fn errors(&mut self) -> Errors {
        let number = DoubleDouble::from;
        let half = number(0.5 * self.cap.angle()).sin_cos().0;
        let area = number(4.0) * DoubleDouble::pi() * half * half;
        let whole = number(4.0) * DoubleDouble::pi();
        let exact = (whole - area) * area / number(self.n as f64);
        let mut errors = Errors::default();
        let error = (number(self.variance) - exact) / exact;
        errors.push(error.value(), || "the variance".to_owned());
        errors
    }
}

/// The harmonic `Y_40` with a pattern whose spectrum has a closed form.
#[derive(Debug)]
pub(super) struct OfHarmonic {
    pattern: Pattern,
    n: usize,
    variance: f64,
}

impl OfHarmonic {
    pub(super) fn new(pattern: Pattern, n: usize) -> Self {
        Self { pattern, n, variance: f64::NAN }
    }
}

impl Subject for OfHarmonic {
    fn run(&mut self) {
        let harmonic = Harmonic::new(DEGREE, 0).expect("an order in range");
        let budget = PredictionBudget::DEFAULT;
        let predictor = Predictor::new(&harmonic, Domain::Sphere, SEED, budget);
        let sampler = self.pattern.build(self.n, Domain::Sphere).expect("a feasible pattern");
        let point = predictor.and_then(|mut p| p.predict(&*sampler, &()));
        self.variance = point.map_or(f64::NAN, |point| point.prediction.variance);
    }

    /// Returns the reference is `4 pi/N P(4)`; the power of white noise is 1.
    fn errors(&mut self) -> Errors {
        let number = DoubleDouble::from;
        let white = number(4.0) * DoubleDouble::pi() / number(self.n as f64);
        let sampler =
            self.pattern.build(self.n, Domain::Sphere).expect("the number of points is valid");
        let power = if sampler.is_random() {
            DoubleDouble::ONE
        } else {
            let mut rng = Streams::new(SEED, Purpose::Pattern, self.n).realization(0);
            let points = sampler.sample(&mut rng).expect("a lattice is feasible").points;
            legendre_sums(&points, DEGREE)[DEGREE]
        };
        let exact = white * power;
        let mut errors = Errors::default();
        let error = (number(self.variance) - exact).value();
        errors.push(error / (white.value() * exact.value()).sqrt(), || {
            format!("a variance of {:.3e}", exact.value())
        });
        errors
    }
}

/// Returns a degree beyond which a lobe has negligible energy.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some hundreds")]
pub(super) fn lobe_degree(kappa: f64) -> usize {
    (8.6 * kappa.sqrt()) as usize + 24
}

/// A smooth lobe with sets of a pattern.
#[derive(Debug)]
pub(super) struct OfLobe {
    sampler: Box<dyn Sampler>,
    lobe: VonMisesFisher,
    kappa: f64,
    variance: f64,
}

impl OfLobe {
    pub(super) fn new(pattern: &Pattern, n: usize, kappa: f64) -> Self {
        let sampler = pattern.build(n, Domain::Sphere).expect("the number of points is valid");
        let lobe = VonMisesFisher::new(kappa).expect("a concentration in range");
        Self { sampler, lobe, kappa, variance: f64::NAN }
    }

    pub(super) fn degree(&self) -> usize {
        lobe_degree(self.kappa)
    }

    fn realizations(&self) -> Realizations<'_> {
        let streams = Streams::new(SEED, Purpose::Pattern, self.sampler.n_points());
        Realizations::rotated(&*self.sampler, streams)
    }

    fn count(&self) -> u64 {
        if self.sampler.is_random() { COUNT } else { 1 }
    }
}

impl Subject for OfLobe {
    fn run(&mut self) {
        let (n, lmax) = (self.sampler.n_points(), self.degree());
        let sum = self.lobe.energy(Domain::Sphere, lmax).ok().and_then(|energy| {
            let empty = PredictionAccumulator::new(&energy, n, lmax);
            let resolution = Resolution::new(lmax, n);
            accumulate(&self.realizations(), resolution, 0..self.count(), &empty, &()).ok()
        });
        self.variance = sum.map_or(f64::NAN, |sum| sum.finish().variance);
    }

    fn errors(&mut self) -> Errors {
        let mut exact = DoubleDouble::ZERO;
        for index in 0..self.count() {
            let points = self.realizations().realize(index).expect("a feasible pattern").points;
            exact += variance(&points, self.kappa) / DoubleDouble::from(self.count());
        }
        // 4 pi int f^2 = kappa coth(kappa).
        let white = (self.kappa / self.kappa.tanh() - 1.0) / self.sampler.n_points() as f64;
        let mut errors = Errors::default();
        let error = (DoubleDouble::from(self.variance) - exact).value();
        let error = error / (white * exact.value()).sqrt();
        errors.push(error, || format!("a variance of {:.3e}", exact.value()));
        errors
    }
}
