use super::patterns::ThesisPattern;
use crate::{Claim, Error, Verdict};

/// The choices about CCVT that the thesis does not state, for notes.
pub(crate) const NOTE: &str = "CCVT has 64 mass points per site, random or of a rotated Fibonacci lattice; the \
     thesis states neither their number nor their kind (erratum 39).";

/// The erratum about unstated choices of CCVT.
const NOT_STATED: u8 = 39;

/// Returns a claim about CCVT, checked with both kinds of mass points. Where the kind decides the
/// outcome its erratum is 39; `erratum` is that of a claim that is wrong with both.
pub(crate) fn with_both_kinds(
    erratum: Option<u8>,
    claim: impl Fn(ThesisPattern) -> Result<Claim, Error>,
) -> Result<Claim, Error> {
    let options = vec![
        ("random", claim(ThesisPattern::CcvtRandom)?),
        ("Fibonacci", claim(ThesisPattern::CcvtFibonacci)?),
    ];
    let claim = Claim::over_choice("the kind of CCVT's mass points", options)
        .erratum_if(Verdict::Depends, NOT_STATED);
    Ok(match erratum {
        Some(number) => claim.erratum_if(Verdict::Wrong, number),
        None => claim,
    })
}

#[cfg(test)]
mod tests {
    use super::with_both_kinds;
    use crate::figures::patterns::ThesisPattern;
    use crate::{Claim, Quantity, Stated, Verdict};

    #[test]
    fn the_kind_of_mass_points_decides_or_does_not() {
        for (random, lattice, verdict, erratum) in [
            (2.0, 0.5, Verdict::Depends, Some(39)),
            (2.0, 3.0, Verdict::Wrong, Some(40)),
            (0.1, 0.2, Verdict::Holds, None),
            (f64::NAN, 2.0, Verdict::Undecided, None),
        ] {
            let claim = |pattern| {
                let value = if pattern == ThesisPattern::CcvtRandom { random } else { lattice };
                Ok(Claim::number("", Stated::AtMost(1.0), Quantity::exact(value)))
            };
            let got = with_both_kinds(Some(40), claim).unwrap();
            assert_eq!((got.verdict, got.erratum), (verdict, erratum), "{random}, {lattice}");
        }
    }
}
