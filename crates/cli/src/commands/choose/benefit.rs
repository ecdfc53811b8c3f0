//! What densities that resemble the integrand buy, compared with uniform directions and the cosine.

use schemars::JsonSchema;
use serde::Serialize;

use super::choosable::Density;
use super::question::{Question, Requested};
use super::ranking::Ranking;
use super::row::Row;
use crate::report::number;

/// From this ratio of numbers of points on, the sentence recommends importance sampling.
const WORTHWHILE: f64 = 2.0;

/// A sampler with its error.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct BestSampler {
    /// The sampler with its parameters.
    sampler: String,
    /// The name in tables.
    #[serde(skip)]
    label: String,
    /// The number of points.
    n: usize,
    /// The standard error of the integral.
    error: f64,
    /// `error` over the integral.
    relative_error: Option<f64>,
}

/// The best sampler by a density that resembles the integrand, and the best ones without.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct DensityBenefit {
    /// The best sampler with a density that resembles the integrand; one that is the integrand itself
    /// only if there is no other.
    importance: BestSampler,
    /// The best sampler of uniform directions; null if none is within reach.
    uniform: Option<BestSampler>,
    /// The best sampler with the density of the cosine.
    cosine: Option<BestSampler>,
    /// The number of points with which the best sampler without such a density has the error of
    /// `importance`, over the points of `importance`; with `-n` extrapolated by its rate.
    points_ratio: Option<f64>,
    /// The same in words.
    pub(super) sentence: String,
}

impl BestSampler {
    fn of(row: &Row) -> Option<Self> {
        Some(Self {
            sampler: row.record.sampler.clone(),
            label: row.record.label.clone(),
            n: row.record.n?,
            error: row.record.error?,
            relative_error: row.record.relative_error,
        })
    }

    fn error(&self) -> String {
        match self.relative_error {
            Some(relative) => number::percent(relative),
            None => number::value(self.error),
        }
    }

    fn result(&self, question: &Question) -> String {
        match question.requested {
            Requested::Error { .. } => format!("N = {}, {}", self.n, self.label),
            Requested::Points(_) => format!("{}, {}", self.error(), self.label),
        }
    }
}

/// Returns what densities buy, if any were ranked beside uniform directions.
pub(super) fn benefit(ranking: &Ranking<'_>) -> Option<DensityBenefit> {
    let Ranking { question, rows, .. } = ranking;
    let has_uniform = rows.iter().any(|row| row.density == Density::Uniform);
    let best = |density: Density| {
        let is_within_reach = |row: &&Row| row.known_to.is_none() && row.variance.is_some();
        rows.iter().filter(is_within_reach).find(|row| row.density == density)
    };
    let mut of_integrand = rows.iter().filter(|row| row.known_to.is_some());
    let known =
        of_integrand.find(|row| row.density == Density::Importance && row.variance.is_some());
    let importance = best(Density::Importance).or(known).filter(|_| has_uniform)?;
    let (uniform, cosine) = (best(Density::Uniform), best(Density::Cosine));
    let others = match cosine {
        Some(_) => "uniform directions and the cosine need",
        None => "uniform directions need",
    };
    let plain = uniform.into_iter().chain(cosine).min_by(|a, b| a.merit.total_cmp(&b.merit));
    let is_known = importance.known_to.is_some();
    let plain = plain.filter(|_| !is_known);
    let points_ratio = plain.and_then(|plain| points_ratio(question, importance, plain));
    let of_importance = BestSampler::of(importance)?;
    let [uniform, cosine] = [uniform, cosine].map(|row| row.and_then(BestSampler::of));
    let what = match question.requested {
        Requested::Error { .. } => "The fewest points",
        Requested::Points(_) => "The least errors",
    };
    let kinds = [
        (uniform.as_ref(), "uniform"),
        (cosine.as_ref(), "cosine"),
        (Some(&of_importance), "importance sampling"),
    ];
    let results = kinds.iter().filter_map(|(sampler, kind)| {
        Some(format!("{} ({kind})", sampler.as_ref()?.result(question)))
    });
    let mut sentence = format!("{what}: {}.", results.collect::<Vec<_>>().join("; "));
    let verdict = format!("Importance-sample this {}", what_is_sampled(importance));
    // An approximate density may be worse than a uniform one though that of the integrand is exact.
    let is_only = is_known || points_ratio.is_some_and(|ratio| ratio < 1.0);
    let own = known.and_then(|known| known.warp.as_deref()).filter(|_| is_only);
    sentence += &match (points_ratio, &question.requested) {
        _ if let Some(own) = own => format!(
            " {verdict} by its own density, {own}, where it has unknown factors; no approximation of it \
             reduces the error."
        ),
        (Some(ratio), _) if ratio >= WORTHWHILE => format!(
            " {verdict}: {others} {} times the points for the same error.",
            number::ratio(ratio)
        ),
        (Some(ratio), _) if ratio >= 1.0 => format!(
            " {}{} only {} times the points for the same error.",
            others[..1].to_uppercase(),
            &others[1..],
            number::ratio(ratio)
        ),
        (Some(_), _) => " Importance sampling does not reduce the error.".to_owned(),
        (None, Requested::Error { max_points, .. }) => {
            let ratio = *max_points as f64 / of_importance.n as f64;
            format!(
                " {verdict}: {others} more than {} times the points for the same error.",
                number::ratio(ratio)
            )
        }
        (None, Requested::Points(_)) => String::new(),
    };
    Some(DensityBenefit { importance: of_importance, uniform, cosine, points_ratio, sentence })
}

/// Returns what the density of a row resembles.
fn what_is_sampled(row: &Row) -> &'static str {
    if row.record.sampler.contains("env:") { "map" } else { "integrand" }
}

/// Returns the points of `plain` over those of `importance` for the error of the latter.
fn points_ratio(question: &Question, importance: &Row, plain: &Row) -> Option<f64> {
    let of_counts = plain.record.n? as f64 / importance.record.n? as f64;
    match question.requested {
        Requested::Error { .. } => Some(of_counts),
        Requested::Points(_) => {
            let of_variances = plain.variance?.0 / importance.variance?.0;
            let rate = plain.record.rate.filter(|rate| *rate < 0.0)?;
            Some(of_counts * of_variances.powf(-1.0 / rate)).filter(|ratio| ratio.is_finite())
        }
    }
}
