//! The charts of `compare`; `variance` shares one of them.

use sphvar_variance::VariancePoint;

use super::curve::Curve;
use crate::commands::power_chart::{BandTexts, PowerCurve, power_chart};
use crate::commands::rows::ShownEnergy;
use crate::plots::{
    Binned, Chart, Ink, MAX_COLOURS, NOTE_OF_OWN, Panel, Scale, Series, Spread, Style, inks,
};
use crate::report::number;

/// Energies below this fraction of the total are 0 to rounding.
const ROUNDING: f64 = 1e-30;
/// If all ratios are within this factor of 1, the axis is linear.
const LINEAR_RATIO: f64 = 5.0;
/// Beyond this frequency only the spectra of lattices are computed, and their power only
/// fluctuates.
const LAST_FREQUENCY: f64 = 4.0;
/// The note where samplers have no curve.
const WITHOUT_SPECTRUM: &str = "Not shown: warped patterns, which have no angular spectrum.";

/// Returns the colours of curves. If there are many curves, only those with the smallest N x
/// variance have a colour.
fn inks_of(curves: &[Curve<'_>]) -> Vec<Ink> {
    let value = |curve: &Curve<'_>| {
        let last = curve.predicted().last().copied();
        last.map_or(f64::NAN, |point: VariancePoint| point.variance * point.n_points)
    };
    let values: Vec<f64> = curves.iter().map(value).collect();
    inks(&values, &curves.iter().map(is_own).collect::<Vec<_>>())
}

/// Returns whether a curve is that of the user's own points.
fn is_own(curve: &Curve<'_>) -> bool {
    curve.sampler.is_file
}

/// Returns notes on the colours if there are more curves than colours, or the user's own.
fn notes_of_colours(curves: &[Curve<'_>]) -> Vec<String> {
    let n_own = curves.iter().filter(|curve| is_own(curve)).count();
    let colours = || format!("In colour: the {MAX_COLOURS} with the smallest N \u{d7} variance.");
    let colours = (curves.len() - n_own > MAX_COLOURS).then(colours);
    colours.into_iter().chain((n_own > 0).then(|| NOTE_OF_OWN.to_owned())).collect()
}

/// Returns the spectra at the largest number of points.
pub(super) fn spectra_chart(curves: &[Curve<'_>], texts: &BandTexts) -> Chart {
    let inks = inks_of(curves);
    let shown = || {
        let rows = curves.iter().zip(&inks).filter_map(|(c, ink)| Some((*c.rows.last()?, *ink)));
        rows.filter(|(row, _)| !row.is_warped())
    };
    let first = shown().next().map(|(row, _)| row.comparison.n_points);
    let common = first.filter(|&n| shown().all(|(row, _)| row.comparison.n_points == n));
    let spectra: Vec<PowerCurve> = shown()
        .map(|(row, ink)| {
            let (name, n) = (&row.sampler.label, row.comparison.n_points);
            let label = match common {
                Some(_) => name.clone(),
                None => format!("{name}, N = {n}"),
            };
            PowerCurve::new(label, n, &row.power, LAST_FREQUENCY, ink)
        })
        .collect();
    let n_points = common.map_or(String::new(), |n| format!(", N = {n}"));
    let title = format!("{}{n_points}", texts.title);
    let chart = Chart { title, ..power_chart(texts, &spectra, Vec::new()) };
    let has_warped = curves.iter().flat_map(|curve| &curve.rows).any(|row| row.is_warped());
    let without = has_warped.then(|| WITHOUT_SPECTRUM.to_owned());
    notes_of_colours(curves).into_iter().chain(without).fold(chart, Chart::with_note)
}

/// Returns predicted and measured variances against N, with their ratio below.
pub(in crate::commands) fn variance_chart(curves: &[Curve<'_>], subject: &str) -> Chart {
    let points = |p: &[VariancePoint]| p.iter().map(|p| (p.n_points, p.variance)).collect();
    let (mut series, mut ratios) = (Vec::new(), Vec::new());
    for (curve, ink) in curves.iter().zip(inks_of(curves)) {
        series.push(Series {
            label: curve.sampler.label.clone(),
            points: points(&curve.predicted()),
            spread: Spread::None,
            style: Style::Line,
            ink,
        });
        let measured = curve.measured();
        series.push(Series {
            label: String::new(),
            points: points(&measured),
            spread: Spread::Errors(measured.iter().map(|p| p.stderr).collect()),
            style: Style::Markers,
            ink,
        });
        let ratio: Vec<(f64, f64)> = curve.rows.iter().map(|r| r.comparison.ratio()).collect();
        ratios.push(Series {
            label: String::new(),
            points: measured.iter().zip(&ratio).map(|(p, r)| (p.n_points, r.0)).collect(),
            spread: Spread::Errors(ratio.iter().map(|r| r.1).collect()),
            style: Style::Markers,
            ink,
        });
    }
    let shown = ratios.iter().flat_map(|s| &s.points).map(|p| p.1).filter(|r| r.is_finite());
    let is_wide = shown.into_iter().any(|r| !(1.0 / LINEAR_RATIO..=LINEAR_RATIO).contains(&r));
    let ratio = Panel {
        reference: Some(1.0),
        side_by_side: true,
        y_scale: if is_wide { Scale::Log } else { Scale::Linear },
        ..Panel::log("measured / predicted", ratios)
    };
    Chart {
        title: format!("Variance of {subject}"),
        x_label: "number of points N".to_owned(),
        x_scale: Scale::Log,
        panels: vec![Panel::log("variance", series), ratio],
        notes: std::iter::once(
            "Lines: predicted. Markers: measured, with one standard error; those of the lower panel are moved apart \
             to the sides."
                .to_owned(),
        )
        .chain(notes_of_colours(curves))
        .collect(),
    }
}

/// Returns the energies of the integrand against the degree.
pub(super) fn integrand_chart(energy: &ShownEnergy, name: &str) -> Chart {
    let ShownEnergy { by_radius, total, texts } = energy;
    let degrees = by_radius.iter().enumerate().skip(1);
    let points: Vec<_> = degrees.map(|(l, e)| (l as f64, e / total)).collect();
    let Binned { points, ranges } = Binned::new(&points, ROUNDING);
    let notes = ranges.iter().map(|_| texts.binned[0].to_owned()).collect();
    let series = Series {
        label: String::new(),
        points,
        spread: ranges.map_or(Spread::None, Spread::Ranges),
        style: Style::Line,
        ink: Ink::Rank(0),
    };
    Chart {
        title: format!("Energy per {} of {name}", texts.unit),
        x_label: texts.radius.to_owned(),
        x_scale: Scale::Log,
        panels: vec![Panel::log(
            format!("{}, total = {}", texts.energy, number::value(*total)),
            vec![series],
        )],
        notes,
    }
}
