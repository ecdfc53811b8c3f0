//! What the thesis says beside what is found, as a table.

use serde::Serialize;
use sphvar_thesis::{Claim, Stated, Verdict};

use super::Drawn;
use crate::report::{Provenance, full, table};

/// A row of the table.
#[derive(Clone, Debug, Serialize)]
pub(super) struct VerdictRecord {
    pub(super) figure: &'static str,
    pub(super) what: String,
    /// What the thesis says.
    pub(super) stated: String,
    pub(super) found: Option<f64>,
    /// Of 95 %.
    pub(super) interval: Option<(f64, f64)>,
    pub(super) verdict: &'static str,
    /// The number in the table of errata.
    pub(super) erratum: Option<u8>,
    pub(super) remark: String,
}

/// All claims of all figures, in their order.
pub(super) fn records(drawn: &[Drawn]) -> Vec<VerdictRecord> {
    let of = |Drawn { figure, .. }: &Drawn| -> Vec<VerdictRecord> {
        figure.claims.iter().map(|claim| VerdictRecord::new(figure.id.number(), claim)).collect()
    };
    drawn.iter().flat_map(of).collect()
}

impl VerdictRecord {
    /// The heading of the CSV form.
    pub(super) const HEADING: &'static str =
        "figure,what,thesis,found,low,high,verdict,erratum,remark";

    fn new(figure: &'static str, claim: &Claim) -> Self {
        Self {
            figure,
            what: claim.what.clone(),
            stated: stated(&claim.stated),
            found: claim.found.map(|found| found.value),
            interval: claim.found.map(|found| found.interval),
            verdict: claim.verdict.name(),
            erratum: claim.erratum,
            remark: claim.remark.clone(),
        }
    }

    /// What is found, to the digits that its interval leaves.
    pub(super) fn found_text(&self) -> String {
        self.found.map_or_else(|| "-".to_owned(), |found| rounded(found, self.interval))
    }

    /// The interval; nothing where it has no width: closed forms, single sets of points, p-values.
    pub(super) fn interval_text(&self) -> String {
        match self.interval {
            Some((low, high)) if low.to_bits() != high.to_bits() => {
                let end = |x| rounded(x, self.interval);
                format!("{} to {}", end(low), end(high))
            }
            _ => "-".to_owned(),
        }
    }

    /// The number of the erratum, or nothing.
    pub(super) fn erratum_text(&self) -> String {
        self.erratum.map_or_else(String::new, |number| number.to_string())
    }
}

