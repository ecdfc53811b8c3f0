//! Changes that keep the layout of a binary format: blocks, sizes and offsets stay, so that inputs reach what lies
//! behind the checks of them.

use std::ops::Range;

use crate::mutation::{FIELDS, Random};

/// Bytes of a FITS card and of a block.
const CARD: usize = 80;
const BLOCK: usize = 2880;
/// Longest piece that is written over at once.
const MAX_PIECE: usize = 8;

/// The parts of a format that can be changed without changing its layout.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Layout {
    /// Cards of headers, and data.
    Fits,
    /// Bytes of a range that a function finds.
    Payload(fn(&[u8]) -> Option<Range<usize>>),
    /// The same of whole numbers of seven bits a byte, whose eighth bit states whether the number continues.
    Varints(fn(&[u8]) -> Option<Range<usize>>),
}

impl Layout {
    /// Returns the layout of the format with an extension; `None` for texts and unknown ones.
    pub(crate) fn of_extension(extension: &str) -> Option<Self> {
        match extension {
            "fits" => Some(Self::Fits),
            "npy" => Some(Self::Payload(npy)),
            "npz" => Some(Self::Payload(npz)),
            "ply" => Some(Self::Payload(ply)),
            "exr" => Some(Self::Payload(exr)),
            "hdr" => Some(Self::Payload(radiance)),
            "shard" => Some(Self::Varints(shard)),
            _ => None,
        }
    }

    /// Changes an input; `change` is any change of a few bytes. The length stays.
    pub(crate) fn change(
        self,
        input: &mut [u8],
        random: &mut Random,
        change: impl FnOnce(&mut Vec<u8>, &mut Random),
    ) {
        match self {
            Self::Payload(find) => {
                if let Some(payload) = find(input).and_then(|range| input.get_mut(range)) {
                    overwrite(payload, random);
                }
            }
            Self::Varints(find) => {
                if let Some(payload) = find(input).and_then(|range| input.get_mut(range)) {
                    let before = payload.to_vec();
                    overwrite(payload, random);
                    for (byte, before) in payload.iter_mut().zip(before) {
                        *byte = *byte & 0x7f | before & 0x80;
                    }
                }
            }
            Self::Fits => {
                let (headers, data) = fits_units(input);
                if random.below(2) == 0
                    && let Some(range) = random.choose(&data)
                {
                    overwrite(&mut input[range.clone()], random);
                } else if let Some(range) = random.choose(&headers) {
                    change_card(&mut input[range.clone()], random, change);
                }
            }
        }
    }
}

/// Writes over some bytes: with random ones, a number at a limit, bytes from elsewhere, or the next number.
fn overwrite(bytes: &mut [u8], random: &mut Random) {
    if bytes.is_empty() {
        return;
    }
    let at = random.below(bytes.len());
    let width = (1 + random.below(MAX_PIECE)).min(bytes.len() - at);
    match random.below(5) {
        0 => bytes[at] ^= 1 << random.below(8),
        1 => bytes[at..at + width].fill_with(|| random.byte()),
        2 => {
            let field = FIELDS[random.below(FIELDS.len())].to_le_bytes();
            bytes[at..at + width].copy_from_slice(&field[..width]);
            if random.below(2) == 0 {
                bytes[at..at + width].reverse();
            }
        }
        3 => {
            // Numbers of a type are often at multiples of its size.
            let from = random.below(bytes.len() - width + 1) / width * width;
            let to = at / width * width;
            bytes.copy_within(from..from + width, to);
        }
        _ => bytes[at] = bytes[at].wrapping_add(1),
    }
}

