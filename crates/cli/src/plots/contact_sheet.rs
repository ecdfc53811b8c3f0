//! Pictures in rows and columns with captions below.

use image::{RgbImage, imageops};
use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::HPos;

use super::canvas::Canvas;
use super::figure::{self, Figure};
use super::palette::INK;
use super::plot_error::PlotError;

/// Between pictures and around them, pixels.
const GAP: u32 = 12;
const LETTERS: f64 = 14.0;
/// A line of text is no wider than this for each letter, in ems.
const WIDEST: f64 = 0.75;
/// From one line of a caption to the next.
const LINE: u32 = 20;
/// For each pixel of a sheet: its captions are drawn three by three times as large, and then there are the sheet, the
/// pictures and the file, of three bytes a pixel each.
const BYTES: f64 = (3 * 3 * 3 + 3 * 3) as f64;
/// Lines below a picture: two, each broken once.
const USUAL_LINES: f64 = 4.0;

/// One picture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Panel {
    /// Width and height.
    pub(crate) size: [usize; 2],
    /// Three bytes a pixel, row by row from the top.
    pub(crate) colours: Vec<u8>,
    /// Lines below it; those that are too long are broken.
    pub(crate) caption: Vec<String>,
}

/// Pictures of the same size, row by row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ContactSheet {
    pub(crate) panels: Vec<Panel>,
    pub(crate) columns: usize,
}

/// Where things are, in pixels.
struct Layout {
    panel: [u32; 2],
    caption: u32,
    columns: u32,
    rows: u32,
}

/// The captions alone, which are drawn larger and averaged down; pictures keep their pixels.
struct Captions<'a> {
    sheet: &'a ContactSheet,
    layout: &'a Layout,
}

impl ContactSheet {
    /// The memory that a sheet of so many pictures of this size takes, about, with captions of two lines.
    pub(crate) fn bytes([width, height]: [usize; 2], panels: usize) -> f64 {
        let (gap, caption) = (f64::from(GAP), USUAL_LINES * f64::from(LINE));
        BYTES * (width as f64 + gap) * (height as f64 + caption + gap) * panels as f64
    }

    /// Width and height, and three bytes a pixel.
    ///
    /// # Errors
    /// When the sheet is too large or the font cannot be drawn.
    pub(crate) fn pixels(&self) -> Result<([usize; 2], Vec<u8>), PlotError> {
        let layout = self.layout()?;
        let mut sheet = figure::raster(&Captions { sheet: self, layout: &layout })?;
        for (panel, corner) in self.panels.iter().zip(layout.corners()) {
            let [width, height] = layout.panel;
            let picture = RgbImage::from_raw(width, height, panel.colours.clone());
            if let Some(picture) = picture {
                imageops::replace(&mut sheet, &picture, corner[0].into(), corner[1].into());
            }
        }
        let size = [sheet.width() as usize, sheet.height() as usize];
        Ok((size, sheet.into_raw()))
    }

    fn layout(&self) -> Result<Layout, PlotError> {
        let too_large = |_| PlotError::Drawing { reason: "the sheet is too large".to_owned() };
        let size = self.panels.first().map_or([1, 1], |panel| panel.size);
        let lines_of = |panel: &Panel| -> usize {
            panel.caption.iter().map(|text| broken_lines(text, size[0])).sum()
        };
        let lines = self.panels.iter().map(lines_of).max().unwrap_or(0);
        let columns = self.columns.clamp(1, self.panels.len().max(1));
        Ok(Layout {
            panel: [
                u32::try_from(size[0]).map_err(too_large)?,
                u32::try_from(size[1]).map_err(too_large)?,
            ],
            caption: LINE * u32::try_from(lines).map_err(too_large)?,
            columns: u32::try_from(columns).map_err(too_large)?,
            rows: u32::try_from(self.panels.len().div_ceil(columns)).map_err(too_large)?,
        })
    }
}

/// Lines that a caption is broken into at most: each line but the last is half full or more, since a word that is longer
/// is cut; two lines are left for those that fit well.
fn broken_lines(text: &str, width: usize) -> usize {
    let letters = text.chars().count();
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a whole number of letters"
    )]
    let per_line = ((width as f64 / (WIDEST * LETTERS)) as usize).max(1);
    if letters <= per_line { 2 } else { (2 * letters.div_ceil(per_line)).max(2) }
}

impl Layout {
    fn step(&self) -> [u32; 2] {
        [self.panel[0] + GAP, self.panel[1] + self.caption + GAP]
    }

    /// The upper left pixels of the pictures.
    fn corners(&self) -> impl Iterator<Item = [u32; 2]> {
        let [across, down] = self.step();
        (0..self.rows).flat_map(move |row| {
            (0..self.columns).map(move |column| [GAP + column * across, GAP + row * down])
        })
    }
}

impl Figure for Captions<'_> {
    fn size(&self) -> (u32, u32) {
        let [across, down] = self.layout.step();
        (GAP + self.layout.columns * across, GAP + self.layout.rows * down)
    }

    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Result<(), PlotError> {
        let [width, height] = self.layout.panel.map(f64::from);
        for (panel, [x, y]) in self.sheet.panels.iter().zip(self.layout.corners()) {
            let mut middle = f64::from(y) + height + 0.7 * f64::from(LINE);
            for text in &panel.caption {
                for line in canvas.wrap(text, LETTERS, width)? {
                    canvas.text(&line, (f64::from(x), middle), LETTERS, INK, HPos::Left)?;
                    middle += f64::from(LINE);
                }
            }
        }
        Ok(())
    }
}
