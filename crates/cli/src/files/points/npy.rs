//! Reads point sets from NPY arrays.

use std::io::BufRead;
use std::ops::Range;

use super::collector::{Cell, PointCollector};
use super::column::Column;
use super::columns::Table;
use super::{FilePoint, PointFile, Purpose, ReadOptions};
use crate::files::file_error::{FileError, Place};
use crate::files::input::Input;
use crate::files::memory_guard::check_announced;
use crate::files::npy::{Field, ItemType, NpyReader};

/// Returns the sets of an NPY file: one for `(N, 3)`, M for `(M, N, 3)`, with 2 instead of 3 on the
/// square; with `--columns`, that
/// option determines the last dimension. Records of shape `(N,)` or `(M, N)`, whose fields are
/// columns, likewise give one set or M.
///
/// Supports floats of 4 and 8 bytes and integers, of either byte order, in C or Fortran order.
pub(super) fn read_npy<P: FilePoint>(
    mut input: Input,
    path: &str,
    options: &ReadOptions,
    file_bytes: Option<u64>,
    mut purpose: Purpose<'_, P>,
) -> Result<PointFile<P>, FileError> {
    let start =
        input.fill_buf().map_err(|source| FileError::Read { path: path.to_owned(), source })?;
    if start.is_empty() {
        return Err(FileError::Empty { path: path.to_owned() });
    }
    let is_regular = input.is_regular();
    let array = NpyReader::new(input, path)?;
    let table = ArrayTable::of(&array, path, options)?;
    let layout = Table {
        path,
        place: Place::Whole,
        columns: &table.columns,
        has_names: array.fields().is_some(),
        options,
    }
    .layout()?;
    let places: Vec<(usize, ItemType)> =
        layout.slots.iter().map(|slot| table.place(slot.column, slot.item)).collect();
    let total = array.rows(table.item, table.row);
    // Whether the file has all the rows that its header announces.
    let is_whole = file_bytes.filter(|_| is_regular).map(|bytes| array.fits(table.item, bytes));
    match &mut purpose {
        Purpose::Keep => {
            if let Some(bytes) = file_bytes {
                let of_point = size_of::<[f64; 4]>() as f64;
                let points = bytes as f64 / table.row.max(1) as f64;
                check_announced(path, "the points of the array", points * of_point)?;
            }
        }
        // The error is that of reading the whole file.
        Purpose::Count(_) if is_whole == Some(false) => return Ok(PointFile::default()),
        Purpose::Count(survey) => survey.has_sets = total > table.points,
        Purpose::Blocks(_) => {}
    }
    let known = P::SPACE.default_roles();
    let is_plain =
        layout.slots.iter().map(|slot| slot.role).take(known.len()).eq(known.iter().copied())
            && layout.value.is_none()
            && layout.sigma.is_none()
            && layout.set.is_none();
    let weight = layout.weight;
    let mut collector = PointCollector::new(path, layout, options, purpose)?;
    let (points, several) = (table.points, table.several);
    if is_whole == Some(true) && !several {
        collector.reserve(total as u64);
    }
    let Range { start, end } = collector.rows(total as u64);
    let [start, end] = [start, end].map(|row| usize::try_from(row).unwrap_or(total));
    let mut coordinates = vec![0.0; known.len()];
    let follow = array.for_some_rows(table.item, table.row, start..end, |index, row| {
        let (set, row_of_set) = (index / points, index % points);
        if row_of_set == 0 {
            collector.next_set();
        }
        if !collector.begin_row()? {
            return Ok(());
        }
        let place = if several { Place::RowOfSet(set, row_of_set) } else { Place::Row(row_of_set) };
        let number = |slot: usize| {
            let (offset, item) = places[slot];
            item.number(&row[offset..offset + item.size()])
        };
        // Most rows, without a look at each of their columns.
        if is_plain {
            coordinates.iter_mut().enumerate().for_each(|(slot, x)| *x = number(slot));
            if collector.plain_row(place, &coordinates, weight.map(number))? {
                return Ok(());
            }
        }
        collector.begun_row(place, |slot| Cell::Number(number(slot)))
    })?;
    if follow {
        collector.warn("bytes follow the array and were not read");
    }
    collector.finish()
}

