//! Writes a figure to a file: selects the image format and encodes it.

use std::io::Cursor;
use std::path::Path;

use image::{DynamicImage, RgbImage};
use plotters::prelude::{BitMapBackend, DrawingBackend, IntoDrawingArea, SVGBackend};

use super::canvas::Canvas;
use super::plot_error::PlotError;
use crate::files::{AtomicFile, is_stream};

/// SVG coordinates are integers in tenths of a unit.
pub(super) const SVG_ZOOM: u32 = 10;
/// PNG is drawn with this factor more pixels per side and averaged down, which smooths all edges.
const PNG_ZOOM: u32 = 2;
/// See [`Canvas::new`]: SVG centres lower-case letters, whose middle is a tenth of an em below that
/// of digits.
const SVG_TEXT_DROP: f64 = 0.09;
/// The bitmap backend assumes half an em for the height of the letters above the middle; the value
/// is measured on the embedded font.
const PNG_TEXT_DROP: f64 = 0.26;

/// An image format of figures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ImageFormat {
    /// Scalable vector graphics.
    Svg,
    /// Portable network graphics, 8 bit RGB.
    Png,
}

impl ImageFormat {
    /// Returns the format of an extension in any case.
    pub(crate) fn of_path(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "svg" => Some(Self::Svg),
            "png" => Some(Self::Png),
            _ => None,
        }
    }
}

/// Something that can be drawn.
pub(super) trait Figure {
    /// The number of pixels of a PNG file per unit.
    const DETAIL: u32 = 1;

    /// Returns width and height in units.
    fn size(&self) -> (u32, u32);

    /// Draws everything on a white canvas.
    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Result<(), PlotError>;
}

/// Writes a figure in the format of its extension; `-` is standard output, as SVG.
pub(super) fn write(figure: &impl Figure, path: &Path) -> Result<(), PlotError> {
    let format = match ImageFormat::of_path(path) {
        Some(format) => format,
        None if is_stream(path) => ImageFormat::Svg,
        None => return Err(PlotError::UnknownExtension { path: path.display().to_string() }),
    };
    let bytes = match format {
        ImageFormat::Svg => svg(figure)?.into_bytes(),
        ImageFormat::Png => png(figure)?,
    };
    Ok(AtomicFile::write_whole(path, &bytes)?)
}

/// Returns a figure as an SVG document.
pub(super) fn svg(figure: &impl Figure) -> Result<String, PlotError> {
    let (width, height) = figure.size();
    let (inner_width, inner_height) = (width * SVG_ZOOM, height * SVG_ZOOM);
    let mut document = String::new();
    let backend = SVGBackend::with_string(&mut document, (inner_width, inner_height));
    draw(figure, backend, SVG_ZOOM, SVG_TEXT_DROP)?;
    // The view box keeps the fine coordinates; width and height are in units.
    Ok(document.replacen(
        &format!("width=\"{inner_width}\" height=\"{inner_height}\" viewBox"),
        &format!("width=\"{width}\" height=\"{height}\" viewBox"),
        1,
    ))
}

/// Returns a figure as a PNG file.
pub(super) fn png(figure: &impl Figure) -> Result<Vec<u8>, PlotError> {
    encoded(&raster(figure)?)
}

/// Returns pixels as a PNG file.
pub(super) fn encoded(picture: &RgbImage) -> Result<Vec<u8>, PlotError> {
    let mut bytes = Cursor::new(Vec::new());
    picture
        .write_to(&mut bytes, image::ImageFormat::Png)
        .map_err(|source| PlotError::Encoding { source })?;
    Ok(bytes.into_inner())
}

/// Returns the pixels of a figure.
pub(super) fn raster<F: Figure>(figure: &F) -> Result<RgbImage, PlotError> {
    let (width, height) = figure.size();
    let (width, height) = (width * F::DETAIL, height * F::DETAIL);
    let (inner_width, inner_height) = (width * PNG_ZOOM, height * PNG_ZOOM);
    let mut image = RgbImage::new(inner_width, inner_height);
    let backend = BitMapBackend::with_buffer(&mut image, (inner_width, inner_height));
    draw(figure, backend, PNG_ZOOM * F::DETAIL, PNG_TEXT_DROP)?;
    // The code is in the image crate, which is optimized in every build.
    Ok(DynamicImage::from(image).thumbnail_exact(width, height).into_rgb8())
}

/// Returns the result of `measure` on a canvas that draws text as PNG files do.
pub(super) fn measured<T>(
    measure: impl FnOnce(&Canvas<BitMapBackend<'_>>) -> Result<T, PlotError>,
) -> Result<T, PlotError> {
    let mut pixel = RgbImage::new(1, 1);
    let area = BitMapBackend::with_buffer(&mut pixel, (1, 1)).into_drawing_area();
    measure(&Canvas::new(area, f64::from(PNG_ZOOM), PNG_TEXT_DROP)?)
}

fn draw<DB: DrawingBackend>(
    figure: &impl Figure,
    backend: DB,
    zoom: u32,
    text_drop: f64,
) -> Result<(), PlotError> {
    let canvas = Canvas::new(backend.into_drawing_area(), f64::from(zoom), text_drop)?;
    figure.draw(&canvas)?;
    canvas.finish()
}
