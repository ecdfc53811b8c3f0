//! Writes images: PNG for viewing, `OpenEXR` and PFM for computation.

use std::io::{self, Cursor};
use std::path::Path;

use exr::prelude::{
    Encoding, Image, Layer, LayerAttributes, SpecificChannels, Text, WritableImage,
};

use super::{AtomicFile, FileError, is_stream};

/// The extensions of [`PictureFormat::of_path`], for messages.
const PICTURES: &str = ".png, .exr or .pfm";

/// A format of images.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PictureFormat {
    /// 8 bits per channel, sRGB.
    Png,
    /// Linear, 32 bits.
    Exr,
    /// Portable float map: linear, 32 bits, grey. It cannot store remarks.
    Pfm,
}

impl PictureFormat {
    /// Every format.
    pub(crate) const ALL: [Self; 3] = [Self::Png, Self::Exr, Self::Pfm];

    /// Returns the extensions of its files, in lower case.
    pub(crate) const fn extensions(self) -> &'static [&'static str] {
        match self {
            Self::Png => &["png"],
            Self::Exr => &["exr"],
            Self::Pfm => &["pfm"],
        }
    }

    /// Returns the format of the extension in any case; `-`, standard output, is PNG.
    ///
    /// # Errors
    ///
    /// [`FileError::UnknownExtension`].
    pub(crate) fn of_path(path: &Path) -> Result<Self, FileError> {
        let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
        let of =
            |extension: &str| Self::ALL.into_iter().find(|f| f.extensions().contains(&extension));
        match extension.as_deref() {
            None if is_stream(path) => Ok(Self::Png),
            extension => extension.and_then(of).ok_or_else(|| FileError::UnknownExtension {
                path: path.display().to_string(),
                known: PICTURES,
            }),
        }
    }
}

/// Grey values, row by row from the top.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Picture<'a> {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) values: &'a [f64],
    /// The fraction of each pixel that its value covers, stored as alpha; all of it if `None`.
    pub(crate) coverage: Option<&'a [f64]>,
}

impl Picture<'_> {
    /// Writes the values unchanged to an `.exr` or `.pfm`, or as the sRGB colours of `colour` to a
    /// `.png`; `remark` is stored in the file if the format supports it.
    ///
    /// Coverage is stored as alpha: in a PNG with the unmodified colour, in an EXR with the value
    /// times alpha, as is customary there. A PFM stores the value times coverage.
    ///
    /// # Errors
    ///
    /// When the extension is another one or the file cannot be written.
    pub(crate) fn write(
        &self,
        path: &Path,
        colour: &dyn Fn(f64) -> [u8; 3],
        remark: &str,
    ) -> Result<(), FileError> {
        let bytes = match PictureFormat::of_path(path)? {
            PictureFormat::Png => {
                let size = [self.width, self.height];
                match self.coverage {
                    None => {
                        let colours: Vec<u8> =
                            self.values.iter().flat_map(|&x| colour(x)).collect();
                        png_bytes(size, png::ColorType::Rgb, &colours, remark)
                    }
                    Some(coverage) => {
                        let pixels = self.values.iter().zip(coverage);
                        let pixels = pixels.map(|(&x, &alpha)| (colour(x), eight_bits(alpha)));
                        let colours: Vec<u8> =
                            pixels.flat_map(|([r, g, b], alpha)| [r, g, b, alpha]).collect();
                        png_bytes(size, png::ColorType::Rgba, &colours, remark)
                    }
                }
            }
            PictureFormat::Exr => self.exr(remark),
            PictureFormat::Pfm => Ok(self.pfm()),
        };
        write_encoded(path, bytes)
    }

    fn exr(&self, remark: &str) -> io::Result<Vec<u8>> {
        let place = |at: exr::math::Vec2<usize>| at.1 * self.width + at.0;
        let value = |at| {
            let grey = single(self.covered(place(at)));
            (grey, grey, grey)
        };
        let size = (self.width, self.height);
        let attributes = LayerAttributes {
            comments: Text::new_or_none(remark),
            ..LayerAttributes::named("linear")
        };
        let mut bytes = Cursor::new(Vec::new());
        let encoding = Encoding::FAST_LOSSLESS;
        let written = match self.coverage {
            None => {
                let channels = SpecificChannels::rgb(value);
                let layer = Layer::new(size, attributes, encoding, channels);
                Image::from_layer(layer).write().to_buffered(&mut bytes)
            }
            Some(coverage) => {
                let channels = SpecificChannels::rgba(|at| {
                    let (r, g, b) = value(at);
                    (r, g, b, single(coverage[place(at)]))
                });
                let layer = Layer::new(size, attributes, encoding, channels);
                Image::from_layer(layer).write().to_buffered(&mut bytes)
            }
        };
        written.map_err(io::Error::other)?;
        Ok(bytes.into_inner())
    }

    /// Returns the file with its rows from the bottom; the negative scale states that numbers are
    /// little-endian.
    fn pfm(&self) -> Vec<u8> {
        let mut bytes = format!("Pf\n{} {}\n-1.0\n", self.width, self.height).into_bytes();
        for row in (0..self.height).rev() {
            let pixels = row * self.width..(row + 1) * self.width;
            bytes.extend(pixels.flat_map(|i| single(self.covered(i)).to_le_bytes()));
        }
        bytes
    }

    /// Returns the value of a pixel times its coverage.
    fn covered(&self, pixel: usize) -> f64 {
        self.values[pixel] * self.coverage.map_or(1.0, |coverage| coverage[pixel])
    }
}

