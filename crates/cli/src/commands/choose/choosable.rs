//! What `choose` needs to know about patterns.

use std::fmt;

use sphvar_samplers::{
    Domain, Ensemble, EqualAreaParameters, Pattern, Placement, PointSet, Purpose, Riesz,
    RieszParameters, SquarePattern, SquareSampler, Streams,
};
use sphvar_spectrum::ExactSquareSpectrum;
use sphvar_variance::{
    BestDesign, CurvePredictor, Error, IntegrationSpace, PredictedPoint, PredictedVariance,
    Predictor, PredictorOn, SquarePredictor, best_design,
};

use super::budgets;
use super::reason::Reason;
use crate::commands::power_chart::{ShownBands, largest_radius};
use crate::error::CliError;
use crate::patterns::{BandsOf, PatternKind, PredictedPattern, n_effective};

/// The share of closed forms and single sets, which take hardly any time.
const KNOWN: f64 = 0.02;

/// Generates the set of an index.
pub(super) type MakeSet<'a> = Box<dyn FnMut(u64) -> Result<(), CliError> + 'a>;

/// The density of points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Density {
    Uniform,
    /// The cosine, or the cosine and uniform points.
    Cosine,
    /// Any other.
    Importance,
}

/// What a prediction follows from.
#[derive(Default)]
pub(super) struct Details {
    /// The largest degree of the spectrum.
    pub(super) lmax: Option<usize>,
    /// The realizations from which the spectrum was estimated; 0 for a closed form.
    pub(super) realizations: Option<u64>,
    /// The effective number of weighted points.
    pub(super) n_effective: Option<f64>,
    pub(super) reason: Option<Reason>,
    /// The variance with as many independent points of the same density.
    pub(super) variance_of_density: Option<f64>,
    /// The relative standard deviation of the ratio of integrand and density, if the density is the
    /// integrand itself to about this.
    pub(super) known_to: Option<f64>,
}

/// A pattern that can be ranked.
pub(super) trait Choosable: Clone + PartialEq + fmt::Display {
    /// The prediction at one number of points.
    type Point: PredictedVariance + Clone;
    /// What predicts the variances of patterns of this kind.
    type Predictor<'a>: CurvePredictor<Self, Point = Self::Point>;
    /// Whether predictions for many points are expensive even where sets are not.
    const IS_LIMITED: bool = false;

    /// Returns the name in tables.
    fn label(&self) -> String;

    /// Returns the name in sentences.
    fn name(&self) -> String;

    /// Returns whether the points are the user's own.
    fn is_file(&self) -> bool;

    /// Returns whether it is the pattern of independent uniform points.
    fn is_white_noise(&self) -> bool;

    /// Returns the density of the points.
    fn density(&self) -> Density {
        Density::Uniform
    }

    /// Returns the densities in tables, if there are others than the uniform one of a pattern of the
    /// sphere.
    fn warp(&self) -> Option<String> {
        None
    }

    /// Returns the nominal work of a set.
    fn nominal_work(&self, n_points: usize) -> f64;

    /// Returns what generates sets, randomized as in predictions.
    ///
    /// # Errors
    ///
    /// Those of samplers.
    fn make_set(
        &self,
        n_points: usize,
        predictor: &Self::Predictor<'_>,
        seed: u64,
    ) -> Result<MakeSet<'_>, CliError>;

    /// Returns what a prediction follows from.
    fn details(&self, point: &Self::Point, predictor: &Self::Predictor<'_>) -> Details;

    /// Returns the degree up to which the pattern has no power, if it is made so.
    fn last_empty_degree(&self, _n_points: usize, _: &Self::Predictor<'_>) -> Option<usize> {
        None
    }

    /// Returns the pattern with the best parameters and its prediction, if it has a smaller variance
    /// than `limit`, and one that was not tried because its prediction is too expensive.
    ///
    /// # Errors
    ///
    /// Those of predictions.
    fn best_design(
        &self,
        _predictor: &mut Self::Predictor<'_>,
        _n_points: usize,
        _limit: f64,
    ) -> Result<BestDesign<Self, Self::Point>, Error> {
        Ok(BestDesign { best: None, unaffordable: None })
    }
}

impl Choosable for SquarePattern {
    type Point = PredictedPoint<BandsOf<Self>>;
    type Predictor<'a> = SquarePredictor<'a>;

    fn label(&self) -> String {
        PatternKind::label(self)
    }

    fn name(&self) -> String {
        if self.own_count().is_some() { self.label() } else { Self::name(self).to_owned() }
    }

    fn is_file(&self) -> bool {
        <Self as PatternKind>::is_file(self)
    }

    fn is_white_noise(&self) -> bool {
        *self == Self::WhiteSquare
    }

    fn nominal_work(&self, n_points: usize) -> f64 {
        Self::nominal_work(self, n_points)
    }

    fn make_set(
        &self,
        n_points: usize,
        predictor: &SquarePredictor<'_>,
        seed: u64,
    ) -> Result<MakeSet<'_>, CliError> {
        make_set(self, n_points, predictor, seed)
    }

