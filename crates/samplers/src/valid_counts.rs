use std::fmt;

/// The valid numbers of points of a pattern; the `Display` text continues "N must be".
///
/// Limits of memory and of indices are not part of these rules; see
/// [`Pattern::build`](crate::Pattern::build).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
        match *self {
            Self::Any => n_points.max(1),
            Self::Squares { unit, .. } => {
                let of = |k: usize| k.checked_mul(k)?.checked_mul(unit);
                let k = (n_points / unit).isqrt().max(1);
                let below = of(k).unwrap_or(unit);
                match of(k + 1) {
                    Some(above) if above.abs_diff(n_points) < below.abs_diff(n_points) => above,
                    _ => below,
                }
            }
        }
    }

    /// Returns the largest valid number that does not exceed `n_points`, if there is one.
    #[must_use]
    pub fn largest_not_exceeding(&self, n_points: usize) -> Option<usize> {
        match *self {
            Self::Any => Some(n_points).filter(|&n| n > 0),
            Self::Squares { unit, .. } => match (n_points / unit).isqrt() {
                0 => None,
                k => Some(unit * k * k),
            },
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
    }
}
