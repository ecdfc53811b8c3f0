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
    use std::fmt;
    use std::marker::PhantomData;

    use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};
    use serde::ser::{Serialize, SerializeTuple, Serializer};
    use sphvar_sh::TailClasses;

    use super::ClassMoments;

    /// The moments of the classes in order, without their number.
    impl<T: TailClasses> Serialize for ClassMoments<T> {
        fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
            let mut tuple = serializer.serialize_tuple(T::COUNT)?;
            for moments in &self.classes {
                tuple.serialize_element(moments)?;
            }
            tuple.end()
        }
    }

    impl<'de, T: TailClasses> Deserialize<'de> for ClassMoments<T> {
        fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
            deserializer.deserialize_tuple(T::COUNT, Classes(PhantomData))
        }
    }

    struct Classes<T>(PhantomData<T>);

    impl<'de, T: TailClasses> Visitor<'de> for Classes<T> {
        type Value = ClassMoments<T>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(f, "the moments of {} classes", T::COUNT)
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
            let next = |class| {
                let moments = seq.next_element()?;
                moments.ok_or_else(|| A::Error::invalid_length(class, &self))
            };
            let classes = (0..T::COUNT).map(next).collect::<Result<_, _>>()?;
            Ok(ClassMoments { classes, values: PhantomData })
        }
    }
}
