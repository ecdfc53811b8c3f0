//! Reads point sets from NPZ files: zip archives of NPY arrays.

use std::io::{Read, Seek};
use std::ops::Range;

use zip::ZipArchive;
use zip::read::ZipFile;
use zip::result::ZipError;

use super::collector::{Cell, PointCollector};
use super::column::Column;
use super::columns::{Layout, Slot, Table};
use super::npy::ArrayTable;
use super::roles::ColumnChoice;
use super::{FilePoint, PointFile, Purpose, ReadOptions};
use crate::files::file_error::{FileError, Place};
use crate::files::input::SkipBytes;
use crate::files::memory_guard::MemoryGuard;
use crate::files::npy::{ItemType, NpyReader};
use crate::files::text_rows::shortened;

/// An archive of more arrays is not one of points.
const MAX_ARRAYS: usize = 4096;

/// Returns the sets of an NPZ file.
///
/// The points are the array `points`, or the only array of two or three dimensions, as in an
/// NPY file, or the only one of records. The weights are `weights` (or `w` or `weight`) of shape
/// `(N,)` or `(M, N)`.
///
/// One-dimensional arrays are columns if there is no such array and their names are those of a
/// point, or if `--columns` contains names and there are no records.
pub(super) fn read_npz<P: FilePoint>(
    input: impl Read + Seek,
    path: &str,
    options: &ReadOptions,
    purpose: Purpose<'_, P>,
) -> Result<PointFile<P>, FileError> {
    let archive = ZipArchive::new(input).map_err(|error| zip_error(path, &error))?;
    let mut file = Npz { archive, path, options };
    let arrays = file.arrays()?;
    if arrays.is_empty() {
        return Err(layout_error(path, "arrays (.npy) in the archive", "none".to_owned()));
    }
    let by_name = matches!(options.columns, Some(ColumnChoice::Names(_)));
    let is_column = |role: &&str| {
        arrays
            .iter()
            .any(|array| array.shape.len() == 1 && P::SPACE.role_of(&array.name) == Some(*role))
    };
    let has_columns = P::SPACE.systems().iter().any(|system| system.iter().all(is_column));
    let has_points =
        |array: &&Shape| array.has_fields || (!by_name && (2..=3).contains(&array.shape.len()));
    let tables: Vec<&Shape> = arrays.iter().filter(has_points).collect();
    let main = match tables[..] {
        [single] if !has_columns => Some(single),
        _ => tables.iter().copied().find(|array| array.name == "points"),
    };
    match main {
        Some(main) => file.read_points(main, &arrays, purpose),
        // Columns are held while the points are made of them.
        None if !matches!(purpose, Purpose::Keep) => Ok(PointFile::default()),
        None => file.read_columns(&arrays),
    }
}

impl<R: Read> SkipBytes for ZipFile<'_, R> {}

/// An archive with its reader.
struct Npz<'a, R> {
    archive: ZipArchive<R>,
    path: &'a str,
    options: &'a ReadOptions,
}

/// The relevant content of an array's header.
#[derive(Debug)]
struct Shape {
    /// Its index in the archive.
    index: usize,
    name: String,
    shape: Vec<usize>,
    /// The type of its items, if they are numbers.
    item: Option<ItemType>,
    /// Whether its items are records.
    has_fields: bool,
}

/// The place of the numbers of a slot.
#[derive(Clone, Copy)]
enum Source<'a> {
    /// The offset in a row of the points, and the type.
    Column((usize, ItemType)),
    /// The numbers of another array.
    Array(&'a [f64]),
}

