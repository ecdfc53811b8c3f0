//! Lays a chart out: title above, panels with the names of curves to the right, labels, legend and
//! notes below. The height follows from the content.

use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::HPos;

use super::axis::{Axis, power_of_ten};
use super::canvas::Canvas;
use super::chart::{Chart, Panel, Series};
use super::dashes::patterns;
use super::end_labels::{EndLabels, Leader, PlacedLabels};
use super::legend::Legend;
use super::palette::{GREY, INK, Ink};
use super::plane::{Frame, Plane, drawable_x, drawable_y};
use super::plot_error::PlotError;
use super::series_drawing::{Look, Sample};
use super::text_box::TextBox;

pub(super) const EDGE: f64 = 18.0;
pub(super) const TITLE: f64 = 19.0;
pub(super) const LABEL: f64 = 16.5;
pub(super) const TICK: f64 = 14.5;
pub(super) const NOTE: f64 = 11.5;
/// The distance between lines of text, in ems.
pub(super) const LEADING: f64 = 1.35;
/// The distance between the frame and the labels of its ticks.
pub(super) const TICK_GAP: f64 = 8.0;

/// Heights of a single panel, of the first of several and of the others, units.
const SINGLE: f64 = 450.0;
const FIRST: f64 = 410.0;
const LOWER: f64 = 150.0;
/// The distance between panels, so that the labels of one do not touch those of the next.
const PANEL_GAP: f64 = 18.0;
/// The space of a tick label, along x and along y, in units.
const TICK_SPACING: (f64, f64) = (84.0, 34.0);
/// The maximum distance of markers that are placed side by side, and the fraction of the distance
/// to the next x that they occupy.
const SIDE_BY_SIDE: (f64, f64) = (8.0, 0.7);
/// The distance between them and the frame.
const MARGIN: f64 = 6.0;

/// The positions of all parts of a chart.
pub(super) struct Layout<'a> {
    /// Width and height, units.
    pub(super) size: (f64, f64),
    pub(super) panels: Vec<PlacedPanel<'a>>,
    pub(super) leaders: Vec<Leader>,
    pub(super) samples: Vec<Sample<'a>>,
    pub(super) texts: Vec<TextBox>,
}

/// A panel and its position.
#[derive(Debug)]
pub(super) struct PlacedPanel<'a> {
    pub(super) panel: &'a Panel,
    pub(super) plane: Plane,
    /// The series in drawing order: grey ones do not cover others.
    pub(super) looks: Vec<Look<'a>>,
}

