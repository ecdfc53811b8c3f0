use sphvar_samplers::{BlueParameters, Domain, Pattern, Sampler, SpectralControl, StepParameters};

use crate::{CurvePredictor, Error, PredictedPoint, PredictionBudget, Predictor};

/// The minimum share of white noise's power beyond a pattern's empty degrees, averaged over many
/// degrees with an integrand's energies as weights. Power that is missing at low degrees appears
/// beyond them (`sum (2l+1) (1 - P(l)) = N`).
const REMAINING_POWER: f64 = 0.7;
/// The factor from one last empty degree to the next one tried, in case fewer empty degrees are
/// better.
const STEP_DOWN: f64 = 0.9;
/// The number of patterns that cannot be generated after which the search ends.
const MAX_FAILURES: usize = 3;
/// The maximum nominal work of one prediction in the search, in units of the budget.
const MAX_WORK: f64 = 2.0;

/// The parameters of a designed pattern that are best for an integrand.
#[derive(Clone, Debug, PartialEq)]
pub struct BestDesign<F = Pattern, P = PredictedPoint> {
    /// The pattern of the least variance with its prediction, if that is below the variance to beat.
    pub best: Option<(F, P)>,
    /// The pattern with the most empty degrees among those that may have less variance but whose
    /// prediction takes too much work.
    pub unaffordable: Option<F>,
}

/// Returns the parameters of a designed pattern with the least variance at `n_points`, with their
/// prediction; none if none has a variance below `to_beat`, or if the pattern has no such
/// parameters.
///
/// A `step` or `blue` set has no power up to a degree t. Each t has one value of alpha, the
/// shortest decimal number. The largest t is best for smooth integrands: it is tried first, then
/// smaller ones while they improve, all with [`PredictionBudget::rough`] predictions; that of the best is
/// precise. The energy beyond t gives a lower bound if it is spread over
/// many degrees ([`Predictor::broad_variance`]): once 0.7 times white noise's variance there
/// exceeds the best known variance, no smaller t is tried. Patterns are left out whose prediction
/// takes more than twice the work of the default budget: near the largest t sets take up to some
/// hundred times the work of the default alpha.
///
/// # Errors
///
/// Returns the errors of [`Predictor::predict`], except those of sets that cannot be generated.
pub fn best_design(
    predictor: &mut Predictor<'_>,
    pattern: &Pattern,
    n_points: usize,
    to_beat: f64,
) -> Result<BestDesign, Error> {
    let default = PredictionBudget::DEFAULT;
    let budget = PredictionBudget { work: MAX_WORK * default.work, ..default };
    let rough = predictor.budget().rough();
    let mut best: Option<(Pattern, Box<dyn Sampler>, PredictedPoint)> = None;
    let mut unaffordable = None;
    let (mut limit, mut below, mut failures) = (to_beat, usize::MAX, 0);
    for (last, design) in designs(pattern, n_points, predictor.domain()).into_iter().rev() {
        if last >= below {
            continue;
        }
        if REMAINING_POWER * predictor.broad_variance(last, n_points)?.sum() >= limit {
            break;
        }
        let Ok(sampler) = design.build(n_points, predictor.domain()) else {
            continue;
        };
        if !predictor.is_affordable_within(budget, &*sampler).unwrap_or(false) {
            unaffordable.get_or_insert(design);
            continue;
        }
        match predictor.predict_within(rough, &*sampler, &()) {
            Ok(point) if point.prediction.variance < limit => {
                limit = point.prediction.variance;
                best = Some((design, sampler, point));
            }
            Ok(_) => break,
            Err(Error::Spectrum(sphvar_spectrum::Error::Sampler(_))) if failures < MAX_FAILURES => {
                failures += 1;
                continue;
            }
            Err(Error::Spectrum(sphvar_spectrum::Error::Sampler(_))) => break,
            Err(error) => return Err(error),
        }
        below = fraction(last);
    }
    let Some((design, sampler, mut point)) = best else {
        return Ok(BestDesign { best: None, unaffordable });
    };
    if !predictor.is_repeated_by(&design, &point, predictor.budget())? {
        point = predictor.predict(&*sampler, &())?;
    }
    let best = (point.prediction.variance < to_beat).then_some((design, point));
    Ok(BestDesign { best, unaffordable })
}

/// Returns the designs of a pattern, one for each last empty degree, in increasing order.
fn designs(pattern: &Pattern, n_points: usize, domain: Domain) -> Vec<(usize, Pattern)> {
    let largest = SpectralControl::max_empty_degree(n_points, domain).unwrap_or(0);
    let degrees = (1..=largest).filter(|&last| domain.has_degree(last));
    degrees.filter_map(|last| Some((last, design(pattern, last, n_points, domain)?))).collect()
}

/// Returns the design whose last empty degree is `last`, with the shortest decimal alpha.
fn design(pattern: &Pattern, last: usize, n_points: usize, domain: Domain) -> Option<Pattern> {
    let min_alpha = last as f64 / domain.count_on_sphere(n_points).sqrt();
    (1..=6).find_map(|digits| {
        let scale = 10_f64.powi(digits);
        let design = with_alpha(pattern, (min_alpha * scale).ceil() / scale)?;
        (design.last_empty_degree(n_points, domain) == Some(last)).then_some(design)
    })
}

/// Returns the pattern with another alpha, if it has that parameter.
fn with_alpha(pattern: &Pattern, alpha: f64) -> Option<Pattern> {
    let alpha = Some(alpha);
    match *pattern {
        Pattern::Step(StepParameters { flat, core, .. }) => {
            Some(Pattern::Step(StepParameters { alpha, flat, core }))
        }
        Pattern::Blue(BlueParameters { core, .. }) => {
            Some(Pattern::Blue(BlueParameters { alpha, core }))
        }
        _ => None,
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a fraction of a degree"
)]
fn fraction(degree: usize) -> usize {
    (STEP_DOWN * degree as f64) as usize + 1
}

#[cfg(test)]
mod tests {
    use sphvar_samplers::{Domain, Pattern, SpectralControl};

    use super::designs;

    #[test]
    fn every_last_empty_degree_has_one_alpha() {
        let step = "step".parse::<Pattern>().unwrap();
        for n in [12, 100, 500, 2000, 20_000] {
            let designs = designs(&step, n, Domain::Sphere);
            let degrees: Vec<usize> = designs.iter().map(|d| d.0).collect();
            assert!(degrees.windows(2).all(|pair| pair[1] == pair[0] + 1), "{n}: {degrees:?}");
            let largest = SpectralControl::max_empty_degree(n, Domain::Sphere).unwrap();
            assert_eq!(degrees.last(), Some(&largest), "{n}");
        }
        let names: Vec<String> =
            designs(&step, 500, Domain::Sphere).iter().map(|d| d.1.to_string()).collect();
        assert!(names.iter().all(|name| name.len() <= "step:alpha=1.36".len()), "{names:?}");
        assert!(designs(&Pattern::FIBONACCI, 500, Domain::Sphere).is_empty());
    }
}
