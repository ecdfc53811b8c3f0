//! HEALPix maps in tables and images of FITS files.

use std::path::Path;

use super::field::{FitsField, REAL_FIELD, chosen_column, image_field, layout, maps_in_image};
use super::hdu::{Hdu, HduChoice, HduKind, HduReader, keyword_error};
use super::header::{Header, Value};
use super::table::{Item, TableColumn};
use crate::files::file_error::{FileError, Place, input_name};
use crate::files::input::open_input;
use crate::files::memory_guard::check_announced;

/// The largest supported nside, with 6 GiB of values.
const MAX_NSIDE: u64 = 8192;
/// The relative tolerance within which a value equals `BAD_DATA`: maps in single precision contain
/// an adjacent number.
const BAD_DATA_TOLERANCE: f64 = 1e-5;

/// A HEALPix map in the order of its file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FitsMap {
    pub(crate) nside: u32,
    /// Whether the values are in nested order, as ORDERING states, and in ring order otherwise.
    pub(crate) nested: bool,
    /// The values of all pixels in the order of the file; NaN where a pixel has none.
    pub(crate) values: Vec<f64>,
    /// COORDSYS, the coordinate system: `G` galactic, `E` ecliptic, `C` equatorial.
    pub(crate) coordinates: Option<String>,
}

/// The pixels that the values of a table belong to.
enum Indexing {
    /// All from the first to the last, in order.
    Implicit { first: u64, last: u64 },
    /// The pixels that a column lists.
    Explicit(TableColumn),
}

/// Reads a field of a map, from the first table or image with a map unless another HDU is selected.
///
/// # Errors
///
/// If the file cannot be read or is truncated, or if the header does not unambiguously
/// state that this is a HEALPix map, its nside and its order.
pub(crate) fn read_fits_map(
    path: &Path,
    choice: &HduChoice,
    field: &FitsField,
) -> Result<FitsMap, FileError> {
    let name = input_name(path);
    let mut reader = HduReader::new(open_input(path)?, &name);
    let is_map = |hdu: &Hdu| {
        let keywords = ["PIXTYPE", "NSIDE", "ORDERING"];
        matches!(hdu.kind, HduKind::BinaryTable | HduKind::Image)
            && keywords.iter().any(|k| hdu.header.get(k).is_some())
    };
    let expected =
        "a binary table or an image with the keywords ORDERING and NSIDE of a HEALPix map";
    let hdu = reader.select(choice, is_map, expected)?;
    let table = MapTable::new(&name, &hdu, field)?;
    table.read(&mut reader)
}

/// The map as the header of a table describes it. An image counts as a table with a single column.
struct MapTable<'a> {
    path: &'a str,
    header: &'a Header,
    nside: u32,
    nested: bool,
    n_pixels: u64,
    indexing: Indexing,
    column: TableColumn,
    /// The number of bytes of a row, and the number of rows.
    row: usize,
    rows: u64,
    /// The rows before the first one, which contain other maps of an image.
    skipped: u64,
}

