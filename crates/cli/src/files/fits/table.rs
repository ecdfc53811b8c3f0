//! Columns of FITS tables, binary and ASCII: their position in a row and the meaning of their
//! bytes.

use std::borrow::Cow;

use super::hdu::{Hdu, HduKind, keyword_error};
use super::header::{Header, Value};
use crate::files::file_error::FileError;

/// An item of a row of a table.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Item<'r> {
    Number(f64),
    Text(Cow<'r, str>),
    /// An undefined value (TNULL, a blank field, a logical 0).
    Missing,
}

/// A column of a table.
#[derive(Clone, Debug)]
pub(crate) struct TableColumn {
    /// TTYPE, empty if there is none.
    pub(crate) name: String,
    /// TUNIT, empty if there is none.
    pub(crate) unit: String,
    /// The number of numbers in a row; 0 if they are not supported: complex numbers, arrays of
    /// variable length.
    pub(crate) items: usize,
    /// The offset of the first byte in a row.
    pub(crate) start: usize,
    /// The number of bytes in a row.
    pub(crate) width: usize,
    kind: Kind,
    scale: f64,
    zero: f64,
    null: Option<i64>,
    null_text: Option<String>,
}

/// The type of the items of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Logical,
    Bit,
    /// Unsigned, of 1 byte.
    Byte,
    /// A signed integer of this number of bytes.
    Integer(usize),
    /// An IEEE float of this number of bytes.
    Float(usize),
    Text,
    /// A number as text, with this number of decimals if it has no decimal point.
    Decimal(i32),
    Unreadable,
}

impl TableColumn {
    /// Returns the columns of a table.
    ///
    /// # Errors
    /// When TFIELDS or a TFORM is missing or malformed, or a column does not fit in a row.
    pub(crate) fn of_table(hdu: &Hdu, path: &str) -> Result<Vec<Self>, FileError> {
        let header = &hdu.header;
        if header.logical("ZTABLE") == Some(true) {
            let expected = "a table that is not compressed (funpack unpacks it)";
            return Err(keyword_error(path, "ZTABLE", expected, "T"));
        }
        let fields = header.integer("TFIELDS").and_then(|n| u16::try_from(n).ok());
        let fields = fields.filter(|&n| n <= 999).ok_or_else(|| {
            let got = header.number("TFIELDS").map_or("nothing".to_owned(), |n| n.to_string());
            keyword_error(path, "TFIELDS", "a number from 0 to 999", &got)
        })?;
        let row = header.integer("NAXIS1").and_then(|n| usize::try_from(n).ok()).unwrap_or(0);
        let mut columns = Vec::new();
        let mut end = 0_usize;
        for i in 1..=fields {
            let keyword = format!("TFORM{i}");
            let form = header.text(&keyword).ok_or_else(|| {
                keyword_error(path, &keyword, "the type of the column", "no such keyword")
            })?;
            let column = match hdu.kind {
                HduKind::AsciiTable => Self::ascii(header, i, form),
                _ => Self::binary(header, i, form, end),
            };
            let column = column.ok_or_else(|| {
                keyword_error(path, &keyword, "a type of columns", &format!("'{form}'"))
            })?;
            end = column.start.checked_add(column.width).filter(|&end| end <= row).ok_or_else(
                || {
                    let expected = format!("columns that fit in a row of NAXIS1 = {row} bytes");
                    keyword_error(path, &keyword, &expected, &format!("'{form}'"))
                },
            )?;
            columns.push(column);
        }
        Ok(columns)
    }

    /// Returns a row of this number of pixels of an image as a column without a name, or `None` if
    /// BITPIX is invalid.
    pub(crate) fn of_image(header: &Header, items: usize) -> Option<Self> {
        let (kind, bytes) = match header.integer("BITPIX")? {
            8 => (Kind::Byte, 1),
            16 => (Kind::Integer(2), 2),
            32 => (Kind::Integer(4), 4),
            64 => (Kind::Integer(8), 8),
            -32 => (Kind::Float(4), 4),
            -64 => (Kind::Float(8), 8),
            _ => return None,
        };
        Some(Self {
            name: String::new(),
            unit: String::new(),
            items,
            start: 0,
            width: items.checked_mul(bytes)?,
            kind,
            scale: header.number("BSCALE").unwrap_or(1.0),
            zero: header.number("BZERO").unwrap_or(0.0),
            null: header.integer("BLANK"),
            null_text: None,
        })
    }

    fn binary(header: &Header, i: u16, form: &str, start: usize) -> Option<Self> {
        let form = form.trim();
        let digits = form.find(|c: char| !c.is_ascii_digit())?;
        let (repeat, kind) = form.split_at(digits);
        let repeat: usize = if repeat.is_empty() { 1 } else { repeat.parse().ok()? };
        let (kind, bytes) = match kind.chars().next()? {
            'L' => (Kind::Logical, 1),
            'X' => (Kind::Bit, 0),
            'B' => (Kind::Byte, 1),
            'I' => (Kind::Integer(2), 2),
            'J' => (Kind::Integer(4), 4),
            'K' => (Kind::Integer(8), 8),
            'E' => (Kind::Float(4), 4),
            'D' => (Kind::Float(8), 8),
            'A' => (Kind::Text, 1),
            'C' | 'P' => (Kind::Unreadable, 8),
            'M' | 'Q' => (Kind::Unreadable, 16),
            _ => return None,
        };
        let width = match kind {
            Kind::Bit => repeat.div_ceil(8),
            _ => repeat.checked_mul(bytes)?,
        };
        let items = match kind {
            Kind::Unreadable => 0,
            Kind::Text => repeat.min(1),
            _ => repeat,
        };
        Some(Self::new(header, i, kind, items, start, width))
    }

