use std::fmt::Debug;

/// One number for each class of bands whose mean power at large radii can differ.
///
/// On the sphere, even and odd degrees are the classes ([`ByParity`](crate::ByParity)); on the
/// square, the frequencies off the axes and those of either axis ([`ByAxis`](crate::ByAxis)).
///
/// # Examples
///
/// ```
/// use sphvar_sh::{ByAxis, TailClasses};
///
/// let power = ByAxis { off: 1.0, u: 4.0, v: 3.0 };
/// let energy = ByAxis::from_fn(|class| class as f64);
/// assert_eq!((power.get(1), energy.sum(), power.dot(energy)), (4.0, 3.0, 10.0));
/// ```
pub trait TailClasses: Copy + Debug + Default + PartialEq + Send + Sync {
    /// The number of classes.
    const COUNT: usize;

    /// Returns the values `f(class)` of all classes.
    fn from_fn(f: impl FnMut(usize) -> f64) -> Self;

    /// Returns the value of a class below [`Self::COUNT`].
    fn get(&self, class: usize) -> f64;

    /// Returns the same value for all classes.
    #[must_use]
    fn all(value: f64) -> Self {
        Self::from_fn(|_| value)
    }

    /// Returns `f` of every value.
    #[must_use]
    fn map(self, mut f: impl FnMut(f64) -> f64) -> Self {
        Self::from_fn(|class| f(self.get(class)))
    }

    /// Returns the sum of the values.
    #[must_use]
    fn sum(self) -> f64 {
        (0..Self::COUNT).map(|class| self.get(class)).sum()
    }

    /// Returns the sum of the products with the values of `other`.
    #[must_use]
    fn dot(self, other: Self) -> f64 {
        (0..Self::COUNT).map(|class| self.get(class) * other.get(class)).sum()
    }
}
