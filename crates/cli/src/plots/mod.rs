//! Figures: charts of series and views of point sets, as SVG or PNG.

mod axis;
mod canvas;
mod chart;
mod chart_layout;
mod contact_sheet;
mod figure;
mod heat_map;
mod legend;
mod orthographic_view;
mod palette;
mod plot_error;
mod series_drawing;

#[cfg(test)]
mod tests;

pub(crate) use axis::Scale;
pub(crate) use chart::{Chart, Series, Style};
pub(crate) use contact_sheet::{ContactSheet, Panel};
pub(crate) use figure::ImageFormat;
pub(crate) use heat_map::{Colours, Edges, HeatMap};
pub(crate) use orthographic_view::OrthographicView;
pub(crate) use plot_error::PlotError;
