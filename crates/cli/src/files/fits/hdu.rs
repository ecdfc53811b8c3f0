//! FITS files as a stream of header and data units (HDUs).
//!
//! The crate `fitsrs` is not used: it needs the whole file in memory, loops over the counts of
//! NAXIS and TFIELDS without a check, and does not support scaled columns and ASCII tables. The
//! names of keywords and the rules are those of the FITS standard, version 4.0.

use std::fmt;
use std::io::{BufRead, Read};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use super::header::{CARD, Header};
use crate::files::file_error::{FileError, Place};
use crate::files::input::SkipBytes;
use crate::files::text_rows::shortened;

/// Headers and data fill blocks of this many bytes.
const BLOCK: u64 = 2880;
/// A header of more cards is damaged: the largest in use have a few thousand.
const MAX_CARDS: usize = 1 << 18;
/// The maximum number of HDUs that a message lists.
const LISTED: usize = 8;

/// The selection of an HDU of a file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) enum HduChoice {
    /// The first HDU with the requested content.
    #[default]
    First,
    /// The HDU with this number; 0 is the primary one.
    Number(usize),
    /// The HDU with this EXTNAME, in any case.
    Name(String),
}

impl FromStr for HduChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim();
        if text.is_empty() {
            return Err(
                "expected the number or the name of an HDU, such as 2 or CATALOG".to_owned()
            );
        }
        Ok(text.parse().map_or_else(|_| Self::Name(text.to_owned()), Self::Number))
    }
}

impl fmt::Display for HduChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::First => f.write_str("the first table"),
            Self::Number(number) => write!(f, "HDU {number}"),
            Self::Name(name) => write!(f, "the HDU named {}", shortened(name)),
        }
    }
}

impl HduChoice {
    /// Returns the path and the HDU of a name such as `file.fits[2]` or `file.fits[CATALOG]`.
    ///
    /// If a file with the whole text as its name exists, that file is meant.
    pub(crate) fn of_path(path: &Path) -> (PathBuf, Self) {
        let whole = || (path.to_path_buf(), Self::First);
        let Some(text) = path.to_str() else { return whole() };
        let Some((file, choice)) = text.strip_suffix(']').and_then(|t| t.rsplit_once('[')) else {
            return whole();
        };
        match choice.parse() {
            Ok(choice) if !path.exists() && Path::new(file).exists() => (file.into(), choice),
            _ => whole(),
        }
    }
}

/// The content of an HDU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum HduKind {
    /// The primary HDU or an image extension.
    Image,
    /// An ASCII table, TABLE.
    AsciiTable,
    /// A binary table, BINTABLE.
    BinaryTable,
    /// An image that is compressed in a binary table.
    CompressedImage,
    /// An extension of another kind.
    Other,
}

/// The header of an HDU.
#[derive(Clone, Debug)]
pub(crate) struct Hdu {
    /// From 0, the primary HDU.
    pub(crate) number: usize,
    pub(crate) kind: HduKind,
    pub(crate) header: Header,
}

impl Hdu {
    /// Returns whether this is a table of either kind.
    pub(crate) fn is_table(&self) -> bool {
        matches!(self.kind, HduKind::AsciiTable | HduKind::BinaryTable)
    }

    /// Returns the bytes of a row of a table, at most `max_row`, and the number of rows.
    ///
    /// # Errors
    /// When NAXIS1 or NAXIS2 is missing, negative, or longer rows are announced.
    pub(crate) fn table_size(&self, path: &str, max_row: usize) -> Result<(usize, u64), FileError> {
        let count = |keyword: &str| {
            let value = self.header.integer(keyword).and_then(|n| u64::try_from(n).ok());
            value.ok_or_else(|| keyword_error(path, keyword, "a number from 0", "another value"))
        };
        let (row, rows) = (count("NAXIS1")?, count("NAXIS2")?);
        let size = usize::try_from(row).ok().filter(|&row| row <= max_row).ok_or_else(|| {
            keyword_error(path, "NAXIS1", &format!("at most {max_row} bytes"), &row.to_string())
        })?;
        Ok((size, rows))
    }

    /// Returns EXTNAME, empty if there is none.
    pub(crate) fn name(&self) -> &str {
        self.header.text("EXTNAME").unwrap_or_default()
    }

    /// Returns a description for lists, such as `[1] table CATALOG`.
    pub(crate) fn summary(&self) -> String {
        let kind = match self.kind {
            HduKind::Image => "image",
            HduKind::AsciiTable | HduKind::BinaryTable => "table",
            HduKind::CompressedImage => "compressed image (funpack unpacks it)",
            HduKind::Other => "other",
        };
        format!("[{}] {kind} {}", self.number, shortened(self.name())).trim_end().to_owned()
    }
}

