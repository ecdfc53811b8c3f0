//! Charts of error against time.

use sphvar_accuracy::Area;

use super::figures::singular;
use super::record::{Document, TrialRecord};
use crate::plots::{Chart, Scale, Series, Style};

/// The name of an area's chart in a folder of charts.
pub(super) fn chart_name(area: Area) -> String {
    format!("accuracy-{}.svg", area.name())
}

/// A line of a chart's notes has room for about as many letters.
const LONGEST_NOTE: usize = 160;

/// Largest error against time per unit, a curve for each method through its cases.
///
/// An axis has one unit: only trials whose errors are relative to the same thing as most are shown.
pub(super) fn area_chart(area: Area, document: &Document<'_>) -> Chart {
    let all: Vec<&TrialRecord> = document.trials_of(area).collect();
    let like =
        |trial: &&TrialRecord| all.iter().filter(|t| t.relative_to == trial.relative_to).count();
    let scale = all.iter().copied().max_by_key(like).map_or("", |trial| trial.relative_to);
    let (mut methods, mut units, mut exact, mut others) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut trials = Vec::new();
    for trial in all.iter().copied() {
        if trial.relative_to != scale {
            add(&mut others, trial.relative_to);
        } else if trial.error > 0.0 {
            add(&mut methods, &trial.method);
            add(&mut units, singular(trial.unit));
            trials.push(trial);
        } else {
            add(&mut exact, &trial.method);
        }
    }
    exact.retain(|method| !methods.contains(method));
    let mut series = Vec::new();
    for (colour, method) in methods.iter().enumerate() {
        let own = trials.iter().filter(|trial| trial.method == *method);
        let points: Vec<_> = own.map(|trial| (trial.seconds_per_unit, trial.error)).collect();
        let of = |label: &str, style| Series {
            label: label.to_owned(),
            points: points.clone(),
            error: None,
            style,
            colour,
        };
        // The line is named by its markers.
        series.extend([of("", Style::Line), of(method, Style::Markers)]);
    }
    let mut cases = Vec::new();
    for trial in &trials {
        add(&mut cases, &trial.case);
    }
    let mut notes = Vec::new();
    let along = format!("Points of the curves: {}.", cases.join("; "));
    if along.len() <= LONGEST_NOTE {
        notes.push(along);
    }
    if !others.is_empty() {
        notes.push(format!("Not shown are errors relative to {}.", others.join("; ")));
    }
    if !exact.is_empty() {
        notes.push(format!("Without any error, and so not shown: {}.", exact.join("; ")));
    }
    notes.push(format!("{}, {}", document.machine.phrase(), document.date));
    notes.push(document.provenance.line());
    Chart {
        title: format!("Accuracy of {}: speed against error", area.name()),
        x_label: format!("seconds per {}", units.join(" or ")),
        y_label: format!("largest error, relative to {scale}"),
        x_scale: Scale::Log,
        y_scale: Scale::Log,
        series,
        notes,
    }
}

/// Adds what is not there yet.
fn add<'a>(list: &mut Vec<&'a str>, item: &'a str) {
    if !list.contains(&item) {
        list.push(item);
    }
}
