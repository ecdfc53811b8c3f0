//! Serialization of one value for each class of bands: in order, without their number.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};
use serde::ser::{Serialize, SerializeTuple, Serializer};
use sphvar_sh::TailClasses;

/// Writes the values of all classes.
///
/// # Errors
///
/// Those of the serializer.
pub(crate) fn serialize<T: TailClasses, S: Serializer>(
    values: &T,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serialize_each((0..T::COUNT).map(|class| values.get(class)), T::COUNT, serializer)
}

/// Reads the values of all classes.
///
/// # Errors
///
/// Those of the deserializer, and an error for another number of values.
pub(crate) fn deserialize<'de, T: TailClasses, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<T, D::Error> {
    let values: Vec<f64> = deserialize_each(T::COUNT, deserializer)?;
    Ok(T::from_fn(|class| values[class]))
}

/// Writes the elements of classes.
///
/// # Errors
///
/// Those of the serializer.
pub(crate) fn serialize_each<V: Serialize, S: Serializer>(
    elements: impl Iterator<Item = V>,
    count: usize,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    let mut tuple = serializer.serialize_tuple(count)?;
    for element in elements {
        tuple.serialize_element(&element)?;
    }
    tuple.end()
}

/// Reads the elements of `count` classes.
///
/// # Errors
///
/// Those of the deserializer, and an error for another number of elements.
pub(crate) fn deserialize_each<'de, V: Deserialize<'de>, D: Deserializer<'de>>(
    count: usize,
    deserializer: D,
) -> Result<Vec<V>, D::Error> {
    deserializer.deserialize_tuple(count, Classes { count, elements: PhantomData })
}

struct Classes<V> {
    count: usize,
    elements: PhantomData<V>,
}

impl<'de, V: Deserialize<'de>> Visitor<'de> for Classes<V> {
    type Value = Vec<V>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the values of {} classes", self.count)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
        let next = |class| {
            let element = seq.next_element()?;
            element.ok_or_else(|| A::Error::invalid_length(class, &self))
        };
        (0..self.count).map(next).collect()
    }
}
