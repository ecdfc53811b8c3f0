//! Mean squared errors against the number of directions.

use super::{Curve, StudyBody};
use crate::plots::{Chart, NOTE_OF_OWN, Panel, Scale, Series, Spread, Style, inks};

/// Returns the chart of a study.
pub(super) fn chart(curves: &[Curve<'_>], body: &StudyBody) -> Chart {
    let last = |curve: &Curve<'_>| {
        curve.points().last().map_or(f64::NAN, |point| point.variance * point.n_points)
    };
    let are_own: Vec<bool> = curves.iter().map(|curve| curve.name.is_file).collect();
    let inks = inks(&curves.iter().map(last).collect::<Vec<f64>>(), &are_own);
    let series = curves.iter().zip(inks).map(|(curve, ink)| {
        let points = curve.points();
        Series {
            label: curve.name.label.clone(),
            points: points.iter().map(|p| (p.n_points, p.variance)).collect(),
            spread: Spread::Errors(points.iter().map(|p| p.stderr).collect()),
            style: Style::Joined,
            ink,
        }
    });
    Chart {
        title: "Mean squared error of the picture".to_owned(),
        x_label: "directions on the visible hemisphere N".to_owned(),
        x_scale: Scale::Log,
        panels: vec![Panel::log("mean squared error", series.collect())],
        notes: [
            "Bars: one standard error.".to_owned(),
            format!(
                "{} pixels, reference image of {} jittered directions each",
                body.pixels, body.reference_n
            ),
        ]
        .into_iter()
        .chain(are_own.contains(&true).then(|| NOTE_OF_OWN.to_owned()))
        .collect(),
    }
}
