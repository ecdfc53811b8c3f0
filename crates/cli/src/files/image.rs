//! Reading environment maps.

use std::path::Path;

use image::ImageReader;

use super::FileError;

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
    let name = path.display().to_string();
    let open_error = |source| FileError::Open { path: name.clone(), source };
    let reader =
        ImageReader::open(path).and_then(ImageReader::with_guessed_format).map_err(open_error)?;
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
