/// Something that the thesis says, beside what is found.
#[derive(Clone, Debug, PartialEq)]
pub struct Claim {
    /// What it is about: `crossover of jittered and Poisson disk, cap`.
    pub what: String,
    /// What the thesis says.
    pub stated: Stated,
    /// What is found, if it is a number.
    pub found: Option<Quantity>,
    /// What follows.
    pub verdict: Verdict,
    /// The number of the erratum in `docs/theory.md` if the thesis is wrong or unclear here.
    pub erratum: Option<u8>,
    /// Why, in a sentence; may be empty.
    pub remark: String,
}

/// What the thesis says about a quantity.
#[derive(Clone, Debug, PartialEq)]
pub enum Stated {
    /// It has this value, which is right if it lies in the interval, widened by this tolerance: half a unit of the
    /// last digit that the thesis prints, or what "about" can mean.
    About {
        /// The value.
        value: f64,
        /// How far off the thesis's own precision is.
        tolerance: f64,
    },
    /// It is at most this.
    AtMost(f64),
    /// It is at least this.
    AtLeast(f64),
    /// Something that is no number.
    Words(&'static str),
}

/// A number with its 95 % interval, which is the number itself if it is exact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    /// The value.
    pub value: f64,
    /// The end points.
    pub interval: (f64, f64),
}

/// The standard normal quantile of 97.5 %.
const Z95: f64 = 1.959_963_984_540_054;

impl Quantity {
    /// A value that is exact.
    #[must_use]
    pub fn exact(value: f64) -> Self {
        Self { value, interval: (value, value) }
    }

    /// A value with a standard error.
    #[must_use]
    pub fn with_stderr(value: f64, stderr: f64) -> Self {
        Self { value, interval: (value - Z95 * stderr, value + Z95 * stderr) }
    }
}

/// What is to be thought of a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// The data agree with it.
    Holds,
    /// The data contradict it.
    Wrong,
    /// The data do not decide it.
    Undecided,
}

impl Verdict {
    /// The word for tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Wrong => "wrong",
            Self::Undecided => "undecided",
        }
    }
}

impl Claim {
    /// A claim about a number; the verdict follows from the interval. "At most" and "at least" are undecided while the
    /// interval reaches over the limit; a value is undecided if it is in the interval only because that is wider than
    /// the value is large.
    #[must_use]
    pub fn number(what: impl Into<String>, stated: Stated, found: Quantity) -> Self {
        let verdict = stated.judge(found);
        Self {
            what: what.into(),
            stated,
            found: Some(found),
            verdict,
            erratum: None,
            remark: String::new(),
        }
    }

    /// A claim in words, judged by whoever makes it.
    #[must_use]
    pub fn words(what: impl Into<String>, stated: &'static str, verdict: Verdict) -> Self {
        Self {
            what: what.into(),
            stated: Stated::Words(stated),
            found: None,
            verdict,
            erratum: None,
            remark: String::new(),
        }
    }

    /// The same claim with a number that was found.
    #[must_use]
    pub fn found(self, found: Quantity) -> Self {
        Self { found: Some(found), ..self }
    }

    /// The same claim with the number of an erratum.
    #[must_use]
    pub fn erratum(self, number: u8) -> Self {
        Self { erratum: Some(number), ..self }
    }

    /// The same claim with a remark.
    #[must_use]
    pub fn because(self, remark: impl Into<String>) -> Self {
        Self { remark: remark.into(), ..self }
    }
}

impl Stated {
    fn judge(&self, found: Quantity) -> Verdict {
        let (low, high) = found.interval;
        if low.is_nan() || high.is_nan() {
            return Verdict::Undecided;
        }
        let decided = |holds| if holds { Verdict::Holds } else { Verdict::Wrong };
        match *self {
            Self::About { value, tolerance } => {
                let inside = low - tolerance <= value && value <= high + tolerance;
                if inside && high - low > value.abs() {
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
        let sharp = Quantity { value: 2.0, interval: (1.9, 2.1) };
        for (stated, found, verdict) in [
            (about(2.05, 0.0), sharp, Verdict::Holds),
            (about(2.2, 0.0), sharp, Verdict::Wrong),
            (about(2.2, 0.15), sharp, Verdict::Holds),
            (about(0.1, 0.0), Quantity { value: 0.0, interval: (-1.0, 1.0) }, Verdict::Undecided),
            (Stated::AtMost(2.1), sharp, Verdict::Holds),
            (Stated::AtMost(2.0), sharp, Verdict::Undecided),
            (Stated::AtMost(1.8), sharp, Verdict::Wrong),
            (Stated::AtLeast(1.9), sharp, Verdict::Holds),
            (Stated::AtLeast(2.0), sharp, Verdict::Undecided),
            (Stated::AtLeast(2.2), sharp, Verdict::Wrong),
            (about(1.0, 9.0), Quantity::exact(f64::NAN), Verdict::Undecided),
        ] {
            let got = Claim::number("", stated.clone(), found).verdict;
            assert_eq!(got, verdict, "{stated:?}, {found:?}");
        }
    }
}
