//! Reads `OpenEXR` files block by block, keeping only the requested channel.

use std::collections::HashSet;
use std::io::Cursor;

use exr::block::chunk::Chunk;
use exr::block::{self, UncompressedBlock};
use exr::math::Vec2;
use exr::meta::BlockDescription;
use exr::meta::attribute::SampleType;
use exr::meta::header::Header;
use exr::prelude::f16;
use rayon::prelude::*;

use super::exr_channels::{Chosen, choose};
use super::{ChannelChoice, ChannelImage, check_size, damaged};
use crate::files::file_error::FileError;

/// The first bytes of an `OpenEXR` file.
pub(super) const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
/// The maximum number of bytes of texels per byte of a file. Zip reaches 1032, for black pictures;
/// DWA applies it after run-length coding of blocks of 64 coefficients.
const MAX_COMPRESSION: f64 = 65536.0;
/// The maximum number of bytes of a tile, so that the library's integers do not overflow.
const MAX_TILE: f64 = 1e15;
/// The number of blocks that are decompressed in parallel.
const BATCH: usize = 16;

/// Reads one channel of the largest level, placed in the display window: texels outside of the data
/// window are 0.
pub(super) fn read(
    name: &str,
    bytes: &[u8],
    choice: &ChannelChoice,
) -> Result<ChannelImage, FileError> {
    let failed = |error: exr::error::Error| damaged(name, error);
    check_attributes(name, bytes)?;
    let reader = block::read(Cursor::new(bytes), false).map_err(failed)?;
    let meta = reader.meta_data().clone();
    let chosen = choose(name, &meta.headers, choice)?;
    let header = &meta.headers[chosen.part];
    meta.headers.iter().try_for_each(|header| check_blocks(name, bytes.len(), header))?;
    let window = header.shared_attributes.display_window;
    check_size(name, window.size.width() as u64, window.size.height() as u64)?;
    let mut frame = Frame {
        width: window.size.width(),
        height: window.size.height(),
        left: i64::from(header.own_attributes.layer_position.x()) - i64::from(window.position.x()),
        top: i64::from(header.own_attributes.layer_position.y()) - i64::from(window.position.y()),
        values: vec![0.0; window.size.area()],
    };

    let mut chunks = reader
        .filter_chunks(false, |_, tile, block| {
            block.layer == chosen.part && tile.is_largest_resolution_level()
        })
        .map_err(failed)?;
    let mut seen = HashSet::new();
    let mut area = 0;
    loop {
        let batch: Result<Vec<Chunk>, _> = chunks.by_ref().take(BATCH).collect();
        let batch = batch.map_err(failed)?;
        if batch.is_empty() {
            break;
        }
        let blocks: Result<Vec<_>, _> = batch
            .into_par_iter()
            .map(|chunk| UncompressedBlock::decompress_chunk(chunk, &meta, false))
            .collect();
        for block in blocks.map_err(failed)? {
            let (position, size) = (block.index.pixel_position, block.index.pixel_size);
            let is_wanted = block.index.layer == chosen.part && block.index.level == Vec2(0, 0);
            if !is_wanted || !seen.insert((position.x(), position.y())) {
                return Err(damaged(name, "a block occurs twice or at a wrong position"));
            }
            area += size.area();
            frame
                .add(header, &chosen, &block)
                .ok_or_else(|| damaged(name, "a block has another size than it should"))?;
        }
    }
    if area != header.layer_size.area() {
        return Err(damaged(name, "blocks of texels are missing"));
    }
    let remarks = frame.uncovered(header.layer_size).into_iter().collect();
    let Frame { width, height, values, .. } = frame;
    Ok(ChannelImage { width, height, values, remarks })
}

/// The display window.
struct Frame {
    width: usize,
    height: usize,
    /// The position of the data window in it.
    left: i64,
    top: i64,
    values: Vec<f64>,
}

impl Frame {
    /// Returns a remark if a data window of this size leaves some texels without values.
    fn uncovered(&self, data: Vec2<usize>) -> Option<String> {
        let common = |start: i64, length: usize, size: usize| {
            let end = i64::try_from(length).map_or(i64::MAX, |length| start.saturating_add(length));
            let end = usize::try_from(end).map_or(0, |end| end.min(size));
            end.saturating_sub(usize::try_from(start).unwrap_or(0))
        };
        let covered = common(self.left, data.width(), self.width)
            * common(self.top, data.height(), self.height);
        let total = self.values.len();
        let remark =
            "texels of the display window are outside of the data window and are read as 0";
        (covered < total).then(|| format!("{} of {total} {remark}", total - covered))
    }

    /// Copies the texels of a block into the window; `None` if its number of bytes disagrees with
    /// its size.
    fn add(&mut self, header: &Header, chosen: &Chosen, block: &UncompressedBlock) -> Option<()> {
        let channels = &header.channels.list;
        let width = block.index.pixel_size.width();
        let row_bytes = width * header.channels.bytes_per_pixel;
        if block.data.len() != row_bytes * block.index.pixel_size.height() {
            return None;
        }
        let left = self.left + i64::try_from(block.index.pixel_position.x()).ok()?;
        let top = self.top + i64::try_from(block.index.pixel_position.y()).ok()?;
        // A row has all samples of the first channel, then those of the second.
        let offset = |channel: usize| -> usize {
            channels[..channel].iter().map(|c| c.sample_type.bytes_per_sample() * width).sum()
        };
        for (y, row) in block.data.chunks_exact(row_bytes.max(1)).enumerate() {
            let target = top + i64::try_from(y).ok()?;
            let Some(target) = usize::try_from(target).ok().filter(|y| *y < self.height) else {
                continue;
            };
            let target = &mut self.values[target * self.width..(target + 1) * self.width];
            for &(channel, weight) in &chosen.terms {
                let bytes = &row[offset(channel)..];
                let columns = (left..).map(|x| usize::try_from(x).ok());
                let cells = columns.zip(samples(channels[channel].sample_type, bytes, width));
                for (column, sample) in cells {
                    if let Some(value) = column.and_then(|column| target.get_mut(column)) {
                        *value += weight * sample;
                    }
                }
            }
        }
        Some(())
    }
}