impl<'a> Layout<'a> {
    pub(super) fn new<DB: DrawingBackend>(
        chart: &'a Chart,
        width: f64,
        canvas: &Canvas<DB>,
    ) -> Result<Self, PlotError> {
        let mut texts = Vec::new();
        let middle_of_figure = 0.5 * width;
        let mut top = EDGE;
        for line in canvas.wrap(&chart.title, TITLE, width - 2.0 * EDGE)? {
            let at = (middle_of_figure, top + 0.5 * TITLE);
            texts.push(TextBox::new(&line, at, TITLE, (INK, HPos::Center), canvas)?);
            top += LEADING * TITLE;
        }
        top += if texts.is_empty() { 0.0 } else { 6.0 };

        let all_x = chart.panels.iter().flat_map(|panel| drawable_x(panel, chart.x_scale));
        let x_axis = Axis::fit(chart.x_scale, all_x, ticks(0.7 * width, TICK_SPACING.0));
        let heights = heights(chart.panels.len());
        let y_axes: Vec<Axis> = (chart.panels.iter().zip(&heights))
            .map(|(panel, &height)| {
                let values = drawable_y(panel, chart.x_scale).into_iter();
                Axis::fit(panel.y_scale, values, ticks(height, TICK_SPACING.1))
            })
            .collect();
        let mut tick_width: f64 = 0.0;
        for tick in y_axes.iter().flat_map(|axis| &axis.ticks) {
            tick_width = tick_width.max(canvas.text_width(&tick.label, TICK)?);
        }
        let gaps = PANEL_GAP * heights.len().saturating_sub(1) as f64;
        let height = heights.iter().sum::<f64>() + gaps;
        let labels = match chart.panels.first() {
            Some(panel) => EndLabels::of(panel, (width, height), canvas)?,
            None => None,
        };
        let names_width = labels.as_ref().map_or(0.0, EndLabels::width);
        let left = EDGE + LABEL * LEADING + tick_width + TICK_GAP;
        // Half of the last label of x extends beyond the frame.
        let right = (width - EDGE - names_width.max(18.0)).max(left + 1.0);

        let mut panels: Vec<PlacedPanel<'_>> = Vec::new();
        let mut y = top;
        for ((panel, height), y_axis) in chart.panels.iter().zip(heights).zip(y_axes) {
            let frame = Frame { left, right, top: y, bottom: y + height };
            y += height + PANEL_GAP;
            let plane = Plane { frame, x: x_axis.clone(), y: y_axis };
            let looks = looks(panel, &plane);
            panels.push(PlacedPanel { panel, plane, looks });
        }
        let mut bottom = top + height;
        for placed in &panels {
            y_texts(placed, &mut texts, canvas)?;
        }
        if let Some(last) = panels.last() {
            x_tick_texts(&last.plane, &mut texts, canvas)?;
            bottom += TICK_GAP + TICK * LEADING;
        }
        let label = with_power(&chart.x_label, x_axis.power);
        if !label.is_empty() {
            let at = (f64::midpoint(left, right), bottom + 0.5 * LABEL + 3.0);
            let max_length = 2.0 * (at.0 - EDGE).min(width - EDGE - at.0);
            texts.push(TextBox::within(&label, at, (LABEL, max_length), INK, canvas)?);
            bottom += LABEL * LEADING + 3.0;
        }
        let mut names = PlacedLabels::default();
        match (&labels, panels.first()) {
            (Some(labels), Some(first)) => {
                let span = (top, top + height);
                names = labels.place(&first.plane, &first.looks, span, canvas)?;
            }
            (None, Some(first)) => {
                let span = (left, width - EDGE);
                let legend = Legend::new(&first.looks, span, bottom + 8.0, canvas)?;
                bottom += 8.0 + legend.height;
                names.texts = legend.texts;
                names.samples = legend.samples;
            }
            (_, None) => {}
        }
        let PlacedLabels { texts: name_texts, leaders, samples } = names;
        texts.extend(name_texts);
        bottom += if chart.notes.is_empty() { 0.0 } else { 10.0 };
        for note in &chart.notes {
            for line in canvas.wrap(note, NOTE, width - 2.0 * EDGE)? {
                let at = (EDGE, bottom + 0.5 * NOTE);
                texts.push(TextBox::new(&line, at, NOTE, (GREY, HPos::Left), canvas)?);
                bottom += LEADING * NOTE;
            }
        }
        let size = (width, (bottom + EDGE).ceil());
        Ok(Self { size, panels, leaders, samples, texts })
    }
}

/// Returns the heights of the given number of panels.
fn heights(n_panels: usize) -> Vec<f64> {
    match n_panels {
        0 => Vec::new(),
        1 => vec![SINGLE],
        n => std::iter::once(FIRST).chain(std::iter::repeat_n(LOWER, n - 1)).collect(),
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the quotient of lengths is small and positive, and the cast saturates"
)]
fn ticks(length: f64, space: f64) -> u32 {
    (length / space).max(2.0) as u32
}

/// Returns the series of a panel in drawing order: grey ones first, the user's own last.
fn looks<'a>(panel: &'a Panel, plane: &Plane) -> Vec<Look<'a>> {
    let mut series: Vec<&Series> = panel.series.iter().collect();
    series.sort_by_key(|series| (!series.ink.is_hollow(), matches!(series.ink, Ink::User(_))));
    let patterns = patterns(&series, plane);
    let shifts = if panel.side_by_side { shifts(&series, plane) } else { vec![0.0; series.len()] };
    let looks = series.into_iter().zip(patterns).zip(shifts);
    looks.map(|((series, pattern), shift)| Look { series, pattern, shift }).collect()
}

