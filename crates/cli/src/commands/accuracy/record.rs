//! Records of the results, for tables, CSV and JSON.

use schemars::JsonSchema;
use serde::Serialize;
use sphvar_accuracy::{Area, Errors, HardCase, Trial};
use std::borrow::Cow;

use super::machine::Machine;
use crate::error::CliError;
use crate::report::{Column, Provenance, csv_of, number, table_of};

/// Measured errors and times: `accuracy --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct AccuracyBody {
    /// Whether every largest error is within its bound.
    pub(super) held: bool,
    /// Whether inputs are smaller than by default, as requested with `--quick`.
    pub(super) quick: bool,
    /// The date in UTC, as YYYY-MM-DD.
    pub(super) date: String,
    /// The version of sphvar.
    pub(super) version: Cow<'static, str>,
    /// The machine on which the times were measured.
    pub(super) machine: Machine,
    /// Methods with their errors and times.
    pub(super) trials: Vec<TrialRecord>,
    /// Extreme inputs with their errors.
    pub(super) hard_cases: Vec<HardCaseRecord>,
}

/// One method on one input.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct TrialRecord {
    /// The area: `harmonics`, `indexing`, `transforms`, `spectra`, `predictions` or `quality`.
    pub(super) area: &'static str,
    /// The method.
    pub(super) method: String,
    /// The input.
    pub(super) case: String,
    /// The unit that a run computes, in the plural.
    pub(super) unit: &'static str,
    /// The number of units that a run computes.
    pub(super) count: f64,
    /// The median time of the runs divided by the count, in seconds.
    pub(super) seconds_per_unit: f64,
    #[serde(flatten)]
    pub(super) outcome: Outcome,
    /// The quantity to which errors are relative.
    pub(super) relative_to: &'static str,
    /// The reference values.
    pub(super) reference: &'static str,
}

/// An extreme input.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct HardCaseRecord {
    /// The area, as for trials.
    pub(super) area: &'static str,
    /// The name, also that of a test.
    pub(super) name: &'static str,
    /// The measured quantity, in words.
    pub(super) what: &'static str,
    #[serde(flatten)]
    pub(super) outcome: Outcome,
    /// The origin of the bound.
    pub(super) reason: &'static str,
}

/// Errors and their bound.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Outcome {
    /// The largest error; null if it is infinite or a value is NaN.
    #[schemars(with = "Option<f64>")]
    pub(super) error: f64,
    /// The root mean square.
    #[schemars(with = "Option<f64>")]
    pub(super) rms: f64,
    /// The number of errors.
    pub(super) compared: u64,
    /// The bound of the largest error.
    pub(super) bound: f64,
    /// Whether the largest error is within the bound.
    pub(super) held: bool,
    /// The location of the largest error.
    pub(super) worst: String,
}

/// A trial or an extreme input, a row of CSV; extreme inputs have neither case nor time.
#[derive(Serialize, JsonSchema)]
struct OutcomeRow<'a> {
    kind: &'static str,
    area: &'static str,
    name: &'a str,
    case: Option<&'a str>,
    seconds_per_unit: Option<f64>,
    unit: Option<&'static str>,
    #[serde(flatten)]
    outcome: &'a Outcome,
    relative_to: &'static str,
    reference: &'static str,
}

impl<'a> From<&'a TrialRecord> for OutcomeRow<'a> {
    fn from(trial: &'a TrialRecord) -> Self {
        Self {
            kind: "trial",
            area: trial.area,
            name: &trial.method,
            case: Some(&trial.case),
            seconds_per_unit: Some(trial.seconds_per_unit),
            unit: Some(trial.unit),
            outcome: &trial.outcome,
            relative_to: trial.relative_to,
            reference: trial.reference,
        }
    }
}

impl<'a> From<&'a HardCaseRecord> for OutcomeRow<'a> {
    fn from(case: &'a HardCaseRecord) -> Self {
        Self {
            kind: "hard case",
            area: case.area,
            name: case.name,
            case: None,
            seconds_per_unit: None,
            unit: None,
            outcome: &case.outcome,
            relative_to: case.what,
            reference: case.reason,
        }
    }
}

