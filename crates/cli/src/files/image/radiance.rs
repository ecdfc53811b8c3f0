//! Reads Radiance pictures (.hdr, .pic), whose values are divided by factors in the header.
//!
//! Values are red, green and blue, or X, Y and Z of the CIE. For XYZ, luminance is Y, and colours
//! are relative to Radiance's standard primaries. This module reads the header, because the decoder
//! of the crate `image` supports only one of the two magic texts, ignores exposures and reads
//! scanlines in one order; the decoder reads the scanlines.

use std::io::Read;

use image::ImageDecoder;
use image::codecs::hdr::HdrDecoder;

use super::{
    CHANNELS, ChannelChoice, ChannelImage, LUMINANCE, check_size, damaged, unknown_channel,
};
use crate::files::file_error::{FileError, Place};

/// The first bytes of a Radiance picture.
pub(super) const MAGICS: [&[u8]; 2] = [b"#?RADIANCE", b"#?RGBE"];
/// A header of more bytes is damaged.
const MAX_HEADER: usize = 1 << 20;
/// Scanlines outside of these widths are uncompressed even if they start with the mark of
/// compressed ones.
const COMPRESSED_WIDTHS: std::ops::RangeInclusive<usize> = 8..=32767;

/// Red, green and blue from X, Y and Z: the inverse of the matrix of Radiance's standard primaries
/// (x, y) = (0.640, 0.330), (0.290, 0.600), (0.150, 0.060) with the white (1/3, 1/3) of luminance 1
/// (`color.h` of Radiance).
const XYZ_TO_RGB: [[f64; 3]; 3] = [
    [2.5653128430296378, -1.1668496158068057, -0.39846322722283205],
    [-1.0221081721279116, 1.9782866166600869, 0.043821555467824714],
    [0.07472437729685586, -0.25193956717027358, 1.1772151898734177],
];

/// The colour space of the texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    /// Red, green and blue.
    Rgbe,
    /// X, Y and Z.
    Xyze,
}

impl Format {
    /// Returns the weights of the stored values in a channel, or `None` if the channel does not
    /// exist.
    fn weights(self, channel: &str) -> Option<[f64; 3]> {
        let colour = match channel {
            "luminance" if self == Self::Xyze => return Some([0.0, 1.0, 0.0]),
            "luminance" => return Some(LUMINANCE),
            "r" => 0,
            "g" => 1,
            "b" => 2,
            _ => return None,
        };
        let mut unit = [0.0; 3];
        unit[colour] = 1.0;
        Some(if self == Self::Xyze { XYZ_TO_RGB[colour] } else { unit })
    }
}

/// The contents of the header.
#[derive(Debug)]
struct Header {
    format: Format,
    /// The divisors of the stored values: EXPOSURE times COLORCORR.
    divisors: [f64; 3],
    resolution: Resolution,
    remarks: Vec<String>,
}

/// The order of scanlines and texels, such as `-Y 512 +X 1024`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Resolution {
    /// The axis from scanline to scanline, then the one within a scanline.
    axes: [Axis; 2],
    lengths: [usize; 2],
}

/// The direction of an axis in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Axis {
    is_x: bool,
    /// Whether it runs from right to left, or from bottom to top.
    is_reversed: bool,
}

/// Reads one channel, oriented as the resolution line states.
pub(super) fn read(
    name: &str,
    bytes: &[u8],
    choice: &ChannelChoice,
) -> Result<ChannelImage, FileError> {
    if let Some(layer) = &choice.layer {
        return Err(damaged(
            name,
            format!("a Radiance picture has no layers, layer={layer} was given"),
        ));
    }
    let (header, mut body) = Header::read(name, bytes)?;
    let channel = choice.channel();
    let weights = header.format.weights(channel);
    let weights = weights.ok_or_else(|| unknown_channel(name, channel, CHANNELS.to_owned()))?;
    let Resolution { axes, lengths: [scanlines, length] } = header.resolution;
    let (width, height) = if axes[0].is_x { (scanlines, length) } else { (length, scanlines) };
    // A scanline has at least one texel or mark of 4 bytes.
    if scanlines > body.len() / 4 || length == 0 {
        return Err(damaged(
            name,
            format!(
                "{} bytes cannot hold its {scanlines} scanlines of {length} texels",
                body.len()
            ),
        ));
    }
    check_size(name, width as u64, height as u64)?;
    let mut values = vec![0.0; width * height];
    let head = format!("#?RADIANCE\n\n-Y 1 +X {length}\n");
    let mut scanline = Vec::new();
    for i in 0..scanlines {
        let failed =
            |reason: String| damaged(name, format!("scanline {i} of {scanlines}: {reason}"));
        if let [2, 2, high @ 0..=127, low, ..] = *body
            && COMPRESSED_WIDTHS.contains(&length)
            && usize::from(high) * 256 + usize::from(low) != length
        {
            let got = usize::from(high) * 256 + usize::from(low);
            return Err(failed(format!("it has {got} texels, but its header states {length}")));
        }
        decode(&head, &mut body, &mut scanline).map_err(failed)?;
        let (texels, _) = scanline.as_chunks::<4>();
        let (texels, _) = texels.as_chunks::<3>();
        for (j, texel) in texels.iter().enumerate() {
            let terms = texel.iter().zip(weights).zip(header.divisors);
            let value = terms
                .filter(|((_, weight), _)| *weight != 0.0)
                .map(|((&c, weight), divisor)| {
                    weight * (f64::from(f32::from_ne_bytes(c)) / divisor)
                })
                .sum();
            let (x, y) = header.resolution.place(i, j);
            values[y * width + x] = value;
        }
    }
    Ok(ChannelImage { width, height, values, remarks: header.remarks })
}

