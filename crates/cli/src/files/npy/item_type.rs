//! The item types of arrays of plain numbers.

/// The item type of an array: a float of 4 or 8 bytes, or an integer of 1, 2, 4 or 8 bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ItemType {
    kind: ItemKind,
    /// Bytes of one item, at most 8.
    size: u8,
    big_endian: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ItemKind {
    Float,
    /// Two's complement.
    Signed,
    Unsigned,
}

impl ItemType {
    /// Returns the type of a `descr` such as `<i8`, or `None` if it is neither a float nor an
    /// integer type.
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

    /// Returns whether the items are floats; otherwise they are integers.
    pub(in crate::files) fn is_float(self) -> bool {
        self.kind == ItemKind::Float
    }

    /// Returns the number of bytes of one item.
    pub(in crate::files) fn size(self) -> usize {
        self.size.into()
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

    /// Returns the number of an item's bytes, an integer rounded to a float.
    pub(in crate::files) fn number(self, bytes: &[u8]) -> f64 {
        let bits = self.bits(bytes);
        if self.is_float() { self.float(bits) } else { self.integer(bits) as f64 }
    }

    /// Returns the number of an item's bits, for a float type.
    pub(in crate::files) fn float(self, bits: u64) -> f64 {
        match u32::try_from(bits) {
            Ok(bits) if self.size == 4 => f32::from_bits(bits).into(),
            _ => f64::from_bits(bits),
        }
    }

    /// Returns the number of an item's bits, for an integer type.
    pub(in crate::files) fn integer(self, bits: u64) -> i128 {
        if self.kind == ItemKind::Unsigned {
            return bits.into();
        }
        // The sign bit of a short item is shifted to the top and extended on the way back.
        let unused = u64::BITS - 8 * u32::from(self.size);
        ((bits << unused).cast_signed() >> unused).into()
    }
}
