//! A claim of the thesis and its outcome, as a row of tables and documents.

use schemars::JsonSchema;
use serde::Serialize;
use sphvar_thesis::{Claim, Quantity, Verdict};

use super::Drawn;
use super::numbers::{rounded, stated};

/// A row of the table.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub(crate) struct VerdictRecord {
    /// The number of the figure.
    pub(super) figure: &'static str,
    /// The quantity or statement.
    pub(super) what: String,
    /// The statement of the thesis about it.
    pub(super) stated: String,
    #[serde(flatten)]
    pub(super) outcome: OutcomeRecord,
    /// The choice that the thesis does not state, where the claim was checked with several options.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) choice: Option<ChoiceRecord>,
    /// The number in sphvar's list of errata of the thesis, if the thesis is wrong or unclear here.
    pub(super) erratum: Option<u8>,
    /// The reason, in a sentence; may be empty.
    pub(super) remark: String,
}

/// The measured values and their verdict.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub(crate) struct OutcomeRecord {
    /// The measured number; null where the claim is not about a number.
    pub(super) measured: Option<f64>,
    /// Its 95 % confidence interval.
    pub(super) interval: Option<(f64, f64)>,
    /// `holds`, `wrong`, `depends`, `undecided`, `not reproduced` or `by construction`.
    pub(super) verdict: &'static str,
}

/// A choice and the outcome with each option.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub(crate) struct ChoiceRecord {
    /// The name of the choice.
    pub(super) of: &'static str,
    /// The outcome with each option.
    pub(super) options: Vec<OptionRecord>,
}

/// The outcome with one option.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub(crate) struct OptionRecord {
    /// The name of the option.
    pub(super) name: &'static str,
    #[serde(flatten)]
    pub(super) outcome: OutcomeRecord,
}

/// Returns all claims of all figures, in order.
pub(super) fn records(drawn: &[Drawn]) -> Vec<VerdictRecord> {
    let of = |Drawn { figure, .. }: &Drawn| -> Vec<VerdictRecord> {
        figure.claims.iter().map(|claim| VerdictRecord::new(figure.id.number(), claim)).collect()
    };
    drawn.iter().flat_map(of).collect()
}

impl OutcomeRecord {
    fn new(measured: Option<Quantity>, verdict: Verdict) -> Self {
        Self {
            measured: measured.map(|measured| measured.value),
            interval: measured.map(|measured| measured.interval),
            verdict: verdict.name(),
        }
    }

    /// Returns the measured values, to the digits that the interval determines.
    fn measured_text(&self) -> String {
        self.measured.map_or_else(|| "-".to_owned(), |measured| rounded(measured, self.interval))
    }

    /// Returns the interval, or an empty text if it has no width, as for closed forms and single
    /// point sets.
    fn interval_text(&self) -> String {
        match self.interval {
            Some((low, high)) if low.to_bits() != high.to_bits() && !low.is_nan() => {
                let end = |x| rounded(x, self.interval);
                format!("{} to {}", end(low), end(high))
            }
            _ => "-".to_owned(),
        }
    }
}

impl VerdictRecord {
    pub(super) fn new(figure: &'static str, claim: &Claim) -> Self {
        let choice = claim.choice.as_ref().map(|choice| ChoiceRecord {
            of: choice.of,
            options: choice
                .options
                .iter()
                .map(|option| OptionRecord {
                    name: option.name,
                    outcome: OutcomeRecord::new(option.measured, option.verdict),
                })
                .collect(),
        });
        Self {
            figure,
            what: claim.what.clone(),
            stated: stated(&claim.stated),
            outcome: OutcomeRecord::new(claim.measured, claim.verdict),
            choice,
            erratum: claim.erratum,
            remark: claim.remark.clone(),
        }
    }

    pub(super) fn is(&self, verdict: Verdict) -> bool {
        self.outcome.verdict == verdict.name()
    }

    /// Returns the measured values, with each option if there are several.
    pub(super) fn measured_text(&self) -> String {
        self.of_each(OutcomeRecord::measured_text)
    }

    /// Returns the interval, with each option if there are several.
    pub(super) fn interval_text(&self) -> String {
        self.of_each(OutcomeRecord::interval_text)
    }

    /// Returns the verdict; if the options differ, it lists theirs and names the choice.
    pub(super) fn verdict_text(&self) -> String {
        let verdict = self.outcome.verdict;
        match &self.choice {
            Some(choice) if choice.options.iter().any(|o| o.outcome.verdict != verdict) => {
                let each = self.of_each(|outcome| outcome.verdict.to_owned());
                format!("{verdict} ({}: {each})", choice.of)
            }
            _ => verdict.to_owned(),
        }
    }

    /// Returns the number of the erratum, or an empty text.
    pub(super) fn erratum_text(&self) -> String {
        self.erratum.map_or_else(String::new, |number| number.to_string())
    }

    fn of_each(&self, text: impl Fn(&OutcomeRecord) -> String) -> String {
        let Some(choice) = &self.choice else {
            return text(&self.outcome);
        };
        let texts: Vec<String> = choice.options.iter().map(|o| text(&o.outcome)).collect();
        if texts.iter().all(|text| text == "-") {
            return "-".to_owned();
        }
        let named = |(option, text): (&OptionRecord, String)| format!("{} {text}", option.name);
        choice.options.iter().zip(texts).map(named).collect::<Vec<_>>().join(", ")
    }
}

#[cfg(test)]
mod tests {
    use sphvar_thesis::{Claim, Quantity, Stated};

    use super::VerdictRecord;

    fn at_most_1(value: f64) -> Claim {
        Claim::number("power", Stated::AtMost(1.0), Quantity::with_stderr(value, 0.01))
    }

    #[test]
    fn undetermined_claims_show_every_option() {
        let claim =
            Claim::over_choice("the kind", vec![("a", at_most_1(0.5)), ("b", at_most_1(2.0))]);
        let record = VerdictRecord::new("7.4", &claim);
        assert_eq!(record.measured_text(), "a 0.50, b 2.00");
        assert_eq!(record.interval_text(), "a 0.48 to 0.52, b 1.98 to 2.02");
        assert_eq!(record.verdict_text(), "depends (the kind: a holds, b wrong)");
        let json = serde_json::to_value(&record).unwrap();
        assert_eq!(json["verdict"], "depends");
        assert_eq!(json["choice"]["options"][1]["verdict"], "wrong");
        assert_eq!(json["choice"]["options"][1]["measured"], 2.0);
    }

    #[test]
    fn options_that_agree_have_one_verdict() {
        let claim =
            Claim::over_choice("the kind", vec![("a", at_most_1(0.5)), ("b", at_most_1(0.6))]);
        assert_eq!(VerdictRecord::new("7.4", &claim).verdict_text(), "holds");
        let single = VerdictRecord::new("7.4", &at_most_1(0.5));
        assert_eq!(
            (single.verdict_text(), single.measured_text()),
            ("holds".into(), "0.50".into())
        );
    }
}