/// A FITS file that is read sequentially.
pub(crate) struct HduReader<'a, R> {
    input: R,
    path: &'a str,
    /// Unread bytes of the current data unit, including its padding.
    unread: u64,
    /// Bytes that have been read or skipped.
    position: u64,
    next_number: usize,
}

impl<'a, R: BufRead> HduReader<'a, R> {
    /// Returns the reader of a file of this name.
    pub(crate) fn new(input: R, path: &'a str) -> Self {
        Self { input, path, unread: 0, position: 0, next_number: 0 }
    }

    /// Returns the selected HDU if `accepts` is true of its content, with the input at its data.
    ///
    /// # Errors
    ///
    /// When the file cannot be read, is not a FITS file, is truncated before that HDU, or
    /// does not have it; the message lists its HDUs.
    pub(crate) fn select(
        &mut self,
        choice: &HduChoice,
        accepts: impl Fn(&Hdu) -> bool,
        expected: &str,
    ) -> Result<Hdu, FileError> {
        let mut seen = Vec::new();
        while let Some(hdu) = self.next_hdu()? {
            let chosen = match choice {
                HduChoice::First => accepts(&hdu),
                HduChoice::Number(number) => hdu.number == *number,
                HduChoice::Name(name) => hdu.name().eq_ignore_ascii_case(name),
            };
            if chosen && accepts(&hdu) {
                return Ok(hdu);
            }
            if chosen {
                let got = hdu.summary();
                return Err(self.layout(&format!("{expected} in {choice}"), &got));
            }
            if seen.len() < LISTED {
                seen.push(hdu.summary());
            }
        }
        let more = if self.next_number > LISTED { ", ..." } else { "" };
        let wanted = match choice {
            HduChoice::First => expected.to_owned(),
            _ => choice.to_string(),
        };
        Err(self.layout(&wanted, &format!("a FITS file with {}{more}", seen.join(", "))))
    }

    /// Returns the next HDU, with the input at its data; `None` at the end of the file.
    ///
    /// # Errors
    ///
    /// When the file cannot be read, is not a FITS file, or is truncated.
    pub(crate) fn next_hdu(&mut self) -> Result<Option<Hdu>, FileError> {
        self.skip_data()?;
        let Some(header) = self.header()? else { return Ok(None) };
        let number = self.next_number;
        let kind = match header.text("XTENSION") {
            None | Some("IMAGE") => HduKind::Image,
            Some("TABLE") => HduKind::AsciiTable,
            Some("BINTABLE") if header.logical("ZIMAGE") == Some(true) => HduKind::CompressedImage,
            Some("BINTABLE" | "A3DTABLE") => HduKind::BinaryTable,
            Some(_) => HduKind::Other,
        };
        let data_bytes = self.data_bytes(&header, number)?;
        let padded = data_bytes.div_ceil(BLOCK).checked_mul(BLOCK);
        self.unread = padded.ok_or_else(|| self.layout("data that fit in a file", "more"))?;
        self.next_number += 1;
        Ok(Some(Hdu { number, kind, header }))
    }

    /// Reads the next bytes of the data unit.
    ///
    /// # Errors
    ///
    /// When reading fails or the file ends before; `what` describes the data that the
    /// header announces.
    pub(crate) fn read_data(&mut self, bytes: &mut [u8], what: &str) -> Result<(), FileError> {
        let mut filled = 0;
        while filled < bytes.len() {
            match self.input.read(&mut bytes[filled..]) {
                Ok(0) => {
                    return Err(FileError::Truncated {
                        path: self.path.to_owned(),
                        what: what.to_owned(),
                        expected: self.position.saturating_add(self.unread),
                        got: self.position + filled as u64,
                    });
                }
                Ok(read) => filled += read,
                Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
                Err(source) => return Err(self.read_error(source)),
            }
        }
        self.position += bytes.len() as u64;
        self.unread = self.unread.saturating_sub(bytes.len() as u64);
        Ok(())
    }

    /// Skips bytes of the data unit.
    ///
    /// # Errors
    ///
    /// When reading fails.
    pub(in crate::files) fn skip_bytes(&mut self, bytes: u64) -> Result<(), FileError>
    where
        R: SkipBytes,
    {
        self.input.skip_bytes(bytes).map_err(|source| self.read_error(source))?;
        self.position = self.position.saturating_add(bytes);
        self.unread = self.unread.saturating_sub(bytes);
        Ok(())
    }

