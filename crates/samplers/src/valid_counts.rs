use std::borrow::Cow;
use std::fmt;

use crate::Error;
use crate::rule::MAX_SIZE;

/// The maximum length of a list that is displayed in full.
const MAX_LISTED: usize = 8;

/// The valid numbers of points of a pattern; the `Display` text continues "N must be".
///
/// Limits of memory and of indices are not part of these rules; see
/// [`Pattern::build`](crate::Pattern::build).
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ValidCounts {
    /// Every positive number.
    Any,
    /// Multiples of a number.
    Multiples {
        /// The smallest number, at least 1.
        of: usize,
    },
    /// `unit k^2` for k = 1, 2, 3, ...
    Squares {
        /// The smallest number, at least 1.
        unit: usize,
        /// The name of k, such as `nside`.
        root: &'static str,
    },
    /// `unit k^3` for k = 1, 2, 3, ...
    Cubes {
        /// The smallest number, at least 1.
        unit: usize,
        /// The name of k, such as `nside`.
        root: &'static str,
    },
    /// `square k^2 - linear k + constant` for k = 1, 2, 3, ..., positive and increasing.
    Quadratic {
        /// The factor of k^2.
        square: usize,
        /// The factor of -k, less than 3 times `square`.
        linear: usize,
        /// The constant, such that the number is positive for k = 1.
        constant: usize,
        /// The name of k, such as `L`.
        root: &'static str,
    },
    /// `first`, `first + step`, `first + 2 step`, ...
    AtLeast {
        /// The smallest number, a multiple of `step`.
        first: usize,
        /// The difference, at least 1.
        step: usize,
    },
    /// Some numbers, then `first`, `first + step`, `first + 2 step`, ...
    ListedOrAtLeast {
        /// At least one number, in ascending order, all less than `first`.
        listed: Cow<'static, [usize]>,
        /// The number from which there are no gaps, a multiple of `step`.
        first: usize,
        /// The difference, at least 1.
        step: usize,
    },
    /// These numbers, in ascending order; an empty list if they depend on a file.
    Listed(Cow<'static, [usize]>),
}

impl ValidCounts {
    /// Returns whether `n_points` is valid.
    #[must_use]
    pub fn contains(&self, n_points: usize) -> bool {
        n_points > 0 && self.nearest(n_points) == n_points
    }

    /// Returns the valid number nearest to `n_points`, the smaller one of two equally near; never
    /// 0.
    #[must_use]
    pub fn nearest(&self, n_points: usize) -> usize {
        match self {
            Self::Any => return n_points.max(1),
            Self::Listed(numbers) if numbers.is_empty() => return n_points.max(1),
            _ => (),
        }
        let k = self.count_not_exceeding(n_points);
        match (self.of(k), self.of(k + 1)) {
            (Some(below), Some(above)) if above.abs_diff(n_points) < below.abs_diff(n_points) => {
                above
            }
            (Some(below), _) => below,
            (None, above) => above.unwrap_or(1),
        }
    }

    /// Returns the largest valid number that does not exceed `n_points`, if there is one.
    #[must_use]
    pub fn largest_not_exceeding(&self, n_points: usize) -> Option<usize> {
        self.of(self.count_not_exceeding(n_points))
    }

    /// Returns the number of valid numbers that do not exceed `n_points`, which for a valid number
    /// is the k that gives it.
    pub(crate) fn count_not_exceeding(&self, n_points: usize) -> usize {
        // Numbers whose k is beyond the range of squares exceed every `n_points`.
        let (mut k, mut beyond) = (0, 1 << (usize::BITS / 2));
        match self {
            Self::Any => return n_points,
            Self::Multiples { of } => return n_points / of,
            _ => (),
        }
        while beyond - k > 1 {
            let middle = k + (beyond - k) / 2;
            if self.of(middle).is_some_and(|n| n <= n_points) {
                k = middle;
            } else {
                beyond = middle;
            }
        }
        k
    }

    /// Returns the k of a valid number as the size of a rule.
    ///
    /// # Errors
    ///
    /// [`Error::TooManyPoints`] if it exceeds [`MAX_SIZE`].
    pub(crate) fn size(&self, pattern: &'static str, n_points: usize) -> Result<u32, Error> {
        let k = u32::try_from(self.count_not_exceeding(n_points).max(1)).ok();
        k.filter(|&k| k <= MAX_SIZE).ok_or(Error::TooManyPoints {
            pattern,
            requested: n_points,
            max: self.of(MAX_SIZE as usize).unwrap_or(usize::MAX),
        })
    }

    /// Returns the k-th valid number, from k = 1, unless it exceeds the range of `usize`.
    fn of(&self, k: usize) -> Option<usize> {
        if k == 0 {
            return None;
        }
        match self {
            Self::Any => Some(k),
            Self::Multiples { of } => k.checked_mul(*of),
            Self::Squares { unit, .. } => k.checked_mul(k)?.checked_mul(*unit),
            Self::Cubes { unit, .. } => k.checked_mul(k)?.checked_mul(k)?.checked_mul(*unit),
            Self::Quadratic { square, linear, constant, .. } => {
                let above = k.checked_mul(k)?.checked_mul(*square)?.checked_add(*constant)?;
                above.checked_sub(k.checked_mul(*linear)?)
            }
            Self::AtLeast { first, step } => (k - 1).checked_mul(*step)?.checked_add(*first),
            Self::ListedOrAtLeast { listed, first, step } => {
                match k.checked_sub(listed.len() + 1) {
                    Some(beyond) => beyond.checked_mul(*step)?.checked_add(*first),
                    None => listed.get(k - 1).copied(),
                }
            }
            Self::Listed(numbers) => numbers.get(k - 1).copied(),
        }
    }
}

impl fmt::Display for ValidCounts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let term = |f: &mut fmt::Formatter<'_>, factor: usize, power: &str| {
            if factor == 1 { f.write_str(power) } else { write!(f, "{factor} {power}") }
        };
        match self {
            Self::Any => return f.write_str("any number from 1"),
            Self::Multiples { of } => write!(f, "a multiple of {of}")?,
            Self::Squares { unit, root } => term(f, *unit, &format!("{root}^2"))?,
            Self::Cubes { unit, root } => term(f, *unit, &format!("{root}^3"))?,
            Self::Quadratic { square, linear, constant, root } => {
                term(f, *square, &format!("{root}^2"))?;
                if *linear > 0 {
                    f.write_str(" - ")?;
                    term(f, *linear, root)?;
                }
                write!(f, " + {constant}")?;
            }
            Self::AtLeast { first, step: 1 } => return write!(f, "at least {first}"),
            Self::AtLeast { first, step } => {
                return write!(f, "a multiple of {step}, at least {first}");
            }
            Self::ListedOrAtLeast { listed, first, step } => {
                match &**listed {
                    [others @ .., last] if others.len() < MAX_LISTED => {
                        others.iter().try_for_each(|n| write!(f, "{n}, "))?;
                        write!(f, "{last}")?;
                    }
                    _ => list(f, listed)?,
                }
                let comma = if *step == 1 && listed.len() <= MAX_LISTED { "" } else { "," };
                let rest = Self::AtLeast { first: *first, step: *step };
                return write!(f, "{comma} or {rest}");
            }
            Self::Listed(numbers) => return list(f, numbers),
        }
        let [first, second, third] = [1, 2, 3].map(|k| self.of(k).unwrap_or(0));
        write!(f, " ({first}, {second}, {third}, ...)")
    }
}

