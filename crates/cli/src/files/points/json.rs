//! Reads point sets from the document of `sphvar sample --json`.

use std::io::BufRead;

use serde::Deserialize;

use super::collector::{Cell, PointCollector};
use super::column::Column;
use super::columns::Table;
use super::{FilePoint, PointFile, Purpose, ReadOptions};
use crate::files::file_error::{FileError, Place};
use crate::files::input::read_rest;

/// The relevant part of the document.
#[derive(Deserialize)]
struct Document<N> {
    points: Vec<Vec<N>>,
    weights: Option<Vec<Vec<f64>>>,
}

/// Returns the sets of a JSON document with `points`, a list of lists of `[x, y, z]` or
/// `[u, v]`, and possibly `weights`, a list of lists of numbers.
pub(super) fn read_json<P: FilePoint>(
    input: impl BufRead,
    path: &str,
    options: &ReadOptions,
    purpose: Purpose<'_, P>,
) -> Result<PointFile<P>, FileError> {
    if !matches!(purpose, Purpose::Keep) {
        // The document is parsed as a whole.
        return Ok(PointFile::default());
    }
    let text = read_rest(input, path)?;
    let document: Document<P::Numbers> =
        serde_json::from_slice(&text).map_err(|error| FileError::Layout {
            path: path.to_owned(),
            place: Place::Whole,
            expected: "a JSON document with \"points\", as sample --json prints it".to_owned(),
            got: format!("an error ({error})"),
        })?;
    let place = Place::Whole;
    if let Some(weights) = &document.weights {
        let lengths = |lists: &[usize]| format!("{lists:?}");
        let points: Vec<usize> = document.points.iter().map(Vec::len).collect();
        let weights: Vec<usize> = weights.iter().map(Vec::len).collect();
        if points != weights {
            return Err(FileError::Layout {
                path: path.to_owned(),
                place,
                expected: format!("weights for sets of {} points", lengths(&points)),
                got: lengths(&weights),
            });
        }
    }
    let has_names = document.weights.is_some();
    let names = P::SPACE.default_roles().iter().chain(has_names.then_some(&"w"));
    let columns: Vec<Column> =
        names.map(|name| Column::single(if has_names { *name } else { "" })).collect();
    let table = Table { path, place, columns: &columns, has_names, options };
    let mut points = PointCollector::new(path, table.layout()?, options, purpose)?;
    let items: Vec<usize> = points.layout().slots.iter().map(|slot| slot.column).collect();
    for (index, set) in document.points.iter().enumerate() {
        points.next_set();
        for (row, numbers) in set.iter().enumerate() {
            let place = Place::RowOfSet(index, row);
            let weight = document.weights.as_ref().map_or(1.0, |weights| weights[index][row]);
            points.row(place, |slot| {
                Cell::Number(numbers.as_ref().get(items[slot]).copied().unwrap_or(weight))
            })?;
        }
    }
    points.finish()
}
