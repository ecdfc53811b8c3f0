use crate::{Quantity, Verdict};

/// A statement of the thesis and the corresponding measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct Claim {
    /// The subject: `crossover of jittered and Poisson disk, cap`.
    pub what: String,
    /// The statement of the thesis.
    pub stated: Stated,
    /// The measured value, if it is a single number.
    pub measured: Option<Quantity>,
    /// The outcome.
    pub verdict: Verdict,
    /// The choice that the thesis does not state, and the outcome with each option, if they differ.
    pub choice: Option<OpenChoice>,
    /// The number of the [`Erratum`](crate::Erratum) if the thesis is wrong or unclear here.
    pub erratum: Option<u8>,
    /// The reason, in a sentence; may be empty.
    pub remark: String,
}

/// A choice that the thesis does not state, on which a quantity depends.
#[derive(Clone, Debug, PartialEq)]
pub struct OpenChoice {
    /// The subject of the choice: `kind of CCVT's mass points`.
    pub of: &'static str,
    /// Every option that was tried.
    pub options: Vec<ChoiceOption>,
}

/// The outcome of a claim with one option of an [`OpenChoice`].
#[derive(Clone, Debug, PartialEq)]
pub struct ChoiceOption {
    /// The option: `random`.
    pub name: &'static str,
    /// The measured value, if it is a number.
    pub measured: Option<Quantity>,
    /// The outcome.
    pub verdict: Verdict,
}

/// A statement of the thesis about a quantity.
#[derive(Clone, Debug, PartialEq)]
pub enum Stated {
    /// The quantity has this value. It is correct if it lies in the interval widened by the
    /// tolerance: half a unit of the last printed digit, or a margin for "about".
    About {
        /// The value.
        value: f64,
        /// The tolerance that the precision of the thesis implies.
        tolerance: f64,
    },
    /// The quantity is at most this value.
    AtMost(f64),
    /// The quantity is at least this value.
    AtLeast(f64),
    /// A statement that is not a number.
    Words(&'static str),
}

impl Claim {
    /// Returns a claim about a number; the verdict follows from the interval. "At most" and "at
    /// least" are undecided while the interval includes the limit; a value within the interval and
    /// its tolerance is undecided if the interval is wider than a tenth of the value and than twice
    /// the tolerance, because other values would agree as well. Without an interval every claim is
    /// undecided.
    #[must_use]
    pub fn number(what: impl Into<String>, stated: Stated, measured: Quantity) -> Self {
        let verdict = stated.judge(measured);
        Self {
            what: what.into(),
            stated,
            measured: Some(measured),
            verdict,
            choice: None,
            erratum: None,
            remark: String::new(),
        }
    }

    /// Returns a claim in words. The caller determines the verdict by its own rule, one of the
    /// tested functions of the figures.
    #[must_use]
    pub fn words(what: impl Into<String>, stated: &'static str, verdict: Verdict) -> Self {
        Self {
            what: what.into(),
            stated: Stated::Words(stated),
            measured: None,
            verdict,
            choice: None,
            erratum: None,
            remark: String::new(),
        }
    }

    /// Returns a claim about a quantity without a stated measure: [`Verdict::NotReproduced`],
    /// whatever the value of `measured`. The remark must name the chosen measure.
    #[must_use]
    pub fn without_measure(
        what: impl Into<String>,
        stated: &'static str,
        measured: Quantity,
    ) -> Self {
        Self::words(what, stated, Verdict::NotReproduced).measured(measured)
    }

