//! Charts of error against time.

use sphvar_accuracy::Area;

use super::record::{Document, TrialRecord};
use crate::plots::{Chart, Scale, Series, Style};

/// The name of an area's chart in a folder of charts.
pub(super) fn chart_name(area: Area) -> String {
    format!("accuracy-{}.svg", area.name())
}

/// Largest error against time per unit, a curve for each method through its cases.
pub(super) fn area_chart(area: Area, document: &Document<'_>) -> Chart {
    let trials: Vec<&TrialRecord> = document.trials_of(area).collect();
    let mut methods: Vec<&str> = Vec::new();
    let (mut units, mut scales, mut exact) = (Vec::new(), Vec::new(), Vec::new());
    for trial in &trials {
        add(&mut units, trial.unit);
        if trial.error > 0.0 {
            add(&mut methods, &trial.method);
            add(&mut scales, trial.relative_to);
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
    let mut notes = vec![format!("Errors are relative to {}.", scales.join(" or "))];
    if !exact.is_empty() {
        notes.push(format!("Without any error, and so not shown: {}.", exact.join("; ")));
    }
    notes.push(format!("{}, {}", document.machine.phrase(), document.date));
    notes.push(document.provenance.line());
    Chart {
        title: format!("Accuracy of {}: speed against error", area.name()),
        x_label: format!("seconds per one of the {}", units.join(" or ")),
        y_label: "largest error".to_owned(),
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
