//! The claims as a table for a terminal and as CSV.

use super::record::{OutcomeRecord, VerdictRecord};
use super::summary::Summary;
use crate::report::{full, table};

/// Returns the table for a terminal.
pub(super) fn plain_table(rows: &[VerdictRecord]) -> String {
    let cells = rows.iter().map(|row| {
        vec![
            row.figure.to_owned(),
            row.what.clone(),
            row.stated.clone(),
            row.measured_text(),
            row.interval_text(),
            row.outcome.verdict.to_owned(),
            row.erratum_text(),
        ]
    });
    let heading = ["figure", "what", "stated", "measured", "95 %", "verdict", "erratum"];
    format!("{}\n{}\n", table(&heading, cells.collect(), 3), Summary::new(rows).sentence())
}

/// The heading of the CSV form.
pub(super) const CSV_HEADING: &str =
    "figure,what,stated,option,measured,low,high,verdict,erratum,remark";

/// Returns the rows of the CSV form: one for each claim, followed by one for each option of a
/// choice that the thesis does not state.
pub(super) fn csv_rows(rows: &[VerdictRecord]) -> Vec<Vec<String>> {
    rows.iter()
        .flat_map(|row| {
            let options = row.choice.iter().flat_map(|choice| &choice.options);
            let options = options.map(|option| csv_row(row, option.name, &option.outcome));
            std::iter::once(csv_row(row, "", &row.outcome)).chain(options)
        })
        .collect()
}

fn csv_row(row: &VerdictRecord, option: &str, outcome: &OutcomeRecord) -> Vec<String> {
    let end = |pick: fn((f64, f64)) -> f64| {
        outcome.interval.map_or_else(String::new, |interval| full(pick(interval)))
    };
    vec![
        row.figure.to_owned(),
        row.what.clone(),
        row.stated.clone(),
        option.to_owned(),
        outcome.measured.map_or_else(String::new, full),
        end(|interval| interval.0),
        end(|interval| interval.1),
        outcome.verdict.to_owned(),
        row.erratum_text(),
        row.remark.clone(),
    ]
}

#[cfg(test)]
mod tests {
    use sphvar_thesis::{Claim, Quantity, Stated};

    use super::{VerdictRecord, csv_rows};

    #[test]
    fn every_option_has_a_row() {
        let claim = |value| Claim::number("power", Stated::AtMost(1.0), Quantity::exact(value));
        let both = Claim::over_choice("kind", vec![("a", claim(0.5)), ("b", claim(2.0))]);
        let rows = csv_rows(&[VerdictRecord::new("7.4", &both)]);
        let got: Vec<[&str; 3]> =
            rows.iter().map(|row| [&row[3], &row[4], &row[7]].map(String::as_str)).collect();
        assert_eq!(got, [["", "", "depends"], ["a", "5e-1", "holds"], ["b", "2e0", "wrong"]]);
    }
}
