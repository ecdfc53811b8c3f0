//! A heat map above a chart, in one file.

use std::path::Path;

use image::{Rgb, RgbImage, imageops};
use plotters::prelude::DrawingBackend;

use super::canvas::Canvas;
use super::chart::Chart;
use super::chart_layout::Layout;
use super::figure::{self, Figure, ImageFormat};
use super::heat_map::HeatMap;
use super::plot_error::PlotError;
use crate::files::AtomicFile;

/// A heat map above a chart of the same data.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MapAndChart {
    pub(crate) map: HeatMap,
    pub(crate) chart: Chart,
}

impl MapAndChart {
    /// Writes both as `.svg` or `.png`.
    ///
    /// # Errors
    /// When the extension is another one or the file cannot be written.
    pub(crate) fn render(&self, path: &Path) -> Result<(), PlotError> {
        let layout = self.chart.layout(Chart::WIDTH)?;
        let bytes = match ImageFormat::of_path(path) {
            Some(ImageFormat::Svg) => {
                let map = (self.map.size_in_units(), self.map.svg()?);
                stacked_documents(&[map, (layout.size(), figure::svg(&layout)?)]).into_bytes()
            }
            Some(ImageFormat::Png) => {
                let chart = figure::raster(&OnePixelAUnit(&layout))?;
                figure::encoded(&stacked_pictures(&[self.map.raster()?, chart]))?
            }
            None => return Err(PlotError::UnknownExtension { path: path.display().to_string() }),
        };
        Ok(AtomicFile::write_whole(path, &bytes)?)
    }
}

/// A chart with as many pixels as a heat map, beside which finer letters would look smaller.
struct OnePixelAUnit<'a>(&'a Layout<'a>);

impl Figure for OnePixelAUnit<'_> {
    fn size(&self) -> (u32, u32) {
        self.0.size()
    }

    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Result<(), PlotError> {
        self.0.draw(canvas)
    }
}

/// Returns SVG documents of these widths and heights, one above the other and centred.
fn stacked_documents(documents: &[((u32, u32), String)]) -> String {
    let width = documents.iter().map(|((width, _), _)| *width).max().unwrap_or(0);
    let height: u32 = documents.iter().map(|((_, height), _)| *height).sum();
    let mut all = format!(
        "<svg width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
         xmlns=\"http://www.w3.org/2000/svg\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#FFFFFF\"/>\n"
    );
    let mut top = 0;
    for ((own_width, own_height), document) in documents {
        let left = (width - own_width) / 2;
        all += &document.replacen("<svg ", &format!("<svg x=\"{left}\" y=\"{top}\" "), 1);
        all.push('\n');
        top += own_height;
    }
    all + "</svg>\n"
}

/// Returns pictures one above the other and centred.
fn stacked_pictures(pictures: &[RgbImage]) -> RgbImage {
    let width = pictures.iter().map(RgbImage::width).max().unwrap_or(0);
    let height = pictures.iter().map(RgbImage::height).sum();
    let mut sheet = RgbImage::from_pixel(width, height, Rgb([255; 3]));
    let mut top = 0;
    for picture in pictures {
        let left = (width - picture.width()) / 2;
        imageops::replace(&mut sheet, picture, left.into(), top);
        top += i64::from(picture.height());
    }
    sheet
}

#[cfg(test)]
mod tests {
    use super::{Chart, HeatMap, MapAndChart};
    use crate::plots::{Colours, Edges, Panel, Scale};

    #[test]
    fn both_parts_are_in_one_file_of_the_same_size() {
        let edges = |range| Edges { label: "k".to_owned(), range };
        let map = HeatMap {
            title: "a map".to_owned(),
            notes: Vec::new(),
            size: [3, 3],
            values: vec![1.0; 9],
            label: "power".to_owned(),
            colours: Colours::Heat,
            scale: Scale::Linear,
            x: edges((-1.5, 1.5)),
            y: edges((1.5, -1.5)),
            rings: vec![(0.0, 0.0)],
        };
        let chart = Chart {
            title: "a chart".to_owned(),
            x_label: String::new(),
            x_scale: Scale::Linear,
            panels: vec![Panel::log("y", Vec::new())],
            notes: Vec::new(),
        };
        let both = MapAndChart { map, chart };
        let folder = tempfile::tempdir().unwrap();
        let [svg, png] = ["f.svg", "f.png"].map(|name| folder.path().join(name));
        both.render(&svg).unwrap();
        both.render(&png).unwrap();
        let text = std::fs::read_to_string(&svg).unwrap();
        // The map's cells and its colour scale are pictures.
        assert_eq!(text.matches("<image ").count(), 2);
        assert!(text.contains("a map") && text.contains("a chart") && text.contains("<circle"));
        let picture = image::open(&png).unwrap();
        let size = format!("<svg width=\"{}\" height=\"{}\"", picture.width(), picture.height());
        assert!(text.starts_with(&size), "{size}");
        assert!(both.render(&folder.path().join("f.pdf")).is_err());
    }
}
