use std::fmt;
use std::marker::PhantomData;

use sphvar_sh::TailClasses;

use crate::Moments;

/// Moments of values that are given for each class of bands ([`TailClasses`]), such as the mean
/// power of realizations beyond their last band.
///
/// # Examples
///
/// ```
/// use sphvar_sh::ByParity;
/// use sphvar_spectrum::ClassMoments;
///
/// let mut moments = ClassMoments::default();
/// moments.push(ByParity { even: 2.0, odd: 0.0 });
/// moments.push(ByParity { even: 1.0, odd: 1.0 });
/// assert_eq!(moments.mean(), ByParity { even: 1.5, odd: 0.5 });
/// ```
#[derive(Clone)]
pub struct ClassMoments<T> {
    classes: Vec<Moments>,
    values: PhantomData<T>,
}

impl<T: TailClasses> ClassMoments<T> {
    /// Adds a value of each class.
    pub fn push(&mut self, values: T) {
        for (class, moments) in self.classes.iter_mut().enumerate() {
            moments.push(values.get(class));
        }
    }

    /// Adds the values of `other`.
    pub fn merge(&mut self, other: &Self) {
        for (mine, theirs) in self.classes.iter_mut().zip(&other.classes) {
            mine.merge(theirs);
        }
    }

    /// Returns the number of values added; `None` if it differs between the classes, which is
    /// possible only for deserialized moments.
    #[must_use]
    pub fn count(&self) -> Option<u64> {
        let count = self.classes.first()?.count();
        self.classes.iter().all(|moments| moments.count() == count).then_some(count)
    }

    /// Returns the means, see [`Moments::mean`].
    #[must_use]
    pub fn mean(&self) -> T {
        T::from_fn(|class| self.classes[class].mean())
    }

    /// Returns the standard errors of the means, see [`Moments::standard_error`].
    #[must_use]
    pub fn standard_error(&self) -> T {
        T::from_fn(|class| self.classes[class].standard_error())
    }
}

impl<T: TailClasses> Default for ClassMoments<T> {
    fn default() -> Self {
        Self { classes: vec![Moments::default(); T::COUNT], values: PhantomData }
    }
}

impl<T> fmt::Debug for ClassMoments<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(&self.classes).finish()
    }
}

#[cfg(feature = "serde")]
mod serialization {
    use std::marker::PhantomData;

    use serde::de::{Deserialize, Deserializer};
    use serde::ser::{Serialize, Serializer};
    use sphvar_sh::TailClasses;

    use super::ClassMoments;
    use crate::class_values::{deserialize_each, serialize_each};

    /// The moments of the classes in order, without their number.
    impl<T: TailClasses> Serialize for ClassMoments<T> {
        fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            serialize_each(self.classes.iter(), T::COUNT, serializer)
        }
    }

    impl<'de, T: TailClasses> Deserialize<'de> for ClassMoments<T> {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            let classes = deserialize_each(T::COUNT, deserializer)?;
            Ok(Self { classes, values: PhantomData })
        }
    }
}
