//! Numbers as lists hold them, in text and in arrays.

use std::fmt::{Display, Write};
use std::num::IntErrorKind;

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
        item.kind == ItemKind::Float
    }

    fn of_bits(item: ItemType, bits: u64) -> Self {
        match u32::try_from(bits) {
            Ok(bits) if item.size == 4 => f32::from_bits(bits).into(),
            _ => Self::from_bits(bits),
        }
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
        item.kind != ItemKind::Float
    }

    fn of_bits(item: ItemType, bits: u64) -> Self {
        if item.kind == ItemKind::Unsigned {
            return bits.into();
        }
        // The sign bit of a short item goes to the top and is spread on the way back.
        let unused = u64::BITS - 8 * u32::from(item.size);
        ((bits << unused).cast_signed() >> unused).into()
    }

    fn is_expected(self) -> bool {
        true
    }
}

/// The families of item types that arrays of numbers have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ItemKind {
    /// 4 or 8 bytes.
    Float,
    /// 1, 2, 4 or 8 bytes, two's complement.
    Signed,
    /// 1, 2, 4 or 8 bytes.
    Unsigned,
}

/// The item type of an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ItemType {
    pub(super) kind: ItemKind,
    /// Bytes of one item, at most 8.
    pub(super) size: u8,
    pub(super) big_endian: bool,
}

impl ItemType {
    /// Returns the type that a `descr` such as `<i8` names; `None` for all but floats and integers.
    pub(super) fn of_descr(descr: &str) -> Option<Self> {
        let &[order, kind, size] = descr.as_bytes() else {
            return None;
        };
        let size = size.checked_sub(b'0')?;
        let kind = match (kind, size) {
            (b'f', 4 | 8) => ItemKind::Float,
            (b'i', 1 | 2 | 4 | 8) => ItemKind::Signed,
            (b'u', 1 | 2 | 4 | 8) => ItemKind::Unsigned,
            _ => return None,
        };
        let big_endian = match order {
            b'<' => false,
            b'>' => true,
            // A single byte has no order.
            b'|' if size == 1 => false,
            _ => return None,
        };
        Some(Self { kind, size, big_endian })
    }

    /// Returns the bits of one item, its lowest byte lowest, with zeros above.
    pub(super) fn bits(self, bytes: &[u8]) -> u64 {
        let append = |bits: u64, byte: &u8| (bits << 8) | u64::from(*byte);
        if self.big_endian {
            bytes.iter().fold(0, append)
        } else {
            bytes.iter().rev().fold(0, append)
        }
    }
}

/// What a list is written from.
pub(crate) trait Written: Copy {
    /// What an NPY array holds, 8 bytes in little-endian order.
    type Stored: npyz::Serialize + npyz::AutoSerialize;
    /// The item type of that array.
    const DESCR: &'static str;

    /// Returns the number as an array holds it.
    fn stored(self) -> Self::Stored;

    /// Appends the shortest digits that are read back to the same number.
    fn append_to(self, text: &mut String);
}

impl Written for f64 {
    type Stored = Self;
    const DESCR: &'static str = "<f8";

    fn stored(self) -> Self {
        self
    }

    fn append_to(self, text: &mut String) {
        // Writing to a string cannot fail.
        let _ = write!(text, "{self:?}");
    }
}

impl Written for i64 {
    type Stored = Self;
    const DESCR: &'static str = "<i8";

    fn stored(self) -> Self {
        self
    }

    fn append_to(self, text: &mut String) {
        // Writing to a string cannot fail.
        let _ = write!(text, "{self}");
    }
}
