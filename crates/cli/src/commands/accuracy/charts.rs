//! Charts of error against time.

use sphvar_accuracy::Area;

use super::record::{AccuracyBody, TrialRecord, singular};
use crate::plots::{Chart, Ink, Panel, Scale, Series, Spread, Style};
use crate::report::Provenance;

/// Returns the file name of an area's chart in a folder of charts.
pub(super) fn chart_name(area: Area) -> String {
    format!("accuracy-{}.svg", area.name())
}

/// The approximate number of letters in a line of a chart's notes.
const LINE: usize = 150;
/// With more cases than this, the notes leave the list to the table.
const MAX_CASES: usize = 12;

/// Returns the chart of the largest error against the time per unit, with a curve for each method.
pub(super) fn area_chart(area: Area, body: &AccuracyBody, provenance: &Provenance) -> Chart {
    let (mut methods, mut units, mut scales, mut cases, mut exact) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let trials: Vec<&TrialRecord> = body.trials_of(area).collect();
    for trial in &trials {
        add(&mut units, singular(trial.unit));
        add(&mut scales, trial.relative_to);
        if trial.outcome.error > 0.0 {
            add(&mut methods, &trial.method);
            add(&mut cases, &trial.case);
        } else {
            add(&mut exact, &trial.method);
        }
    }
    exact.retain(|method| !methods.contains(method));
    let mut series = Vec::new();
    for (rank, method) in methods.iter().enumerate() {
        let own = trials.iter().filter(|trial| trial.method == *method);
        series.push(Series {
            label: (*method).to_owned(),
            points: own.map(|trial| (trial.seconds_per_unit, trial.outcome.error)).collect(),
            spread: Spread::None,
            style: Style::Joined,
            ink: Ink::Rank(rank),
        });
    }
    let mut notes = lines("Errors are relative to", &scales);
    if cases.len() <= MAX_CASES {
        notes.extend(lines("Points of the curves:", &cases));
    }
    if !exact.is_empty() {
        notes.extend(lines("Not shown, because the error is 0:", &exact));
    }
    notes.push(format!("{}, {}", body.machine.phrase(), body.date));
    notes.push(provenance.line());
    Chart {
        title: format!("Accuracy of {}: speed against error", area.name()),
        x_label: format!("seconds per {}", units.join(" or ")),
        x_scale: Scale::Log,
        panels: vec![Panel::log("largest error", series)],
        notes,
    }
}

/// Returns a list with its heading, wrapped to lines.
fn lines(of: &str, items: &[&str]) -> Vec<String> {
    let mut lines = vec![of.to_owned()];
    for (i, item) in items.iter().enumerate() {
        let end = if i + 1 < items.len() { ";" } else { "." };
        match lines.last_mut() {
            Some(line) if line.len() + item.len() < LINE => *line += &format!(" {item}{end}"),
            _ => lines.push(format!("{item}{end}")),
        }
    }
    lines
}

/// Adds an item that is not in the list yet.
fn add<'a>(list: &mut Vec<&'a str>, item: &'a str) {
    if !list.contains(&item) {
        list.push(item);
    }
}