/// The numbers of claims that hold, are wrong, and are not decided.
pub(super) fn tally(claims: &[VerdictRecord]) -> [(&'static str, usize); 3] {
    [Verdict::Holds, Verdict::Wrong, Verdict::Undecided].map(|verdict| {
        let name = verdict.name();
        (name, claims.iter().filter(|claim| claim.verdict == name).count())
    })
}

/// The table for a terminal.
pub(super) fn plain_table(claims: &[VerdictRecord]) -> String {
    let rows = claims.iter().map(|claim| {
        vec![
            claim.figure.to_owned(),
            claim.what.clone(),
            claim.stated.clone(),
            claim.found_text(),
            claim.interval_text(),
            claim.verdict.to_owned(),
            claim.erratum_text(),
        ]
    });
    let heading = ["figure", "what", "the thesis says", "we find", "95 %", "verdict", "erratum"];
    let counts: Vec<String> = tally(claims).iter().map(|(name, n)| format!("{name} {n}")).collect();
    format!(
        "{}\n{} claims: {}\n",
        table(&heading, rows.collect(), 3),
        claims.len(),
        counts.join(", ")
    )
}

/// The rows of the CSV form.
pub(super) fn verdict_rows(claims: &[VerdictRecord]) -> Vec<Vec<String>> {
    let row = |claim: &VerdictRecord| {
        let end = |pick: fn((f64, f64)) -> f64| {
            claim.interval.map_or_else(String::new, |interval| full(pick(interval)))
        };
        vec![
            claim.figure.to_owned(),
            claim.what.clone(),
            claim.stated.clone(),
            claim.found.map_or_else(String::new, full),
            end(|interval| interval.0),
            end(|interval| interval.1),
            claim.verdict.to_owned(),
            claim.erratum_text(),
            claim.remark.clone(),
        ]
    };
    claims.iter().map(row).collect()
}

/// The table as a document of its own.
pub(super) fn markdown(
    claims: &[VerdictRecord],
    drawn: &[Drawn],
    provenance: &Provenance,
) -> String {
    let mut text = format!(
        "# The thesis, figure by figure\n\nWritten by `{}` (sphvar {}, seed {}). Errata are those of \
         the project's docs/theory.md.\n\n",
        provenance.command, provenance.version, provenance.seed
    );
    for (name, n) in tally(claims) {
        text.push_str(&format!("- {name}: {n}\n"));
    }
    for Drawn { figure, .. } in drawn {
        text.push_str(&format!("\n## Figure {}: {}\n\n", figure.id, figure.id.title()));
        for note in &figure.notes {
            text.push_str(&format!("{note}\n\n"));
        }
        let number = figure.id.number();
        let own: Vec<_> = claims.iter().filter(|claim| claim.figure == number).collect();
        if own.is_empty() {
            text.push_str("The thesis states no number here.\n");
            continue;
        }
        text.push_str("| what | the thesis says | we find | 95 % | verdict | erratum | remark |\n");
        text.push_str("|---|---|---|---|---|---|---|\n");
        for claim in own {
            let cells = [
                &claim.what,
                &claim.stated,
                &claim.found_text(),
                &claim.interval_text(),
                &claim.verdict.to_owned(),
                &claim.erratum_text(),
                &claim.remark,
            ];
            let cells: Vec<_> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
            text.push_str(&format!("| {} |\n", cells.join(" | ")));
        }
    }
    text
}

fn stated(stated: &Stated) -> String {
    match *stated {
        Stated::About { value, tolerance } if tolerance > SLIGHT * value.abs().max(1.0) => {
            format!("{} \u{b1} {}", plain(value), plain(tolerance))
        }
        Stated::About { value, .. } => plain(value),
        Stated::AtMost(limit) => format!("at most {}", plain(limit)),
        Stated::AtLeast(limit) => format!("at least {}", plain(limit)),
        Stated::Words(words) => words.to_owned(),
    }
}

/// Tolerances below this are for roundings and say nothing to a reader.
const SLIGHT: f64 = 1e-9;

/// A number that is printed somewhere: all its digits if it is very small or large, else six.
fn plain(x: f64) -> String {
    let size = x.abs();
    if size != 0.0 && !(1e-4..1e6).contains(&size) {
        return format!("{x:e}");
    }
    #[expect(clippy::cast_possible_truncation, reason = "logarithms of f64 are below 400")]
    let decimals = if size > 0.0 { 5 - size.log10().floor() as i32 } else { 0 };
    let text = format!("{x:.*}", usize::try_from(decimals).unwrap_or(0));
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// A number to two digits of its interval's width, or five if it has none.
fn rounded(x: f64, interval: Option<(f64, f64)>) -> String {
    if !x.is_finite() {
        return "-".to_owned();
    }
    let width = interval.map_or(0.0, |(low, high)| high - low);
    let step = if width > 0.0 && width.is_finite() { 0.05 * width } else { 1e-5 * x.abs() };
    let size = x.abs().max(step);
    #[expect(clippy::cast_possible_truncation, reason = "logarithms of f64 are below 400")]
    let decimals = if step > 0.0 { (-step.log10()).floor() as i32 } else { 0 };
    if (1e-3..1e6).contains(&size) || x == 0.0 {
        format!("{x:.*}", usize::try_from(decimals.clamp(0, 12)).unwrap_or(0))
    } else {
        #[expect(clippy::cast_possible_truncation, reason = "logarithms of f64 are below 400")]
        let digits = (size / step).log10().floor() as i32;
        format!("{x:.*e}", usize::try_from(digits.clamp(0, 12)).unwrap_or(0))
    }
}

#[cfg(test)]
mod tests {
    use sphvar_thesis::Quantity;

    use super::{plain, rounded};

    #[test]
    fn printed_numbers_stay_as_they_are() {
        for (x, text) in [
            (0.055, "0.055"),
            (300.0, "300"),
            (-1.5, "-1.5"),
            (0.0, "0"),
            (1e-6, "1e-6"),
            (232.166_318_621_979_88, "232.166"),
            (0.6, "0.6"),
        ] {
            assert_eq!(plain(x), text);
        }
    }

    #[test]
    fn numbers_have_the_digits_that_their_intervals_leave() {
        for (x, interval, text) in [
            (346.21, Some((342.0, 351.0)), "346"),
            (0.059_512, Some((0.0587, 0.0603)), "0.0595"),
            (-1.998_7, Some((-2.02, -1.97)), "-2.00"),
            (3.9e-8, Some((3.8e-8, 4.0e-8)), "3.90e-8"),
            (1.262_18, Some((1.262_18, 1.262_18)), "1.2622"),
            (0.0, Some((0.0, 0.0)), "0"),
            (f64::NAN, None, "-"),
            (12.0, Some((f64::NEG_INFINITY, f64::INFINITY)), "12.000"),
        ] {
            assert_eq!(rounded(x, interval), text, "{x}");
        }
        let exact = Quantity::exact(2.0);
        assert_eq!(rounded(exact.value, Some(exact.interval)), "2.0000");
    }
}
