//! The legend below the data, used if names do not fit next to it.

use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::HPos;

use super::canvas::Canvas;
use super::names::fitted;
use super::palette::INK;
use super::plot_error::PlotError;
use super::series_drawing::{Look, Sample};
use super::text_box::TextBox;

const TEXT: f64 = 13.0;
/// The distance between entries, in units.
const STEP: f64 = 18.0;
const SAMPLE: f64 = 34.0;
const SAMPLE_GAP: f64 = 8.0;
const COLUMN_GAP: f64 = 22.0;
/// Longer names are shortened, in units.
const MAX_LABEL: f64 = 420.0;

/// The positions of the entries of a legend.
pub(super) struct Legend<'a> {
    pub(super) samples: Vec<Sample<'a>>,
    pub(super) texts: Vec<TextBox>,
    /// The height of all entries, units.
    pub(super) height: f64,
}

impl<'a> Legend<'a> {
    /// Returns the legend of the named series, in columns between `left` and `right` below `top`.
    pub(super) fn new<DB: DrawingBackend>(
        looks: &[Look<'a>],
        (left, right): (f64, f64),
        top: f64,
        canvas: &Canvas<DB>,
    ) -> Result<Self, PlotError> {
        let max_width = MAX_LABEL.min(right - left - SAMPLE - SAMPLE_GAP);
        let mut named = Vec::new();
        let mut width: f64 = 0.0;
        for look in by_importance(looks) {
            let label = fitted(&look.series.label, TEXT, max_width, 1, canvas)?.concat();
            width = width.max(canvas.text_width(&label, TEXT)?);
            named.push((look, label));
        }
        let step = SAMPLE + SAMPLE_GAP + width + COLUMN_GAP;
        let mut columns: usize = 1;
        while left + step * (columns + 1) as f64 - COLUMN_GAP <= right {
            columns += 1;
        }
        let rows = named.len().div_ceil(columns);
        let height = STEP * rows as f64;
        let mut legend = Self { samples: Vec::new(), texts: Vec::new(), height };
        for (place, (look, label)) in named.into_iter().enumerate() {
            let (column, row) = (place / rows, place % rows);
            let x = left + step * column as f64;
            let y = top + STEP * (row as f64 + 0.5);
            legend.samples.push(Sample::new(look, looks, (x, y), SAMPLE));
            let at = (x + SAMPLE + SAMPLE_GAP, y);
            legend.texts.push(TextBox::new(&label, at, TEXT, (INK, HPos::Left), canvas)?);
        }
        Ok(legend)
    }
}

/// Returns the series that have a name, coloured ones before grey ones.
pub(super) fn by_importance<'a>(looks: &[Look<'a>]) -> Vec<Look<'a>> {
    let named = looks.iter().copied().filter(|look| !look.series.label.is_empty());
    let (grey, mut coloured): (Vec<Look<'_>>, Vec<Look<'_>>) =
        named.partition(|look| look.series.ink.is_hollow());
    coloured.extend(grey);
    coloured
}
