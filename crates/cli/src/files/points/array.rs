//! Points that an embedding program gives as an array.

use super::collector::{Cell, PointCollector};
use super::column::Column;
use super::columns::Table;
use super::{FilePoint, PointFile, Purpose, ReadOptions};
use crate::files::file_error::{FileError, Place};
use crate::given::PointTable;

/// Returns the sets of an array as those of a file with the same numbers; `name` is for messages.
///
/// # Errors
///
/// Those of [`read_points`](super::read_points) in the content.
pub(crate) fn points_of_array<P: FilePoint>(
    name: &str,
    table: &PointTable,
    options: &ReadOptions,
) -> Result<PointFile<P>, FileError> {
    let options = &ReadOptions { space: P::SPACE, ..options.clone() };
    let names: &[&str] = if table.dimension == 2 { &["u", "v"] } else { &["x", "y", "z"] };
    let others = [("w", &table.weights), ("value", &table.values), ("sigma", &table.errors)];
    let others: Vec<(&str, &[f64])> =
        others.iter().filter_map(|(name, numbers)| Some((*name, numbers.as_deref()?))).collect();
    let columns: Vec<Column> = names
        .iter()
        .copied()
        .chain(others.iter().map(|(name, _)| *name))
        .map(Column::single)
        .collect();
    let place = Place::Whole;
    let layout =
        Table { path: name, place, columns: &columns, has_names: true, options }.layout()?;
    let sources: Vec<usize> = layout.slots.iter().map(|slot| slot.column).collect();
    // Slots are the coordinates in their order, then the others.
    let is_plain = layout.value.is_none()
        && layout.sigma.is_none()
        && layout.set.is_none()
        && sources.iter().take(names.len()).copied().eq(0..names.len());
    let weights = table.weights.as_deref().filter(|_| layout.weight.is_some());
    let mut collector = PointCollector::new(name, layout, options, Purpose::Keep)?;
    if table.sets.is_none() {
        collector.reserve(table.len() as u64);
    }
    let n_of_set = table.len() / table.sets.unwrap_or(1).max(1);
    for (index, coordinates) in table.coordinates.chunks_exact(names.len()).enumerate() {
        let (set, row) = (index / n_of_set, index % n_of_set);
        if row == 0 {
            collector.next_set();
        }
        let place = if table.sets.is_some() { Place::RowOfSet(set, row) } else { Place::Row(row) };
        // Most rows, without a look at each of their columns.
        let weight = weights.map(|weights| weights[index]);
        if is_plain && collector.plain_row(place, coordinates, weight)? {
            continue;
        }
        collector.row(place, |slot| {
            Cell::Number(match sources[slot].checked_sub(names.len()) {
                None => coordinates[sources[slot]],
                Some(other) => others[other].1[index],
            })
        })?;
    }
    collector.finish()
}