    /// Returns whether a file of this number of bytes has this number of bytes of the data unit.
    pub(crate) fn fits(&self, data_bytes: u64, file_bytes: u64) -> bool {
        self.position.saturating_add(data_bytes) <= file_bytes
    }

    /// Skips the unread part of the current data unit; the last one may lack its padding.
    fn skip_data(&mut self) -> Result<(), FileError> {
        let mut part = self.input.by_ref().take(self.unread);
        let skipped = std::io::copy(&mut part, &mut std::io::sink());
        let skipped = skipped.map_err(|source| self.read_error(source))?;
        self.position += skipped;
        self.unread = 0;
        Ok(())
    }

    /// Returns the header at the current position, or `None` if the file ends or continues with
    /// other data.
    fn header(&mut self) -> Result<Option<Header>, FileError> {
        let start: &[u8] = if self.next_number == 0 { b"SIMPLE  =" } else { b"XTENSION=" };
        let mut header = Header::default();
        for block_number in 0..MAX_CARDS * CARD / 2880 {
            let mut block = Vec::new();
            let read = self.input.by_ref().take(BLOCK).read_to_end(&mut block);
            read.map_err(|source| self.read_error(source))?;
            if block_number == 0 && !block.starts_with(start) {
                // The standard allows other bytes after the last HDU.
                return match self.next_number {
                    0 => Err(self.layout("a FITS file", "a file that does not start with SIMPLE")),
                    _ => Ok(None),
                };
            }
            let is_last = block.chunks_exact(CARD).any(|card| header.push(card));
            self.position += block.len() as u64;
            if is_last {
                return Ok(Some(header));
            }
            if (block.len() as u64) < BLOCK {
                return Err(FileError::Truncated {
                    path: self.path.to_owned(),
                    what: format!("the header of HDU {}", self.next_number),
                    expected: self.position.next_multiple_of(BLOCK),
                    got: self.position,
                });
            }
        }
        Err(self.layout("a header that ends with END", &format!("{MAX_CARDS} cards without it")))
    }

    /// Returns `|BITPIX|/8 GCOUNT (PCOUNT + NAXIS1 ... NAXISn)`.
    fn data_bytes(&self, header: &Header, number: usize) -> Result<u64, FileError> {
        let count = |keyword: &str, default: Option<u64>| {
            let value = header.integer(keyword).and_then(|value| u64::try_from(value).ok());
            let absent = header.get(keyword).is_none();
            value.or(default.filter(|_| absent)).ok_or_else(|| {
                let got = if absent { "no such keyword" } else { "another value" };
                keyword_error(self.path, keyword, "a number from 0", got)
            })
        };
        let axes = count("NAXIS", None)?;
        if axes > 999 {
            return Err(keyword_error(self.path, "NAXIS", "at most 999", &axes.to_string()));
        }
        let bits = header.integer("BITPIX").map_or(0, i64::unsigned_abs);
        if !matches!(bits, 8 | 16 | 32 | 64) {
            let expected = "8, 16, 32, 64, -32 or -64";
            return Err(keyword_error(self.path, "BITPIX", expected, &bits.to_string()));
        }
        if axes == 0 {
            return Ok(0);
        }
        let mut items = Some(1_u64);
        for axis in 1..=axes {
            let length = count(&format!("NAXIS{axis}"), None)?;
            // Random groups have NAXIS1 = 0, which is not part of the product.
            if !(axis == 1 && length == 0 && header.logical("GROUPS") == Some(true)) {
                items = items.and_then(|items| items.checked_mul(length));
            }
        }
        let (parameters, groups) = (count("PCOUNT", Some(0))?, count("GCOUNT", Some(1))?);
        items
            .and_then(|items| items.checked_add(parameters))
            .and_then(|items| items.checked_mul(groups))
            .and_then(|items| items.checked_mul(bits / 8))
            .ok_or_else(|| {
                let got = format!("more bytes in HDU {number}");
                self.layout("data that fit in a file", &got)
            })
    }

    fn layout(&self, expected: &str, got: &str) -> FileError {
        FileError::Layout {
            path: self.path.to_owned(),
            place: Place::Whole,
            expected: expected.to_owned(),
            got: got.to_owned(),
        }
    }

    fn read_error(&self, source: std::io::Error) -> FileError {
        FileError::Read { path: self.path.to_owned(), source }
    }
}

/// Returns the error of a keyword with an invalid value.
pub(crate) fn keyword_error(path: &str, keyword: &str, expected: &str, got: &str) -> FileError {
    FileError::Value {
        path: path.to_owned(),
        place: Place::Whole,
        field: format!("keyword {keyword}"),
        expected: expected.to_owned(),
        got: shortened(got),
    }
}
