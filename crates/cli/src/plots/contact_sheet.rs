//! Pictures in rows and columns with captions below.

use image::{RgbImage, imageops};
use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::HPos;

use super::canvas::Canvas;
use super::figure::{self, Figure};
use super::palette::INK;
use super::plot_error::PlotError;

/// The distance between pictures and around them, in pixels.
const GAP: u32 = 12;
const LETTERS: f64 = 14.0;
/// The minimum width of captions below narrower pictures, in pixels: about 25 letters.
const MIN_WIDTH: u32 = 192;
/// The distance between lines of a caption.
const LINE: u32 = 20;
/// The memory of each pixel of a sheet: its captions are drawn at three times the size, and the
/// sheet, the pictures and the file take three bytes a pixel each.
const BYTES: f64 = (3 * 3 * 3 + 3 * 3) as f64;
/// The number of lines below a picture, for estimates: two, each broken once.
const DEFAULT_LINES: f64 = 4.0;

/// One picture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SheetPanel {
    /// Width and height.
    pub(crate) size: [usize; 2],
    /// Three bytes a pixel, row by row from the top.
    pub(crate) colours: Vec<u8>,
    /// Lines below it; long lines are wrapped.
    pub(crate) caption: Vec<String>,
}

/// Pictures of the same size, row by row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ContactSheet {
    pub(crate) panels: Vec<SheetPanel>,
    pub(crate) columns: usize,
}

/// The positions of all parts, in pixels.
struct Layout {
    panel: [u32; 2],
    /// The width of a picture with its caption.
    width: u32,
    /// The lines below each picture.
    captions: Vec<Vec<String>>,
    columns: u32,
    rows: u32,
}

/// The captions alone, which are drawn larger and averaged down; pictures keep their pixels.
struct Captions<'a> {
    layout: &'a Layout,
}

impl ContactSheet {
    /// Returns the approximate memory of a sheet of this number of pictures of this size, with
    /// captions of two lines.
    pub(crate) fn bytes([width, height]: [usize; 2], panels: usize) -> f64 {
        let (gap, caption) = (f64::from(GAP), DEFAULT_LINES * f64::from(LINE));
        BYTES
            * (f64::max(width as f64, f64::from(MIN_WIDTH)) + gap)
            * (height as f64 + caption + gap)
            * panels as f64
    }

    /// Width and height, and three bytes a pixel.
    ///
    /// # Errors
    /// When the sheet is too large or the font cannot be drawn.
    pub(crate) fn pixels(&self) -> Result<([usize; 2], Vec<u8>), PlotError> {
        let layout = self.layout()?;
        let mut sheet = figure::raster(&Captions { layout: &layout })?;
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
        let [panel_width, panel_height] = size.map(u32::try_from);
        let panel = [panel_width.map_err(too_large)?, panel_height.map_err(too_large)?];
        let width = panel[0].max(MIN_WIDTH);
        let captions = figure::measured(|canvas| {
            let lines = |text: &String| canvas.wrap(text, LETTERS, f64::from(width));
            let caption = |panel: &SheetPanel| {
                let parts: Result<Vec<_>, _> = panel.caption.iter().map(lines).collect();
                Ok(parts?.concat())
            };
            self.panels.iter().map(caption).collect()
        })?;
        let columns = self.columns.clamp(1, self.panels.len().max(1));
        Ok(Layout {
            panel,
            width,
            captions,
            columns: u32::try_from(columns).map_err(too_large)?,
            rows: u32::try_from(self.panels.len().div_ceil(columns)).map_err(too_large)?,
        })
    }
}

impl Layout {
    fn step(&self) -> [u32; 2] {
        let lines = self.captions.iter().map(Vec::len).max().unwrap_or(0);
        let caption = LINE * u32::try_from(lines).unwrap_or(u32::MAX / LINE);
        [self.width + GAP, self.panel[1] + caption + GAP]
    }

    /// Returns the upper left pixels of the pictures.
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
        let height = f64::from(self.layout.panel[1]);
        for (caption, [x, y]) in self.layout.captions.iter().zip(self.layout.corners()) {
            let mut middle = f64::from(y) + height + 0.7 * f64::from(LINE);
            for line in caption {
                canvas.text(line, (f64::from(x), middle), LETTERS, INK, HPos::Left)?;
                middle += f64::from(LINE);
            }
        }
        Ok(())
    }
}
