/// Outcome of checking a claim of the thesis.
///
/// Verdicts follow from the data by the rules of [`Claim`](crate::Claim); none is assigned by hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// The data agree with the claim.
    Holds,
    /// The data contradict the claim.
    Wrong,
    /// The outcome depends on a choice that the thesis does not state: with one option the claim
    /// holds, with another it is wrong.
    Depends,
    /// The data do not decide the claim: its interval includes both outcomes, or only substitutes
    /// for the sets of the thesis contradict it.
    Undecided,
    /// The thesis does not define a measure of the quantity, so no number can be compared with it.
    NotReproduced,
    /// True by definition, by construction of the pattern, or an identity. It is checked, but could
    /// only fail by a programming error, and is listed separately.
    ByConstruction,
}

impl Verdict {
    /// Every verdict, in the order of tables.
    pub const ALL: [Self; 6] = [
        Self::Holds,
        Self::Wrong,
        Self::Depends,
        Self::Undecided,
        Self::NotReproduced,
        Self::ByConstruction,
    ];

    /// Returns the name for tables, such as `not reproduced`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Wrong => "wrong",
            Self::Depends => "depends",
            Self::Undecided => "undecided",
            Self::NotReproduced => "not reproduced",
            Self::ByConstruction => "by construction",
        }
    }

    /// Returns the rule of the verdict in a sentence.
    #[must_use]
    pub const fn rule(self) -> &'static str {
        match self {
            Self::Holds => {
                "The 95 % interval of the measured value, widened by the stated precision, agrees with the claim."
            }
            Self::Wrong => {
                "The 95 % interval of the measured value, widened by the stated precision, contradicts the claim."
            }
            Self::Depends => {
                "The thesis does not state a choice on which the outcome depends. The claim is checked with each option: \
                 it holds with one and is wrong with another."
            }
            Self::Undecided => {
                "The interval includes both outcomes, an option that the thesis leaves open is undecided while the other \
                 is not, or the claim is contradicted only by point sets that replace those of the thesis."
            }
            Self::NotReproduced => {
                "The thesis states no measure of the quantity. Values of a measure chosen here are given without a \
                 verdict."
            }
            Self::ByConstruction => {
                "The claim is a definition, an identity, or a property that the construction enforces. It is checked, but \
                 only a programming error could contradict it."
            }
        }
    }

    /// Returns the verdict of a claim that was checked with each option of a choice: the common one
    /// if all agree, [`Self::Depends`] if it holds with one and is wrong with another, else
    /// [`Self::Undecided`].
    pub(crate) fn over_options(verdicts: &[Self]) -> Self {
        match verdicts {
            [first, rest @ ..] if rest.iter().all(|verdict| verdict == first) => *first,
            _ if verdicts.contains(&Self::Holds) && verdicts.contains(&Self::Wrong) => {
                Self::Depends
            }
            _ => Self::Undecided,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Verdict::{self, Depends, Holds, Undecided, Wrong};

    #[test]
    fn options_that_contradict_each_other_depend() {
        for (options, expected) in [
            (&[Holds, Holds][..], Holds),
            (&[Wrong, Wrong], Wrong),
            (&[Holds, Wrong], Depends),
            (&[Wrong, Holds], Depends),
            (&[Wrong, Undecided, Holds], Depends),
            (&[Wrong, Undecided], Undecided),
            (&[Undecided, Holds], Undecided),
            (&[], Undecided),
        ] {
            assert_eq!(Verdict::over_options(options), expected, "{options:?}");
        }
    }

    #[test]
    fn names_and_rules_differ() {
        for (i, a) in Verdict::ALL.iter().enumerate() {
            for b in &Verdict::ALL[..i] {
                assert!(a.name() != b.name() && a.rule() != b.rule(), "{a:?}, {b:?}");
            }
        }
    }
}
