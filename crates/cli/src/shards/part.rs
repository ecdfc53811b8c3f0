//! Parts of a run.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// One of several equal parts of a run, `I/K`, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Part {
    pub(crate) part: u64,
    pub(crate) parts: u64,
}

impl Part {
    /// The whole run.
    pub(crate) const WHOLE: Self = Self { part: 1, parts: 1 };

    /// Returns the units of this part of `count`. The sizes of parts differ by at most one.
    pub(crate) fn range(self, count: u64) -> Range<u64> {
        let end = |part: u64| {
            let wide = (u128::from(count) * u128::from(part)).div_ceil(u128::from(self.parts));
            u64::try_from(wide).unwrap_or(count)
        };
        end(self.part - 1)..end(self.part)
    }

    /// Returns the units of this part of `count`, fewer than there are parts, which are assigned in
    /// turn: the first unit to the part that follows `first` others.
    pub(crate) fn in_turn(self, first: u64, count: u64) -> Range<u64> {
        let position = u128::from(self.part - 1) + u128::from(self.parts - first);
        match u64::try_from(position % u128::from(self.parts)) {
            Ok(unit) if unit < count => unit..unit + 1,
            _ => 0..0,
        }
    }

    /// Returns whether this is all of the run.
    pub(crate) fn is_whole(self) -> bool {
        self.parts == 1
    }
}

impl FromStr for Part {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers =
            text.split_once('/').and_then(|(i, k)| Some((i.parse().ok()?, k.parse().ok()?)));
        numbers
            .map(|(part, parts)| Self { part, parts })
            .filter(|part| 1 <= part.part && part.part <= part.parts)
            .ok_or_else(|| format!("expected I/K with 1 <= I <= K as in 2/4, got \"{text}\""))
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.part, self.parts)
    }
}

#[cfg(test)]
mod tests {
    use super::Part;

    #[test]
    fn parts_are_equal_and_the_first_ones_are_never_empty() {
        for (count, parts) in [(10_u64, 3_u64), (7, 7), (u64::MAX, 5), (3, 8), (1, 16), (0, 2)] {
            let ranges: Vec<_> =
                (1..=parts).map(|part| Part { part, parts }.range(count)).collect();
            assert_eq!((ranges[0].start, ranges[ranges.len() - 1].end), (0, count));
            assert!(ranges.windows(2).all(|pair| pair[0].end == pair[1].start), "{ranges:?}");
            let size = |range: &std::ops::Range<u64>| range.end - range.start;
            let sizes = || ranges.iter().map(size);
            assert!(sizes().max().unwrap() - sizes().min().unwrap() <= 1, "{ranges:?}");
            assert_eq!(size(&ranges[0]), count.div_ceil(parts), "{ranges:?}");
        }
    }

    #[test]
    fn units_in_turn_are_each_in_one_part() {
        for (parts, first, count) in [(1, 0, 0), (3, 2, 2), (16, 5, 8), (16, 15, 15), (16, 0, 1)] {
            let units = |part| Part { part, parts }.in_turn(first, count);
            for unit in 0..count {
                let of_unit = (first + unit) % parts + 1;
                let has = |part: &u64| units(*part) == (unit..unit + 1);
                assert_eq!((1..=parts).filter(has).collect::<Vec<_>>(), [of_unit], "{unit}");
            }
            let all = (1..=parts).map(|part| units(part).count() as u64).sum::<u64>();
            assert_eq!(all, count, "{first} of {parts}");
        }
        let huge = Part { part: 1, parts: u64::MAX };
        assert_eq!(huge.in_turn(u64::MAX - 1, 2), 1..2);
    }

    #[test]
    fn other_texts_are_no_parts() {
        for text in ["", "1", "0/2", "3/2", "1/0", "-1/2", "1/2/3", "a/b", "1/99999999999999999999"]
        {
            assert!(text.parse::<Part>().is_err(), "{text}");
        }
        assert_eq!("2/3".parse::<Part>().unwrap().to_string(), "2/3");
    }
}
