//! Reads PNG pictures, whose texels are numbers from 0 to 1 as they are stored, without
//! linearization: for functions on the unit square, not for radiances.

use image::{ImageFormat, ImageReader, Limits};

use super::{CHANNELS, ChannelChoice, ChannelImage, LUMINANCE, unknown_channel};
use crate::files::file_error::FileError;
use crate::files::memory_guard::check_announced;

/// The first bytes of a PNG file.
pub(super) const MAGIC: [u8; 8] = *b"\x89PNG\r\n\x1a\n";

/// The bytes that decoding takes for each texel: up to 4 stored numbers of 2 bytes, or the values,
/// and 3 numbers of 4 bytes.
const BYTES_PER_TEXEL: u64 = 20;

/// The memory that the decoder may take for other data in the file, such as colour profiles.
const OTHER_BYTES: u64 = 64 << 20;

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
    let size = size(bytes).ok_or_else(|| damaged(name, "the header of a PNG file is missing"))?;
    let [width, height] = size.map(u64::from);
    let what = format!("a picture of {width} x {height} texels");
    check_announced(name, &what, BYTES_PER_TEXEL as f64 * width as f64 * height as f64)?;
    let mut reader = ImageReader::with_format(std::io::Cursor::new(bytes), ImageFormat::Png);
    let mut limits = Limits::default();
    let texels = width.saturating_mul(height);
    limits.max_alloc = Some(texels.saturating_mul(BYTES_PER_TEXEL).saturating_add(OTHER_BYTES));
    reader.limits(limits);
    let picture = reader.decode().map_err(|e| damaged(name, e))?.into_rgb32f();
    let value = |texel: &image::Rgb<f32>| {
        texel.0.iter().zip(weights).map(|(x, w)| w * f64::from(*x)).sum::<f64>()
    };
    let values = picture.pixels().map(value).collect();
    let [width, height] = size.map(|n| n as usize);
    Ok(ChannelImage { width, height, values, remarks: Vec::new() })
}

fn damaged(name: &str, reason: impl std::fmt::Display) -> FileError {
    let format = "a PNG image";
    FileError::Image { path: name.to_owned(), format, reason: reason.to_string() }
}

/// Returns width and height in the header, which follows the first bytes; `None` if it is missing.
fn size(bytes: &[u8]) -> Option<[u32; 2]> {
    let header = bytes.get(MAGIC.len() + 4..)?.strip_prefix(b"IHDR")?;
    let (width, rest) = header.split_first_chunk()?;
    let height = rest.first_chunk()?;
    Some([*width, *height].map(u32::from_be_bytes))
}
