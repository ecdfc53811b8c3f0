//! What was measured, for people and for scripts.

use serde::Serialize;
use sphvar_accuracy::{Area, Errors, HardCase, Trial};

use super::machine::Machine;
use crate::error::CliError;
use crate::report::{Provenance, full, short, table};

/// The document of `--json`.
#[derive(Debug, Serialize)]
pub(super) struct Document<'a> {
    /// Whether every largest error is within its bound.
    pub(super) held: bool,
    pub(super) quick: bool,
    /// UTC, YYYY-MM-DD.
    pub(super) date: String,
    pub(super) version: &'static str,
    pub(super) machine: Machine,
    pub(super) trials: &'a [TrialRecord],
    pub(super) hard_cases: &'a [HardCaseRecord],
    pub(super) provenance: &'a Provenance,
}

/// A trial as scripts see it.
#[derive(Debug, Serialize)]
pub(super) struct TrialRecord {
    pub(super) area: &'static str,
    pub(super) method: String,
    pub(super) case: String,
    pub(super) unit: &'static str,
    /// How many units a run computes.
    pub(super) count: f64,
    /// The median of the runs, divided by the count.
    pub(super) seconds_per_unit: f64,
    /// The largest; null in JSON if it is infinite, as is that of what is not a number.
    pub(super) error: f64,
    pub(super) rms: f64,
    /// Where the largest error is.
    pub(super) worst: String,
    /// How many errors were looked at.
    pub(super) compared: u64,
    pub(super) bound: f64,
    pub(super) held: bool,
    pub(super) relative_to: &'static str,
    pub(super) reference: &'static str,
}

/// A hard case as scripts see it.
#[derive(Debug, Serialize)]
pub(super) struct HardCaseRecord {
    pub(super) area: &'static str,
    pub(super) name: &'static str,
    pub(super) what: &'static str,
    pub(super) error: f64,
    pub(super) rms: f64,
    pub(super) worst: String,
    pub(super) compared: u64,
    pub(super) bound: f64,
    pub(super) held: bool,
    pub(super) reason: &'static str,
}

/// A comparison of nothing holds no bound.
fn held(errors: &Errors, bound: f64) -> bool {
    errors.count() > 0 && errors.max() <= bound
}

/// Of errors that are all 0 none is the worst.
fn worst(errors: &Errors) -> String {
    if errors.max() > 0.0 { errors.worst().to_owned() } else { "-".to_owned() }
}

impl TrialRecord {
    pub(super) fn new(trial: &Trial, seconds: f64, errors: &Errors) -> Self {
        Self {
            area: trial.area.name(),
            method: trial.method.clone(),
            case: trial.case.clone(),
            unit: trial.unit,
            count: trial.count,
            seconds_per_unit: seconds / trial.count,
            error: errors.max(),
            rms: errors.rms(),
            worst: worst(errors),
            compared: errors.count(),
            bound: trial.bound,
            held: held(errors, trial.bound),
            relative_to: trial.relative_to,
            reference: trial.reference,
        }
    }
}

impl HardCaseRecord {
    pub(super) fn new(area: Area, case: &HardCase, errors: &Errors) -> Self {
        Self {
            area: area.name(),
            name: case.name,
            what: case.what,
            error: errors.max(),
            rms: errors.rms(),
            worst: worst(errors),
            compared: errors.count(),
            bound: case.bound,
            held: held(errors, case.bound),
            reason: case.reason,
        }
    }
}

