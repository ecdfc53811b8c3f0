/// An error, inconsistency or ambiguity of the thesis, with its number in the list of errata.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Erratum {
    /// Its number in the list.
    pub number: u8,
    /// Equations, sections or figures.
    pub place: &'static str,
    /// The error or ambiguity.
    pub problem: &'static str,
}

/// The errata cited by claims.
const CITED: [Erratum; 22] = [
    Erratum {
        number: 1,
        place: "3.10",
        problem: "the factor (2 - delta_0m) occurs together with `e^{im phi}` and m = -l .. l, so the squared norm is 2 for m != 0",
    },
    Erratum {
        number: 9,
        place: "4.2.2",
        problem: "the power of any pattern is said to converge to 1",
    },
    Erratum { number: 10, place: "4.2, Fig. 4.17", problem: "phases are said to be uniform" },
    Erratum {
        number: 12,
        place: "6.2.2",
        problem: "HEALPix sets are said to have no power at low frequencies (4.2.1 only describes a plot, in which none is visible)",
    },
    Erratum {
        number: 21,
        place: "5.18 against 6.1, 6.2, 6.4, 6.6, 6.8, C.27",
        problem: "mu/N becomes mu^2/N",
    },
    Erratum {
        number: 22,
        place: "6.1, 6.6",
        problem: "the weight 2l+1 is missing; `l < l0` in the text, `l <= l0` in the sum",
    },
    Erratum {
        number: 23,
        place: "6.2",
        problem: "the power that falls as l^-3 is said to be that of S; 1/l^2 is the weight of an energy (the inequality holds all the same)",
    },
    Erratum { number: 24, place: "6.3", problem: "zero variance \"for N > l^2/alpha^2\"" },
    Erratum { number: 25, place: "6.4", problem: "gamma is missing" },
    Erratum { number: 26, place: "6.5", problem: "b-th root of N" },
    Erratum { number: 27, place: "6.5", problem: "\"cannot be solved for an unknown degree b\"" },
    Erratum {
        number: 28,
        place: "6.8",
        problem: "`a_F` for `a'_F`; l = alpha sqrt(N) counts twice if it is whole",
    },
    Erratum {
        number: 30,
        place: "6.2.2 against 7.2",
        problem: "the lower bound of Poisson disk patterns is 1/20 or 0.055",
    },
    Erratum {
        number: 33,
        place: "7.1, 7.2, C.5-C.12, C.20",
        problem: "4 pi too large for 5.18; C.12 is called power and is energy",
    },
    Erratum {
        number: 35,
        place: "C.20",
        problem: "true and loose; the constant has the factor 4 pi of erratum 33",
    },
    Erratum { number: 36, place: "C.25", problem: "true and crude" },
    Erratum { number: 37, place: "C.26, C.27", problem: "at l = 0 the bound is negative" },
    Erratum { number: 38, place: "7.1, 7.2", problem: "HEALPix patterns of 1024 and 4096 points" },
    Erratum {
        number: 39,
        place: "7.1",
        problem: "capacity-constrained patterns (CCVT) without capacity or kind of mass points, on which their low degrees depend",
    },
    Erratum {
        number: 40,
        place: "6.2.2, 7.4",
        problem: "CCVT \"has an energy-free region\", and jitter has its rate",
    },
    Erratum {
        number: 43,
        place: "7.3 (Figure 7.8)",
        problem: "structural artifacts of Fibonacci points \"are way more visible\" than those of HEALPix, without a measure",
    },
    Erratum {
        number: 44,
        place: "7.4 (Figure 7.9)",
        problem: "jitter overtakes Poisson disks \"just after 300\" points, for no integrand in particular",
    },
];

impl Erratum {
    /// Returns the erratum with this number, if claims refer to it.
    #[must_use]
    pub fn numbered(number: u8) -> Option<&'static Self> {
        CITED.iter().find(|erratum| erratum.number == number)
    }

    /// Every erratum that claims refer to, by number.
    pub fn cited() -> impl Iterator<Item = &'static Self> {
        CITED.iter()
    }
}
