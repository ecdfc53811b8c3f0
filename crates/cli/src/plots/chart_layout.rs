//! Lays a chart out: title above, legend to the right, labels and notes below, data in what is left.

use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::HPos;

use super::axis::{Axis, Scale, power_of_ten};
use super::canvas::{Canvas, Pen};
use super::chart::{Chart, Series};
use super::legend::Legend;
use super::palette::{FINE_GRID, GREY, GRID, INK};
use super::plot_error::PlotError;
use super::series_drawing::draw_series;

pub(super) const EDGE: f64 = 22.0;
pub(super) const TITLE: f64 = 24.0;
pub(super) const LABEL: f64 = 20.0;
pub(super) const TICK: f64 = 17.0;
pub(super) const NOTE: f64 = 13.0;
/// From one line of text to the next, in ems.
pub(super) const LEADING: f64 = 1.35;
/// Between the frame and the labels of its ticks.
pub(super) const TICK_GAP: f64 = 9.0;
/// An error bar may stretch the axis below the lowest point by this factor and no further: on a
/// logarithmic scale a bar that nearly reaches zero would squeeze everything else.
const BAR_REACH: f64 = 10.0;

/// The rectangle of the data, in figure units with y pointing down.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    pub(super) left: f64,
    pub(super) right: f64,
    pub(super) top: f64,
    pub(super) bottom: f64,
}

impl Frame {
    fn x(&self, at: f64) -> f64 {
        self.left + at * (self.right - self.left)
    }

    fn y(&self, at: f64) -> f64 {
        self.bottom - at * (self.bottom - self.top)
    }
}

/// The frame with both axes: from values to places on the canvas.
#[derive(Debug)]
pub(super) struct Plane {
    frame: Frame,
    x: Axis,
    y: Axis,
}

impl Plane {
    /// Returns the place of a point, or `None` when it cannot be drawn.
    pub(super) fn place(&self, (x, y): (f64, f64)) -> Option<(f64, f64)> {
        Some((self.frame.x(self.x.position(x)?), self.frame.y(self.y.position(y)?)))
    }

    /// Returns the heights of both ends of an error bar, cut at the frame.
    pub(super) fn bar(&self, y: f64, error: f64) -> Option<(f64, f64)> {
        if !(error.is_finite() && error > 0.0) {
            return None;
        }
        let place = |value: f64, otherwise: f64| {
            let at = self.y.position(value).unwrap_or(otherwise).clamp(0.0, 1.0);
            self.frame.y(at)
        };
        self.y.position(y)?;
        // The lower end may be zero or negative on a logarithmic axis: that is below the frame.
        Some((place(y - error, 0.0), place(y + error, 1.0)))
    }
}

/// Draws a whole chart.
pub(super) fn draw<DB: DrawingBackend>(
    chart: &Chart,
    canvas: &Canvas<DB>,
) -> Result<(), PlotError> {
    let (width, height) = (f64::from(Chart::SIZE.0), f64::from(Chart::SIZE.1));
    let x_axis = Axis::fit(chart.x_scale, chart.series.iter().flat_map(drawable_x(chart)), 9);
    let y_axis = Axis::fit(chart.y_scale, chart.series.iter().flat_map(drawable_y(chart)), 8);

    let title = canvas.wrap(&chart.title, TITLE, width - 2.0 * EDGE)?;
    let mut notes = Vec::new();
    for note in &chart.notes {
        notes.extend(canvas.wrap(note, NOTE, width - 2.0 * EDGE)?);
    }
    let legend = Legend::of(&chart.series, canvas)?;
    let x_label = with_power(&chart.x_label, x_axis.power);
    let y_label = with_power(&chart.y_label, y_axis.power);

    let mut tick_width: f64 = 0.0;
    for tick in &y_axis.ticks {
        tick_width = tick_width.max(canvas.text_width(&tick.label, TICK)?);
    }
    let y_label_room = if y_label.is_empty() { 0.0 } else { LABEL * LEADING + 4.0 };
    let x_label_room = if x_label.is_empty() { 0.0 } else { LABEL * LEADING + 4.0 };
    let notes_room = if notes.is_empty() { 0.0 } else { 10.0 + rows(&notes) * NOTE * LEADING };
    let title_room = if title.is_empty() { 0.0 } else { rows(&title) * TITLE * LEADING + 6.0 };
    // Half of the last label of x stands to the right of the frame.
    let right_room = legend.as_ref().map_or(26.0, |legend| legend.width() + 24.0);
    let frame = Frame {
        left: EDGE + y_label_room + tick_width + TICK_GAP,
        right: width - EDGE - right_room,
        top: EDGE + title_room,
        bottom: height - EDGE - notes_room - x_label_room - TICK_GAP - TICK * LEADING,
    };
    let plane = Plane { frame, x: x_axis, y: y_axis };

    draw_grid(&plane, canvas)?;
    for series in &chart.series {
        draw_series(series, &plane, canvas)?;
    }
    draw_frame(&plane, canvas)?;

    let middle = f64::midpoint(frame.left, frame.right);
    let mut half_title: f64 = 0.0;
    for line in &title {
        half_title = half_title.max(0.5 * canvas.text_width(line, TITLE)?);
    }
    // Over the data where that leaves it whole.
    let half_title = half_title.min(0.5 * width - EDGE);
    let title_x = middle.clamp(EDGE + half_title, width - EDGE - half_title);
    for (row, line) in (0_u8..).zip(&title) {
        let y = EDGE + TITLE * (0.5 + LEADING * f64::from(row));
        canvas.text(line, (title_x, y), TITLE, INK, HPos::Center)?;
    }
    let y = frame.bottom + TICK_GAP + TICK * LEADING + LABEL * 0.5 + 4.0;
    canvas.text(&x_label, (middle, y), LABEL, INK, HPos::Center)?;
    let at = (EDGE + 0.5 * LABEL, f64::midpoint(frame.top, frame.bottom));
    canvas.text_upwards(&y_label, at, LABEL, INK)?;
    for (row, line) in (0_u8..).zip(notes.iter().rev()) {
        let y = height - EDGE - NOTE * (0.5 + LEADING * f64::from(row));
        canvas.text(line, (EDGE, y), NOTE, GREY, HPos::Left)?;
    }
    if let Some(legend) = legend {
        legend.draw((frame.right + 24.0, frame.top), frame.bottom - frame.top, canvas)?;
    }
    Ok(())
}