    /// Returns the claim checked with each option of a choice that the thesis does not state.
    ///
    /// The verdict is the common one if all options agree, [`Verdict::Depends`] if the claim holds
    /// with one and is wrong with another, else [`Verdict::Undecided`]. The options must be claims
    /// of the same statement; name, statement and erratum are those of the first.
    ///
    /// # Panics
    ///
    /// Panics if there are no options.
    #[must_use]
    pub fn over_choice(of: &'static str, options: Vec<(&'static str, Self)>) -> Self {
        let verdicts: Vec<Verdict> = options.iter().map(|option| option.1.verdict).collect();
        let first = options[0].1.clone();
        let same = options.iter().all(|(_, claim)| claim.remark == first.remark);
        let remark = if same {
            first.remark
        } else {
            let named = |(name, claim): &(&str, Self)| format!("{name}: {}", claim.remark);
            options.iter().map(named).collect::<Vec<_>>().join("; ")
        };
        let option = |(name, claim): (&'static str, Self)| ChoiceOption {
            name,
            measured: claim.measured,
            verdict: claim.verdict,
        };
        let verdict = Verdict::over_options(&verdicts);
        let choice = OpenChoice { of, options: options.into_iter().map(option).collect() };
        Self { measured: None, verdict, choice: Some(choice), remark, ..first }
    }

    /// Returns the same claim with a measured value.
    #[must_use]
    pub fn measured(self, measured: Quantity) -> Self {
        Self { measured: Some(measured), ..self }
    }

    /// Returns the same claim, marked as true by construction if it holds. A claim that does not
    /// hold keeps its verdict, because it indicates a program error.
    #[must_use]
    pub fn by_construction(self) -> Self {
        match self.verdict {
            Verdict::Holds => Self { verdict: Verdict::ByConstruction, ..self },
            _ => self,
        }
    }

    /// Returns the same claim for substitutes of the point sets of the thesis, which are unknown or
    /// unavailable here. A contradiction may be due to the sets, so wrong becomes undecided and
    /// `remark` is added. Other verdicts are unchanged.
    #[must_use]
    pub fn on_substitute(self, remark: &str) -> Self {
        match self.verdict {
            Verdict::Wrong => {
                let remark = format!("{}; {remark}", self.remark);
                Self { verdict: Verdict::Undecided, remark, ..self }
            }
            _ => self,
        }
    }

    /// Returns the same claim with the number of an erratum.
    #[must_use]
    pub fn erratum(self, number: u8) -> Self {
        Self { erratum: Some(number), ..self }
    }

    /// Returns the same claim with the number of an erratum if it has this verdict.
    #[must_use]
    pub fn erratum_if(self, verdict: Verdict, number: u8) -> Self {
        if self.verdict == verdict { self.erratum(number) } else { self }
    }

    /// Returns the same claim with a remark.
    #[must_use]
    pub fn because(self, remark: impl Into<String>) -> Self {
        Self { remark: remark.into(), ..self }
    }
}