/// Returns the samples at the start of some bytes, in the byte order of the machine.
fn samples(kind: SampleType, bytes: &[u8], count: usize) -> Box<dyn Iterator<Item = f64> + '_> {
    match kind {
        SampleType::F16 => {
            let (items, _) = bytes.as_chunks::<2>();
            Box::new(items.iter().take(count).map(|&item| f16::from_ne_bytes(item).into()))
        }
        SampleType::F32 => {
            let (items, _) = bytes.as_chunks::<4>();
            Box::new(items.iter().take(count).map(|&item| f32::from_ne_bytes(item).into()))
        }
        SampleType::U32 => {
            let (items, _) = bytes.as_chunks::<4>();
            Box::new(items.iter().take(count).map(|&item| u32::from_ne_bytes(item).into()))
        }
    }
}

/// Returns an error for sizes that exceed the file or the memory, because a header may contain any
/// numbers.
fn check_blocks(name: &str, file_bytes: usize, header: &Header) -> Result<(), FileError> {
    let size = header.layer_size;
    let window = header.shared_attributes.display_window.size;
    let texel = header.channels.bytes_per_pixel as f64;
    let area = |size: Vec2<usize>| size.width() as f64 * size.height() as f64;
    // Each chunk has an entry of 8 bytes in a table.
    let table = 8.0 * header.chunk_count as f64;
    let max_bytes = MAX_COMPRESSION * file_bytes as f64;
    if texel * area(size) > max_bytes || area(window) > max_bytes || table > file_bytes as f64 {
        let (width, height) = (size.width(), size.height());
        return Err(damaged(
            name,
            format!(
                "a file of {file_bytes} bytes cannot hold its data window of {width} x {height} texels \
                 or its display window of {} x {}",
                window.width(),
                window.height(),
            ),
        ));
    }
    match header.blocks {
        BlockDescription::Tiles(tiles) if texel * area(tiles.tile_size) > MAX_TILE => {
            Err(damaged(name, "its tiles are larger than any memory"))
        }
        _ => Ok(()),
    }
}

/// Returns an error for windows with a minimum above their maximum, which the library would swap,
/// and for channels with fewer samples than texels, which it does not support.
///
/// The library rejects other malformed attributes.
fn check_attributes(name: &str, bytes: &[u8]) -> Result<(), FileError> {
    let mut rest = bytes.get(8..).unwrap_or_default();
    while let Some(attribute) = Attribute::take(&mut rest) {
        let (attribute_name, value) = (attribute.name, attribute.value);
        let is_window = matches!(attribute_name, b"dataWindow" | b"displayWindow");
        if attribute_name == b"channels" {
            let channels = subsampled(value);
            if !channels.is_empty() {
                return Err(damaged(
                    name,
                    format!(
                        "its channels {} have fewer samples than texels, as in luminance-chroma pictures, which are \
                         not supported; convert it to channels R, G and B of all texels",
                        channels.join(", ")
                    ),
                ));
            }
        }
        let (corners, _) = value.as_chunks::<4>();
        if let (true, &[x, y, x_end, y_end]) = (is_window, corners) {
            let [x, y, x_end, y_end] = [x, y, x_end, y_end].map(i32::from_le_bytes);
            if x > x_end || y > y_end {
                return Err(damaged(
                    name,
                    format!(
                        "its {} goes from ({x}, {y}) to ({x_end}, {y_end}); the minimum must not exceed the maximum",
                        String::from_utf8_lossy(attribute_name)
                    ),
                ));
            }
        }
    }
    Ok(())
}

/// Returns the names of the channels of a list, starting with the first one, that are subsampled.
fn subsampled(mut list: &[u8]) -> Vec<String> {
    let mut found = Vec::new();
    while let Some(name) = text(&mut list).filter(|name| !name.is_empty() && found.len() < 4) {
        // The type, four bytes of flags, and the sampling steps in x and y.
        let Some((numbers, rest)) = list.split_at_checked(16) else { break };
        if numbers[8..] != [1, 0, 0, 0, 1, 0, 0, 0] {
            found.push(String::from_utf8_lossy(name).escape_debug().to_string());
        }
        list = rest;
    }
    found
}

/// An attribute of a header.
struct Attribute<'a> {
    name: &'a [u8],
    value: &'a [u8],
}

impl<'a> Attribute<'a> {
    /// Returns the next attribute; an empty name ends the header of a part, two of them the last
    /// one.
    fn take(rest: &mut &'a [u8]) -> Option<Self> {
        let mut name = text(rest)?;
        if name.is_empty() {
            name = text(rest)?;
        }
        let _type = text(rest).filter(|_| !name.is_empty())?;
        let (size, after) = rest.split_first_chunk::<4>()?;
        let (value, after) = after.split_at_checked(u32::from_le_bytes(*size) as usize)?;
        *rest = after;
        Some(Self { name, value })
    }
}

/// Returns the bytes up to a zero.
fn text<'a>(rest: &mut &'a [u8]) -> Option<&'a [u8]> {
    let end = rest.iter().position(|&byte| byte == 0)?;
    let text = &rest[..end];
    *rest = &rest[end + 1..];
    Some(text)
}
