use statrs::distribution::{ContinuousCDF, StudentsT};

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

/// A number with its 95 % interval, which is the number itself if it is exact, and NaN if nothing is known of its error.
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

    /// A random value of which there is one only, without an interval.
    #[must_use]
    pub fn single(value: f64) -> Self {
        Self { value, interval: (f64::NAN, f64::NAN) }
    }

    /// A value with a standard error.
    #[must_use]
    pub fn with_stderr(value: f64, stderr: f64) -> Self {
        Self::within(value, Z95 * stderr)
    }

    /// A value with a standard error that was estimated from data with so many degrees of freedom: the interval of
    /// Student's t, NaN without degrees of freedom.
    #[must_use]
    pub fn with_student(value: f64, stderr: f64, dof: f64) -> Self {
        let quantile = StudentsT::new(0.0, 1.0, dof).map_or(f64::NAN, |t| t.inverse_cdf(0.975));
        Self::within(value, quantile * stderr)
    }

    fn within(value: f64, half: f64) -> Self {
        Self { value, interval: (value - half, value + half) }
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
    /// interval reaches over the limit; a value that is within the interval and its tolerance is undecided if the
    /// interval is wider than a tenth of the value and than twice the tolerance: it would agree with other values as
    /// well. Without an interval everything is undecided.
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
        for (stated, found, verdict) in [
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
            let got = Claim::number("", stated.clone(), found).verdict;
            assert_eq!(got, verdict, "{stated:?}, {found:?}");
        }
    }

    /// Two-sided 5 % of Student's t: 12.706 with one degree of freedom, 2.571 with five (any table).
    #[test]
    fn few_renders_have_wide_intervals() {
        for (dof, quantile) in [(1.0, 12.706), (5.0, 2.571)] {
            let got = Quantity::with_student(3.0, 2.0, dof);
            // Half a unit of the tables' last digit.
            assert!((got.interval.1 - 3.0 - 2.0 * quantile).abs() < 1e-3, "{dof}: {got:?}");
            assert!((got.interval.0 + got.interval.1 - 6.0).abs() < 1e-12, "{dof}: {got:?}");
        }
        assert!(Quantity::with_student(3.0, 2.0, 0.0).interval.0.is_nan());
    }
}
