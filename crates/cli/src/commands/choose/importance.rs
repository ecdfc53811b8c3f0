//! Patterns of the square that are mapped to densities, in the ranking.

use sphvar_integrands::{Strategy, WarpTerm};
use sphvar_samplers::{PointSet, Progress, Purpose};
use sphvar_variance::{
    CurvePredictor, Error, PredictionBudget, WarpedPattern, WarpedPoint, WarpedPredictor,
    WarpedRealizations,
};

use super::choosable::{Choosable, Density, Details, MakeSet};
use crate::commands::power_chart::largest_frequency;
use crate::error::CliError;

/// The nominal work of mapping a point.
const WORK_OF_MAP: f64 = 1.0;
/// The density of a map is that of the magnitudes of its texels, so that even a density with the
/// text of the integrand differs from it where texels are negative. Otherwise, up to this relative
/// standard deviation of f/p, a density counts as the integrand itself: a single point has an error
/// of at most 1 %.
const SAME: f64 = 0.01;

/// Predicts the variances of patterns that are mapped to the same densities.
pub(super) struct Importance<'a> {
    pub(super) predictor: WarpedPredictor<'a>,
    pub(super) strategies: &'a [Strategy],
    /// Whether the density is the integrand's magnitude by its text.
    pub(super) is_of_integrand: bool,
}

impl Choosable for WarpedPattern {
    type Point = WarpedPoint;
    type Predictor<'a> = Importance<'a>;
    const IS_LIMITED: bool = true;

    fn label(&self) -> String {
        Self::label(self)
    }

    fn name(&self) -> String {
        self.label()
    }

    fn is_file(&self) -> bool {
        self.pattern.is_file()
    }

    fn is_white_noise(&self) -> bool {
        Choosable::is_white_noise(&self.pattern) && self.density() == Density::Uniform
    }

    fn density(&self) -> Density {
        let is_uniform =
            |term: &WarpTerm| matches!(term, WarpTerm::Cylinder | WarpTerm::Octahedral);
        let is_plain = |term: &WarpTerm| is_uniform(term) || *term == WarpTerm::Cosine;
        if self.warp.terms().all(is_uniform) {
            Density::Uniform
        } else if self.warp.terms().all(is_plain) {
            Density::Cosine
        } else {
            Density::Importance
        }
    }

    fn warp(&self) -> Option<String> {
        let warp = if self.has_long_label { &self.warp } else { &self.warp.shortened() };
        Some(warp.to_string())
    }

    fn nominal_work(&self, n_points: usize) -> f64 {
        let parts = self.counts(n_points);
        let of_square: f64 = parts.iter().map(|&n| self.pattern.nominal_work(n)).sum();
        // Each point is weighted by the densities of all strategies.
        of_square + WORK_OF_MAP * (n_points * self.n_strategies()) as f64
    }

    fn make_set(
        &self,
        n_points: usize,
        predictor: &Importance<'_>,
        seed: u64,
    ) -> Result<MakeSet<'_>, CliError> {
        let samplers = self.samplers(n_points).map_err(CliError::failed)?;
        let (strategies, heuristic) = (predictor.strategies.to_vec(), self.heuristic);
        let mut set = PointSet::new(Vec::with_capacity(n_points));
        Ok(Box::new(move |index| {
            let purpose = Purpose::Pattern;
            let sets = WarpedRealizations::new(&strategies, heuristic, &samplers, seed, purpose);
            sets.realize_into(index, &mut set, &()).map_err(CliError::failed)
        }))
    }

    fn details(&self, point: &WarpedPoint, predictor: &Importance<'_>) -> Details {
        let is_of_integrand = predictor.is_of_integrand;
        let spectra = || point.strategies.iter().map(|strategy| &strategy.spectrum);
        let predictor = &predictor.predictor;
        let white = |n: usize| predictor.white_variance(self, n);
        let deviation = predictor.integral().map(|integral| white(1).sqrt() / integral.abs());
        Details {
            lmax: spectra().map(largest_frequency).max(),
            realizations: spectra().map(|spectrum| spectrum.realizations()).max(),
            variance_of_density: Some(white(point.n_points())),
            // The weights of several strategies are no constant multiples of the integrand.
            known_to: deviation
                .filter(|d| self.n_strategies() == 1 && (is_of_integrand || *d <= SAME)),
            ..Details::default()
        }
    }
}

impl CurvePredictor<WarpedPattern> for Importance<'_> {
    type Point = WarpedPoint;

    fn budget(&self) -> PredictionBudget {
        self.predictor.budget()
    }

    fn nearest_count(&self, pattern: &WarpedPattern, requested: usize) -> usize {
        CurvePredictor::nearest_count(&self.predictor, pattern, requested)
    }

    fn predict_at(
        &mut self,
        pattern: &WarpedPattern,
        n_points: usize,
        budget: PredictionBudget,
        progress: &dyn Progress,
    ) -> Result<WarpedPoint, Error> {
        self.predictor.predict_at(pattern, n_points, budget, progress)
    }

    fn is_affordable_at(
        &mut self,
        pattern: &WarpedPattern,
        n_points: usize,
        budget: PredictionBudget,
    ) -> Result<bool, Error> {
        self.predictor.is_affordable_at(pattern, n_points, budget)
    }

    fn is_repeated_by(
        &mut self,
        pattern: &WarpedPattern,
        point: &WarpedPoint,
        budget: PredictionBudget,
    ) -> Result<bool, Error> {
        self.predictor.is_repeated_by(pattern, point, budget)
    }

    fn is_random_at(&self, pattern: &WarpedPattern, n_points: usize) -> bool {
        self.predictor.is_random_at(pattern, n_points)
    }

    fn is_ruled_out(
        &mut self,
        pattern: &WarpedPattern,
        n_points: usize,
        variance: f64,
    ) -> Result<bool, Error> {
        self.predictor.is_ruled_out(pattern, n_points, variance)
    }
}
