use crate::TailClasses;

/// A value for even and one for odd degrees, the two classes that a point set or function can
/// distinguish at any degree: `Y_lm(-x) = (-1)^l Y_lm(x)`.
///
/// # Examples
///
/// ```
/// use sphvar_sh::ByParity;
///
/// // The mean power of an antipodally symmetric point set at high degrees.
/// let power = ByParity { even: 2.0, odd: 0.0 };
/// assert_eq!((*power.of(6), *power.of(7), power.sum()), (2.0, 0.0, 2.0));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ByParity<T = f64> {
    /// The value of even degrees.
    pub even: T,
    /// The value of odd degrees.
    pub odd: T,
}

impl<T> ByParity<T> {
    /// Returns the value for degree `l`.
    #[must_use]
    pub fn of(&self, l: usize) -> &T {
        if l.is_multiple_of(2) { &self.even } else { &self.odd }
    }

    /// Returns the value for degree `l`, mutably.
    #[must_use]
    pub fn of_mut(&mut self, l: usize) -> &mut T {
        if l.is_multiple_of(2) { &mut self.even } else { &mut self.odd }
    }

    /// Returns references to both values.
    #[must_use]
    pub fn as_ref(&self) -> ByParity<&T> {
        ByParity { even: &self.even, odd: &self.odd }
    }

    /// Returns `f` of both values.
    #[must_use]
    pub fn map<U>(self, mut f: impl FnMut(T) -> U) -> ByParity<U> {
        ByParity { even: f(self.even), odd: f(self.odd) }
    }

    /// Returns both pairs of values.
    #[must_use]
    pub fn zip<U>(self, other: ByParity<U>) -> ByParity<(T, U)> {
        ByParity { even: (self.even, other.even), odd: (self.odd, other.odd) }
    }
}

impl ByParity {
    /// Returns the same value for both parities.
    #[must_use]
    pub const fn both(value: f64) -> Self {
        Self { even: value, odd: value }
    }

    /// Returns the sum of the two values.
    #[must_use]
    pub fn sum(self) -> f64 {
        self.even + self.odd
    }

    /// Returns `sum_p self_p other_p` over the two parities.
    #[must_use]
    pub fn dot(self, other: Self) -> f64 {
        self.even * other.even + self.odd * other.odd
    }
}

/// Class 0 has the even degrees, class 1 the odd ones.
impl TailClasses for ByParity {
    const COUNT: usize = 2;

    fn from_fn(mut f: impl FnMut(usize) -> f64) -> Self {
        Self { even: f(0), odd: f(1) }
    }

    fn get(&self, class: usize) -> f64 {
        *self.of(class)
    }
}