/// Writes 8-bit sRGB colours, row by row from the top, as a PNG file with a remark in it.
///
/// # Errors
/// When the file cannot be written.
pub(crate) fn write_png(
    path: &Path,
    size: [usize; 2],
    colours: &[u8],
    remark: &str,
) -> Result<(), FileError> {
    write_encoded(path, png_bytes(size, png::ColorType::Rgb, colours, remark))
}

fn write_encoded(path: &Path, bytes: io::Result<Vec<u8>>) -> Result<(), FileError> {
    let unwritten = |source| FileError::Write { path: path.display().to_string(), source };
    AtomicFile::write_whole(path, &bytes.map_err(unwritten)?)
}

/// Returns a PNG file of 8-bit sRGB colours, row by row from the top, with a remark in it.
fn png_bytes(
    [width, height]: [usize; 2],
    channels: png::ColorType,
    colours: &[u8],
    remark: &str,
) -> io::Result<Vec<u8>> {
    let side = |n: usize| u32::try_from(n).map_err(io::Error::other);
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, side(width)?, side(height)?);
    encoder.set_color(channels);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    encoder.add_itxt_chunk("Comment".to_owned(), remark.to_owned()).map_err(io::Error::other)?;
    let mut writer = encoder.write_header().map_err(io::Error::other)?;
    writer.write_image_data(colours).map_err(io::Error::other)?;
    writer.finish().map_err(io::Error::other)?;
    Ok(bytes)
}

/// Returns a share in [0, 1] as an 8-bit number.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 0 and 255")]
fn eight_bits(share: f64) -> u8 {
    (255.0 * share).round() as u8
}

/// Returns a linear value, clamped to [0, 1], as a grey of sRGB (IEC 61966-2-1).
pub(crate) fn srgb(linear: f64) -> u8 {
    // NaN is shown as black.
    let x = if linear > 0.0 { linear.min(1.0) } else { 0.0 };
    let encoded = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between 0 and 255"
    )]
    let byte = (255.0 * encoded).round() as u8;
    byte
}

#[expect(clippy::cast_possible_truncation, reason = "the formats have 32 bits")]
fn single(x: f64) -> f32 {
    x as f32
}

#[cfg(test)]
mod tests {
    use super::{Path, Picture, PictureFormat, srgb};
    use crate::files::{ChannelChoice, read_image};

    #[test]
    fn greys_are_those_of_the_standard() {
        // Values of the curve in the sRGB standard: half of the light is 188, the linear part ends
        // at 10.
        for (linear, grey) in [
            (0.0, 0),
            (1.0, 255),
            (0.5, 188),
            (0.003_130_8, 10),
            (-1.0, 0),
            (f64::NAN, 0),
            (9.0, 255),
        ] {
            assert_eq!(srgb(linear), grey, "{linear}");
        }
    }

    #[test]
    fn values_come_back_from_exr_and_pfm() {
        let folder = tempfile::tempdir().unwrap();
        let values = [0.0, 0.25, -0.5, 1e-20, 3.5, 1e20];
        let picture = Picture { width: 3, height: 2, values: &values, coverage: None };
        let path = folder.path().join("p.exr");
        picture.write(&path, &|_| [0; 3], "a remark").unwrap();
        let red = ChannelChoice { channel: Some("r".to_owned()), layer: None };
        let got = read_image(&path, &red).unwrap();
        assert_eq!((got.width, got.height), (3, 2));
        for (a, b) in got.values.iter().zip(values) {
            // Rounded to 24 bits.
            assert!((a - b).abs() <= 6e-8 * b.abs(), "{a} {b}");
        }
        let bytes = std::fs::read(&path).unwrap();
        assert!(bytes.windows(8).any(|w| w == b"a remark"), "the remark is in the file");
        let path = folder.path().join("p.pfm");
        picture.write(&path, &|_| [0; 3], "").unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let (head, body) = bytes.split_at(bytes.len() - 24);
        assert_eq!(head, b"Pf\n3 2\n-1.0\n");
        let last_row_first: Vec<f32> =
            body.chunks(4).map(|c| f32::from_le_bytes(c.try_into().unwrap())).collect();
        assert_eq!(last_row_first, [1e-20, 3.5, 1e20, 0.0, 0.25, -0.5]);
    }

    #[test]
    fn a_png_has_its_colours_and_its_remark() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p.PNG");
        let picture = Picture { width: 2, height: 1, values: &[0.0, 1.0], coverage: None };
        picture.write(&path, &|x| [srgb(x), 7, 9], "sphvar \u{3c0}").unwrap();
        let got = image::open(&path).unwrap().into_rgb8();
        assert_eq!(got.into_raw(), [0, 7, 9, 255, 7, 9]);
        let bytes = std::fs::read(&path).unwrap();
        assert!(bytes.windows(4).any(|w| w == b"sRGB") && bytes.windows(4).any(|w| w == b"iTXt"));
        assert!(PictureFormat::of_path(Path::new("a.gif")).is_err());
    }
}
