//! The chart of standard errors against N, compared with white noise.

use super::question::{Question, Requested};
use super::row::{Row, distinct, recommended};
use crate::plots::{
    Chart, Ink, MAX_COLOURS, NOTE_OF_OWN, Panel, Scale, Series, Spread, Style, inks,
};

/// The number of best rows that are drawn.
const MAX_SERIES: usize = 40;
/// The same where densities are ranked, whose names are long.
const MAX_WITH_DENSITIES: usize = 12;

/// Returns the chart of the rows, best first; `white_variance` is the variance of white noise
/// with one point.
pub(super) fn chart(question: &Question, rows: &[Row], white_variance: f64) -> Chart {
    // Densities that are the integrand have next to no error.
    let shown = distinct(rows, recommended(rows, question)).into_iter().map(|(row, _)| row);
    let unknown = shown.filter(|row| row.known_to.is_none());
    let has_densities = rows.iter().any(|row| row.warp.is_some());
    let max_series = if has_densities { MAX_WITH_DENSITIES } else { MAX_SERIES };
    let rows: Vec<&Row> = unknown.take(max_series).collect();
    let scale = question.integral.map_or(1.0, |i| 100.0 / i.abs());
    let (mut series, mut ratios) = (Vec::new(), Vec::new());
    let are_own: Vec<bool> = rows.iter().map(|row| row.is_file).collect();
    let n_own = are_own.iter().filter(|is_own| **is_own).count();
    // Rows are sorted, so that the position is the rank.
    let ranks: Vec<f64> = (0..rows.len()).map(|rank| rank as f64).collect();
    for (ink, row) in inks(&ranks, &are_own).into_iter().zip(&rows) {
        let points = &row.points;
        let errors = points.iter().map(|p| (p.n_points, scale * p.variance.sqrt()));
        // The relative error of a square root is half that of its argument; a larger error than the
        // argument is not propagated, as in the table.
        let unknown = points.iter().map(|p| {
            0.5 * scale * p.stderr * (p.variance / p.variance.max(p.stderr)) / p.variance.sqrt()
        });
        series.push(Series {
            label: row.record.label.clone(),
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
    let unit = match question.integral {
        Some(_) => format!(", % of the {}", question.quantity),
        None => String::new(),
    };
    let relative = Panel { reference: Some(1.0), ..Panel::log("variance / white noise", ratios) };
    let chart = Chart {
        title: match question.quantity {
            "irradiance" => format!("Predicted standard error of the {}", question.integrand),
            _ => format!("Predicted standard error of integrating {}", question.integrand),
        },
        x_label: "number of points N".to_owned(),
        x_scale: Scale::Log,
        panels: vec![Panel::log(format!("standard error{unit}"), series), relative],
        notes: vec!["Bars: one standard error of the prediction.".to_owned()],
    };
    let has_grey = rows.len() - n_own > MAX_COLOURS;
    let colours = has_grey.then(|| format!("In colour: the {MAX_COLOURS} best."));
    let own = (n_own > 0).then(|| NOTE_OF_OWN.to_owned());
    colours.into_iter().chain(own).fold(chart, Chart::with_note)
}