    fn ascii(header: &Header, i: u16, form: &str) -> Option<Self> {
        let start = header.integer(&format!("TBCOL{i}")).and_then(|n| usize::try_from(n).ok())?;
        let form = form.trim();
        let letter = form.chars().next()?;
        let (width, decimals) = match form[letter.len_utf8()..].split_once('.') {
            Some((width, decimals)) => (width, decimals.parse().ok()?),
            None => (&form[letter.len_utf8()..], 0_u8),
        };
        let width = width.parse().ok()?;
        let kind = match letter {
            'A' => Kind::Text,
            'I' => Kind::Decimal(0),
            'F' | 'E' | 'D' => Kind::Decimal(decimals.into()),
            _ => return None,
        };
        Some(Self::new(header, i, kind, 1, start.checked_sub(1)?, width))
    }

    fn new(header: &Header, i: u16, kind: Kind, items: usize, start: usize, width: usize) -> Self {
        let text = |keyword: &str| header.text(&format!("{keyword}{i}")).unwrap_or_default();
        let number = |keyword: &str| header.number(&format!("{keyword}{i}"));
        let null = format!("TNULL{i}");
        Self {
            name: text("TTYPE").trim().to_owned(),
            unit: text("TUNIT").trim().to_owned(),
            items,
            start,
            width,
            kind,
            scale: number("TSCAL").unwrap_or(1.0),
            zero: number("TZERO").unwrap_or(0.0),
            null: header.integer(&null),
            null_text: match header.get(&null) {
                Some(Value::Text(text)) => Some(text.trim().to_owned()),
                _ => None,
            },
        }
    }

    /// Returns an item, from 0 and below [`items`](Self::items), of a row.
    ///
    /// # Panics
    ///
    /// If the index is out of range or the row is shorter than NAXIS1.
    pub(crate) fn item<'r>(&self, row: &'r [u8], index: usize) -> Item<'r> {
        let bytes = &row[self.start..self.start + self.width];
        match self.kind {
            Kind::Logical => match bytes[index] {
                b'T' => Item::Number(1.0),
                b'F' => Item::Number(0.0),
                _ => Item::Missing,
            },
            Kind::Bit => Item::Number(f64::from((bytes[index / 8] >> (7 - index % 8)) & 1)),
            Kind::Byte => self.integer(bytes[index].into()),
            Kind::Integer(size) => {
                let item = &bytes[index * size..][..size];
                let sign = if item[0] >> 7 == 1 { -1 } else { 0 };
                self.integer(item.iter().fold(sign, |sum, &byte| (sum << 8) | i64::from(byte)))
            }
            Kind::Float(size) => {
                let item = &bytes[index * size..][..size];
                let bits = item.iter().fold(0_u64, |sum, &byte| (sum << 8) | u64::from(byte));
                self.scaled(match u32::try_from(bits) {
                    Ok(bits) if size == 4 => f32::from_bits(bits).into(),
                    _ => f64::from_bits(bits),
                })
            }
            Kind::Text => {
                let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
                match String::from_utf8_lossy(&bytes[..end]) {
                    Cow::Borrowed(text) => Item::Text(text.trim().into()),
                    Cow::Owned(text) => Item::Text(text.trim().to_owned().into()),
                }
            }
            Kind::Decimal(decimals) => self.decimal(&String::from_utf8_lossy(bytes), decimals),
            Kind::Unreadable => Item::Missing,
        }
    }

    /// Replaces `out` by the items of a row of a column of floats; returns false, without changes, for
    /// other columns.
    pub(crate) fn floats(&self, row: &[u8], out: &mut [f64]) -> bool {
        let bytes = &row[self.start..self.start + self.width];
        match self.kind {
            Kind::Float(4) => {
                for (out, &item) in out.iter_mut().zip(bytes.as_chunks().0) {
                    *out = self.scale * f64::from(f32::from_be_bytes(item)) + self.zero;
                }
                true
            }
            Kind::Float(8) => {
                for (out, &item) in out.iter_mut().zip(bytes.as_chunks().0) {
                    *out = self.scale * f64::from_be_bytes(item) + self.zero;
                }
                true
            }
            _ => false,
        }
    }

    fn integer<'r>(&self, value: i64) -> Item<'r> {
        if self.null == Some(value) {
            return Item::Missing;
        }
        // Unsigned numbers are stored with TZERO = 2^15, 2^31 or 2^63: the sum is rounded once.
        #[expect(clippy::float_cmp, reason = "the default, which is exact")]
        let is_shift = self.scale == 1.0 && self.zero.fract() == 0.0 && self.zero.abs() < 2e19;
        if is_shift {
            #[expect(clippy::cast_possible_truncation, reason = "a whole number below 2^65")]
            let shift = self.zero as i128;
            return Item::Number((i128::from(value) + shift) as f64);
        }
        self.scaled(value as f64)
    }

    fn scaled<'r>(&self, value: f64) -> Item<'r> {
        Item::Number(self.scale * value + self.zero)
    }

    fn decimal<'r>(&self, field: &str, decimals: i32) -> Item<'r> {
        let field = field.trim();
        if field.is_empty() || self.null_text.as_deref() == Some(field) {
            return Item::Missing;
        }
        match field.replace(['D', 'd'], "E").parse::<f64>() {
            Ok(value) if field.contains('.') || decimals == 0 => self.scaled(value),
            // A decimal point is implied where none is written.
            Ok(value) => self.scaled(value * 10_f64.powi(-decimals)),
            Err(_) => Item::Text(field.to_owned().into()),
        }
    }
}
