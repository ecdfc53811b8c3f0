use std::fmt::Debug;
use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use glam::{DVec2, DVec3};

/// A vector in the plane or in space.
pub(crate) trait Vector:
    Copy
    + Debug
    + PartialEq
    + Add<Output = Self>
    + Sub<Output = Self>
    + Neg<Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
    + AddAssign
    + SubAssign
    + Sum
{
    const ZERO: Self;

    fn dot(self, other: Self) -> f64;

    fn length(self) -> f64;

    /// Returns the vector, shortened to `max` if it is longer.
    fn clamp_length_max(self, max: f64) -> Self;
}

macro_rules! vector {
    ($Vector:ty) => {
        impl Vector for $Vector {
            const ZERO: Self = Self::ZERO;

            #[inline(always)]
            fn dot(self, other: Self) -> f64 {
                self.dot(other)
            }

            #[inline(always)]
            fn length(self) -> f64 {
                self.length()
            }

            #[inline(always)]
            fn clamp_length_max(self, max: f64) -> Self {
                self.clamp_length_max(max)
            }
        }
    };
}

vector!(DVec2);
vector!(DVec3);