    fn details(&self, point: &Self::Point, predictor: &SquarePredictor<'_>) -> Details {
        details(self, point, predictor)
    }
}

impl Choosable for Pattern {
    type Point = PredictedPoint;
    type Predictor<'a> = Predictor<'a>;

    fn label(&self) -> String {
        PatternKind::label(self)
    }

    fn name(&self) -> String {
        if self.own_count().is_some() { self.label() } else { Self::name(self).to_owned() }
    }

    fn is_file(&self) -> bool {
        <Self as PatternKind>::is_file(self)
    }

    fn is_white_noise(&self) -> bool {
        *self == Self::WhiteNoise
    }

    fn nominal_work(&self, n_points: usize) -> f64 {
        Self::nominal_work(self, n_points)
    }

    fn make_set(
        &self,
        n_points: usize,
        predictor: &Predictor<'_>,
        seed: u64,
    ) -> Result<MakeSet<'_>, CliError> {
        make_set(self, n_points, predictor, seed)
    }

    fn details(&self, point: &Self::Point, predictor: &Predictor<'_>) -> Details {
        details(self, point, predictor)
    }

    fn last_empty_degree(&self, n_points: usize, predictor: &Predictor<'_>) -> Option<usize> {
        Self::last_empty_degree(self, n_points, predictor.domain())
    }

    fn best_design(
        &self,
        predictor: &mut Predictor<'_>,
        n_points: usize,
        limit: f64,
    ) -> Result<BestDesign<Self, Self::Point>, Error> {
        best_design(predictor, self, n_points, limit)
    }
}

fn make_set<'s, P: PredictedPattern<Sampler: 's>>(
    pattern: &P,
    n_points: usize,
    predictor: &PredictorOn<'_, P::Space>,
    seed: u64,
) -> Result<MakeSet<'s>, CliError> {
    let sampler = pattern.build(n_points, predictor.space()).map_err(CliError::failed)?;
    let mut set = PointSet::new(Vec::with_capacity(n_points));
    Ok(Box::new(move |index| {
        let sampler = P::Space::sampler(&sampler);
        let streams = Streams::new(seed, Purpose::Pattern, P::Space::stream_group(sampler));
        let sets = P::Space::realizations(sampler, streams);
        sets.realize_into(index, &mut set, &()).map_err(CliError::failed)
    }))
}

fn details<P: PredictedPattern<Bands: ShownBands>>(
    pattern: &P,
    point: &PredictedPoint<BandsOf<P>>,
    predictor: &PredictorOn<'_, P::Space>,
) -> Details {
    let sampler = pattern.build(point.n_points(), predictor.space()).ok();
    Details {
        lmax: Some(largest_radius(&point.spectrum)),
        realizations: Some(point.spectrum.realizations()),
        n_effective: sampler
            .and_then(|sampler| n_effective::<P>(P::Space::sampler(&sampler), &point.spectrum)),
        reason: Reason::new(pattern.to_string(), point, predictor),
        ..Details::default()
    }
}

/// Returns the patterns of the square that are ranked by default.
pub(super) fn square_patterns() -> Vec<SquarePattern> {
    SquarePattern::ALL.to_vec()
}

/// Returns the patterns of the sphere that are ranked by default: all, and parameter variants that
/// are the best for some integrands: centred equal-area points for caps, the logarithmic energy for
/// lobes.
pub(super) fn patterns() -> Vec<Pattern> {
    let mut patterns = Pattern::ALL.to_vec();
    patterns.push(Pattern::EqualArea(EqualAreaParameters { placement: Placement::Centred }));
    patterns
        .push(Pattern::Riesz(RieszParameters { s: 0.0, iterations: Riesz::DEFAULT_ITERATIONS }));
    patterns
}

/// Returns the share of a pattern of the square in the total time, for the progress bar.
pub(super) fn square_share(pattern: &SquarePattern, n_points: usize) -> f64 {
    let sampler = pattern.build(pattern.nearest_count(n_points));
    let has_closed_form =
        |sampler: Box<dyn SquareSampler>| ExactSquareSpectrum::of(&*sampler).is_some();
    if sampler.is_ok_and(has_closed_form) {
        KNOWN
    } else {
        budgets(pattern.nominal_work(n_points)).max(1.0)
    }
}

/// Returns the share of a pattern of the sphere in the total time, for the progress bar.
pub(super) fn share(pattern: &Pattern, n_points: usize, domain: Domain) -> f64 {
    let is_estimated = pattern.build(n_points, domain).is_ok_and(|sampler| sampler.is_random())
        && !matches!(pattern, Pattern::WhiteNoise | Pattern::Jittered);
    let is_designed = matches!(pattern, Pattern::Step { .. } | Pattern::Blue { .. });
    let of_estimate = budgets(pattern.nominal_work(n_points)).max(1.0);
    // A budget, or the minimum number of realizations; designed patterns are also tuned.
    match (is_estimated, is_designed) {
        (false, _) => KNOWN,
        (true, false) => of_estimate,
        (true, true) => 8.0 * of_estimate,
    }
}
