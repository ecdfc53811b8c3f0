use std::borrow::Cow;
use std::fmt;

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
    /// `unit k^2` for k = 1, 2, 3, ...
    Squares {
        /// The smallest number, at least 1.
        unit: usize,
        /// The name of k, such as `nside`.
        root: &'static str,
    },
    /// These numbers, in ascending order; an empty list says that they depend on a file.
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
            Self::Any => n_points.max(1),
            &Self::Squares { unit, .. } => {
                let of = |k: usize| k.checked_mul(k)?.checked_mul(unit);
                let k = (n_points / unit).isqrt().max(1);
                let below = of(k).unwrap_or(unit);
                match of(k + 1) {
                    Some(above) if above.abs_diff(n_points) < below.abs_diff(n_points) => above,
                    _ => below,
                }
            }
            Self::Listed(counts) => {
                let nearest = counts.iter().copied().min_by_key(|n| n.abs_diff(n_points));
                nearest.unwrap_or(n_points).max(1)
            }
        }
    }

    /// Returns the largest valid number that does not exceed `n_points`, if there is one.
    #[must_use]
    pub fn largest_not_exceeding(&self, n_points: usize) -> Option<usize> {
        match self {
            Self::Any => Some(n_points).filter(|&n| n > 0),
            &Self::Squares { unit, .. } => match (n_points / unit).isqrt() {
                0 => None,
                k => Some(unit * k * k),
            },
            Self::Listed(counts) => counts.iter().copied().rfind(|&n| n <= n_points),
        }
    }
}

impl fmt::Display for ValidCounts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Any => f.write_str("any number from 1"),
            Self::Squares { unit, root } => {
                if *unit != 1 {
                    write!(f, "{unit} ")?;
                }
                write!(f, "{root}^2 ({unit}, {}, {}, ...)", 4 * unit, 9 * unit)
            }
            Self::Listed(counts) => match &counts[..] {
                [] => f.write_str("the number in the file, or one for each file of a template"),
                [only] => write!(f, "{only}"),
                [first, others @ ..] if others.len() < MAX_LISTED => {
                    write!(f, "{first}")?;
                    let (last, between) = others.split_last().unwrap_or((first, &[]));
                    between.iter().try_for_each(|n| write!(f, ", {n}"))?;
                    write!(f, " or {last}")
                }
                [first, second, .., last] => {
                    write!(f, "one of {} numbers ({first}, {second}, ..., {last})", counts.len())
                }
                _ => Ok(()),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::ValidCounts;

    #[test]
    fn the_nearest_count_is_the_nearest_of_all() {
        for unit in [1, 6, 12] {
            let counts = ValidCounts::Squares { unit, root: "nside" };
            let all: Vec<usize> = (1..60).map(|k| unit * k * k).collect();
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
            assert!(counts.nearest(usize::MAX) > usize::MAX / 2);
        }
        let listed = ValidCounts::Listed(vec![3, 10, 12].into());
        for (asked, nearest, below) in [
            (0, 3, None),
            (6, 3, Some(3)),
            (7, 10, Some(3)),
            (11, 10, Some(10)),
            (99, 12, Some(12)),
        ] {
            assert_eq!(listed.nearest(asked), nearest, "{asked}");
            assert_eq!(listed.largest_not_exceeding(asked), below, "{asked}");
        }
        assert!(listed.contains(10) && !listed.contains(11));
        assert_eq!(ValidCounts::Listed(vec![].into()).nearest(0), 1);
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
        assert_eq!(ValidCounts::Any.to_string(), "any number from 1");
        let listed = |counts: &[usize]| ValidCounts::Listed(counts.to_vec().into()).to_string();
        assert_eq!(listed(&[777]), "777");
        assert_eq!(listed(&[5, 7]), "5 or 7");
        assert_eq!(listed(&[5, 7, 9]), "5, 7 or 9");
        let many: Vec<usize> = (1..=20).collect();
        assert_eq!(listed(&many), "one of 20 numbers (1, 2, ..., 20)");
    }
}
