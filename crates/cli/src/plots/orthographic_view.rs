//! An orthographic view of directions on the unit sphere.

use std::path::Path;

use glam::DVec3;
use plotters::prelude::DrawingBackend;

use super::canvas::{Canvas, Pen};
use super::figure::{self, Figure};
use super::headings::{EDGE, draw_headings};
use super::palette::{GREY, GRID, Ink};
use super::plot_error::PlotError;

/// The settings of a view: the half of the sphere that faces the viewer, with directions as dots.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct OrthographicView {
    /// The heading; may be empty.
    pub(crate) title: String,
    /// Small lines at the foot, for provenance.
    pub(crate) notes: Vec<String>,
    /// The direction from the centre to the viewer, of any nonzero length; +z points up in the
    /// image, or +y if the viewer is on the z axis.
    pub(crate) viewpoint: DVec3,
    /// Lines on the sphere that are part of the pattern, such as the borders of its strata, each
    /// through unit vectors.
    pub(crate) lines: Vec<Vec<DVec3>>,
}

impl Default for OrthographicView {
    /// The viewer is 30 degrees above the equator, so that pole and equator are both visible.
    fn default() -> Self {
        let viewpoint = DVec3::new(0.75, 0.433_012_701_892_219_3, 0.5);
        Self { title: String::new(), notes: Vec::new(), viewpoint, lines: Vec::new() }
    }
}

const TICK_DEGREES: u8 = 30;
/// The radius of a dot relative to the mean distance of points, sqrt(4 pi / N).
const DOT: f64 = 0.14;

impl OrthographicView {
    /// Width and height in pixels.
    pub(crate) const SIZE: (u32, u32) = (900, 900);

    /// Writes the view of these unit vectors as `.svg` or `.png`; `-` is SVG on standard output.
    /// Vectors that are not finite are omitted.
    ///
    /// # Errors
    ///
    /// If the extension is another one or the file cannot be written.
    pub(crate) fn render(&self, directions: &[DVec3], path: &Path) -> Result<(), PlotError> {
        figure::write(&Sight { view: self, directions }, path)
    }

    /// Returns the axes of the image: to the right, up, and towards the viewer.
    fn axes(&self) -> [DVec3; 3] {
        let towards = self.viewpoint.try_normalize().unwrap_or(DVec3::Z);
        let right = DVec3::Z.cross(towards).try_normalize().unwrap_or(DVec3::X);
        [right, towards.cross(right), towards]
    }
}

/// A view together with its directions.
pub(super) struct Sight<'a> {
    pub(super) view: &'a OrthographicView,
    pub(super) directions: &'a [DVec3],
}

impl Figure for Sight<'_> {
    fn size(&self) -> (u32, u32) {
        OrthographicView::SIZE
    }

    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Result<(), PlotError> {
        let width = f64::from(self.size().0);
        let (top, bottom) = draw_headings(&self.view.title, &self.view.notes, self.size(), canvas)?;
        let radius = 0.5 * (bottom - top - 8.0).min(width - 2.0 * EDGE).max(100.0);
        let globe = Globe {
            centre: (0.5 * width, f64::midpoint(top, bottom)),
            radius,
            axes: self.view.axes(),
        };
        if self.view.lines.is_empty() {
            globe.draw_graticule(canvas)?;
        } else {
            for line in &self.view.lines {
                globe.curve(line.iter().copied(), Pen::new(GRID, 1.2), canvas)?;
            }
        }
        globe.draw_outline(canvas)?;

        let count = self.directions.len().max(1);
        let spacing = (4.0 * std::f64::consts::PI
            / f64::from(u32::try_from(count).unwrap_or(u32::MAX)))
        .sqrt();
        let dot = (DOT * spacing * radius).clamp(0.8, 8.0);
        for &direction in self.directions {
            if let Some(at) = globe.front(direction) {
                canvas.disc(at, dot, Pen::new(Ink::Rank(0).colour(), 1.0))?;
            }
        }
        Ok(())
    }
}

/// The sphere on the canvas.
struct Globe {
    centre: (f64, f64),
    radius: f64,
    axes: [DVec3; 3],
}

impl Globe {
    /// Returns the position of a direction, or `None` if it is on the far side.
    fn front(&self, direction: DVec3) -> Option<(f64, f64)> {
        let [right, up, towards] = self.axes.map(|axis| axis.dot(direction));
        (towards >= 0.0 && right.is_finite() && up.is_finite())
            .then_some((self.centre.0 + self.radius * right, self.centre.1 - self.radius * up))
    }

    /// Draws the visible halves of circles of latitude and longitude, faintly.
    fn draw_graticule<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Result<(), PlotError> {
        let faint = Pen::new(GRID, 1.2);
        let on_sphere = |theta: f64, phi: f64| {
            let (theta, phi) = (theta.to_radians(), phi.to_radians());
            DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
        };
        let degrees =
            |from: u16, to: u16, step: u8| (from..=to).step_by(step.into()).map(f64::from);
        for theta in degrees(u16::from(TICK_DEGREES), 150, TICK_DEGREES) {
            self.curve(degrees(0, 360, 2).map(|phi| on_sphere(theta, phi)), faint, canvas)?;
        }
        for phi in degrees(0, 330, TICK_DEGREES) {
            self.curve(degrees(0, 180, 2).map(|theta| on_sphere(theta, phi)), faint, canvas)?;
        }
        Ok(())
    }

    fn draw_outline<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Result<(), PlotError> {
        let outline: Vec<_> = (0..=360_u16)
            .map(|angle| {
                let (sin, cos) = f64::from(angle).to_radians().sin_cos();
                (self.centre.0 + self.radius * cos, self.centre.1 + self.radius * sin)
            })
            .collect();
        canvas.line(&outline, Pen::new(GREY, 1.5))
    }

    fn curve<DB: DrawingBackend>(
        &self,
        directions: impl Iterator<Item = DVec3>,
        pen: Pen,
        canvas: &Canvas<DB>,
    ) -> Result<(), PlotError> {
        let mut run = Vec::new();
        for direction in directions {
            match self.front(direction) {
                Some(at) => run.push(at),
                None => canvas.line(&std::mem::take(&mut run), pen)?,
            }
        }
        canvas.line(&run, pen)
    }
}
