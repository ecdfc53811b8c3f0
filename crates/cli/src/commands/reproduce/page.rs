//! A self-contained page with every figure, the table and the provenance.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use sphvar_thesis::{Content, Panel, Scale, Verdict};

use super::Drawn;
use super::folder::OutFolder;
use super::record::VerdictRecord;
use super::summary::{ErratumRows, Summary};
use crate::error::CliError;
use crate::report::Provenance;

/// The style sheet: wide figures, narrow text, light and dark mode, and print.
const STYLE: &str = "
:root { color-scheme: light dark; --ink: #222; --faint: #666; --line: #d9d9d9; --ground: #fff; --soft: #f6f6f4;
  --good: #00694b; --bad: #a64500; }
@media (prefers-color-scheme: dark) { :root { --ink: #e8e8e6; --faint: #a0a09c; --line: #3a3a38; --ground: #161615;
  --soft: #222220; --good: #4fc79a; --bad: #f0965a; } }
body { margin: 0 auto; max-width: 78rem; padding: 1.5rem; background: var(--ground); color: var(--ink);
  font: 16px/1.55 system-ui, sans-serif; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 0 0 .5rem; }
h2 { font-size: 1.25rem; margin: 3rem 0 .5rem; border-top: 1px solid var(--line); padding-top: 1.2rem; }
p, li { max-width: 46rem; }
nav { display: flex; flex-wrap: wrap; gap: .4rem; margin: 1rem 0; }
nav a { border: 1px solid var(--line); border-radius: .3rem; padding: .1rem .5rem; text-decoration: none; color: inherit; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-size: .9rem; }
th, td { text-align: left; vertical-align: top; padding: .3rem .7rem .3rem 0; border-bottom: 1px solid var(--line); }
td.number { white-space: nowrap; font-variant-numeric: tabular-nums; }
.holds { color: var(--good); font-weight: 600; } .wrong { color: var(--bad); font-weight: 600; }
.depends, .undecided, .not-reproduced, .by-construction { color: var(--faint); font-weight: 600; }
.panels { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(32rem, 100%), 1fr)); gap: 1.2rem; margin: 1rem 0;
  align-items: start; }
figure { margin: 0; background: var(--soft); border-radius: .4rem; padding: .6rem; }
figure img { display: block; width: 100%; height: auto; background: #fff; border-radius: .2rem; }
figure.picture img { image-rendering: pixelated; }
figcaption { font-size: .85rem; color: var(--faint); padding: .5rem .2rem 0; }
code { font-size: .9em; }
@media print { nav { display: none; } h2 { break-after: avoid; } figure { break-inside: avoid; } }
";

/// Returns the page as HTML.
pub(super) fn page(
    drawn: &[Drawn],
    claims: &[VerdictRecord],
    folder: &OutFolder,
    scale: Scale,
    provenance: &Provenance,
) -> Result<String, CliError> {
    let summary = Summary::new(claims);
    let mut sections = Vec::new();
    for figure in drawn {
        sections.push(section(figure, &summary, folder)?);
    }
    let markup = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "The thesis, figure by figure" }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header {
                    h1 { "The thesis, figure by figure" }
                    p {
                        "The figures and numbers of G. Singh, "
                        cite { "Sampling and Variance Analysis for Monte Carlo Integration in Spherical Domain" }
                        " (2015), computed again. " (summary.sentence())
                        " " (scale.description()) " Intervals are of 95 %. Errata have the numbers of sphvar's list of errata of the thesis."
                    }
                    p { code { (provenance.command) } " (sphvar " (provenance.version) ", seed " (provenance.seed) ")" }
                    nav aria-label="Figures" {
                        a href="#errata" { "What is wrong" }
                        @for Drawn { figure, .. } in drawn {
                            a href={ "#figure-" (figure.id) } title=(figure.id.title()) { (figure.id) }
                        }
                        a href="#by-construction" { "By construction" }
                    }
                }
                main {
                    (verdict_table(&summary))
                    (errata(&summary))
                    @for section in sections { (section) }
                    section id="by-construction" {
                        h2 { "True by construction" }
                        (claim_table(&summary.by_construction(), true))
                    }
                }
            }
        }
    };
    Ok(markup.into_string())
}

