//! The chart of standard errors against N, compared with white noise.

use super::candidate::TimedCandidate;
use super::question::{Question, Requested};
use crate::plots::{Chart, Ink, MAX_COLOURS, Panel, Scale, Series, Spread, Style};

/// Returns the chart of the candidates, best first; `white_variance` is the variance of white noise
/// with one point.
pub(super) fn chart(
    question: &Question,
    candidates: &[TimedCandidate],
    white_variance: f64,
) -> Chart {
    let scale = question.integral.map_or(1.0, |i| 100.0 / i.abs());
    let (mut series, mut ratios) = (Vec::new(), Vec::new());
    for (rank, candidate) in candidates.iter().enumerate() {
        let points = candidate.answer.curve.variance_points();
        let errors = points.iter().map(|p| (p.n_points, scale * p.variance.sqrt()));
        // The relative error of a square root is half that of its argument.
        let unknown = points.iter().map(|p| 0.5 * scale * p.stderr / p.variance.sqrt());
        let ink = Ink::Rank(rank);
        series.push(Series {
            label: candidate.answer.curve.pattern().to_string(),
            points: errors.collect(),
            spread: Spread::Errors(unknown.collect()),
            style: Style::Joined,
            ink,
        });
        let of_white = |n_points: f64| n_points / white_variance;
        ratios.push(Series {
            label: String::new(),
            points: points
                .iter()
                .map(|p| (p.n_points, p.variance * of_white(p.n_points)))
                .collect(),
            spread: Spread::Errors(
                points.iter().map(|p| p.stderr * of_white(p.n_points)).collect(),
            ),
            style: Style::Joined,
            ink,
        });
    }
    if let Requested::Error { text, standard_error, .. } = &question.requested {
        let counts = || series.iter().flat_map(|s| s.points.iter().map(|p| p.0));
        let requested = scale * standard_error;
        let (first, last) = (counts().fold(f64::INFINITY, f64::min), counts().fold(0.0, f64::max));
        series.push(Series {
            label: format!("requested: {text}"),
            points: vec![(first, requested), (last, requested)],
            spread: Spread::None,
            style: Style::Dashed,
            ink: Ink::Black,
        });
    }
    let unit = if question.integral.is_some() { ", % of the integral" } else { "" };
    let relative = Panel { reference: Some(1.0), ..Panel::log("variance / white noise", ratios) };
    let chart = Chart {
        title: format!("Predicted standard error of integrating {}", question.integrand),
        x_label: "number of points N".to_owned(),
        x_scale: Scale::Log,
        panels: vec![Panel::log(format!("standard error{unit}"), series), relative],
        notes: vec!["Bars: one standard error of the prediction.".to_owned()],
    };
    if candidates.len() > MAX_COLOURS {
        chart.with_note(format!("In colour: the {MAX_COLOURS} best."))
    } else {
        chart
    }
}