impl<'a, R: Read + Seek> Npz<'a, R> {
    /// Returns the arrays of the archive in its order.
    fn arrays(&mut self) -> Result<Vec<Shape>, FileError> {
        let count = self.archive.len();
        if count > MAX_ARRAYS {
            let expected = format!("at most {MAX_ARRAYS} arrays");
            return Err(layout_error(self.path, &expected, count.to_string()));
        }
        let mut arrays = Vec::new();
        let mut first_error = None;
        for index in 0..count {
            let path = self.path;
            let entry = self.archive.by_index(index).map_err(|error| zip_error(path, &error))?;
            let name = entry.name().map_err(|error| zip_error(path, &error))?;
            let Some(name) = name.strip_suffix(".npy").map(str::to_owned) else { continue };
            // An array of objects or another type does not invalidate the other arrays.
            match NpyReader::new(entry, &format!("{path}: {}", shortened(&name))) {
                Ok(array) => {
                    let (shape, item) = (array.shape().to_vec(), array.item_type());
                    let has_fields = array.fields().is_some();
                    arrays.push(Shape { index, name, shape, item, has_fields });
                }
                Err(error) => first_error = first_error.or(Some(error)),
            }
        }
        match first_error {
            Some(error) if arrays.is_empty() => Err(error),
            _ => Ok(arrays),
        }
    }

    /// Returns the sets of an array of directions, with the weights of another one.
    fn read_points<P: FilePoint>(
        &mut self,
        main: &Shape,
        arrays: &[Shape],
        mut purpose: Purpose<'_, P>,
    ) -> Result<PointFile<P>, FileError> {
        let path = self.path;
        let (options, name) = (self.options, format!("{path}: {}", main.name));
        let entry = self.archive.by_index(main.index).map_err(|e| zip_error(path, &e))?;
        let mut table = ArrayTable::of(&NpyReader::new(entry, &name)?, &name, options)?;
        let (place, has_names) = (Place::Whole, main.has_fields);
        let mut layout =
            Table { path: &name, place, columns: &table.columns, has_names, options }.layout()?;
        let own: Vec<&str> = layout.slots.iter().map(|slot| slot.role).collect();
        let of_points = match main.has_fields {
            true => &main.shape[..],
            false => &main.shape[..main.shape.len() - 1],
        };
        let roles: &[&str] = if options.values { &["w", "value", "sigma"] } else { &["w"] };
        // The index of an array, its role and its numbers.
        let mut loaded: Vec<(usize, &str, Vec<f64>)> = Vec::new();
        for &role in roles.iter().filter(|role| !own.contains(role)) {
            let Some(array) = arrays.iter().find(|a| P::SPACE.role_of(&a.name) == Some(role))
            else {
                continue;
            };
            let fits = array.shape == of_points || (table.several && array.shape == of_points[1..]);
            if !fits {
                let what = if role == "w" { "weights" } else { role };
                let expected = format!("{what} of the shape of {}, {of_points:?}", main.name);
                let got = format!("{} of the shape {:?}", array.name, array.shape);
                return Err(layout_error(path, &expected, got));
            }
            layout.add(role, table.columns.len());
            table.columns.push(Column::single(&array.name));
            let numbers = if matches!(purpose, Purpose::Count(_)) {
                Vec::new()
            } else {
                self.load(array, 0, 1)?
            };
            loaded.push((array.index, role, numbers));
        }
        let is_used = |array: &Shape| {
            array.index == main.index || loaded.iter().any(|(index, ..)| *index == array.index)
        };
        let unused = arrays.iter().filter(|array| !is_used(array));
        layout.unused.extend(unused.map(|array| shortened(&array.name)));
        let source = |slot: &Slot| match loaded.iter().find(|(_, role, _)| *role == slot.role) {
            Some((.., numbers)) => Source::Array(numbers),
            None => Source::Column(table.place(slot.column, slot.item)),
        };
        let sources: Vec<Source<'_>> = layout.slots.iter().map(source).collect();
        let entry = self.archive.by_index(main.index).map_err(|e| zip_error(path, &e))?;
        let array = NpyReader::new(entry, &name)?;
        let total = array.rows(table.item, table.row);
        match &mut purpose {
            Purpose::Keep | Purpose::Blocks(_) => {}
            // Their numbers are held while the points are read.
            Purpose::Count(_) if !loaded.is_empty() => return Ok(PointFile::default()),
            Purpose::Count(survey) => survey.has_sets = total > table.points,
        }
        let mut collector = PointCollector::new(&name, layout, options, purpose)?;
        let (points, several) = (table.points, table.several);
        let Range { start, end } = collector.rows(total as u64);
        let [start, end] = [start, end].map(|row| usize::try_from(row).unwrap_or(total));
        array.for_some_rows(table.item, table.row, start..end, |index, row| {
            let (set, row_of_set) = (index / points, index % points);
            if row_of_set == 0 {
                collector.next_set();
            }
            let place =
                if several { Place::RowOfSet(set, row_of_set) } else { Place::Row(row_of_set) };
            collector.row(place, |slot| match sources[slot] {
                Source::Column((offset, item)) => {
                    Cell::Number(item.number(&row[offset..offset + item.size()]))
                }
                // One number per point, or one per point of each set.
                Source::Array(numbers) => Cell::Number(numbers[index % numbers.len()]),
            })
        })?;
        collector.finish()
    }