/// An array as a table with a row for each point.
pub(super) struct ArrayTable {
    pub(super) columns: Vec<Column>,
    /// The offset and the type of every column's items.
    places: Vec<Option<(usize, ItemType)>>,
    /// The number of bytes of an item or a record.
    pub(super) item: usize,
    /// The number of bytes of a row.
    pub(super) row: usize,
    /// The number of points of a set.
    pub(super) points: usize,
    /// Whether the array has a dimension for the sets.
    pub(super) several: bool,
}

impl ArrayTable {
    /// Returns an array as a table.
    ///
    /// # Errors
    ///
    /// If its shape or its type is not that of points.
    pub(super) fn of<R: std::io::Read>(
        array: &NpyReader<'_, R>,
        path: &str,
        options: &ReadOptions,
    ) -> Result<Self, FileError> {
        if let Some(fields) = array.fields() {
            return Self::of_records(array, fields);
        }
        let (points, width, several) = match *array.shape() {
            [points, width] => (points, width, false),
            [_, points, width] => (points, width, true),
            _ => return Err(array.shape_error(options.space.shapes())),
        };
        let known = options.space.default_roles().len();
        let is_known = width == known || (options.values && (3..=5).contains(&width));
        if !is_known && options.columns.is_none() {
            let error = array.shape_error(match options.values {
                true => "an array of shape (N, 4) with x,y,z,value, or (N, 5) with w",
                false => options.space.shapes(),
            });
            let spelling = options.spelling;
            return Err(error.with_hint(&match *array.shape() {
                [rows, _] if rows == known => {
                    "transpose it, a point in a row: array.T in Python".to_owned()
                }
                _ if width == 3 => "directions x,y,z are read without --square".to_owned(),
                _ => {
                    let roles = match options.values {
                        true => "ra,dec,value",
                        false => options.space.weighted_example(),
                    };
                    let (option, example) = (spelling.name("columns"), spelling.columns(roles));
                    format!("{option} names other columns, as in {example}")
                }
            }));
        }
        let Some(item) = array.item_type() else {
            return Err(FileError::Layout {
                path: path.to_owned(),
                place: Place::Whole,
                expected: "numbers of type float64 or float32, or integers".to_owned(),
                got: format!("the type '{}'", array.descr()),
            });
        };
        let size = item.size();
        // A header may announce any number of columns, so they are not allocated.
        let columns = width.min(1 << 20);
        Ok(Self {
            columns: vec![Column::single(""); columns],
            places: (0..columns).map(|column| Some((column * size, item))).collect(),
            item: size,
            row: width.saturating_mul(size),
            points,
            several,
        })
    }

    fn of_records<R: std::io::Read>(
        array: &NpyReader<'_, R>,
        fields: &[Field],
    ) -> Result<Self, FileError> {
        let (points, several) = match *array.shape() {
            [points] => (points, false),
            [_, points] => (points, true),
            _ => return Err(array.shape_error("records in an array of shape (N,) or (M, N)")),
        };
        let row = fields.last().map_or(0, |field| field.offset + field.bytes);
        let column = |field: &Field| Column {
            name: field.name.clone(),
            items: field.item.map_or(0, |_| field.items),
            unit: String::new(),
        };
        Ok(Self {
            columns: fields.iter().map(column).collect(),
            places: fields.iter().map(|field| Some((field.offset, field.item?))).collect(),
            item: row,
            row,
            points,
            several,
        })
    }

    /// Returns the offset of an item of a column in a row, and its type.
    pub(super) fn place(&self, column: usize, item: usize) -> (usize, ItemType) {
        // The slots of a layout are numeric.
        let (offset, kind) = self.places[column].expect("a column of numbers");
        (offset + item * kind.size(), kind)
    }
}
