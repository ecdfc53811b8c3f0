//! The results as a Markdown document.

use sphvar_accuracy::Area;

use super::record::{AccuracyBody, HardCaseRecord, TrialRecord};
use crate::report::{Column, Provenance};

impl AccuracyBody {
    /// Returns the results as a document; `charts` are links to the charts of areas.
    pub(super) fn markdown(&self, charts: &[(Area, String)], provenance: &Provenance) -> String {
        let effort = if self.quick { " with smaller inputs than by default" } else { "" };
        let mut text = format!(
            "# Accuracy\n\nMeasured on {} ({}) by sphvar {}{effort}; this file was written by\n\n\
             ```text\n{}\n```\n\n{INTRODUCTION}",
            self.date,
            self.machine.phrase(),
            self.version,
            provenance.command,
        );
        for area in self.areas() {
            text += &self.area(area, charts);
        }
        text += &self.edge();
        let broken = self.trials.iter().filter(|t| !t.outcome.held).count()
            + self.hard_cases.iter().filter(|c| !c.outcome.held).count();
        let bounds = self.trials.len() + self.hard_cases.len();
        text + &format!("\n{} of {bounds} bounds hold.\n", bounds - broken)
    }

    fn area(&self, area: Area, charts: &[(Area, String)]) -> String {
        let groups = self.groups_of(area);
        if groups.is_empty() {
            return String::new();
        }
        let mut text = format!("\n## {}\n", capital(area.name()));
        for (_, link) in charts.iter().filter(|(of, _)| *of == area) {
            text += &format!("\n![Largest error against time, {}]({link})\n", area.name());
        }
        for group in groups {
            let TrialRecord { relative_to, reference, .. } = group[0];
            text += &format!("\nErrors relative to {relative_to}; reference: {reference}.\n\n");
            let mut columns = TrialRecord::columns();
            columns.push(Column::text("worst case", |t: &TrialRecord| t.outcome.worst.clone()));
            text += &pipe_table(&columns, group);
        }
        text
    }

    fn edge(&self) -> String {
        if self.hard_cases.is_empty() {
            return String::new();
        }
        let mut columns = HardCaseRecord::columns();
        columns[0] = Column::text("name", |c: &HardCaseRecord| format!("`{}`", c.name));
        columns.push(Column::text("worst case", |c: &HardCaseRecord| c.outcome.worst.clone()));
        let mut text = format!("\n## Hard cases\n\n{HARD_CASES}\n");
        text += &pipe_table(&columns, &self.hard_cases);
        text += "\nMeasured quantity and origin of the bound:\n\n";
        // Adjacent groups with the same text share it.
        for group in self.hard_cases.chunk_by(|a, b| (a.what, a.reason) == (b.what, b.reason)) {
            let names: Vec<String> = group.iter().map(|c| format!("`{}`", c.name)).collect();
            text += &format!(
                "- {}: {}. Bound: {}.\n",
                names.join(", "),
                group[0].what,
                group[0].reason
            );
        }
        text
    }
}

const INTRODUCTION: &str = "\
Every method is timed (the median of several runs that together take at least 0.1 s) and compared with a more accurate
reference. `bound` limits the largest error; it is the documented accuracy of the method if there is one. A transform to
coefficients has one error, a norm of all differences, so its rms equals its largest error. EPSILON is 2.2e-16. Times
hold for this machine only; errors are nearly the same on all machines.
";

const HARD_CASES: &str = "\
Extreme inputs at the limits of floating-point numbers. Each is also a test of this name in `crates/accuracy/tests/hard_cases`.
";

fn capital(word: &str) -> String {
    let mut letters = word.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// Returns a table in pipes with a row for each record.
fn pipe_table<'r, R: 'r>(
    columns: &[Column<'_, R>],
    records: impl IntoIterator<Item = &'r R>,
) -> String {
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let names = columns.iter().map(|column| column.heading().to_owned()).collect();
    let rule = |column: &Column<'_, R>| if column.is_number() { "--:" } else { "---" }.to_owned();
    let mut text = line(names) + &line(columns.iter().map(rule).collect());
    for record in records {
        text += &line(columns.iter().map(|c| c.cell(record).replace('|', "\\|")).collect());
    }
    text
}