impl<'a> MapTable<'a> {
    fn new(path: &'a str, hdu: &'a Hdu, field: &FitsField) -> Result<Self, FileError> {
        let header = &hdu.header;
        let wrong = |keyword: &str, expected: &str| {
            let got = match header.get(keyword) {
                None => "no such keyword".to_owned(),
                Some(Value::Text(text)) => format!("'{text}'"),
                Some(Value::Integer(value)) => value.to_string(),
                Some(Value::Real(value)) => value.to_string(),
                Some(Value::Logical(value)) => if *value { "T" } else { "F" }.to_owned(),
            };
            keyword_error(path, keyword, expected, &got)
        };
        let text = |keyword: &str| header.text(keyword).map(str::to_ascii_uppercase);
        if header.get("PIXTYPE").is_some() && text("PIXTYPE").as_deref() != Some("HEALPIX") {
            return Err(wrong("PIXTYPE", "'HEALPIX'"));
        }
        let nested = match text("ORDERING").as_deref() {
            Some("RING") => false,
            Some("NESTED" | "NEST") => true,
            Some("NUNIQ") => {
                let expected = "'RING' or 'NESTED' (ligo-skymap-flatten converts multi-order maps)";
                return Err(wrong("ORDERING", expected));
            }
            _ => return Err(wrong("ORDERING", "'RING' or 'NESTED'")),
        };
        let nside = header
            .integer("NSIDE")
            .and_then(|n| u64::try_from(n).ok())
            .filter(|n| (1..=MAX_NSIDE).contains(n))
            .ok_or_else(|| wrong("NSIDE", &format!("an integer from 1 to {MAX_NSIDE}")))?;
        if nested && !nside.is_power_of_two() {
            return Err(wrong("NSIDE", "a power of two, which ORDERING = 'NESTED' requires"));
        }
        let n_pixels = 12 * nside * nside;
        let count = |keyword: &str| {
            let count = header.integer(keyword).and_then(|n| u64::try_from(n).ok());
            count.ok_or_else(|| wrong(keyword, "an integer from 0"))
        };
        let nside = u32::try_from(nside).map_err(|_| wrong("NSIDE", "a smaller number"))?;
        let mut columns = match hdu.kind {
            HduKind::Image => Vec::new(),
            _ => TableColumn::of_table(hdu, path)?,
        };
        let indexing = match text("INDXSCHM").as_deref() {
            None | Some("IMPLICIT") => {
                let pixel = |keyword: &str, default: u64| match header.get(keyword) {
                    None => Ok(default),
                    Some(_) => count(keyword).ok().filter(|n| *n < n_pixels).ok_or_else(|| {
                        let expected = format!("a pixel from 0 to {}, by NSIDE", n_pixels - 1);
                        wrong(keyword, &expected)
                    }),
                };
                let (first, last) = (pixel("FIRSTPIX", 0)?, pixel("LASTPIX", n_pixels - 1)?);
                if last < first {
                    return Err(wrong("LASTPIX", &format!("at least FIRSTPIX = {first}")));
                }
                Indexing::Implicit { first, last }
            }
            Some("EXPLICIT") if hdu.kind == HduKind::Image => {
                return Err(wrong("INDXSCHM", "'IMPLICIT' in an image"));
            }
            Some("EXPLICIT") => {
                let names = ["PIXEL", "PIX", "PIXEL_INDEX", "INDEX"];
                let is_pixel =
                    |c: &TableColumn| names.iter().any(|name| c.name.eq_ignore_ascii_case(name));
                // Without a name it is the first column.
                let at = columns.iter().position(is_pixel).unwrap_or(0);
                if columns.len() < 2 {
                    let expected = "a column of pixel numbers and one of values";
                    return Err(wrong("TFIELDS", expected));
                }
                Indexing::Explicit(columns.remove(at))
            }
            Some(_) => return Err(wrong("INDXSCHM", "'IMPLICIT' or 'EXPLICIT'")),
        };
        let table =
            if let (HduKind::Image, Indexing::Implicit { first, last }) = (hdu.kind, &indexing) {
                let pixels = last - first + 1;
                let maps = maps_in_image(path, header, pixels)?;
                let field = image_field(path, maps, field)?;
                // The rows are neither short nor long, and divide the map evenly.
                let items = [12 * u64::from(nside), 12, 1].into_iter().find(|n| pixels % n == 0);
                let items = items.unwrap_or(1);
                let column = usize::try_from(items).ok();
                let column = column.and_then(|items| TableColumn::of_image(header, items));
                let column = column.ok_or_else(|| wrong("BITPIX", "8, 16, 32, 64, -32 or -64"))?;
                let (row, rows) = (column.width, pixels / items);
                let skipped = field * rows;
                Self { path, header, nside, nested, n_pixels, indexing, column, row, rows, skipped }
            } else {
                let (row, rows) = (count("NAXIS1")?, count("NAXIS2")?);
                let column = chosen_column(path, columns, field)?;
                let row = usize::try_from(row)
                    .map_err(|_| wrong("NAXIS1", "a row that fits in memory"))?;
                let skipped = 0;
                Self { path, header, nside, nested, n_pixels, indexing, column, row, rows, skipped }
            };
        table.check_counts()?;
        Ok(table)
    }

    /// Compares the number of values with the number of pixels.
    fn check_counts(&self) -> Result<(), FileError> {
        let items = self.column.items as u64;
        let got = self.rows.checked_mul(items);
        let (fits, expected) = match &self.indexing {
            Indexing::Implicit { first, last } => {
                let pixels = last - first + 1;
                let range = if pixels == self.n_pixels {
                    String::new()
                } else {
                    format!(", FIRSTPIX = {first} and LASTPIX = {last}")
                };
                (got == Some(pixels), format!("{pixels} values for NSIDE = {}{range}", self.nside))
            }
            Indexing::Explicit(pixels) => (
                got.is_some_and(|got| got <= self.n_pixels) && pixels.items as u64 == items,
                format!(
                    "a pixel number to each value and at most {} for NSIDE = {}",
                    self.n_pixels, self.nside
                ),
            ),
        };
        if fits {
            return Ok(());
        }
        let (row, rows) = (self.row, self.rows);
        Err(self.layout(&expected, &format!("{rows} rows of {row} bytes with {items} values each")))
    }

