//! Reads PNG pictures, whose texels are numbers from 0 to 1 as they are stored, without
//! linearization: for functions on the unit square, not for radiances.

use image::{ImageFormat, ImageReader};

use super::{
    CHANNELS, ChannelChoice, ChannelImage, LUMINANCE, check_size, damaged, unknown_channel,
};
use crate::files::file_error::FileError;

/// The first bytes of a PNG file.
pub(super) const MAGIC: [u8; 8] = *b"\x89PNG\r\n\x1a\n";

pub(super) fn read(
    name: &str,
    bytes: &[u8],
    choice: &ChannelChoice,
) -> Result<ChannelImage, FileError> {
    let weights = match choice.channel() {
        _ if choice.layer.is_some() => None,
        "luminance" => Some(LUMINANCE),
        "r" => Some([1.0, 0.0, 0.0]),
        "g" => Some([0.0, 1.0, 0.0]),
        "b" => Some([0.0, 0.0, 1.0]),
        _ => None,
    };
    let wanted = choice.layer.as_deref().unwrap_or(choice.channel());
    let weights = weights.ok_or_else(|| unknown_channel(name, wanted, CHANNELS.to_owned()))?;
    let reader = || ImageReader::with_format(std::io::Cursor::new(bytes), ImageFormat::Png);
    let size = reader().into_dimensions().map_err(|e| damaged(name, e))?;
    check_size(name, size.0.into(), size.1.into())?;
    let picture = reader().decode().map_err(|e| damaged(name, e))?.into_rgb32f();
    let value = |texel: &image::Rgb<f32>| {
        texel.0.iter().zip(weights).map(|(x, w)| w * f64::from(*x)).sum::<f64>()
    };
    let values = picture.pixels().map(value).collect();
    let (width, height) = (size.0 as usize, size.1 as usize);
    Ok(ChannelImage { width, height, values, remarks: Vec::new() })
}