fn section(
    Drawn { figure, files }: &Drawn,
    summary: &Summary<'_>,
    folder: &OutFolder,
) -> Result<Markup, CliError> {
    let mut panels = Vec::new();
    for (panel, files) in figure.panels.iter().zip(files) {
        panels.push(panel_markup(panel, files, folder)?);
    }
    let number = figure.id.number();
    let own = summary.of_figure(number);
    Ok(html! {
        section id={ "figure-" (number) } {
            h2 { "Figure " (number) ": " (figure.id.title()) }
            @for note in &figure.notes { p { (note) } }
            div class="panels" { @for panel in panels { (panel) } }
            @if !own.is_empty() { (claim_table(&own, false)) }
        }
    })
}

fn panel_markup(
    panel: &Panel,
    [picture, numbers]: &[String; 2],
    folder: &OutFolder,
) -> Result<Markup, CliError> {
    let kind = if picture.ends_with(".svg") { "image/svg+xml" } else { "image/png" };
    let source = format!("data:{kind};base64,{}", STANDARD.encode(folder.read(picture)?));
    let (class, caption) = match &panel.content {
        Content::Picture(picture) => ("picture", picture.caption.as_str()),
        _ => ("", ""),
    };
    Ok(html! {
        figure class=(class) {
            img src=(source) alt=(panel.title) loading="lazy";
            figcaption {
                (panel.title) ". " (caption) " "
                a href=(numbers) { "Numbers" }
            }
        }
    })
}

/// Returns every verdict with its number of rows and its rule.
fn verdict_table(summary: &Summary<'_>) -> Markup {
    html! {
        div class="scroll" {
            table {
                thead { tr { th { "Verdict" } th { "Rows" } th { "Rule" } } }
                tbody {
                    @for verdict in Verdict::ALL {
                        tr {
                            td class=(class_of(verdict.name())) { (verdict.name()) }
                            td class="number" { (summary.count(verdict)) }
                            td { (verdict.rule()) }
                        }
                    }
                }
            }
        }
    }
}

/// Returns the contradicted claims by erratum, then the errata that no row contradicts.
fn errata(summary: &Summary<'_>) -> Markup {
    let (wrong, other): (Vec<_>, Vec<_>) =
        summary.errata().into_iter().partition(ErratumRows::is_wrong);
    html! {
        section id="errata" {
            h2 { "What is wrong, and why" }
            (erratum_table(&wrong, |row| row.is(Verdict::Wrong)))
            @let unexplained = summary.unexplained();
            @if !unexplained.is_empty() {
                p { "Wrong, and not in the list of errata:" }
                (claim_table(&unexplained, true))
            }
            @if !other.is_empty() {
                p { "Other errata that rows refer to without a contradiction:" }
                (erratum_table(&other, |_| true))
            }
        }
    }
}

fn erratum_table(errata: &[ErratumRows<'_>], shown: impl Fn(&VerdictRecord) -> bool) -> Markup {
    html! {
        div class="scroll" {
            table {
                thead { tr { th { "Erratum" } th { "Where and what" } th { "Rows" } } }
                tbody {
                    @for erratum in errata {
                        tr {
                            td class="number" { (erratum.number) }
                            td { (erratum.title().replace('`', "")) }
                            td {
                                @for row in erratum.rows.iter().filter(|row| shown(row)) {
                                    a href={ "#figure-" (row.figure) } { (row.figure) } ": " (row.what) ", stated "
                                    (row.stated) ", measured " (row.measured_text()) br;
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Returns the CSS class of a verdict.
fn class_of(verdict: &str) -> String {
    verdict.replace(' ', "-")
}

fn claim_table(claims: &[&VerdictRecord], with_figure: bool) -> Markup {
    html! {
        div class="scroll" {
            table {
                thead {
                    tr {
                        @if with_figure { th { "Figure" } }
                        th { "What" } th { "Stated" } th { "Measured" } th { "95 %" } th { "Verdict" }
                        th { "Erratum" } th { "Remark" }
                    }
                }
                tbody {
                    @for claim in claims {
                        tr {
                            @if with_figure { td { a href={ "#figure-" (claim.figure) } { (claim.figure) } } }
                            td { (claim.what) }
                            td { (claim.stated) }
                            td class=(number_class(claim)) { (claim.measured_text()) }
                            td class=(number_class(claim)) { (claim.interval_text()) }
                            td class=(class_of(claim.outcome.verdict)) { (claim.verdict_text()) }
                            td { (claim.erratum_text()) }
                            td { (claim.remark) }
                        }
                    }
                }
            }
        }
    }
}

/// Returns the CSS class of a cell: a single number is not wrapped, those of several options are.
fn number_class(claim: &VerdictRecord) -> &'static str {
    if claim.choice.is_none() { "number" } else { "" }
}
