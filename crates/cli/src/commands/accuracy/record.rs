//! What was measured, for people and for scripts.

use serde::Serialize;
use sphvar_accuracy::{Area, Errors, HardCase, Trial};
use std::borrow::Cow;

use super::figures::{figure, time, verdict};
use super::machine::Machine;
use crate::error::CliError;
use crate::report::{Provenance, full, table};

/// The document of `--json`.
#[derive(Debug, Serialize)]
pub(super) struct Document<'a> {
    /// Whether every largest error is within its bound.
    pub(super) held: bool,
    pub(super) quick: bool,
    /// UTC, YYYY-MM-DD.
    pub(super) date: String,
    pub(super) version: Cow<'static, str>,
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
    #[serde(flatten)]
    pub(super) outcome: Outcome,
    pub(super) relative_to: &'static str,
    pub(super) reference: &'static str,
}

/// A hard case as scripts see it.
#[derive(Debug, Serialize)]
pub(super) struct HardCaseRecord {
    pub(super) area: &'static str,
    pub(super) name: &'static str,
    pub(super) what: &'static str,
    #[serde(flatten)]
    pub(super) outcome: Outcome,
    pub(super) reason: &'static str,
}

/// Errors beside their bound.
#[derive(Debug, Serialize)]
pub(super) struct Outcome {
    /// The largest; null in JSON if it is infinite, as is that of what is not a number.
    pub(super) error: f64,
    pub(super) rms: f64,
    /// Where the largest error is.
    pub(super) worst: String,
    /// How many errors were looked at.
    pub(super) compared: u64,
    pub(super) bound: f64,
    pub(super) held: bool,
}

impl Outcome {
    /// A comparison of nothing holds no bound; of errors that are all 0 none is the worst.
    fn new(errors: &Errors, bound: f64) -> Self {
        let (error, compared) = (errors.max(), errors.count());
        let worst = if error > 0.0 { errors.worst() } else { "-" };
        Self {
            error,
            rms: errors.rms(),
            worst: worst.to_owned(),
            compared,
            bound,
            held: compared > 0 && error <= bound,
        }
    }
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
            outcome: Outcome::new(errors, trial.bound),
            relative_to: trial.relative_to,
            reference: trial.reference,
        }
    }
}

impl TrialRecord {
    /// The heading of [`Self::cells`].
    pub(super) const HEADING: [&str; 7] =
        ["method", "case", "time", "largest error", "rms", "bound", "held"];

    /// A row of a table for people.
    pub(super) fn cells(&self) -> [String; 7] {
        [
            self.method.clone(),
            self.case.clone(),
            time(self.seconds_per_unit, self.unit),
            figure(self.outcome.error),
            figure(self.outcome.rms),
            figure(self.outcome.bound),
            verdict(self.outcome.held).to_owned(),
        ]
    }
}

impl HardCaseRecord {
    pub(super) fn new(area: Area, case: &HardCase, errors: &Errors) -> Self {
        Self {
            area: area.name(),
            name: case.name,
            what: case.what,
            outcome: Outcome::new(errors, case.bound),
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
            let numbers = [
                full(t.seconds_per_unit),
                t.unit.to_owned(),
                full(t.outcome.error),
                full(t.outcome.rms),
            ];
            let bound =
                [t.outcome.compared.to_string(), full(t.outcome.bound), t.outcome.held.to_string()];
            let rest = [t.relative_to, t.reference, &t.outcome.worst].map(str::to_owned);
            [&words[..], &numbers, &bound, &rest].concat()
        });
        let cases = self.hard_cases.iter().map(|c| {
            let words = ["hard case", c.area, c.name, ""].map(str::to_owned);
            let numbers =
                [String::new(), String::new(), full(c.outcome.error), full(c.outcome.rms)];
            let bound =
                [c.outcome.compared.to_string(), full(c.outcome.bound), c.outcome.held.to_string()];
            let rest = [c.what, c.reason, &c.outcome.worst].map(str::to_owned);
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

    /// The trials of an area by what their errors are relative to and compared with.
    pub(super) fn groups_of(&self, area: Area) -> Vec<Vec<&TrialRecord>> {
        let mut groups: Vec<Vec<&TrialRecord>> = Vec::new();
        for trial in self.trials_of(area) {
            let key = (trial.relative_to, trial.reference);
            match groups.iter_mut().find(|g| (g[0].relative_to, g[0].reference) == key) {
                Some(group) => group.push(trial),
                None => groups.push(vec![trial]),
            }
        }
        groups
    }

    /// The tables for people.
    pub(super) fn text(&self) -> String {
        let mut text = String::new();
        for area in self.areas() {
            for group in self.groups_of(area) {
                let TrialRecord { relative_to, reference, .. } = group[0];
                text += &format!(
                    "{}: errors relative to {relative_to}; reference: {reference}\n",
                    area.name()
                );
                let rows = group.iter().map(|trial| trial.cells().to_vec()).collect();
                text += &format!("{}\n", table(&TrialRecord::HEADING, rows, 2));
            }
        }
        let rows: Vec<_> = self
            .hard_cases
            .iter()
            .map(|c| {
                let name = c.name.replace('_', " ");
                vec![
                    name,
                    figure(c.outcome.error),
                    figure(c.outcome.bound),
                    verdict(c.outcome.held).to_owned(),
                ]
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
        let trials = self.trials.iter().filter(|t| !t.outcome.held);
        let cases = self.hard_cases.iter().filter(|c| !c.outcome.held);
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

#[cfg(test)]
mod tests {
    use super::*;

    fn errors(sizes: &[f64]) -> Errors {
        let mut errors = Errors::default();
        for &size in sizes {
            errors.push(size, || "here".to_owned());
        }
        errors
    }

    fn case(measured: &[f64]) -> HardCaseRecord {
        let case = HardCase {
            name: "a_hard_case",
            what: "something",
            bound: 0.5,
            reason: "it is so",
            measure: Errors::default,
        };
        HardCaseRecord::new(Area::Indexing, &case, &errors(measured))
    }

    #[test]
    fn bounds_that_are_not_held_are_named() {
        let provenance = Provenance { command: String::new(), version: "0".into(), seed: 0 };
        for (measured, holds) in [
            (&[0.5, -0.25][..], true),
            (&[0.25, -0.6], false),
            (&[0.25, f64::NAN], false),
            (&[f64::INFINITY], false),
            (&[], false),
        ] {
            let cases = [case(&[0.0]), case(measured)];
            assert_eq!(cases[1].outcome.held, holds, "{measured:?}");
            let document = Document {
                held: holds,
                quick: true,
                date: String::new(),
                version: "0".into(),
                machine: Machine { cpu: String::new(), cores: 1, threads: 1 },
                trials: &[],
                hard_cases: &cases,
                provenance: &provenance,
            };
            match document.verdict() {
                Ok(()) => assert!(holds, "{measured:?}"),
                Err(error) => {
                    assert!(!holds, "{measured:?}");
                    assert_eq!(error.status(), 1);
                    let text = error.to_string();
                    assert!(text.contains("1 of 2") && text.contains("a_hard_case"), "{text}");
                }
            }
            let word = if holds { "yes" } else { "NO" };
            assert!(document.text().contains(word), "{}", document.text());
        }
    }
}
