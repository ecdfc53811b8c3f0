//! What `choose` needs to know about patterns.

use sphvar_samplers::{
    Domain, EqualAreaParameters, Pattern, Placement, Riesz, RieszParameters, Square, SquarePattern,
    SquareSampler,
};
use sphvar_spectrum::ExactSquareSpectrum;
use sphvar_variance::{
    Error, PredictedPoint, Predictor, PredictorOn, best_design, settled_degree_of,
};

use super::budgets;
use crate::commands::power_chart::ShownBands;
use crate::patterns::{BandsOf, PatternKind, PredictedPattern};

/// The predictor of a pattern's variances.
pub(super) type PredictorOf<'a, P> = PredictorOn<'a, <P as PatternKind>::Space>;

/// A pattern with the prediction of its variance.
pub(super) type Design<P> = (P, PredictedPoint<BandsOf<P>>);

/// The share of closed forms and single sets, which take hardly any time.
const KNOWN: f64 = 0.02;

/// A pattern that can be ranked.
pub(super) trait Choosable: PredictedPattern<Bands: ShownBands> {
    /// Returns the patterns that are ranked by default.
    fn considered() -> Vec<Self>;

    /// Returns the name without parameters.
    fn name(&self) -> &'static str;

    /// Returns the nominal work of a set.
    fn nominal_work(&self, n_points: usize) -> f64;

    /// Returns whether it is the pattern of independent points.
    fn is_white_noise(&self) -> bool;

    /// Returns the share of a pattern in the total time, for the progress bar.
    fn share(&self, n_points: usize, space: Self::Space) -> f64;

    /// Returns the degree up to which the pattern has no power, if it is made so.
    fn last_empty_degree(&self, _n_points: usize, _space: Self::Space) -> Option<usize> {
        None
    }

    /// Returns the pattern with the best parameters, if it has a smaller variance than `limit`.
    ///
    /// # Errors
    ///
    /// Those of predictions.
    fn best_design(
        &self,
        _predictor: &mut PredictorOf<'_, Self>,
        _n_points: usize,
        _limit: f64,
    ) -> Result<Option<Design<Self>>, Error> {
        Ok(None)
    }

    /// Returns the degree beyond which every pattern has the mean power of white noise, and the
    /// share of white noise's variance beyond it; `None` if there is no such degree.
    ///
    /// # Errors
    ///
    /// Those of the integrand's energies.
    fn beyond_settled(
        _predictor: &mut PredictorOf<'_, Self>,
        _n_points: usize,
    ) -> Result<Option<(usize, f64)>, Error> {
        Ok(None)
    }
}

impl Choosable for SquarePattern {
    fn considered() -> Vec<Self> {
        Self::ALL.to_vec()
    }

    fn name(&self) -> &'static str {
        Self::name(self)
    }

    fn nominal_work(&self, n_points: usize) -> f64 {
        Self::nominal_work(self, n_points)
    }

    fn is_white_noise(&self) -> bool {
        *self == Self::WhiteSquare
    }

    fn share(&self, n_points: usize, _: Square) -> f64 {
        let sampler = self.build(self.nearest_count(n_points));
        let has_closed_form =
            |sampler: Box<dyn SquareSampler>| ExactSquareSpectrum::of(&*sampler).is_some();
        if sampler.is_ok_and(has_closed_form) { KNOWN } else { budgets(self, n_points).max(1.0) }
    }
}

impl Choosable for Pattern {
    /// Returns all patterns, and parameter variants that are the best for some integrands: centred
    /// equal-area points for caps, the logarithmic energy for lobes.
    fn considered() -> Vec<Self> {
        let mut patterns = Self::ALL.to_vec();
        patterns.push(Self::EqualArea(EqualAreaParameters { placement: Placement::Centred }));
        patterns
            .push(Self::Riesz(RieszParameters { s: 0.0, iterations: Riesz::DEFAULT_ITERATIONS }));
        patterns
    }

    fn name(&self) -> &'static str {
        Self::name(self)
    }

    fn nominal_work(&self, n_points: usize) -> f64 {
        Self::nominal_work(self, n_points)
    }

    fn is_white_noise(&self) -> bool {
        *self == Self::WhiteNoise
    }

    fn share(&self, n_points: usize, domain: Domain) -> f64 {
        let is_estimated = self.build(n_points, domain).is_ok_and(|sampler| sampler.is_random())
            && !matches!(self, Self::WhiteNoise | Self::Jittered);
        let is_designed = matches!(self, Self::Step { .. } | Self::Blue { .. });
        // A budget, or the minimum number of realizations; designed patterns are also tuned.
        match (is_estimated, is_designed) {
            (false, _) => KNOWN,
            (true, false) => budgets(self, n_points).max(1.0),
            (true, true) => 8.0 * budgets(self, n_points).max(1.0),
        }
    }

    fn last_empty_degree(&self, n_points: usize, domain: Domain) -> Option<usize> {
        Self::last_empty_degree(self, n_points, domain)
    }

    fn best_design(
        &self,
        predictor: &mut Predictor<'_>,
        n_points: usize,
        limit: f64,
    ) -> Result<Option<Design<Self>>, Error> {
        best_design(predictor, self, n_points, limit)
    }

    fn beyond_settled(
        predictor: &mut Predictor<'_>,
        n_points: usize,
    ) -> Result<Option<(usize, f64)>, Error> {
        let settled = settled_degree_of(n_points, predictor.domain());
        Ok(Some((settled, predictor.share_beyond(settled)?)))
    }
}
