//! Charts of error against time.

use sphvar_accuracy::Area;

use super::record::{AccuracyBody, TrialRecord, singular};
use crate::plots::{Chart, Ink, Panel, Scale, Series, Spread, Style};
use crate::report::Provenance;

/// The name of an area's chart in a folder of charts.
pub(super) fn chart_name(area: Area) -> String {
    format!("accuracy-{}.svg", area.name())
}

/// A line of a chart's notes has room for about as many letters.
const LINE: usize = 150;
/// More cases than this are for the table to tell.
const MOST_CASES: usize = 12;

/// Largest error against time per unit, a curve for each method through its cases.
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
    if cases.len() <= MOST_CASES {
        notes.extend(lines("Points of the curves:", &cases));
    }
    if !exact.is_empty() {
        notes.extend(lines("Without any error, and so not shown:", &exact));
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

/// A list with what it is a list of, in as many lines as it takes.
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

/// Adds what is not there yet.
fn add<'a>(list: &mut Vec<&'a str>, item: &'a str) {
    if !list.contains(&item) {
        list.push(item);
    }
}
