//! The names of curves at their ends, to the right of the data.

use plotters::prelude::DrawingBackend;
use plotters::style::RGBColor;
use plotters::style::text_anchor::HPos;

use super::axis::Scale;
use super::canvas::{Canvas, Pen};
use super::chart::{Panel, Series};
use super::legend::by_importance;
use super::names::fitted;
use super::plane::{Frame, Plane};
use super::plot_error::PlotError;
use super::series_drawing::{Look, Sample, THIN_LINE};
use super::spreading::spread;
use super::text_box::TextBox;

/// Font sizes; the first that fits is used.
const SIZES: [f64; 3] = [15.0, 13.5, 12.0];
/// The distance between lines and between names, in ems.
const LEADING: f64 = 1.15;
const PAUSE: f64 = 0.15;
/// The distance between the frame and the names, which leaders cross.
const LEADER_LENGTH: f64 = 30.0;
/// The maximum width of a name, as a fraction of the figure's width, and its number of lines.
const MAX_WIDTH: f64 = 0.24;
const MAX_LINES: usize = 3;
/// Three ends within this height look like one point.
const ONE_PLACE: f64 = 5.0;
/// A name this close to the end of its curve needs no leader.
const AT_THE_END: f64 = 3.0;

/// The names of the series with their sizes.
#[derive(Debug)]
pub(super) struct EndLabels<'a> {
    labels: Vec<(&'a Series, Vec<String>)>,
    size: f64,
    width: f64,
}

/// The positions of the names, with a leader or a sample each.
#[derive(Default)]
pub(super) struct PlacedLabels<'a> {
    pub(super) texts: Vec<TextBox>,
    pub(super) leaders: Vec<Leader>,
    pub(super) samples: Vec<Sample<'a>>,
}

/// A line from the end of a curve to its name.
#[derive(Debug, Clone, Copy)]
pub(super) struct Leader {
    /// The end of the curve, the point of the frame at the same height, and the name.
    points: [(f64, f64); 3],
    colour: RGBColor,
}

impl<'a> EndLabels<'a> {
    /// Returns the names of the series that have one, or `None` if they do not fit beside a frame
    /// of this height in a figure of this width.
    pub(super) fn of<DB: DrawingBackend>(
        panel: &'a Panel,
        (figure_width, height): (f64, f64),
        canvas: &Canvas<DB>,
    ) -> Result<Option<Self>, PlotError> {
        for size in SIZES {
            let mut labels = Self { labels: Vec::new(), size, width: 0.0 };
            for one in panel.series.iter().filter(|one| !one.label.is_empty()) {
                let max_width = MAX_WIDTH * figure_width;
                let lines = fitted(&name(one, panel.y_scale), size, max_width, MAX_LINES, canvas)?;
                for line in &lines {
                    labels.width = labels.width.max(canvas.text_width(line, size)?);
                }
                labels.labels.push((one, lines));
            }
            let taken: f64 = labels.labels.iter().map(|(_, lines)| labels.height(lines)).sum();
            if taken <= height && labels.width <= MAX_WIDTH * figure_width {
                return Ok(Some(labels));
            }
        }
        Ok(None)
    }

    /// Returns the width of the names with their leaders, units.
    pub(super) fn width(&self) -> f64 {
        if self.labels.is_empty() { 0.0 } else { LEADER_LENGTH + self.width }
    }

    fn height(&self, lines: &[String]) -> f64 {
        self.size * (LEADING * lines.len() as f64 + PAUSE)
    }

    /// Returns the names as close to the ends of their curves as the space between `top` and
    /// `bottom` permits, with leaders. Where several curves end at one point, leaders would be
    /// ambiguous, so all names are listed from the top, with samples.
    pub(super) fn place<DB: DrawingBackend>(
        &self,
        plane: &Plane,
        looks: &[Look<'a>],
        (top, bottom): (f64, f64),
        canvas: &Canvas<DB>,
    ) -> Result<PlacedLabels<'a>, PlotError> {
        let Frame { right, bottom: foot, .. } = plane.frame;
        let ends: Vec<_> = self.labels.iter().map(|(series, _)| plane.end(series)).collect();
        let listed = by_importance(looks);
        let is_list = meet(&ends);
        let order = |series: &Series| listed.iter().position(|l| std::ptr::eq(l.series, series));
        // Series that cannot be drawn are named below all others.
        let wanted: Vec<f64> = (self.labels.iter().zip(&ends))
            .map(|((series, _), end)| match is_list {
                // Far above, so that the list begins at the top.
                true => order(series).unwrap_or(0) as f64 - 1e6,
                false => end.map_or(foot, |end| end.1),
            })
            .collect();
        let heights: Vec<f64> = self.labels.iter().map(|(_, lines)| self.height(lines)).collect();
        let Some(middles) = spread(&wanted, &heights, top, bottom) else {
            return Err(PlotError::Drawing { reason: "labels do not fit".to_owned() });
        };
        let x = right + LEADER_LENGTH;
        let mut placed = PlacedLabels::default();
        for (((series, lines), middle), end) in self.labels.iter().zip(middles).zip(ends) {
            let colour = series.ink.colour();
            let mut y = middle - 0.5 * self.size * LEADING * (lines.len() as f64 - 1.0);
            let first = y;
            for line in lines {
                let style = (colour, HPos::Left);
                placed.texts.push(TextBox::new(line, (x, y), self.size, style, canvas)?);
                y += LEADING * self.size;
            }
            match (is_list, order(series), end) {
                (true, Some(place), _) => {
                    let at = (right + 6.0, first);
                    placed.samples.push(Sample::new(
                        listed[place],
                        looks,
                        at,
                        LEADER_LENGTH - 11.0,
                    ));
                }
                (false, _, Some(end)) => {
                    let points = [end, (right + 3.0, end.1), (x - 3.0, middle)];
                    placed.leaders.push(Leader { points, colour });
                }
                _ => {}
            }
        }
        Ok(placed)
    }
}

/// Returns whether more than two curves end at one point.
fn meet(ends: &[Option<(f64, f64)>]) -> bool {
    let mut heights: Vec<f64> = ends.iter().flatten().map(|end| end.1).collect();
    heights.sort_by(f64::total_cmp);
    heights.windows(3).any(|three| three[2] - three[0] < ONE_PLACE)
}

/// Returns the name of a series, with a remark if it cannot be drawn on a logarithmic axis.
fn name(series: &Series, y_scale: Scale) -> String {
    let Series { label, points, .. } = series;
    let is_zero = y_scale == Scale::Log && points.iter().all(|point| point.1 == 0.0);
    if is_zero && !points.is_empty() { format!("{label} (0)") } else { label.clone() }
}

impl Leader {
    /// Draws the part within the frame as dots, which cannot be mistaken for data.
    pub(super) fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Result<(), PlotError> {
        let [end, frame, name] = self.points;
        let pen = Pen { colour: self.colour, opacity: 0.75, width: 0.8 * THIN_LINE };
        let mut x = end.0 + 9.0;
        while x < frame.0 - 5.0 {
            canvas.line(&[(x, end.1), (x + 1.5, end.1)], pen)?;
            x += 6.0;
        }
        if (frame.1 - name.1).abs() > AT_THE_END || frame.0 - end.0 > LEADER_LENGTH {
            canvas.line(&[frame, name], pen)?;
        }
        Ok(())
    }
}
