//! The recommendation and its reason in a sentence, or the reason why there is none.

use super::candidate::TimedCandidate;
use super::choosable::{Choosable, PredictorOf};
use super::question::{Question, Requested};
use super::reason::Reason;
use crate::error::CliError;
use crate::report::number;

/// The recommendation with its reason, in a sentence.
pub(super) fn recommendation<P: Choosable>(
    best: Option<&TimedCandidate<P>>,
    question: &Question,
    predictor: &mut PredictorOf<'_, P>,
) -> Result<(Option<Reason>, String), CliError> {
    let white = predictor.white_variance(1);
    if white <= 0.0 {
        let text =
            "All samplers are exact: the integrand is constant, so its integral has no variance.";
        return Ok((None, text.to_owned()));
    }
    let (Some(best), Some(n)) = (best, best.and_then(|b| b.answer.n_points)) else {
        let (mut text, mut max_considered) = ("No sampler achieves this error".to_owned(), 1);
        if let Requested::Error { max_points, .. } = question.requested {
            max_considered = max_points;
            text += &format!(
                " with {max_considered} points (--max-count): white noise needs {} \
                 points.",
                number::optional(question.white_noise_points(predictor), number::count)
            );
        }
        return Ok((None, text + &beyond_help::<P>(max_considered, predictor)?));
    };
    if let Some(text) = no_recommendation(best, n, question, predictor)? {
        return Ok((None, text));
    }
    let reason = Reason::new(best, predictor);
    let extrapolated = if best.basis() == "extrapolated" { ", by extrapolation" } else { "" };
    let choice = match question.requested {
        _ if question.cost_per_sample.is_some() => {
            "the minimum time for a set and the values at its points"
        }
        Requested::Error { .. } => {
            "the least expensive sampler among those within 10 % of the fewest points"
        }
        Requested::Points(_) => {
            "the least expensive sampler among those within 10 % of the least variance"
        }
    };
    let name = best.answer.curve.pattern();
    let label = name.label();
    let why = match &reason {
        _ if best.answer.is_exact() => ": it integrates this function exactly".to_owned(),
        Some(reason) => {
            let name = if name.own_count().is_some() { &label } else { P::name(name) };
            format!(": {}", reason.sentence(name))
        }
        None => String::new(),
    };
    let text = format!("Recommended: {label} with N = {n} ({choice}{extrapolated}){why}.");
    Ok((reason, text))
}

/// Returns why not even the best pattern is recommended: its error exceeds the integral, or its
/// variance is not below white noise's within the known accuracy.
fn no_recommendation<P: Choosable>(
    best: &TimedCandidate<P>,
    n: usize,
    question: &Question,
    predictor: &mut PredictorOf<'_, P>,
) -> Result<Option<String>, CliError> {
    let Some((variance, stderr)) = best.answer.variance else {
        return Ok(None);
    };
    let name = best.answer.curve.pattern();
    let relative = question.relative(variance.sqrt());
    if let Some(error) = relative.filter(|error| *error > 1.0) {
        let text = format!(
            "No recommendation: the minimum error with {n} points, that of {}, is {} of the integral.",
            name.label(),
            number::percent(error)
        );
        return Ok(Some(text + &beyond_help::<P>(n, predictor)?));
    }
    let unknown = if stderr.is_finite() { 2.0 * stderr } else { 0.0 };
    let is_white = predictor.white_variance(n) <= variance + unknown;
    let is_white_noise = name.is_white_noise();
    if is_white && !is_white_noise
        || is_white_noise && matches!(question.requested, Requested::Points(_))
    {
        let text = format!(
            "No recommendation: with {n} points no pattern has a significantly smaller variance than white \
             noise."
        );
        return Ok(Some(text + &beyond_help::<P>(n, predictor)?));
    }
    Ok(None)
}

/// Returns a remark if most of the variance lies in degrees in which no pattern has less power than
/// white noise.
fn beyond_help<P: Choosable>(
    n_points: usize,
    predictor: &mut PredictorOf<'_, P>,
) -> Result<String, CliError> {
    Ok(match P::beyond_settled(predictor, n_points)? {
        Some((settled, share)) if share > 0.5 => format!(
            " No pattern can: {} of the variance lies beyond degree {settled}, where every pattern of \
             {n_points} points has the mean power of white noise.",
            number::percent(share)
        ),
        _ => String::new(),
    })
}
