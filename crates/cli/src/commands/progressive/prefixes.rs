//! The prefixes whose errors are computed, and those that tables show.

/// The prefixes of a sequence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Prefixes {
    /// The numbers of points at which the error is computed, in increasing order.
    pub(super) computed: Vec<usize>,
    /// Those from which rates are fitted, and which tables show.
    pub(super) shown: Vec<usize>,
    /// Whether the numbers are the user's own, so that tables show all of them.
    pub(super) are_listed: bool,
}

/// The maximum number of points up to which the error is computed at every prefix: the work grows with
/// its square.
pub(super) const MAX_EVERY: usize = 20_000;

/// The number of points up to which every prefix is compared with a reference.
const EVERY_COMPARED: usize = 256;

/// The maximum number of prefixes that are shown, unless the user lists more.
const MAX_SHOWN: usize = 40;

impl Prefixes {
    /// Returns every prefix up to a single number, or the listed ones, of a sequence of at most `own`
    /// points; `None` if `own` is smaller than all of them.
    ///
    /// Of more than [`MAX_EVERY`] prefixes, only those that are shown are computed. These are the
    /// powers of two, those times the square root of 2, and the last one.
    pub(super) fn new(counts: &[usize], own: Option<usize>) -> Option<Self> {
        let (&[max] | &[.., max]) = counts else { return None };
        let limit = own.unwrap_or(usize::MAX);
        if counts.len() > 1 {
            let mut listed: Vec<usize> = counts.iter().copied().filter(|&n| n <= limit).collect();
            listed.sort_unstable();
            listed.dedup();
            let is_empty = listed.is_empty();
            return (!is_empty).then(|| Self {
                shown: listed.clone(),
                computed: listed,
                are_listed: true,
            });
        }
        let max = max.min(limit);
        let shown = spaced(max);
        let computed = if max <= MAX_EVERY { (1..=max).collect() } else { shown.clone() };
        Some(Self { computed, shown, are_listed: false })
    }

    /// Returns the prefixes that are compared with inexpensive references: those that are shown, all up
    /// to [`EVERY_COMPARED`], and beyond it some about 4 % apart.
    pub(super) fn compared(&self) -> Vec<usize> {
        if self.are_listed || self.has_gaps() {
            return self.shown.clone();
        }
        let max = self.computed.len();
        let mut all: Vec<usize> = (1..=max.min(EVERY_COMPARED)).collect();
        let next = |n: &usize| Some(n + n / 25);
        all.extend(std::iter::successors(Some(EVERY_COMPARED), next).take_while(|&n| n < max));
        all.extend(&self.shown);
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Returns whether prefixes are left out that the user did not leave out.
    pub(super) fn has_gaps(&self) -> bool {
        !self.are_listed && self.computed.last().is_some_and(|&max| max != self.computed.len())
    }

    /// Returns the prefixes in a table with this number of sequences, at least six for each, from
    /// the last one.
    pub(super) fn in_table(&self, sequences: usize) -> Vec<usize> {
        const MIN: usize = 6;
        let max = (MAX_SHOWN / sequences.max(1)).max(MIN);
        let step = if self.are_listed { 1 } else { self.shown.len().div_ceil(max).max(1) };
        let mut chosen: Vec<usize> = self.shown.iter().rev().step_by(step).copied().collect();
        chosen.reverse();
        chosen
    }
}

/// Returns the powers of two and their multiples by the square root of 2, rounded, up to `max`, and
/// `max`; of more than [`MAX_SHOWN`], every second.
fn spaced(max: usize) -> Vec<usize> {
    let half_octave = |k: u32| {
        // 2^k is an integer; the root of twice its square is the next one, rounded.
        let power = 1_u128 << (k / 2);
        if k.is_multiple_of(2) { power } else { rounded_root(2 * power * power) }
    };
    let below: Vec<usize> = (0..2 * usize::BITS)
        .map(half_octave)
        .map_while(|n| usize::try_from(n).ok().filter(|&n| n < max))
        .collect();
    let step = if below.len() >= MAX_SHOWN { 2 } else { 1 };
    let mut all: Vec<usize> = below.into_iter().step_by(step).collect();
    all.dedup();
    all.push(max);
    all
}

/// Returns the square root, rounded to the nearest integer.
fn rounded_root(square: u128) -> u128 {
    let root = square.isqrt();
    // Beyond (root + 1/2)^2 = root^2 + root + 1/4.
    if square - root * root > root { root + 1 } else { root }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn prefixes(counts: &[usize], own: Option<usize>) -> Prefixes {
        Prefixes::new(counts, own).unwrap()
    }

    #[test]
    fn one_number_is_every_prefix() {
        let Prefixes { computed, shown, .. } = prefixes(&[100], None);
        assert_eq!(computed, (1..=100).collect::<Vec<_>>());
        assert_eq!(shown, [1, 2, 3, 4, 6, 8, 11, 16, 23, 32, 45, 64, 91, 100]);
        assert_eq!(prefixes(&[1], None).shown, [1]);
        assert_eq!(prefixes(&[64], Some(3)).computed, [1, 2, 3]);
        let large = prefixes(&[3_000_000], None);
        assert_eq!(large.computed, large.shown);
        assert!(large.has_gaps() && !prefixes(&[9], None).has_gaps());
        assert!(large.shown.len() <= MAX_SHOWN && large.shown.ends_with(&[2_097_152, 3_000_000]));
        assert!(prefixes(&[usize::MAX], None).shown.len() <= 2 * MAX_SHOWN);
    }

    #[test]
    fn many_prefixes_are_compared() {
        let few = prefixes(&[40], None);
        assert_eq!(few.compared(), few.computed);
        let all = prefixes(&[4096], None).compared();
        assert_eq!(all[..256], (1..=256).collect::<Vec<_>>());
        assert!(all.ends_with(&[4096]) && all.len() < 400, "{all:?}");
        assert!(all.windows(2).all(|pair| pair[1] - pair[0] <= 1 + pair[0] / 25), "{all:?}");
        assert_eq!(prefixes(&[9, 5], None).compared(), [5, 9]);
    }

    #[test]
    fn listed_numbers_are_those_prefixes() {
        let Prefixes { computed, shown, .. } = prefixes(&[16, 8, 16, 4], None);
        assert_eq!((computed, shown), (vec![4, 8, 16], vec![4, 8, 16]));
        assert_eq!(prefixes(&[16, 8, 4], Some(9)).shown, [4, 8]);
        assert_eq!(Prefixes::new(&[16, 8], Some(7)), None);
        let many: Vec<usize> = (1..=60).collect();
        assert_eq!(prefixes(&many, None).in_table(9), many);
    }

    #[test]
    fn tables_have_few_rows() {
        let all = prefixes(&[4096], None);
        for sequences in 1..=12 {
            let rows = all.in_table(sequences);
            assert!(rows.ends_with(&[4096]) && rows.len() >= 6, "{rows:?}");
            assert!(sequences * rows.len() <= MAX_SHOWN.max(6 * sequences), "{rows:?}");
        }
    }
}
