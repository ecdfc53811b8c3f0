//! Draws the data of a panel.

use std::path::Path;

use sphvar_thesis::{
    Axis, Content, Curves, Field, Figure, Mark, Palette, Panel, Picture, SquarePoints,
};

use crate::error::CliError;
use crate::files::{self, srgb};
use crate::plots::{
    Chart, Colours, Edges, HeatMap, Ink, OrthographicView, Panel as ChartPanel, Scale, Series,
    Spread, SquareView, Style,
};
use crate::report::Provenance;

/// Returns the extension of a panel's picture: charts are SVG, heat maps of many cells PNG.
pub(super) fn extension(content: &Content) -> &'static str {
    match content {
        Content::Curves(_) | Content::Directions(_) | Content::SquarePoints(_) => "svg",
        Content::Field(_) | Content::Picture(_) => "png",
    }
}

/// Draws a panel into a file.
pub(super) fn draw(
    figure: &Figure,
    panel: &Panel,
    provenance: &Provenance,
    path: &Path,
) -> Result<(), CliError> {
    let title = format!("Figure {}: {}", figure.id, panel.title);
    let notes = vec![provenance.line()];
    match &panel.content {
        Content::Curves(curves) => chart(title, notes, curves).render(path)?,
        Content::Directions(directions) => {
            let view = OrthographicView {
                title,
                notes,
                viewpoint: directions.viewpoint,
                lines: directions.lines.clone(),
            };
            view.render(&directions.points, path)?;
        }
        Content::SquarePoints(SquarePoints { points }) => {
            SquareView { title, notes }.render(points, path)?;
        }
        Content::Field(field) => heat_map(title, notes, field).render(path)?,
        Content::Picture(picture) => write_picture(picture, &title, provenance, path)?,
    }
    Ok(())
}

fn scale(axis: &Axis) -> Scale {
    if axis.logarithmic { Scale::Log } else { Scale::Linear }
}

fn chart(title: String, notes: Vec<String>, curves: &Curves) -> Chart {
    let inside = |axis: &Axis, x: f64| {
        axis.range.is_none_or(|(low, high)| low.min(high) <= x && x <= low.max(high))
    };
    let series = curves.curves.iter().map(|curve| {
        let points: Vec<_> = curve
            .points
            .iter()
            .filter(|[x, y, _]| inside(&curves.x, *x) && inside(&curves.y, *y))
            .collect();
        let has_errors = points.iter().any(|point| point[2] > 0.0);
        Series {
            label: curve.label.clone(),
            points: points.iter().map(|point| (point[0], point[1])).collect(),
            spread: if has_errors {
                Spread::Errors(points.iter().map(|point| point[2]).collect())
            } else {
                Spread::None
            },
            style: match curve.mark {
                Mark::Line => Style::Line,
                Mark::Markers => Style::Markers,
            },
            ink: Ink::Rank(curve.colour),
        }
    });
    Chart {
        title,
        x_label: curves.x.label.clone(),
        x_scale: scale(&curves.x),
        panels: vec![ChartPanel {
            y_scale: scale(&curves.y),
            ..ChartPanel::log(curves.y.label.clone(), series.collect())
        }],
        notes,
    }
}

fn heat_map(title: String, notes: Vec<String>, field: &Field) -> HeatMap {
    let edges = |axis: &Axis, n: usize| Edges {
        label: axis.label.clone(),
        range: axis.range.unwrap_or((0.0, n as f64)),
    };
    HeatMap {
        title,
        notes,
        size: field.size,
        values: field.values.clone(),
        label: field.label.clone(),
        colours: match field.palette {
            Palette::Heat => Colours::Heat,
            Palette::Grey => Colours::Grey,
            Palette::Signed => Colours::Signed,
        },
        scale: Scale::Linear,
        x: edges(&field.x, field.size[0]),
        y: edges(&field.y, field.size[1]),
        rings: field.rings.iter().map(|&[x, y]| (x, y)).collect(),
    }
}

fn write_picture(
    picture: &Picture,
    title: &str,
    provenance: &Provenance,
    path: &Path,
) -> Result<(), CliError> {
    let [width, height] = picture.size;
    let remark = format!("{title}. {}. {}", picture.caption, provenance.line());
    let image = files::Picture { width, height, values: &picture.values, coverage: None };
    Ok(image.write(path, &|value| [srgb(value); 3], &remark)?)
}
