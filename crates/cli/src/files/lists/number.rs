//! The numbers of lists, in text and in arrays.

use std::fmt::{Display, Write};
use std::num::IntErrorKind;

use crate::files::npy::ItemType;

/// The number type of a list: `f64` for finite reals, `i128` for integers of any 64-bit type.
pub(crate) trait Number: Copy + Default + Display {
    /// The valid content of a text field, for messages.
    const EXPECTED: &'static str;
    /// The valid item types of arrays, for messages.
    const ITEM_TYPES: &'static str;

    /// Returns the number in a text field.
    fn of_text(field: &str) -> Option<Self>;

    /// Returns whether items of this type are supported.
    fn takes(item: ItemType) -> bool;

    /// Returns the number of an item's bits, for a type that [`takes`](Self::takes) supports.
    fn of_bits(item: ItemType, bits: u64) -> Self;

    /// Returns whether a list may contain this number.
    fn is_expected(self) -> bool;
}

impl Number for f64 {
    const EXPECTED: &'static str = "a finite number";
    const ITEM_TYPES: &'static str = "numbers of type float64 or float32";

    fn of_text(field: &str) -> Option<Self> {
        field.parse().ok().filter(|number: &Self| number.is_expected())
    }

    fn takes(item: ItemType) -> bool {
        item.is_float()
    }

    fn of_bits(item: ItemType, bits: u64) -> Self {
        item.float(bits)
    }

    fn is_expected(self) -> bool {
        self.is_finite()
    }
}

impl Number for i128 {
    const EXPECTED: &'static str = "an integer";
    const ITEM_TYPES: &'static str = "integers, such as int64 (astype(np.int64) converts)";

    fn of_text(field: &str) -> Option<Self> {
        // Nearly all numbers are of this kind, and the wide parser is slower.
        if let Ok(number) = field.parse::<u64>() {
            return Some(number.into());
        }
        match field.parse() {
            Ok(number) => Some(number),
            // It is still an integer; callers with a range reject it as out of range.
            Err(error) => match error.kind() {
                IntErrorKind::PosOverflow => Some(Self::MAX),
                IntErrorKind::NegOverflow => Some(Self::MIN),
                _ => None,
            },
        }
    }

    fn takes(item: ItemType) -> bool {
        !item.is_float()
    }

    fn of_bits(item: ItemType, bits: u64) -> Self {
        item.integer(bits)
    }

    fn is_expected(self) -> bool {
        true
    }
}

/// The type of numbers that a list is written from.
pub(crate) trait Written: Copy + npyz::Serialize {
    /// The item type of an NPY array of these numbers, in little-endian order.
    const DESCR: &'static str;

    /// Appends the shortest digits that are read back as the same number.
    fn append_to(self, text: &mut String);
}

impl Written for f64 {
    const DESCR: &'static str = "<f8";

    fn append_to(self, text: &mut String) {
        // Writing to a string cannot fail.
        let _ = write!(text, "{self:?}");
    }
}

impl Written for i64 {
    const DESCR: &'static str = "<i8";

    fn append_to(self, text: &mut String) {
        // Writing to a string cannot fail.
        let _ = write!(text, "{self}");
    }
}
