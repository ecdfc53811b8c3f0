use std::str::FromStr;

/// The numbers of directions of `-n`: a list, or a range that doubles.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Counts(Vec<usize>);

impl Counts {
    /// All of them.
    pub(super) fn all(&self) -> &[usize] {
        &self.0
    }

    /// From `first`, doubling, to no more than `last`.
    pub(super) fn doubling(first: usize, last: usize) -> Self {
        Self(
            std::iter::successors(Some(first), |n| n.checked_mul(2))
                .take_while(|&n| n <= last)
                .collect(),
        )
    }
}

impl FromStr for Counts {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let count = |text: &str| match text.trim().parse::<usize>() {
            Ok(n) if n > 0 => Ok(n),
            _ => Err(format!(
                "expected numbers from 1 as in 256, 16,64,256 or 16..1024, got \"{text}\""
            )),
        };
        if let Some((first, last)) = text.split_once("..") {
            let (first, last) = (count(first)?, count(last)?);
            if first > last {
                return Err(format!(
                    "the range {first}..{last} is empty: give the smaller number first"
                ));
            }
            return Ok(Self::doubling(first, last));
        }
        Ok(Self(text.split(',').map(count).collect::<Result<_, _>>()?))
    }
}

#[cfg(test)]
mod tests {
    use super::Counts;

    #[test]
    fn lists_and_ranges() {
        for (text, counts) in [
            ("256", &[256][..]),
            ("16..64", &[16, 32, 64]),
            ("3..13", &[3, 6, 12]),
            ("5..5", &[5]),
            ("7, 9", &[7, 9]),
        ] {
            assert_eq!(text.parse::<Counts>().unwrap().all(), counts, "{text}");
        }
        for text in ["", "0", "1..", "..", "9..3", "-4", "1,,2", "2.5"] {
            assert!(text.parse::<Counts>().is_err(), "{text}");
        }
    }
}
