//! Reads point sets from tables in FITS files.

use std::io::BufRead;
use std::ops::Range;

use super::collector::{Cell, PointCollector};
use super::column::Column;
use super::columns::Table;
use super::{FilePoint, OptionSpelling, PointFile, Purpose, ReadOptions};
use crate::files::file_error::{FileError, Place};
use crate::files::fits::{Hdu, HduChoice, HduReader, Item, TableColumn};
use crate::files::input::Input;
use crate::files::memory_guard::check_announced;

/// The number of bytes that are read at a time if rows are not longer.
const CHUNK: usize = 1 << 16;
/// The maximum number of tables that a message lists.
const LISTED: usize = 4;
/// The maximum length of a row, in bytes.
const MAX_ROW: usize = 1 << 26;

/// Returns the sets of a table, binary or ASCII, from the selected HDU or the first table.
pub(super) fn read_fits<P: FilePoint>(
    input: Input,
    path: &str,
    options: &ReadOptions,
    file_bytes: Option<u64>,
    purpose: Purpose<'_, P>,
) -> Result<PointFile<P>, FileError> {
    let is_regular = input.is_regular();
    let mut file = HduReader::new(input, path);
    let hdu = file.select(&options.hdu, Hdu::is_table, "a table")?;
    let (row, rows) = hdu.table_size(path, MAX_ROW)?;
    let fields = TableColumn::of_table(&hdu, path)?;
    let columns: Vec<Column> = fields
        .iter()
        .map(|f| Column { name: f.name.clone(), items: f.items, unit: f.unit.clone() })
        .collect();
    let table = Table { path, place: Place::Whole, columns: &columns, has_names: true, options };
    let layout = match table.layout() {
        Ok(layout) => layout,
        Err(error) if options.hdu == HduChoice::First => {
            return Err(error.with_hint(&other_tables(&mut file, options.spelling)));
        }
        Err(error) => return Err(error),
    };
    let table_bytes = rows.saturating_mul(row as u64);
    // Whether the file has all the rows that its header announces.
    let is_whole = file_bytes.filter(|_| is_regular).map(|bytes| file.fits(table_bytes, bytes));
    if matches!(purpose, Purpose::Count(_)) && is_whole == Some(false) {
        // The error is that of reading the whole file.
        return Ok(PointFile::default());
    }
    if let Some(bytes) = file_bytes
        && matches!(purpose, Purpose::Keep)
    {
        let points = (bytes as f64 / row.max(1) as f64).min(rows as f64);
        check_announced(path, "the points of the table", points * size_of::<[f64; 4]>() as f64)?;
    }
    let places: Vec<(usize, usize)> =
        layout.slots.iter().map(|slot| (slot.column, slot.item)).collect();
    let mut points = PointCollector::new(path, layout, options, purpose)?;
    let what = format!("{rows} rows of {row} bytes");
    let together = (CHUNK / row.max(1)).max(1) as u64;
    let mut bytes = Vec::new();
    if is_whole == Some(true) {
        points.reserve(rows);
    }
    let Range { start: mut done, end } = points.rows(rows);
    file.skip_bytes(done.saturating_mul(row as u64))?;
    while done < end {
        let count = together.min(end - done);
        // At most a chunk or a row.
        let length = usize::try_from(count).unwrap_or(usize::MAX).saturating_mul(row);
        bytes.resize(length, 0);
        file.read_data(&mut bytes, &what)?;
        for (index, row) in bytes.chunks_exact(row).enumerate() {
            let place = Place::TableRow(done + index as u64 + 1);
            points.row(place, |slot| {
                let (column, item) = places[slot];
                match fields[column].item(row, item) {
                    Item::Number(number) => Cell::Number(number),
                    Item::Text(text) => Cell::Text(text),
                    Item::Missing => Cell::Missing,
                }
            })?;
        }
        done += count;
    }
    points.finish()
}

/// Returns a remark that the first table was read, with the names of the others.
fn other_tables(file: &mut HduReader<'_, impl BufRead>, spelling: OptionSpelling) -> String {
    let mut tables = Vec::new();
    // Errors in other tables are reported when these are selected.
    while let Ok(Some(hdu)) = file.next_hdu() {
        if hdu.is_table() && tables.len() < LISTED {
            tables.push(hdu.summary());
        }
    }
    match tables.is_empty() {
        true => "it is the only table".to_owned(),
        false => {
            let (option, tables) = (spelling.name("hdu"), tables.join(", "));
            format!("this is the first table; {option} chooses another: {tables}")
        }
    }
}
