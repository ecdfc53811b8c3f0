//! Reads environment maps: one channel of a linear picture.

mod array;
mod exr_channels;
mod exr_file;
mod png_file;
mod radiance;

use std::path::Path;

use super::file_error::{FileError, Place, input_name};
use super::input::read_whole;
use super::memory_guard::check_announced;

pub(crate) use self::array::PictureArray;

/// The channels of every colour picture.
const CHANNELS: &str = "luminance, r, g, b";
/// Luminance is 0.2126 R + 0.7152 G + 0.0722 B (ITU-R BT.709).
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// The channel of a picture to read.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct ChannelChoice {
    /// `luminance`, `r`, `g`, `b`, or the name of a channel in the file; luminance if omitted.
    pub(crate) channel: Option<String>,
    /// A layer or part; if omitted, the channels without a layer.
    pub(crate) layer: Option<String>,
}

impl ChannelChoice {
    fn channel(&self) -> &str {
        self.channel.as_deref().unwrap_or("luminance")
    }
}

/// One channel of an image, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ChannelImage {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) values: Vec<f64>,
    /// Remarks for the user.
    pub(crate) remarks: Vec<String>,
}

/// Reads one channel of an `OpenEXR` or Radiance HDR image, linear as it is stored.
///
/// # Errors
///
/// If the file cannot be opened, has another format, is damaged, does not have the
/// channel, or does not fit in memory.
pub(crate) fn read_image(path: &Path, choice: &ChannelChoice) -> Result<ChannelImage, FileError> {
    decode_image(input_name(path), &read_whole(path)?, choice)
}

/// Reads one channel of a picture for a function on the unit square, as [`decode_image`] or from
/// PNG.
///
/// # Errors
///
/// As [`read_image`].
pub(crate) fn decode_picture(
    name: String,
    bytes: &[u8],
    choice: &ChannelChoice,
) -> Result<ChannelImage, FileError> {
    if bytes.starts_with(&png_file::MAGIC) {
        png_file::read(&name, bytes, choice)
    } else {
        decode_linear(name, bytes, choice, "PNG (.png), OpenEXR (.exr) or Radiance HDR (.hdr)")
    }
}

/// Reads one channel of an image in memory; `name` is for messages.
///
/// # Errors
///
/// As [`read_image`].
pub(crate) fn decode_image(
    name: String,
    bytes: &[u8],
    choice: &ChannelChoice,
) -> Result<ChannelImage, FileError> {
    decode_linear(name, bytes, choice, "OpenEXR (.exr) or Radiance HDR (.hdr)")
}

/// Decodes `OpenEXR` and Radiance HDR; the error for other formats states what was `expected`.
fn decode_linear(
    name: String,
    bytes: &[u8],
    choice: &ChannelChoice,
    expected: &str,
) -> Result<ChannelImage, FileError> {
    let mut image = if bytes.starts_with(&exr_file::MAGIC) {
        exr_file::read(&name, bytes, choice)?
    } else if radiance::MAGICS.iter().any(|magic| bytes.starts_with(magic)) {
        radiance::read(&name, bytes, choice)?
    } else {
        // Other formats are not linear: their values are not radiances.
        let format = image::guess_format(bytes).ok();
        let extension = format.and_then(|format| format.extensions_str().first());
        return Err(FileError::Layout {
            path: name,
            place: Place::Whole,
            expected: expected.to_owned(),
            got: extension.map_or("an unknown format".to_owned(), |extension| {
                format!("the format of .{extension}")
            }),
        });
    };
    image.remarks.extend(negative_texels(&image));
    image.remarks.iter_mut().for_each(|remark| *remark = format!("{name}: {remark}"));
    Ok(image)
}

/// Returns a remark if there are negative texels, which are not physical.
fn negative_texels(image: &ChannelImage) -> Option<String> {
    let negative = || image.values.iter().enumerate().filter(|(_, value)| **value < 0.0);
    let (at, smallest) = negative().min_by(|a, b| a.1.total_cmp(b.1))?;
    // Four digits without trailing zeros.
    let shown = format!("{smallest:.3e}").parse::<f64>().unwrap_or(*smallest);
    Some(format!(
        "{} of {} texels are negative, the smallest is {shown} (row {}, column {}); integrands use their values, \
         densities their magnitudes",
        negative().count(),
        image.values.len(),
        at / image.width,
        at % image.width,
    ))
}

/// Returns an error if the channel of a picture of this size does not fit in memory.
fn check_size(name: &str, width: u64, height: u64) -> Result<(), FileError> {
    let what = format!("a channel of {width} x {height} texels");
    check_announced(name, &what, size_of::<f64>() as f64 * width as f64 * height as f64)
}

fn damaged(name: &str, reason: impl std::fmt::Display) -> FileError {
    let format = "an EXR or HDR image";
    FileError::Image { path: name.to_owned(), format, reason: reason.to_string() }
}

fn unknown_channel(name: &str, channel: &str, known: String) -> FileError {
    FileError::UnknownChannel { path: name.to_owned(), channel: channel.to_owned(), known }
}

#[cfg(test)]
mod tests;
