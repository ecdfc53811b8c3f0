//! Draws a chart according to its layout.

use plotters::prelude::DrawingBackend;

use super::canvas::{Canvas, Pen};
use super::chart_layout::{Layout, PlacedPanel};
use super::figure::Figure;
use super::palette::{GREY, GRID, INK};
use super::plane::{Frame, Plane};
use super::plot_error::PlotError;
use super::series_drawing::draw_series;

/// Lengths of ticks with and without labels.
const TICK: f64 = 6.0;
const MINOR_TICK: f64 = 3.0;

impl Figure for Layout<'_> {
    const DETAIL: u32 = 2;

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "whole numbers of some thousand units"
    )]
    fn size(&self) -> (u32, u32) {
        (self.size.0.ceil() as u32, self.size.1.ceil() as u32)
    }

    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Result<(), PlotError> {
        for placed in &self.panels {
            draw_grid(&placed.plane, canvas)?;
            draw_reference(placed, canvas)?;
            for look in &placed.looks {
                draw_series(look, &placed.plane, canvas)?;
            }
            draw_frame(&placed.plane, canvas)?;
        }
        for leader in &self.leaders {
            leader.draw(canvas)?;
        }
        for sample in &self.samples {
            sample.draw(canvas)?;
        }
        for text in &self.texts {
            text.draw(canvas)?;
        }
        Ok(())
    }
}

fn draw_grid<DB: DrawingBackend>(plane: &Plane, canvas: &Canvas<DB>) -> Result<(), PlotError> {
    let frame = &plane.frame;
    let pen = Pen::new(GRID, 1.0);
    for tick in &plane.x.ticks {
        canvas.line(&[(frame.x(tick.at), frame.top), (frame.x(tick.at), frame.bottom)], pen)?;
    }
    for tick in &plane.y.ticks {
        canvas.line(&[(frame.left, frame.y(tick.at)), (frame.right, frame.y(tick.at))], pen)?;
    }
    Ok(())
}

fn draw_reference<DB: DrawingBackend>(
    placed: &PlacedPanel<'_>,
    canvas: &Canvas<DB>,
) -> Result<(), PlotError> {
    let Plane { frame, y, .. } = &placed.plane;
    let Some(at) = placed.panel.reference.and_then(|value| y.position(value)) else {
        return Ok(());
    };
    canvas.line(&[(frame.left, frame.y(at)), (frame.right, frame.y(at))], Pen::new(GREY, 1.3))
}

fn draw_frame<DB: DrawingBackend>(plane: &Plane, canvas: &Canvas<DB>) -> Result<(), PlotError> {
    let Plane { frame, x, y } = plane;
    let Frame { left, right, top, bottom } = *frame;
    let pen = Pen::new(INK, 1.2);
    let corners = [(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
    for side in corners.windows(2) {
        canvas.line(side, pen)?;
    }
    let ticks = |axis: &super::axis::Axis| {
        let labelled: Vec<_> = axis.ticks.iter().map(|tick| (tick.at, TICK)).collect();
        let minor = axis.minor.iter().map(|&at| (at, MINOR_TICK));
        labelled.into_iter().chain(minor).collect::<Vec<_>>()
    };
    for (at, length) in ticks(x) {
        canvas.line(&[(frame.x(at), bottom), (frame.x(at), bottom - length)], pen)?;
        canvas.line(&[(frame.x(at), top), (frame.x(at), top + length)], pen)?;
    }
    for (at, length) in ticks(y) {
        canvas.line(&[(left, frame.y(at)), (left + length, frame.y(at))], pen)?;
        canvas.line(&[(right, frame.y(at)), (right - length, frame.y(at))], pen)?;
    }
    Ok(())
}
