//! Variances of all prefixes of a set.

use crate::reference::DoubleDouble;
use glam::DVec3;
use sphvar_integrands::VonMisesFisher;
use sphvar_samplers::{Domain, PointSet, PointSets};
use sphvar_variance::{PredictionBudget, Predictor, ProgressivePredictor, SpectrumOptions};

use super::lobe_pairs::variance;
use super::subjects::lobe_degree;
use crate::{Errors, Subject};

/// A lobe with every prefix of a set.
#[derive(Debug)]
pub(super) struct OfPrefixes {
    set: PointSets,
    lobe: VonMisesFisher,
    kappa: f64,
    /// The numbers of points whose errors are measured.
    counts: Vec<usize>,
    variances: Vec<f64>,
}

impl OfPrefixes {
    pub(super) fn new(points: Vec<DVec3>, kappa: f64, counts: Vec<usize>) -> Self {
        let set = PointSets::new(vec![PointSet::new(points)], Domain::Sphere);
        let set = set.expect("a set of unit vectors");
        let lobe = VonMisesFisher::new(kappa).expect("a concentration in range");
        Self { set, lobe, kappa, counts, variances: Vec::new() }
    }

    fn points(&self) -> &[DVec3] {
        &self.set.sets()[0].points
    }
}

impl Subject for OfPrefixes {
    fn run(&mut self) {
        let budget = PredictionBudget::DEFAULT;
        let all: Vec<usize> = (1..=self.points().len()).collect();
        let lmax = Some(lobe_degree(self.kappa));
        let options = SpectrumOptions { lmax, ..SpectrumOptions::default() };
        let curve = Predictor::new(&self.lobe, Domain::Sphere, 0, budget).and_then(|predictor| {
            let predictor = predictor.with_options(options);
            ProgressivePredictor::new(predictor).predict(&self.set, 0, &all, &())
        });
        let variances =
            curve.map(|curve| curve.points.iter().map(|point| point.prediction.variance).collect());
        self.variances = variances.unwrap_or_default();
    }

    fn errors(&mut self) -> Errors {
        let mut errors = Errors::default();
        for &n in &self.counts {
            let exact = variance(&self.points()[..n], self.kappa);
            // 4 pi int f^2 = kappa coth(kappa).
            let white = (self.kappa / self.kappa.tanh() - 1.0) / n as f64;
            let got = self.variances.get(n - 1).copied().unwrap_or(f64::NAN);
            let error = (DoubleDouble::from(got) - exact).value();
            errors.push(error / (white * exact.value()).sqrt(), || {
                format!("a variance of {:.3e} with {n} points", exact.value())
            });
        }
        errors
    }
}