/// Writes a list of numbers, in full if it is short.
fn list(f: &mut fmt::Formatter<'_>, numbers: &[usize]) -> fmt::Result {
    match numbers {
        [] => f.write_str("the number in the file, or one for each file of a template"),
        [only] => write!(f, "{only}"),
        [first, others @ ..] if others.len() < MAX_LISTED => {
            write!(f, "{first}")?;
            let (last, between) = others.split_last().unwrap_or((first, &[]));
            between.iter().try_for_each(|n| write!(f, ", {n}"))?;
            write!(f, " or {last}")
        }
        [first, second, .., last] => {
            write!(f, "one of {} numbers ({first}, {second}, ..., {last})", numbers.len())
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::ValidCounts;

    #[test]
    fn the_nearest_count_is_the_nearest_of_all() {
        let squares = |unit| {
            (ValidCounts::Squares { unit, root: "k" }, (1..60).map(|k| unit * k * k).collect())
        };
        let quadratic = |square, linear, constant| {
            let counts = ValidCounts::Quadratic { square, linear, constant, root: "k" };
            (counts, (1..60).map(|k| square * k * k + constant - linear * k).collect())
        };
        let cubes = (1..60).map(|k| 72 * k * k * k).collect();
        let at_least = |step, first: usize| {
            (ValidCounts::AtLeast { first, step }, (first..3100).step_by(step).collect())
        };
        let gaps = ValidCounts::ListedOrAtLeast { listed: vec![12, 18].into(), first: 24, step: 2 };
        let rules: [(ValidCounts, Vec<usize>); 12] = [
            (gaps, [12, 18].into_iter().chain((24..3100).step_by(2)).collect()),
            (ValidCounts::Cubes { unit: 72, root: "k" }, cubes),
            (ValidCounts::Multiples { of: 16 }, (1..200).map(|k| 16 * k).collect()),
            at_least(1, 482),
            at_least(2, 14),
            squares(1),
            squares(6),
            squares(12),
            quadratic(4, 2, 1),
            quadratic(2, 3, 2),
            quadratic(10, 0, 2),
            (ValidCounts::Listed(vec![6, 14, 26, 302].into()), vec![6, 14, 26, 302]),
        ];
        for (counts, all) in rules {
            for requested in 0..3000 {
                let nearest = counts.nearest(requested);
                let best = all.iter().map(|n| n.abs_diff(requested)).min();
                assert_eq!(
                    Some(nearest.abs_diff(requested)),
                    best,
                    "requested {requested}, got {nearest}"
                );
                assert_eq!(counts.contains(requested), all.contains(&requested), "{requested}");
                let below = all.iter().copied().filter(|&n| n <= requested).max();
                assert_eq!(counts.largest_not_exceeding(requested), below, "{requested}");
            }
            // Lists end, and so do 2^32 numbers in steps of 1 or 2.
            let ends = matches!(
                counts,
                ValidCounts::Listed(_)
                    | ValidCounts::AtLeast { .. }
                    | ValidCounts::ListedOrAtLeast { .. }
            );
            assert!(ends || counts.nearest(usize::MAX) > usize::MAX / 2);
        }
        let any = ValidCounts::Any;
        assert_eq!((any.nearest(0), any.nearest(7)), (1, 7));
        assert_eq!((any.largest_not_exceeding(0), any.largest_not_exceeding(7)), (None, Some(7)));
        assert!(any.contains(1) && !any.contains(0));
    }

    #[test]
    fn rules_are_displayed_in_words() {
        let squares = ValidCounts::Squares { unit: 12, root: "nside" };
        assert_eq!(squares.to_string(), "12 nside^2 (12, 48, 108, ...)");
        let squares = ValidCounts::Squares { unit: 1, root: "k" };
        assert_eq!(squares.to_string(), "k^2 (1, 4, 9, ...)");
        let cubes = ValidCounts::Cubes { unit: 72, root: "nside" };
        assert_eq!(cubes.to_string(), "72 nside^3 (72, 576, 1944, ...)");
        let rings = ValidCounts::Quadratic { square: 2, linear: 1, constant: 1, root: "L" };
        assert_eq!(rings.to_string(), "2 L^2 - L + 1 (2, 7, 16, ...)");
        let grid = ValidCounts::Quadratic { square: 10, linear: 0, constant: 2, root: "f" };
        assert_eq!(grid.to_string(), "10 f^2 + 2 (12, 42, 92, ...)");
        let at_least = |step, first| ValidCounts::AtLeast { first, step }.to_string();
        assert_eq!(at_least(1, 482), "at least 482");
        assert_eq!(at_least(2, 14), "a multiple of 2, at least 14");
        let with_gaps = |step, listed: Vec<usize>, first| {
            ValidCounts::ListedOrAtLeast { listed: listed.into(), first, step }.to_string()
        };
        assert_eq!(with_gaps(1, vec![6, 8], 10), "6, 8 or at least 10");
        assert_eq!(with_gaps(2, vec![12], 18), "12, or a multiple of 2, at least 18");
        let many = with_gaps(1, (1000..1040).step_by(2).collect(), 1041);
        assert_eq!(many, "one of 20 numbers (1000, 1002, ..., 1038), or at least 1041");
        let listed = |counts: &[usize]| ValidCounts::Listed(counts.to_vec().into()).to_string();
        assert_eq!(listed(&[777]), "777");
        assert_eq!(listed(&[5, 7]), "5 or 7");
        assert_eq!(listed(&[5, 7, 9]), "5, 7 or 9");
        let many: Vec<usize> = (1..=20).collect();
        assert_eq!(listed(&many), "one of 20 numbers (1, 2, ..., 20)");
        let multiples = ValidCounts::Multiples { of: 16 };
        assert_eq!(multiples.to_string(), "a multiple of 16 (16, 32, 48, ...)");
        assert_eq!(ValidCounts::Any.to_string(), "any number from 1");
    }
}