/// Decodes the next scanline to f32 numbers in native byte order.
fn decode(head: &str, body: &mut &[u8], scanline: &mut Vec<u8>) -> Result<(), String> {
    let said = |error: image::ImageError| match error {
        image::ImageError::IoError(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => {
            "the file ends within it".to_owned()
        }
        error => error.to_string(),
    };
    let decoder = HdrDecoder::new(head.as_bytes().chain(body)).map_err(said)?;
    let length = usize::try_from(decoder.total_bytes()).map_err(|error| error.to_string())?;
    scanline.resize(length, 0);
    decoder.read_image(scanline).map_err(said)
}

impl Header {
    /// Reads the header; returns it with the bytes that follow.
    fn read<'a>(name: &str, bytes: &'a [u8]) -> Result<(Self, &'a [u8]), FileError> {
        let mut header = Self {
            format: Format::Rgbe,
            divisors: [1.0; 3],
            resolution: Resolution {
                axes: [Axis { is_x: false, is_reversed: false }; 2],
                lengths: [0; 2],
            },
            remarks: Vec::new(),
        };
        let mut rest = bytes;
        let mut line_number = 1;
        let mut next_line = || {
            let end = rest.iter().take(MAX_HEADER).position(|&byte| byte == b'\n')?;
            let line = String::from_utf8_lossy(&rest[..end]).trim().to_owned();
            rest = &rest[end + 1..];
            line_number += 1;
            Some((line, line_number - 1))
        };
        let ended = || damaged(name, "the header does not end with an empty line");
        loop {
            let (line, number) = next_line().ok_or_else(ended)?;
            if line.is_empty() {
                break;
            }
            let wrong = |expected: &str| FileError::Layout {
                path: name.to_owned(),
                place: Place::Line(number),
                expected: expected.to_owned(),
                got: format!("\"{}\"", line.chars().take(80).collect::<String>().escape_debug()),
            };
            let Some((key, value)) = line.split_once('=').filter(|_| !line.starts_with('#')) else {
                continue;
            };
            match key.trim() {
                "EXPOSURE" => {
                    let number = numbers::<1>(value).ok_or_else(|| wrong("EXPOSURE=NUMBER"))?;
                    header.divide([number[0]; 3], &line);
                }
                "COLORCORR" => {
                    let colours =
                        numbers::<3>(value).ok_or_else(|| wrong("COLORCORR=RED GREEN BLUE"))?;
                    header.divide(colours, &line);
                }
                "FORMAT" => {
                    header.format = match value.trim() {
                        "32-bit_rle_rgbe" => Format::Rgbe,
                        "32-bit_rle_xyze" => Format::Xyze,
                        _ => return Err(wrong("FORMAT=32-bit_rle_rgbe or 32-bit_rle_xyze")),
                    };
                }
                _ => {}
            }
        }
        let (line, number) = next_line().ok_or_else(ended)?;
        header.resolution = Resolution::parse(&line).ok_or_else(|| FileError::Layout {
            path: name.to_owned(),
            place: Place::Line(number),
            expected: "a resolution such as \"-Y 512 +X 1024\"".to_owned(),
            got: format!("\"{}\"", line.chars().take(80).collect::<String>().escape_debug()),
        })?;
        Ok((header, rest))
    }

    /// Multiplies the divisors by those of a line; factors of several lines accumulate.
    fn divide(&mut self, divisors: [f64; 3], line: &str) {
        let product = [0, 1, 2].map(|c| self.divisors[c] * divisors[c]);
        if divisors.iter().all(|d| *d > 0.0) && product.iter().all(|p| p.is_normal()) {
            self.divisors = product;
        } else {
            self.remarks.push(format!("{line} is ignored: it is not a number above 0"));
        }
    }
}

/// Returns the numbers of a text separated by spaces, or `None` if there are not exactly `N`.
fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let numbers: Option<Vec<f64>> = text.split_whitespace().map(|n| n.parse().ok()).collect();
    numbers?.try_into().ok()
}

impl Resolution {
    fn parse(line: &str) -> Option<Self> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let &[first, first_length, second, second_length] = words.as_slice() else { return None };
        let axes = [Axis::parse(first)?, Axis::parse(second)?];
        let length = |text: &str| text.parse::<u32>().ok().and_then(|n| usize::try_from(n).ok());
        let lengths = [length(first_length)?, length(second_length)?];
        (axes[0].is_x != axes[1].is_x).then_some(Self { axes, lengths })
    }

    /// Returns column and row of a texel from its scanline and its index within it.
    fn place(&self, scanline: usize, texel: usize) -> (usize, usize) {
        let places = [scanline, texel];
        let along = |axis: usize| match self.axes[axis].is_reversed {
            false => places[axis],
            true => self.lengths[axis] - 1 - places[axis],
        };
        if self.axes[0].is_x { (along(0), along(1)) } else { (along(1), along(0)) }
    }
}

impl Axis {
    /// Y points upwards, so `-Y` runs down the picture.
    fn parse(text: &str) -> Option<Self> {
        let (is_x, is_reversed) = match text {
            "+X" => (true, false),
            "-X" => (true, true),
            "-Y" => (false, false),
            "+Y" => (false, true),
            _ => return None,
        };
        Some(Self { is_x, is_reversed })
    }
}