/// Changes the text of a card, or exchanges two, or has one twice in place of a blank one.
fn change_card(
    header: &mut [u8],
    random: &mut Random,
    change: impl FnOnce(&mut Vec<u8>, &mut Random),
) {
    let is_blank = |card: &[u8]| card.iter().all(|&b| b == b' ');
    let cards = header.chunks(CARD).filter(|card| !is_blank(card)).count();
    // The first card and END stay, or there would be no header.
    let inner = cards.saturating_sub(2);
    if inner == 0 {
        return;
    }
    let place = |card: usize| (1 + card) * CARD..(2 + card) * CARD;
    let card = place(random.below(inner));
    match random.below(8) {
        0 => {
            let other = place(random.below(inner));
            let copy = header[card.clone()].to_vec();
            header.copy_within(other.clone(), card.start);
            header[other].copy_from_slice(&copy);
        }
        1 if header.len() >= (cards + 1) * CARD => {
            // Behind what was there, where the last one counts.
            let end = place(inner);
            header.copy_within(end.clone(), end.end);
            header.copy_within(card, end.start);
        }
        _ => {
            let text = header[card.clone()].trim_ascii_end();
            let mut text = text.to_vec();
            change(&mut text, random);
            text.retain(|b| (b' '..=b'~').contains(b));
            text.resize(CARD, b' ');
            header[card].copy_from_slice(&text);
        }
    }
}

/// Returns the positions of the headers and the data of a FITS file.
fn fits_units(file: &[u8]) -> (Vec<Range<usize>>, Vec<Range<usize>>) {
    let (mut headers, mut data): (Vec<Range<usize>>, Vec<Range<usize>>) = (Vec::new(), Vec::new());
    let mut is_header = false;
    for start in (0..file.len()).step_by(BLOCK) {
        let range = start..(start + BLOCK).min(file.len());
        let block = &file[range.clone()];
        let begins = block.starts_with(b"SIMPLE  =") || block.starts_with(b"XTENSION=");
        let units = if begins || is_header { &mut headers } else { &mut data };
        match units.last_mut() {
            Some(last) if last.end == start && !begins => last.end = range.end,
            _ => units.push(range),
        }
        let ends = block.chunks(CARD).any(|card| card.starts_with(b"END     "));
        is_header = (begins || is_header) && !ends;
    }
    (headers, data)
}

/// The place behind the first occurrence of a mark.
fn behind(file: &[u8], mark: &[u8]) -> Option<usize> {
    file.windows(mark.len()).position(|piece| piece == mark).map(|at| at + mark.len())
}

/// The items of an array, behind a header whose length is at byte 8.
fn npy(file: &[u8]) -> Option<Range<usize>> {
    let length = file.get(8..10)?;
    Some(10 + usize::from(length[0]) + 256 * usize::from(length[1])..file.len())
}

/// The items of one of the arrays of an archive, or its compressed bytes.
fn npz(file: &[u8]) -> Option<Range<usize>> {
    let start = behind(file, b"\n").or_else(|| behind(file, b".npy"))?;
    let end = file.windows(4).position(|piece| piece == b"PK\x01\x02")?;
    (start < end).then_some(start..end)
}

fn ply(file: &[u8]) -> Option<Range<usize>> {
    Some(behind(file, b"end_header\n")?..file.len())
}

/// From the first chunk on, to which the first entry of the table of offsets leads.
fn exr(file: &[u8]) -> Option<Range<usize>> {
    let entry = |at: usize| {
        let bytes = file.get(at..at + 8)?.first_chunk::<8>()?;
        usize::try_from(u64::from_le_bytes(*bytes)).ok()
    };
    let leads_behind = |at: usize| {
        let start = entry(at)?;
        let is_table = start > at && start < file.len() && (start - at).is_multiple_of(8);
        // Behind the place and the size of the first chunk.
        is_table.then_some((start + 8).min(file.len())..file.len())
    };
    (8..file.len()).find_map(leads_behind)
}

fn radiance(file: &[u8]) -> Option<Range<usize>> {
    let resolution = behind(file, b"\n\n")?;
    let line = behind(&file[resolution..], b"\n")?;
    Some(resolution + line..file.len())
}

/// The results, behind the texts of the question.
fn shard(file: &[u8]) -> Option<Range<usize>> {
    Some(file.len() / 2..file.len())
}
