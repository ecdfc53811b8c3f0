//! The number of rows of each verdict, and the errata that they belong to.

use std::collections::BTreeMap;

use sphvar_thesis::{Erratum, Verdict};

use super::record::VerdictRecord;

/// The rows by verdict and by erratum.
pub(super) struct Summary<'a> {
    rows: &'a [VerdictRecord],
}

/// An erratum with the rows that refer to it; it counts once, whatever the number of rows.
pub(super) struct ErratumRows<'a> {
    pub(super) number: u8,
    /// Its entry in the list.
    pub(super) erratum: Option<&'static Erratum>,
    pub(super) rows: Vec<&'a VerdictRecord>,
}

impl ErratumRows<'_> {
    /// Returns whether a row contradicts the thesis.
    pub(super) fn is_wrong(&self) -> bool {
        self.rows.iter().any(|row| row.is(Verdict::Wrong))
    }

    /// Returns place and problem.
    pub(super) fn title(&self) -> String {
        self.erratum.map_or_else(String::new, |e| format!("{}: {}", e.place, e.problem))
    }
}

impl<'a> Summary<'a> {
    pub(super) fn new(rows: &'a [VerdictRecord]) -> Self {
        Self { rows }
    }

    /// Returns the number of rows with a verdict.
    pub(super) fn count(&self, verdict: Verdict) -> usize {
        self.rows.iter().filter(|row| row.is(verdict)).count()
    }

    /// Returns the errata that rows refer to, by number.
    pub(super) fn errata(&self) -> Vec<ErratumRows<'a>> {
        let mut rows: BTreeMap<u8, Vec<&VerdictRecord>> = BTreeMap::new();
        for row in self.rows {
            if let Some(number) = row.erratum {
                rows.entry(number).or_default().push(row);
            }
        }
        rows.into_iter()
            .map(|(number, rows)| ErratumRows { number, erratum: Erratum::numbered(number), rows })
            .collect()
    }

    /// Returns the wrong rows that no erratum explains.
    pub(super) fn unexplained(&self) -> Vec<&'a VerdictRecord> {
        self.rows.iter().filter(|row| row.is(Verdict::Wrong) && row.erratum.is_none()).collect()
    }

    /// Returns the rows that are true by construction.
    pub(super) fn by_construction(&self) -> Vec<&'a VerdictRecord> {
        self.rows.iter().filter(|row| row.is(Verdict::ByConstruction)).collect()
    }

    /// Returns the rows of a figure that could have failed.
    pub(super) fn of_figure(&self, figure: &str) -> Vec<&'a VerdictRecord> {
        let could_fail = |row: &&VerdictRecord| !row.is(Verdict::ByConstruction);
        self.rows.iter().filter(|row| row.figure == figure).filter(could_fail).collect()
    }

    /// Returns both counts in words: rows by verdict, errata by number.
    pub(super) fn sentence(&self) -> String {
        let apart = self.count(Verdict::ByConstruction);
        let errata = self.errata();
        let wrong = errata.iter().filter(|erratum| erratum.is_wrong()).count();
        format!(
            "{} claims could have failed: {} hold, {} are wrong, {} depend on a choice that the thesis does not state, {} \
             are undecided, {} are not reproduced. {apart} more are true by construction and listed separately. The wrong \
             ones come from {wrong} errata; all rows together refer to {} errata, each counted once.",
            self.rows.len() - apart,
            self.count(Verdict::Holds),
            self.count(Verdict::Wrong),
            self.count(Verdict::Depends),
            self.count(Verdict::Undecided),
            self.count(Verdict::NotReproduced),
            errata.len()
        )
    }
}

#[cfg(test)]
mod tests {
    use sphvar_thesis::{Claim, Quantity, Stated, Verdict};

    use super::{Summary, VerdictRecord};

    fn rows() -> Vec<VerdictRecord> {
        let claim = |value| Claim::number("power", Stated::AtMost(1.0), Quantity::exact(value));
        [
            ("3.1", claim(0.5).by_construction()),
            ("3.1", claim(2.0).erratum(33)),
            ("7.1", claim(3.0).erratum(33)),
            ("7.1", claim(0.5).erratum(36)),
            ("7.1", claim(4.0)),
        ]
        .map(|(figure, claim)| VerdictRecord::new(figure, &claim))
        .into()
    }

    #[test]
    fn an_erratum_counts_once() {
        let rows = rows();
        let summary = Summary::new(&rows);
        let errata: Vec<_> =
            summary.errata().iter().map(|e| (e.number, e.rows.len(), e.is_wrong())).collect();
        assert_eq!(errata, [(33, 2, true), (36, 1, false)]);
        assert_eq!(summary.count(Verdict::Wrong), 3);
        assert_eq!(summary.unexplained().len(), 1);
        let sentence = summary.sentence();
        for part in ["4 claims", "1 hold", "3 are wrong", "1 more", "from 1 errata", "to 2 errata"]
        {
            assert!(sentence.contains(part), "{part}: {sentence}");
        }
    }

    #[test]
    fn rows_that_cannot_fail_are_separate() {
        let rows = rows();
        let summary = Summary::new(&rows);
        assert_eq!(summary.by_construction().len(), 1);
        assert_eq!(summary.of_figure("3.1").len(), 1);
        assert_eq!(summary.of_figure("7.1").len(), 3);
    }
}
