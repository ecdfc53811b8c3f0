//! The data of a panel, as CSV.

use sphvar_thesis::Content;

use crate::report::{Provenance, csv, full};

/// Returns a heading and a row for each value of a panel; values that are not finite are empty
/// cells.
pub(super) fn csv_of(content: &Content, provenance: &Provenance) -> String {
    let (heading, rows): (&str, Vec<Vec<String>>) = match content {
        Content::Curves(curves) => (
            "series,x,y,stderr",
            curves
                .curves
                .iter()
                .flat_map(|curve| {
                    let name = |[x, y, e]: &[f64; 3]| {
                        vec![curve.label.clone(), full(*x), full(*y), full(*e)]
                    };
                    curve.points.iter().map(name)
                })
                .collect(),
        ),
        Content::Directions(directions) => {
            ("x,y,z", directions.points.iter().map(|p| p.to_array().map(full).to_vec()).collect())
        }
        Content::SquarePoints(set) => {
            ("u,v", set.points.iter().map(|p| p.map(full).to_vec()).collect())
        }
        Content::Field(field) => ("column,row,value", cells(field.size[0], &field.values)),
        Content::Picture(picture) => ("column,row,value", cells(picture.size[0], &picture.values)),
    };
    csv(provenance, heading, &rows)
}

/// Returns column and row, counted from 0 at the upper left, and value.
fn cells(columns: usize, values: &[f64]) -> Vec<Vec<String>> {
    let cell = |(i, &value): (usize, &f64)| {
        let (column, row) = (i % columns.max(1), i / columns.max(1));
        vec![column.to_string(), row.to_string(), full(value)]
    };
    values.iter().enumerate().map(cell).collect()
}