fn draw_grid<DB: DrawingBackend>(plane: &Plane, canvas: &Canvas<DB>) -> Result<(), PlotError> {
    let frame = &plane.frame;
    let upright =
        |at: f64, pen| canvas.line(&[(frame.x(at), frame.top), (frame.x(at), frame.bottom)], pen);
    let level =
        |at: f64, pen| canvas.line(&[(frame.left, frame.y(at)), (frame.right, frame.y(at))], pen);
    let fine = Pen::new(FINE_GRID, 1.0);
    for &at in &plane.x.fine {
        upright(at, fine)?;
    }
    for &at in &plane.y.fine {
        level(at, fine)?;
    }
    let strong = Pen::new(GRID, 1.0);
    for tick in &plane.x.ticks {
        upright(tick.at, strong)?;
    }
    for tick in &plane.y.ticks {
        level(tick.at, strong)?;
    }
    Ok(())
}

fn draw_frame<DB: DrawingBackend>(plane: &Plane, canvas: &Canvas<DB>) -> Result<(), PlotError> {
    const LENGTH: f64 = 5.0;
    let Frame { left, right, top, bottom } = plane.frame;
    let pen = Pen::new(INK, 1.3);
    let corners = [(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
    for side in corners.windows(2) {
        canvas.line(side, pen)?;
    }
    // Labels that would run into the one before are left out.
    let mut free_from = f64::NEG_INFINITY;
    for tick in &plane.x.ticks {
        let x = plane.frame.x(tick.at);
        canvas.line(&[(x, bottom), (x, bottom - LENGTH)], pen)?;
        let half = 0.5 * canvas.text_width(&tick.label, TICK)?;
        if x - half >= free_from {
            let at = (x, bottom + TICK_GAP + 0.5 * TICK);
            canvas.text(&tick.label, at, TICK, INK, HPos::Center)?;
            free_from = x + half + 0.5 * TICK;
        }
    }
    let mut free_above = f64::INFINITY;
    for tick in &plane.y.ticks {
        let y = plane.frame.y(tick.at);
        canvas.line(&[(left, y), (left + LENGTH, y)], pen)?;
        if y <= free_above {
            canvas.text(&tick.label, (left - TICK_GAP, y), TICK, INK, HPos::Right)?;
            free_above = y - 1.1 * TICK;
        }
    }
    Ok(())
}

/// The x of the points that can be drawn.
fn drawable_x(chart: &Chart) -> impl Fn(&Series) -> Vec<f64> {
    let (x_scale, y_scale) = (chart.x_scale, chart.y_scale);
    move |series| drawable(series, x_scale, y_scale).map(|(_, (x, _))| x).collect()
}

/// The y of the points that can be drawn, with the ends of their errors as far as they are shown.
fn drawable_y(chart: &Chart) -> impl Fn(&Series) -> Vec<f64> {
    let (x_scale, y_scale) = (chart.x_scale, chart.y_scale);
    let points = |series| drawable(series, x_scale, y_scale);
    let lowest =
        chart.series.iter().flat_map(points).map(|(_, (_, y))| y).fold(f64::INFINITY, f64::min);
    let floor = if y_scale == Scale::Log { lowest / BAR_REACH } else { f64::NEG_INFINITY };
    move |series| {
        let mut values = Vec::new();
        for (index, (_, y)) in drawable(series, x_scale, y_scale) {
            values.push(y);
            let error = series.error.as_ref().and_then(|errors| errors.get(index));
            if let Some(error) = error.filter(|error| error.is_finite() && **error > 0.0) {
                values.push(y + error);
                values.push((y - error).max(floor));
            }
        }
        values
    }
}

fn drawable(
    series: &Series,
    x_scale: Scale,
    y_scale: Scale,
) -> impl Iterator<Item = (usize, (f64, f64))> {
    series
        .points
        .iter()
        .copied()
        .enumerate()
        .filter(move |&(_, (x, y))| x_scale.place(x).is_some() && y_scale.place(y).is_some())
}

pub(super) fn with_power(label: &str, power: Option<i32>) -> String {
    match power {
        None => label.to_owned(),
        Some(power) if label.is_empty() => format!("\u{d7} {}", power_of_ten(power)),
        Some(power) => format!("{label}  (\u{d7} {})", power_of_ten(power)),
    }
}

pub(super) fn rows(lines: &[String]) -> f64 {
    f64::from(u32::try_from(lines.len()).unwrap_or(u32::MAX))
}
