//! The recommendation and its reason in a sentence, or the reason why there is none.

use super::question::Requested;
use super::ranking::Ranking;
use super::reason::Reason;
use super::row::{Row, is_best_accurate, recommended};
use crate::error::CliError;
use crate::report::number;

/// The recommendation with its reason, in a sentence.
pub(super) fn recommendation(
    ranking: &mut Ranking<'_>,
) -> Result<(Option<Reason>, String), CliError> {
    if ranking.white_variance <= 0.0 {
        let text =
            "All samplers are exact: the integrand is constant, so its integral has no variance.";
        return Ok((None, text.to_owned()));
    }
    let known = known_integral(&ranking.rows);
    let (reason, text) = of_others(ranking)?;
    Ok((reason, text + &known))
}

/// Returns the recommendation of a sampler whose density is not the integrand itself.
fn of_others(ranking: &mut Ranking<'_>) -> Result<(Option<Reason>, String), CliError> {
    let best = recommended(&ranking.rows, &ranking.question);
    let (Some(best), Some(n)) = (best, best.and_then(|b| b.record.n)) else {
        let is_known =
            ranking.rows.iter().any(|row| row.known_to.is_some() && row.variance.is_some());
        let other = if is_known { "other " } else { "" };
        let (mut text, mut max_considered) = (format!("No {other}sampler achieves this error"), 1);
        if let Requested::Error { max_points, .. } = ranking.question.requested {
            max_considered = max_points;
            text += &format!(
                " with {max_considered} points (--max-count): white noise needs {} \
                 points.",
                number::optional(ranking.white_noise_points, number::count)
            );
        }
        return Ok((None, text + &ranking.beyond_help(max_considered)?));
    };
    if let Some(text) = no_recommendation(best, n, ranking) {
        return Ok((None, text + &ranking.beyond_help(n)?));
    }
    let reason = best.reason.clone();
    let accurate = if is_best_accurate(&ranking.rows, best) {
        ", apart from samplers whose variance is known less accurately than to 25 %"
    } else {
        ""
    };
    let extrapolated = if best.record.basis == "extrapolated" { ", by extrapolation" } else { "" };
    let choice = match ranking.question.requested {
        _ if ranking.question.cost_per_sample.is_some() => {
            "the minimum time for a set and the values at its points"
        }
        Requested::Error { .. } => {
            "the least expensive sampler among those within 10 % of the fewest points"
        }
        Requested::Points(_) => {
            "the least expensive sampler among those within 10 % of the least variance"
        }
    };
    let of_density = best.white_variance.zip(best.variance_of_density);
    let why = match (&reason, of_density) {
        _ if best.is_exact() => ": it integrates this function exactly".to_owned(),
        (Some(reason), _) => format!(": {}", reason.sentence(&best.name)),
        (None, Some((white, of_density))) => {
            let of_pattern = of_density / best.variance.map_or(f64::NAN, |v| v.0);
            format!(
                ": independent points of its density have {} times less variance than uniform ones, and the pattern \
                 has {} times less than these",
                number::ratio(white / of_density),
                number::ratio(of_pattern)
            )
        }
        (None, None) => String::new(),
    };
    let label = &best.record.label;
    let text =
        format!("Recommended: {label} with N = {n} ({choice}{accurate}{extrapolated}){why}.");
    Ok((reason, text))
}

/// Returns why not even the best row is recommended: its error exceeds the integral, or its
/// variance is not below white noise's within the known accuracy.
fn no_recommendation(best: &Row, n: usize, ranking: &Ranking<'_>) -> Option<String> {
    let (variance, stderr) = best.variance?;
    let relative = ranking.question.relative(variance.sqrt());
    if let Some(error) = relative.filter(|error| *error > 1.0) {
        return Some(format!(
            "No recommendation: the minimum error with {n} points, that of {}, is {} of the integral.",
            best.record.label,
            number::percent(error)
        ));
    }
    let unknown = if stderr.is_finite() { 2.0 * stderr } else { 0.0 };
    let is_white = best.white_variance? <= variance + unknown;
    if is_white && !best.is_white_noise
        || best.is_white_noise && matches!(ranking.question.requested, Requested::Points(_))
    {
        return Some(format!(
            "No recommendation: with {n} points no pattern has a significantly smaller variance than white \
             noise."
        ));
    }
    None
}

/// Returns a remark on a density that is the integrand itself.
fn known_integral(rows: &[Row]) -> String {
    let Some((row, deviation)) = rows.iter().find_map(|row| row.known_to.map(|to| (row, to)))
    else {
        return String::new();
    };
    let how = if deviation > 1e-8 {
        format!(" to {}", number::percent(deviation))
    } else {
        String::new()
    };
    let warp = row.warp.as_deref().unwrap_or(&row.record.label);
    format!(
        " The density {warp} is the integrand itself{how}: its normalization is the integral, which needs no \
         samples, so it is not recommended; it is of use for products of this integrand with unknown factors, such as \
         visibility."
    )
}