    /// Returns the set whose columns are arrays.
    fn read_columns<P: FilePoint>(&mut self, arrays: &[Shape]) -> Result<PointFile<P>, FileError> {
        let columns: Vec<Column> = arrays
            .iter()
            .map(|array| {
                let items = match array.shape[..] {
                    [_] => 1,
                    [_, width] => width,
                    _ => 0,
                };
                let items = array.item.map_or(0, |_| items);
                Column { name: array.name.clone(), items, unit: String::new() }
            })
            .collect();
        let path = self.path;
        let (place, options) = (Place::Whole, self.options);
        let table = Table { path, place, columns: &columns, has_names: true, options };
        let layout: Layout = table.layout()?;
        let mut loaded: Vec<Vec<f64>> = Vec::new();
        for slot in &layout.slots {
            let array = &arrays[slot.column];
            let column = self.load(array, slot.item, columns[slot.column].items)?;
            if let Some(first) = loaded.first()
                && first.len() != column.len()
            {
                let first_name = &arrays[layout.slots[0].column].name;
                let expected = format!("{} numbers as in {}", first.len(), shortened(first_name));
                let got = format!("{} in {}", column.len(), shortened(&array.name));
                return Err(layout_error(path, &expected, got));
            }
            loaded.push(column);
        }
        let mut points = PointCollector::new(path, layout, self.options, Purpose::Keep)?;
        for (index, _) in loaded.first().into_iter().flatten().enumerate() {
            points.row(Place::Row(index), |slot| Cell::Number(loaded[slot][index]))?;
        }
        points.finish()
    }

    /// Returns one of `width` numbers of every row of an array.
    fn load(&mut self, array: &Shape, column: usize, width: usize) -> Result<Vec<f64>, FileError> {
        let path = self.path;
        let name = format!("{path}: {}", array.name);
        let Some(item) = array.item else {
            return Err(layout_error(&name, "an array of numbers", "another type".to_owned()));
        };
        let entry = self.archive.by_index(array.index).map_err(|error| zip_error(path, &error))?;
        let mut numbers = Vec::new();
        let mut guard = MemoryGuard::default();
        let size = item.size();
        NpyReader::new(entry, &name)?.for_each_row(size, size * width, |_, row| {
            numbers.push(item.number(&row[column * size..][..size]));
            guard.check(&name, "the array", 8 * numbers.len() as u64)
        })?;
        Ok(numbers)
    }
}

fn zip_error(path: &str, error: &ZipError) -> FileError {
    let got = match error {
        ZipError::InvalidArchive(_) => "a damaged or truncated one".to_owned(),
        _ => format!("an error ({error})"),
    };
    layout_error(path, "an NPZ file, a zip archive of arrays", got)
}

fn layout_error(path: &str, expected: &str, got: String) -> FileError {
    FileError::Layout {
        path: path.to_owned(),
        place: Place::Whole,
        expected: expected.to_owned(),
        got,
    }
}
