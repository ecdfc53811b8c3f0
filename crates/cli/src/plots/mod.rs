//! Figures: charts of series and views of point sets, as SVG or PNG.

mod axis;
mod binning;
mod canvas;
mod chart;
mod chart_drawing;
mod chart_layout;
mod colour_scale;
mod contact_sheet;
mod dashes;
mod end_labels;
mod figure;
mod headings;
mod heat_map;
mod legend;
mod map_and_chart;
mod names;
mod orthographic_view;
mod palette;
mod plane;
mod plot_error;
mod series_drawing;
mod spreading;
mod square_view;
mod text_box;

#[cfg(test)]
mod structure_tests;
#[cfg(test)]
mod tests;

pub(crate) use axis::Scale;
pub(crate) use binning::Binned;
pub(crate) use chart::{Chart, Panel, Series, Spread, Style};
pub(crate) use colour_scale::Colours;
pub(crate) use contact_sheet::{ContactSheet, SheetPanel};
pub(crate) use figure::ImageFormat;
pub(crate) use heat_map::{Edges, HeatMap};
pub(crate) use map_and_chart::MapAndChart;
pub(crate) use orthographic_view::OrthographicView;
pub(crate) use palette::{Ink, MAX_COLOURS, NOTE_OF_OWN, inks};
pub(crate) use plot_error::PlotError;
pub(crate) use square_view::SquareView;
