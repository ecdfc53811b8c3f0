//! The report as Markdown: summary, errors and their reasons, then one section per figure.

use std::fmt::Write;

use sphvar_thesis::{Scale, Verdict};

use super::Drawn;
use super::record::VerdictRecord;
use super::summary::{ErratumRows, Summary};
use crate::report::Provenance;

/// Returns the report.
pub(super) fn markdown(
    rows: &[VerdictRecord],
    drawn: &[Drawn],
    scale: Scale,
    provenance: &Provenance,
) -> String {
    let summary = Summary::new(rows);
    let mut text = format!(
        "# The thesis, figure by figure\n\nWritten by `{}` (sphvar {}, seed {}). {} Intervals are of 95 %. Errata have the \
         numbers of sphvar's list of errata of the thesis.\n\n## Summary\n\n{}\n\n| verdict | rows | rule |\n|---|---|---|\n",
        provenance.command,
        provenance.version,
        provenance.seed,
        scale.description(),
        summary.sentence()
    );
    for verdict in Verdict::ALL {
        let (name, rule) = (verdict.name(), verdict.rule());
        line(&mut text, &format!("| {name} | {} | {rule} |", summary.count(verdict)));
    }
    errata(&mut text, &summary);
    for Drawn { figure, .. } in drawn {
        line(&mut text, &format!("\n## Figure {}: {}\n", figure.id, figure.id.title()));
        for note in &figure.notes {
            line(&mut text, &format!("{note}\n"));
        }
        let own = summary.of_figure(figure.id.number());
        if own.is_empty() {
            line(&mut text, "No claim here could have failed.");
        } else {
            claims(&mut text, &own, false);
        }
    }
    let apart = summary.by_construction();
    if !apart.is_empty() {
        line(&mut text, "\n## True by construction\n");
        claims(&mut text, &apart, true);
    }
    text
}

/// Appends the contradicted claims and the other errata that rows refer to, each once.
fn errata(text: &mut String, summary: &Summary<'_>) {
    let (wrong, other): (Vec<_>, Vec<_>) =
        summary.errata().into_iter().partition(ErratumRows::is_wrong);
    if !wrong.is_empty() || !summary.unexplained().is_empty() {
        line(text, "\n## What is wrong, and why\n");
        line(text, "| erratum | where and what | rows: stated, measured |");
        line(text, "|---|---|---|");
        for erratum in &wrong {
            let contradicted = erratum.rows.iter().filter(|row| row.is(Verdict::Wrong));
            let examples: Vec<String> = contradicted.map(|row| example(row)).collect();
            let cells = [erratum.number.to_string(), erratum.title(), examples.join("; ")];
            line(text, &row_of(&cells));
        }
        for row in summary.unexplained() {
            line(
                text,
                &row_of(&["-".to_owned(), "not in the list of errata".to_owned(), example(row)]),
            );
        }
    }
    if !other.is_empty() {
        line(text, "\nOther errata that rows refer to without a contradiction:\n");
        line(text, "| erratum | where and what | figures |");
        line(text, "|---|---|---|");
        for erratum in &other {
            let mut figures: Vec<_> = erratum.rows.iter().map(|row| row.figure).collect();
            figures.dedup();
            let cells = [erratum.number.to_string(), erratum.title(), figures.join(", ")];
            line(text, &row_of(&cells));
        }
    }
}

/// Returns a short description of a row.
fn example(row: &VerdictRecord) -> String {
    format!(
        "Figure {}, {}: stated {}, measured {}",
        row.figure,
        row.what,
        row.stated,
        row.measured_text()
    )
}

fn claims(text: &mut String, rows: &[&VerdictRecord], with_figure: bool) {
    let figure = if with_figure { "| figure " } else { "" };
    let rule = if with_figure { "|---" } else { "" };
    line(
        text,
        &format!("{figure}| what | stated | measured | 95 % | verdict | erratum | remark |"),
    );
    line(text, &format!("{rule}|---|---|---|---|---|---|---|"));
    for row in rows {
        let figure = with_figure.then(|| row.figure.to_owned());
        let cells = [
            row.what.clone(),
            row.stated.clone(),
            row.measured_text(),
            row.interval_text(),
            row.verdict_text(),
            row.erratum_text(),
            row.remark.clone(),
        ];
        let cells: Vec<String> = figure.into_iter().chain(cells).collect();
        line(text, &row_of(&cells));
    }
}

fn row_of(cells: &[String]) -> String {
    let cells: Vec<_> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
    format!("| {} |", cells.join(" | "))
}

fn line(text: &mut String, line: &str) {
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{line}");
}