impl Document<'_> {
    /// The heading of [`Self::rows`].
    pub(super) const COLUMNS: &'static str = "kind,area,name,case,seconds_per_unit,unit,error,rms,compared,bound,held,relative_to,reference,worst";

    /// The rows of a CSV file: the trials and the hard cases.
    pub(super) fn rows(&self) -> Vec<Vec<String>> {
        let trials = self.trials.iter().map(|t| {
            let words = ["trial", t.area, &t.method, &t.case].map(str::to_owned);
            let numbers = [full(t.seconds_per_unit), t.unit.to_owned(), full(t.error), full(t.rms)];
            let bound = [t.compared.to_string(), full(t.bound), t.held.to_string()];
            let rest = [t.relative_to, t.reference, &t.worst].map(str::to_owned);
            [&words[..], &numbers, &bound, &rest].concat()
        });
        let cases = self.hard_cases.iter().map(|c| {
            let words = ["hard case", c.area, c.name, ""].map(str::to_owned);
            let numbers = [String::new(), String::new(), full(c.error), full(c.rms)];
            let bound = [c.compared.to_string(), full(c.bound), c.held.to_string()];
            let rest = [c.what, c.reason, &c.worst].map(str::to_owned);
            [&words[..], &numbers, &bound, &rest].concat()
        });
        trials.chain(cases).collect()
    }

    pub(super) fn trials_of(&self, area: Area) -> impl Iterator<Item = &TrialRecord> {
        self.trials.iter().filter(move |trial| trial.area == area.name())
    }

    /// The areas that were measured.
    pub(super) fn areas(&self) -> impl Iterator<Item = Area> {
        Area::ALL.into_iter().filter(|&area| {
            self.trials_of(area).next().is_some()
                || self.hard_cases.iter().any(|case| case.area == area.name())
        })
    }

    /// The tables for people.
    pub(super) fn text(&self) -> String {
        let mut text = String::new();
        for area in self.areas() {
            let rows: Vec<_> = self
                .trials_of(area)
                .map(|t| {
                    vec![
                        t.method.clone(),
                        t.case.clone(),
                        time(t.seconds_per_unit, t.unit),
                        short(t.error),
                        short(t.rms),
                        short(t.bound),
                        verdict(t.held).to_owned(),
                        t.relative_to.to_owned(),
                    ]
                })
                .collect();
            if !rows.is_empty() {
                let heading = [
                    "method",
                    "case",
                    "time",
                    "largest error",
                    "rms",
                    "bound",
                    "held",
                    "relative to",
                ];
                text += &format!("{}\n{}\n", area.name(), table(&heading, rows, 2));
            }
        }
        let rows: Vec<_> = self
            .hard_cases
            .iter()
            .map(|c| {
                let name = c.name.replace('_', " ");
                vec![name, short(c.error), short(c.bound), verdict(c.held).to_owned()]
            })
            .collect();
        if !rows.is_empty() {
            let heading = ["hard case", "largest error", "bound", "held"];
            text += &format!("{}\n", table(&heading, rows, 1));
        }
        text + &format!("{}, {}\n", self.machine.phrase(), self.date)
    }

    /// An error that names the bounds that are not held, if there are any.
    pub(super) fn verdict(&self) -> Result<(), CliError> {
        let trials = self.trials.iter().filter(|t| !t.held);
        let cases = self.hard_cases.iter().filter(|c| !c.held);
        let broken: Vec<String> = trials
            .map(|t| format!("{} ({})", t.method, t.case))
            .chain(cases.map(|c| c.name.to_owned()))
            .collect();
        if broken.is_empty() {
            return Ok(());
        }
        Err(CliError::Failed(format!(
            "{} of {} bounds are not held: {}",
            broken.len(),
            self.trials.len() + self.hard_cases.len(),
            broken.join("; ")
        )))
    }
}

/// Whether a bound is held, in a word.
pub(super) fn verdict(held: bool) -> &'static str {
    if held { "yes" } else { "NO" }
}

/// A time for each unit, in the fitting part of a second.
pub(super) fn time(seconds: f64, unit: &str) -> String {
    let (number, name) = match seconds {
        s if s >= 1.0 => (s, "s"),
        s if s >= 1e-3 => (1e3 * s, "ms"),
        s if s >= 1e-6 => (1e6 * s, "us"),
        s => (1e9 * s, "ns"),
    };
    // Units are plurals: one of the points.
    let one = unit.strip_suffix('s').unwrap_or(unit);
    format!("{number:.3} {name}/{one}")
}