    fn read(
        &self,
        reader: &mut HduReader<'_, impl std::io::BufRead>,
    ) -> Result<FitsMap, FileError> {
        let what = format!("a map of {} pixels", self.n_pixels);
        let bytes = size_of::<f64>() as f64 * self.n_pixels as f64 + self.row as f64;
        check_announced(self.path, &what, bytes)?;
        // At most the number of pixels of the largest nside.
        let n_pixels = usize::try_from(self.n_pixels).unwrap_or(usize::MAX);
        let mut values = vec![f64::NAN; n_pixels];
        let mut row = vec![0; self.row];
        let mut seen = match self.indexing {
            Indexing::Implicit { .. } => Vec::new(),
            Indexing::Explicit(_) => vec![false; n_pixels],
        };
        let promise = format!("{} rows of {} bytes", self.skipped + self.rows, self.row);
        let bad = self.header.number("BAD_DATA");
        for _ in 0..self.skipped {
            reader.read_data(&mut row, &promise)?;
        }
        let mut next = 0;
        for number in 0..self.rows {
            reader.read_data(&mut row, &promise)?;
            // Nearly all maps are floats in order.
            if let Indexing::Implicit { first, .. } = &self.indexing {
                let start = usize::try_from(*first + next).unwrap_or(usize::MAX);
                let values = &mut values[start..start + self.column.items];
                if self.column.floats(&row, values) {
                    if let Some(bad) = bad {
                        values.iter_mut().filter(|x| is_near(**x, bad)).for_each(|x| *x = f64::NAN);
                    }
                    next += self.column.items as u64;
                    continue;
                }
            }
            for item in 0..self.column.items {
                let pixel = match &self.indexing {
                    Indexing::Implicit { first, .. } => *first + next,
                    Indexing::Explicit(pixels) => {
                        self.pixel(pixels.item(&row, item), number, &mut seen)?
                    }
                };
                next += 1;
                let at = usize::try_from(pixel).unwrap_or(usize::MAX);
                values[at] = match self.column.item(&row, item) {
                    Item::Number(x) if !bad.is_some_and(|bad| is_near(x, bad)) => x,
                    Item::Number(_) | Item::Missing => f64::NAN,
                    Item::Text(_) => return Err(self.layout(REAL_FIELD, "a column of texts")),
                };
            }
        }
        Ok(FitsMap {
            nside: self.nside,
            nested: self.nested,
            values,
            coordinates: self.header.text("COORDSYS").filter(|c| !c.is_empty()).map(str::to_owned),
        })
    }

    /// Returns the pixel of an item, or an error if an earlier item has the same pixel.
    fn pixel(&self, item: Item<'_>, row: u64, seen: &mut [bool]) -> Result<u64, FileError> {
        let wrong = |expected: String, got: String| FileError::Value {
            path: self.path.to_owned(),
            place: Place::Row(usize::try_from(row).unwrap_or(usize::MAX)),
            field: "pixel number".to_owned(),
            expected,
            got,
        };
        let expected = || format!("an integer from 0 to {}", self.n_pixels - 1);
        let Item::Number(number) = item else {
            return Err(wrong(expected(), "none".to_owned()));
        };
        if !(number.fract() == 0.0 && (0.0..self.n_pixels as f64).contains(&number)) {
            return Err(wrong(expected(), number.to_string()));
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a whole number below that of pixels"
        )]
        let pixel = number as u64;
        let seen = &mut seen[usize::try_from(pixel).unwrap_or(usize::MAX)];
        if std::mem::replace(seen, true) {
            return Err(wrong("each pixel once".to_owned(), format!("{pixel} again")));
        }
        Ok(pixel)
    }

    fn layout(&self, expected: &str, got: &str) -> FileError {
        layout(self.path, expected, got)
    }
}

fn is_near(x: f64, bad: f64) -> bool {
    (x - bad).abs() <= BAD_DATA_TOLERANCE * bad.abs()
}
