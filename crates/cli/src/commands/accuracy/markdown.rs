//! What was measured, as a document.

use sphvar_accuracy::Area;

use super::record::{Document, time, verdict};
use crate::report::short;

impl Document<'_> {
    /// The findings as a document; `charts` are links to the charts of areas.
    pub(super) fn markdown(&self, charts: &[(Area, String)]) -> String {
        let effort = if self.quick { " with smaller inputs than usual" } else { "" };
        let mut text = format!(
            "# Accuracy\n\nMeasured on {} ({}) by sphvar {}{effort}; this file was written by\n\n\
             ```text\n{}\n```\n\n{INTRODUCTION}",
            self.date,
            self.machine.phrase(),
            self.version,
            self.provenance.command,
        );
        for area in self.areas() {
            text += &self.area(area, charts);
        }
        text += &self.edge();
        let broken = self.trials.iter().filter(|t| !t.held).count()
            + self.hard_cases.iter().filter(|c| !c.held).count();
        let bounds = self.trials.len() + self.hard_cases.len();
        text + &format!("\n{} of {bounds} bounds are held.\n", bounds - broken)
    }

    fn area(&self, area: Area, charts: &[(Area, String)]) -> String {
        let mut text = String::new();
        let rows: Vec<_> = self
            .trials_of(area)
            .map(|t| {
                [
                    t.method.clone(),
                    t.case.clone(),
                    time(t.seconds_per_unit, t.unit),
                    short(t.error),
                    short(t.rms),
                    short(t.bound),
                    verdict(t.held).to_owned(),
                    t.relative_to.to_owned(),
                    t.reference.to_owned(),
                    t.worst.clone(),
                ]
            })
            .collect();
        if rows.is_empty() {
            return text;
        }
        text += &format!("\n## {}\n\n", capital(area.name()));
        for (_, link) in charts.iter().filter(|(of, _)| *of == area) {
            text += &format!("![Largest error against time, {}]({link})\n\n", area.name());
        }
        let heading = [
            "method",
            "case",
            "time",
            "largest error",
            "rms",
            "bound",
            "held",
            "relative to",
            "reference",
            "worst case",
        ];
        text + &pipe_table(&heading, &rows, 2..6)
    }

    fn edge(&self) -> String {
        let rows: Vec<_> = self
            .hard_cases
            .iter()
            .map(|c| {
                [
                    format!("`{}`", c.name),
                    short(c.error),
                    short(c.bound),
                    verdict(c.held).to_owned(),
                    c.what.to_owned(),
                    c.reason.to_owned(),
                    c.worst.clone(),
                ]
            })
            .collect();
        if rows.is_empty() {
            return String::new();
        }
        let heading =
            ["name", "largest error", "bound", "held", "what", "why this bound", "worst case"];
        format!("\n## Hard cases\n\n{HARD_CASES}\n{}", pipe_table(&heading, &rows, 1..3))
    }
}

const INTRODUCTION: &str = "\
Every method is timed (the median of several runs that take 0.1 s together at least) and compared with a reference that is
better than it. `bound` is what the largest error must not exceed; where a method promises an accuracy, it is
that. EPSILON is 2.2e-16. Times are those of this machine and of nothing else; errors are nearly the same everywhere.
";

const HARD_CASES: &str = "\
Inputs at the edge of what numbers can hold. Each is also a test of this name in `crates/accuracy/tests/hard_cases`.
";

fn capital(word: &str) -> String {
    let mut letters = word.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// A table in pipes; the `right` columns are numbers.
fn pipe_table<const N: usize>(
    heading: &[&str; N],
    rows: &[[String; N]],
    right: std::ops::Range<usize>,
) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let rule = (0..N).map(|i| if right.contains(&i) { "--:" } else { "---" }.to_owned());
    let mut text = line(&heading.map(str::to_owned)) + &line(&rule.collect::<Vec<_>>());
    for row in rows {
        text += &line(&row.clone().map(|cell| cell.replace('|', "\\|")));
    }
    text
}