impl Stated {
    fn judge(&self, measured: Quantity) -> Verdict {
        let (low, high) = measured.interval;
        if low.is_nan() || high.is_nan() {
            return Verdict::Undecided;
        }
        let decided = |holds| if holds { Verdict::Holds } else { Verdict::Wrong };
        match *self {
            Self::About { value, tolerance } => {
                let inside = low - tolerance <= value && value <= high + tolerance;
                if inside && high - low > (0.1 * value.abs()).max(2.0 * tolerance) {
                    Verdict::Undecided
                } else {
                    decided(inside)
                }
            }
            Self::AtMost(limit) if low <= limit && limit < high => Verdict::Undecided,
            Self::AtMost(limit) => decided(high <= limit),
            Self::AtLeast(limit) if low < limit && limit <= high => Verdict::Undecided,
            Self::AtLeast(limit) => decided(low >= limit),
            Self::Words(_) => Verdict::Undecided,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Claim, Quantity, Stated, Verdict};

    #[test]
    fn verdicts_follow_from_intervals() {
        let about = |value, tolerance| Stated::About { value, tolerance };
        let around = |value, half| Quantity { value, interval: (value - half, value + half) };
        let sharp = Quantity { value: 2.0, interval: (1.9, 2.1) };
        for (stated, measured, verdict) in [
            (about(2.05, 0.0), sharp, Verdict::Holds),
            (about(2.2, 0.0), sharp, Verdict::Wrong),
            (about(2.2, 0.15), sharp, Verdict::Holds),
            (about(0.1, 0.0), around(0.0, 1.0), Verdict::Undecided),
            (about(0.0, 1e-3), around(2e-4, 1e-4), Verdict::Holds),
            (about(0.0, 1e-3), around(5e-3, 1e-4), Verdict::Wrong),
            (about(0.0, 1e-3), around(2e-4, 2e-3), Verdict::Undecided),
            (about(-1.0, 0.05), around(-1.0, 0.2), Verdict::Undecided),
            (about(-1.0, 0.05), around(-1.02, 0.04), Verdict::Holds),
            (about(-1.0, 0.05), around(-1.5, 0.2), Verdict::Wrong),
            (about(1.0, 9.0), Quantity::single(1.0), Verdict::Undecided),
            (Stated::AtMost(9.0), Quantity::single(1.0), Verdict::Undecided),
            (about(2.0, 0.0), Quantity::exact(2.0), Verdict::Holds),
            (Stated::AtMost(2.1), sharp, Verdict::Holds),
            (Stated::AtMost(2.0), sharp, Verdict::Undecided),
            (Stated::AtMost(1.8), sharp, Verdict::Wrong),
            (Stated::AtLeast(1.9), sharp, Verdict::Holds),
            (Stated::AtLeast(2.0), sharp, Verdict::Undecided),
            (Stated::AtLeast(2.2), sharp, Verdict::Wrong),
            (about(1.0, 9.0), Quantity::exact(f64::NAN), Verdict::Undecided),
        ] {
            let got = Claim::number("", stated.clone(), measured).verdict;
            assert_eq!(got, verdict, "{stated:?}, {measured:?}");
        }
    }

    /// Returns a value for a statement "at most 1".
    fn at_most_1(value: f64) -> Claim {
        Claim::number("power", Stated::AtMost(1.0), Quantity::exact(value)).because("N = 4")
    }

    #[test]
    fn dependent_claims_show_both_outcomes() {
        let got = Claim::over_choice(
            "kind",
            vec![("a", at_most_1(0.5)), ("b", at_most_1(2.0).because("N = 9"))],
        );
        assert_eq!((got.verdict, got.measured), (Verdict::Depends, None));
        let choice = got.choice.unwrap();
        assert_eq!(choice.of, "kind");
        let outcomes: Vec<_> =
            choice.options.iter().map(|o| (o.name, o.measured.unwrap().value, o.verdict)).collect();
        assert_eq!(outcomes, [("a", 0.5, Verdict::Holds), ("b", 2.0, Verdict::Wrong)]);
        assert_eq!(got.remark, "a: N = 4; b: N = 9");
        let both = Claim::over_choice("kind", vec![("a", at_most_1(0.5)), ("b", at_most_1(0.1))]);
        assert_eq!((both.verdict, both.remark.as_str()), (Verdict::Holds, "N = 4"));
    }

    #[test]
    fn without_a_measure_no_number_decides() {
        for value in [0.0, 1.0, f64::NAN] {
            let got = Claim::without_measure("artifacts", "are visible", Quantity::exact(value));
            assert_eq!(got.verdict, Verdict::NotReproduced, "{value}");
        }
    }

    #[test]
    fn only_claims_that_hold_are_true_by_construction() {
        assert_eq!(at_most_1(0.5).by_construction().verdict, Verdict::ByConstruction);
        assert_eq!(at_most_1(2.0).by_construction().verdict, Verdict::Wrong);
        assert_eq!(at_most_1(f64::NAN).by_construction().verdict, Verdict::Undecided);
    }

    #[test]
    fn substitutes_contradict_nothing() {
        let got = at_most_1(2.0).on_substitute("other sets");
        assert_eq!((got.verdict, got.remark.as_str()), (Verdict::Undecided, "N = 4; other sets"));
        let got = at_most_1(0.5).on_substitute("other sets");
        assert_eq!((got.verdict, got.remark.as_str()), (Verdict::Holds, "N = 4"));
    }

    #[test]
    fn errata_belong_to_their_verdict() {
        assert_eq!(at_most_1(2.0).erratum_if(Verdict::Wrong, 9).erratum, Some(9));
        assert_eq!(at_most_1(0.5).erratum_if(Verdict::Wrong, 9).erratum, None);
    }
}