/// Returns the shift of each series to the right that places markers at the same x side by side.
fn shifts(series: &[&Series], plane: &Plane) -> Vec<f64> {
    let count = series.iter().filter(|series| series.style.has_markers()).count();
    let points = series.iter().flat_map(|series| &series.points);
    let mut places: Vec<f64> = points.filter_map(|&p| plane.place(p)).map(|at| at.0).collect();
    places.sort_by(f64::total_cmp);
    // Closer positions than this belong to one requested number, which patterns meet only
    // approximately.
    let gaps = places.windows(2).map(|pair| pair[1] - pair[0]).filter(|&gap| gap > 20.0);
    let space = SIDE_BY_SIDE.1 * gaps.fold(120.0, f64::min);
    let margins = places.first().map(|x| x - plane.frame.left).into_iter();
    let margins = margins.chain(places.last().map(|x| plane.frame.right - x));
    let space = margins.map(|margin| 2.0 * (margin - MARGIN)).fold(space, f64::min).max(0.0);
    let step = SIDE_BY_SIDE.0.min(space / count.max(1) as f64);
    let first = -0.5 * step * (count.max(1) - 1) as f64;
    let mut before = 0;
    let shift = |series: &&Series| {
        let has = series.style.has_markers();
        let shift = first + step * f64::from(before);
        before += u32::from(has);
        if has { shift } else { 0.0 }
    };
    series.iter().map(shift).collect()
}

/// Adds the label of y and those of its ticks, except labels that would touch the one below.
fn y_texts<DB: DrawingBackend>(
    placed: &PlacedPanel<'_>,
    texts: &mut Vec<TextBox>,
    canvas: &Canvas<DB>,
) -> Result<(), PlotError> {
    let Plane { frame, y: axis, .. } = &placed.plane;
    let mut free_above = f64::INFINITY;
    for tick in &axis.ticks {
        let at = (frame.left - TICK_GAP, frame.y(tick.at));
        if at.1 <= free_above {
            texts.push(TextBox::new(&tick.label, at, TICK, (INK, HPos::Right), canvas)?);
            free_above = at.1 - 1.1 * TICK;
        }
    }
    let label = with_power(&placed.panel.y_label, axis.power);
    if !label.is_empty() {
        let at = (EDGE + 0.5 * LABEL, f64::midpoint(frame.top, frame.bottom));
        let length = frame.bottom - frame.top;
        texts.push(TextBox::within(&label, at, (LABEL, length), INK, canvas)?.upward());
    }
    Ok(())
}

/// Adds the labels of the ticks of x, except labels that would touch the one before.
fn x_tick_texts<DB: DrawingBackend>(
    plane: &Plane,
    texts: &mut Vec<TextBox>,
    canvas: &Canvas<DB>,
) -> Result<(), PlotError> {
    let mut free_from = f64::NEG_INFINITY;
    for tick in &plane.x.ticks {
        let at = (plane.frame.x(tick.at), plane.frame.bottom + TICK_GAP + 0.5 * TICK);
        let text = TextBox::new(&tick.label, at, TICK, (INK, HPos::Center), canvas)?;
        if text.bounds().left >= free_from {
            free_from = text.bounds().right + 0.5 * TICK;
            texts.push(text);
        }
    }
    Ok(())
}

pub(super) fn with_power(label: &str, power: Option<i32>) -> String {
    match power {
        None => label.to_owned(),
        Some(power) if label.is_empty() => format!("\u{d7} {}", power_of_ten(power)),
        Some(power) => format!("{label}  (\u{d7} {})", power_of_ten(power)),
    }
}