impl Outcome {
    /// Returns whether the bound holds, in a word.
    pub(super) fn word(&self) -> &'static str {
        if self.held { "yes" } else { "NO" }
    }

    /// An empty comparison does not satisfy the bound. If all errors are 0, no case is the worst.
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
    /// Returns the columns of a table.
    pub(super) fn columns() -> Vec<Column<'static, Self>> {
        vec![
            Column::text("method", |t: &Self| t.method.clone()),
            Column::text("case", |t: &Self| t.case.clone()),
            Column::number("time", |t: &Self| {
                format!("{}/{}", number::seconds(t.seconds_per_unit), singular(t.unit))
            }),
            Column::number("largest error", |t: &Self| number::ratio(t.outcome.error)),
            Column::number("rms", |t: &Self| number::ratio(t.outcome.rms)),
            Column::number("bound", |t: &Self| number::ratio(t.outcome.bound)),
            Column::text("held", |t: &Self| t.outcome.word().to_owned()),
        ]
    }
}

impl HardCaseRecord {
    /// Returns the columns of a table.
    pub(super) fn columns() -> Vec<Column<'static, Self>> {
        vec![
            Column::text("hard case", |c: &Self| c.name.replace('_', " ")),
            Column::number("largest error", |c: &Self| number::ratio(c.outcome.error)),
            Column::number("bound", |c: &Self| number::ratio(c.outcome.bound)),
            Column::text("held", |c: &Self| c.outcome.word().to_owned()),
        ]
    }

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

impl AccuracyBody {
    /// Returns CSV with a row for each trial and extreme input.
    pub(super) fn csv(&self, provenance: &Provenance) -> Result<String, CliError> {
        let trials = self.trials.iter().map(OutcomeRow::from);
        let cases = self.hard_cases.iter().map(OutcomeRow::from);
        csv_of(provenance, &trials.chain(cases).collect::<Vec<_>>())
    }

    pub(super) fn trials_of(&self, area: Area) -> impl Iterator<Item = &TrialRecord> {
        self.trials.iter().filter(move |trial| trial.area == area.name())
    }

    /// Returns the areas that were measured.
    pub(super) fn areas(&self) -> impl Iterator<Item = Area> {
        Area::ALL.into_iter().filter(|&area| {
            self.trials_of(area).next().is_some()
                || self.hard_cases.iter().any(|case| case.area == area.name())
        })
    }

    /// Returns the trials of an area, grouped by what their errors are relative to and compared
    /// with.
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

    /// Returns the tables for the terminal.
    pub(super) fn text(&self) -> String {
        let mut text = String::new();
        for area in self.areas() {
            for group in self.groups_of(area) {
                let TrialRecord { relative_to, reference, .. } = group[0];
                text += &format!(
                    "{}: errors relative to {relative_to}; reference: {reference}\n",
                    area.name()
                );
                text += &format!("{}\n", table_of(&TrialRecord::columns(), group));
            }
        }
        if !self.hard_cases.is_empty() {
            text += &format!("{}\n", table_of(&HardCaseRecord::columns(), &self.hard_cases));
        }
        text + &format!("{}, {}\n", self.machine.phrase(), self.date)
    }

    /// Returns an error that names the violated bounds, if there are any.
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
            "{} of {} bounds are exceeded: {}",
            broken.len(),
            self.trials.len() + self.hard_cases.len(),
            broken.join("; ")
        )))
    }
}

/// Returns the singular of a unit, whose name is a plural.
pub(super) fn singular(unit: &str) -> &str {
    unit.strip_suffix('s').unwrap_or(unit)
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
        for (measured, holds) in [
            (&[0.5, -0.25][..], true),
            (&[0.25, -0.6], false),
            (&[0.25, f64::NAN], false),
            (&[f64::INFINITY], false),
            (&[], false),
        ] {
            let cases = vec![case(&[0.0]), case(measured)];
            assert_eq!(cases[1].outcome.held, holds, "{measured:?}");
            let document = AccuracyBody {
                held: holds,
                quick: true,
                date: String::new(),
                version: "0".into(),
                machine: Machine { cpu: String::new(), cores: 1, threads: 1 },
                trials: Vec::new(),
                hard_cases: cases,
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
