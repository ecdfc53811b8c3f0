//! Reading environment maps.

use std::fs::File;
use std::io::{BufRead, BufReader, Seek};
use std::path::Path;

use image::{ImageFormat, ImageReader};

use super::{FileError, Place};

/// What an environment map is a map of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Channel {
    /// 0.2126 R + 0.7152 G + 0.0722 B (ITU-R BT.709).
    Luminance,
    Red,
    Green,
    Blue,
}

/// One channel of an image, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ChannelImage {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) values: Vec<f64>,
}

/// Reads one channel of an `OpenEXR` or Radiance HDR image, linear as it is stored.
///
/// # Errors
/// When the file cannot be opened, is of another format, or is damaged.
pub(crate) fn read_image(path: &Path, channel: Channel) -> Result<ChannelImage, FileError> {
    let open_error = |source| FileError::Open { path: path.display().to_string(), source };
    decode_image(BufReader::new(File::open(path).map_err(open_error)?), path, channel)
}

/// Reads one channel of an image that is called `path` in messages.
///
/// # Errors
/// As [`read_image`].
pub(crate) fn decode_image(
    input: impl BufRead + Seek,
    path: &Path,
    channel: Channel,
) -> Result<ChannelImage, FileError> {
    let name = path.display().to_string();
    let open_error = |source| FileError::Open { path: name.clone(), source };
    let reader = ImageReader::new(input).with_guessed_format().map_err(open_error)?;
    match reader.format() {
        Some(ImageFormat::OpenExr | ImageFormat::Hdr) => (),
        // Others are not linear: their numbers are no radiance.
        other => {
            let other = other.and_then(|format| format.extensions_str().first());
            return Err(FileError::Layout {
                path: name,
                place: Place::Whole,
                expected: "OpenEXR (.exr) or Radiance HDR (.hdr)".to_owned(),
                got: other.map_or("another format".to_owned(), |e| format!("the format of .{e}")),
            });
        }
    }
    let decoded = reader.decode().map_err(|source| FileError::Image { path: name, source })?;
    let weights: [f64; 3] = match channel {
        Channel::Luminance => [0.2126, 0.7152, 0.0722],
        Channel::Red => [1.0, 0.0, 0.0],
        Channel::Green => [0.0, 1.0, 0.0],
        Channel::Blue => [0.0, 0.0, 1.0],
    };
    let (width, height) = (decoded.width() as usize, decoded.height() as usize);
    let value = |pixel: &image::Rgb<f32>| -> f64 {
        pixel
            .0
            .iter()
            .zip(weights)
            .map(|(&c, w)| if w == 0.0 { 0.0 } else { w * f64::from(c) })
            .sum()
    };
    let values = decoded.into_rgb32f().pixels().map(value).collect();
    Ok(ChannelImage { width, height, values })
}

#[cfg(test)]
mod tests {
    use super::{Channel, ImageFormat, read_image};

    #[test]
    fn pictures_that_are_not_linear_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let picture = image::RgbImage::from_pixel(8, 4, image::Rgb([188; 3]));
        // What is in a file counts, not its name.
        for (name, format) in [("map.png", ImageFormat::Png), ("map.exr", ImageFormat::Png)] {
            let path = folder.path().join(name);
            picture.save_with_format(&path, format).unwrap();
            let message = read_image(&path, Channel::Red).unwrap_err().to_string();
            assert!(
                message.contains(name)
                    && message.contains("expected OpenEXR (.exr) or Radiance HDR (.hdr)")
                    && message.contains(".png"),
                "{message}"
            );
        }
        let path = folder.path().join("map.hdr");
        let map = image::Rgb32FImage::from_pixel(8, 4, image::Rgb([0.5; 3]));
        map.save_with_format(&path, ImageFormat::Hdr).unwrap();
        let got = read_image(&path, Channel::Red).unwrap();
        assert_eq!((got.width, got.height, got.values), (8, 4, vec![0.5; 32]));
    }
}
