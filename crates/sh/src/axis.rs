use crate::TailClasses;

/// The values of frequencies off the axes, of (k, 0) and of (0, k): the three classes of bands of
/// the square whose mean power a point set can distinguish at any radius.
///
/// The power on an axis is that of the projection of the points onto one coordinate. Class 0 is
/// `off`, class 1 `u`, class 2 `v`.
///
/// # Examples
///
/// ```
/// use sphvar_sh::{ByAxis, TailClasses};
///
/// // The mean power of a grid of 8 x 4 points at high frequencies: every coordinate u occurs four
/// // times, every v eight times.
/// let power = ByAxis { off: 1.0, u: 4.0, v: 8.0 };
/// assert_eq!(power, ByAxis::from_fn(|class| [1.0, 4.0, 8.0][class]));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ByAxis<T = f64> {
    /// The value of frequencies (k1, k2) with nonzero k1 and k2.
    pub off: T,
    /// The value of frequencies (k, 0), the spectrum of the first coordinate.
    pub u: T,
    /// The value of frequencies (0, k), the spectrum of the second coordinate.
    pub v: T,
}

impl TailClasses for ByAxis {
    const COUNT: usize = 3;

    fn from_fn(mut f: impl FnMut(usize) -> f64) -> Self {
        Self { off: f(0), u: f(1), v: f(2) }
    }

    fn get(&self, class: usize) -> f64 {
        match class {
            0 => self.off,
            1 => self.u,
            _ => self.v,
        }
    }
}
