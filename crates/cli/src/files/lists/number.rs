//! Numbers as lists hold them, in text and in arrays.

use std::fmt::{Display, Write};
use std::num::IntErrorKind;

use crate::files::npy::ItemType;

/// What a list is read into: `f64` for finite reals, `i128` for integers of any 64-bit type.
pub(crate) trait Number: Copy + Default + Display {
    /// What a field of text has to be, for messages.
    const EXPECTED: &'static str;
    /// The item types of arrays, for messages.
    const ITEM_TYPES: &'static str;

    /// Returns the number that a field of text shows.
    fn of_text(field: &str) -> Option<Self>;

    /// Returns whether items of this type can be read.
    fn takes(item: ItemType) -> bool;

    /// Returns the number that an item's bits show, for a type that [`takes`](Self::takes) allows.
    fn of_bits(item: ItemType, bits: u64) -> Self;

    /// Returns whether this is a number that lists may hold.
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
        // Nearly all are of this kind, and the wide parser is slower.
        if let Ok(number) = field.parse::<u64>() {
            return Some(number.into());
        }
        match field.parse() {
            Ok(number) => Some(number),
            // An integer all the same: whoever asks for a range will refuse it as beyond that.
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

/// What a list is written from.
pub(crate) trait Written: Copy + npyz::Serialize {
    /// The item type of an NPY array of these numbers, in little-endian order.
    const DESCR: &'static str;

    /// Appends the shortest digits that are read back to the same number.
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
