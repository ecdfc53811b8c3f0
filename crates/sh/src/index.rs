use core::ops::Range;

use crate::Error;

/// The maximum supported degree, one million.
///
/// Up to this degree every integer in a recurrence coefficient, such as `(2l + 3)(l + 1 + m)`, is
/// exact in `f64` (below `2^53`), and every binary exponent fits in an `i64` with a large margin.
pub const MAX_DEGREE: usize = 1_000_000;

/// Position of the coefficient `(l, m)`, `0 <= m <= l <= lmax`, in a flat array.
///
/// ```text
/// i(l, m) = m (2 lmax + 1 - m) / 2 + l
/// ```
///
/// The order is that of healpy: all degrees of `m = 0` first, then `l = 1..=lmax` of `m = 1`, and
/// so on. A column of fixed `m` is therefore contiguous. `lmax` is inclusive. All arrays of this
/// workspace indexed by `(l, m)` use this type.
///
/// # Examples
///
/// ```
/// use sphvar_sh::LmIndex;
///
/// let index = LmIndex::new(2)?;
/// let order: Vec<_> = index.iter().collect();
/// assert_eq!(order, [(0, 0), (1, 0), (2, 0), (1, 1), (2, 1), (2, 2)]);
/// assert_eq!(index.at(2, 1), 4);
/// assert_eq!(index.column(1), 3..5);
/// # Ok::<(), sphvar_sh::Error>(())
/// ```
///
/// # References
///
/// Górski et al. 2005, doi:10.1086/427976; the layout is that of the `a_lm` files of HEALPix.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LmIndex {
    lmax: usize,
}

impl LmIndex {
    /// Returns the index for degrees `0..=lmax`.
    ///
    /// # Errors
    ///
    /// [`Error::DegreeTooLarge`] if `lmax` exceeds [`MAX_DEGREE`] or the length does not fit in a
    /// `usize`.
    pub fn new(lmax: usize) -> Result<Self, Error> {
        let fits = lmax <= MAX_DEGREE && (lmax + 1).checked_mul(lmax + 2).is_some();
        if fits { Ok(Self { lmax }) } else { Err(Error::DegreeTooLarge { lmax, max: MAX_DEGREE }) }
    }

    /// Returns the maximum degree, inclusive.
    #[must_use]
    pub const fn lmax(self) -> usize {
        self.lmax
    }

    /// Returns the number of pairs, `(lmax + 1)(lmax + 2) / 2`.
    #[must_use]
    #[expect(clippy::len_without_is_empty, reason = "never empty: contains (0, 0)")]
    pub const fn len(self) -> usize {
        (self.lmax + 1) * (self.lmax + 2) / 2
    }

    /// Returns the position of `(l, m)`.
    ///
    /// # Panics
    ///
    /// Panics unless `m <= l <= lmax`; the formula would return the position of another pair.
    #[must_use]
    #[inline]
    pub fn at(self, l: usize, m: usize) -> usize {
        assert!(
            m <= l && l <= self.lmax,
            "m <= l <= lmax violated: l = {l}, m = {m}, lmax = {}",
            self.lmax
        );
        self.column_base(m) + l
    }

    /// Returns the positions of `l = m..=lmax` at fixed `m`.
    ///
    /// # Panics
    ///
    /// Panics if `m > lmax`.
    #[must_use]
    #[inline]
    pub fn column(self, m: usize) -> Range<usize> {
        assert!(m <= self.lmax, "m <= lmax violated: m = {m}, lmax = {}", self.lmax);
        let base = self.column_base(m);
        base + m..base + self.lmax + 1
    }

    /// Returns all pairs `(l, m)` in the order of their positions.
    pub fn iter(self) -> impl Iterator<Item = (usize, usize)> {
        (0..=self.lmax).flat_map(move |m| (m..=self.lmax).map(move |l| (l, m)))
    }

    /// Returns `i(l, m) - l`; one factor of the product is even.
    const fn column_base(self, m: usize) -> usize {
        m * (2 * self.lmax + 1 - m) / 2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn iteration_visits_positions_in_order() {
        for lmax in [0, 1, 2, 7, 64] {
            let index = LmIndex::new(lmax).unwrap();
            let pairs: Vec<_> = index.iter().collect();
            assert_eq!(pairs.len(), index.len(), "lmax = {lmax}");
            for (i, &(l, m)) in pairs.iter().enumerate() {
                assert_eq!(index.at(l, m), i, "lmax = {lmax}, l = {l}, m = {m}");
                assert!(index.column(m).contains(&i), "lmax = {lmax}, l = {l}, m = {m}");
            }
            let columns: usize = (0..=lmax).map(|m| index.column(m).len()).sum();
            assert_eq!(columns, index.len(), "lmax = {lmax}");
        }
    }

    #[test]
    fn degrees_out_of_range_are_rejected() {
        for lmax in [MAX_DEGREE + 1, usize::MAX - 1, usize::MAX] {
            assert_eq!(LmIndex::new(lmax), Err(Error::DegreeTooLarge { lmax, max: MAX_DEGREE }));
        }
        let index = LmIndex::new(MAX_DEGREE).unwrap();
        assert_eq!(index.at(MAX_DEGREE, MAX_DEGREE) + 1, index.len());
    }

    #[test]
    #[should_panic(expected = "m <= l <= lmax violated")]
    fn order_above_degree_panics() {
        let _ = LmIndex::new(4).unwrap().at(2, 3);
    }
}
