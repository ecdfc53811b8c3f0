//! Small valid files of the binary formats, uncompressed, so that changed bytes reach the readers.

use std::io::{Cursor, Write};

use exr::prelude::{Encoding, Image, SpecificChannels, WritableImage};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// Bytes of a FITS card and of a block.
const CARD: usize = 80;
const BLOCK: usize = 2880;

/// A header and data unit, as cards and bytes.
type Unit<'a> = (&'a [&'a str], Vec<u8>);

/// Returns a FITS file; a card ends with its value.
fn fits(units: &[Unit<'_>]) -> Vec<u8> {
    let mut file = Vec::new();
    for (cards, data) in units {
        for card in cards.iter().chain(&["END"]) {
            let (keyword, value) = card.split_once(' ').unwrap_or((card, ""));
            let equals = if value.is_empty() { "" } else { "= " };
            file.extend(format!("{:<CARD$}", format!("{keyword:<8}{equals}{value}")).bytes());
        }
        file.resize(file.len().next_multiple_of(BLOCK), b' ');
        file.extend(data);
        file.resize(file.len().next_multiple_of(BLOCK), 0);
    }
    file
}

const PRIMARY: Unit<'_> = (&["SIMPLE T", "BITPIX 8", "NAXIS 0", "EXTEND T"], Vec::new());

/// Returns numbers, big-endian.
fn doubles(numbers: impl IntoIterator<Item = f64>) -> Vec<u8> {
    numbers.into_iter().flat_map(f64::to_be_bytes).collect()
}

/// Returns tables of points of each kind of column.
pub(super) fn point_tables() -> Vec<Vec<u8>> {
    let angles = doubles([10.0, -45.0, 1.0, 359.5, 89.0, 0.5, 180.0, 0.0, 2.0]);
    let plain = fits(&[
        PRIMARY,
        (
            &[
                "XTENSION 'BINTABLE'",
                "BITPIX 8",
                "NAXIS 2",
                "NAXIS1 24",
                "NAXIS2 3",
                "PCOUNT 0",
                "GCOUNT 1",
                "TFIELDS 3",
                "TTYPE1 'RAJ2000 '",
                "TFORM1 'D       '",
                "TUNIT1 'deg     '",
                "TTYPE2 'DEJ2000 '",
                "TFORM2 '1D'",
                "TUNIT2 'degrees'",
                "TTYPE3 'WEIGHT'",
                "TFORM3 'D'",
                "EXTNAME 'CATALOG'",
            ],
            angles,
        ),
    ]);
    // Scaled integers of each size with a null, floats, bits, logicals, texts and a list of any
    // length.
    let rows = [[0x10, 0x20, 0x7f], [0x30, 0x01, 0x02], [0x55, 0xf0, 0x03]];
    let row = |bytes: [u8; 3]| -> Vec<u8> {
        let [a, b, c] = bytes;
        let list = [0, 0, 0, 1, 0, 0, 0, c % 4];
        let numbers = [a, b, b >> 3, c, 0, a, 9, c, c & 0x7f, 0xa0, b'T', b'x', b'y'];
        [&numbers[..], &list].concat()
    };
    let scaled = fits(&[
        PRIMARY,
        (
            &[
                "XTENSION 'BINTABLE'",
                "BITPIX 8",
                "NAXIS 2",
                "NAXIS1 21",
                "NAXIS2 3",
                "PCOUNT 4",
                "GCOUNT 1",
                "TFIELDS 8",
                "TTYPE1 'lon     '",
                "TFORM1 'I       '",
                "TSCAL1 0.01",
                "TZERO1 -10.5",
                "TNULL1 -7",
                "TTYPE2 'lat     '",
                "TFORM2 'B       '",
                "TZERO2 1.0",
                "TTYPE3 'w       '",
                "TFORM3 'J       '",
                "TZERO3 2147483648",
                "TTYPE4 'set     '",
                "TFORM4 'I       '",
                "TTYPE5 'FLAGS'",
                "TFORM5 '3X'",
                "TTYPE6 'GOOD'",
                "TFORM6 'L'",
                "TTYPE7 'NAME'",
                "TFORM7 '2A'",
                "TTYPE8 'LIST'",
                "TFORM8 'PB(4)'",
                "THEAP 63",
                "COMMENT rows, then a heap",
            ],
            rows.map(row).concat().into_iter().chain([1, 2, 3, 4]).collect(),
        ),
    ]);
    let text = fits(&[
        PRIMARY,
        (
            &["XTENSION 'IMAGE   '", "BITPIX 16", "NAXIS 1", "NAXIS1 4", "PCOUNT 0", "GCOUNT 1"],
            vec![7; 8],
        ),
        (
            &[
                "XTENSION 'TABLE   '",
                "BITPIX 8",
                "NAXIS 2",
                "NAXIS1 22",
                "NAXIS2 2",
                "PCOUNT 0",
                "GCOUNT 1",
                "TFIELDS 3",
                "TTYPE1 'x'",
                "TBCOL1 1",
                "TFORM1 'F8.4'",
                "TTYPE2 'y'",
                "TBCOL2 9",
                "TFORM2 'E8.2'",
                "TTYPE3 'z'",
                "TBCOL3 18",
                "TFORM3 'I5'",
                "TNULL3 '-'",
            ],
            b"  0.6000  8.0E-1     0  1.0D+0     0.0     0".to_vec(),
        ),
    ]);
    vec![plain, scaled, text]
}

/// Returns maps in tables and images, of the smallest nside.
pub(super) fn maps() -> Vec<Vec<u8>> {
    let values = || doubles((0..12).map(f64::from));
    let column = fits(&[
        PRIMARY,
        (
            &[
                "XTENSION 'BINTABLE'",
                "BITPIX 8",
                "NAXIS 2",
                "NAXIS1 32",
                "NAXIS2 3",
                "PCOUNT 0",
                "GCOUNT 1",
                "TFIELDS 1",
                "TTYPE1 'T'",
                "TFORM1 '4D'",
                "PIXTYPE 'HEALPIX '",
                "ORDERING 'NESTED  '",
                "NSIDE 1",
                "INDXSCHM 'IMPLICIT'",
                "FIRSTPIX 0",
                "LASTPIX 11",
                "COORDSYS 'G'",
                "BAD_DATA -1.6375E30",
            ],
            values(),
        ),
    ]);
    let explicit: Vec<u8> =
        [3, 1, 11].iter().flat_map(|&pixel| [0, pixel, pixel + 40, 9]).collect();
    let part = fits(&[
        PRIMARY,
        (
            &[
                "XTENSION 'BINTABLE'",
                "BITPIX 8",
                "NAXIS 2",
                "NAXIS1 4",
                "NAXIS2 3",
                "PCOUNT 0",
                "GCOUNT 1",
                "TFIELDS 3",
                "TTYPE1 'PIXEL'",
                "TFORM1 'I'",
                "TTYPE2 'N'",
                "TFORM2 'B'",
                "TNULL2 0",
                "TTYPE3 'M'",
                "TFORM3 '8X'",
                "ORDERING 'RING'",
                "NSIDE 1",
                "INDXSCHM 'EXPLICIT'",
            ],
            explicit,
        ),
    ]);
    let image = fits(&[(
        &[
            "SIMPLE T",
            "BITPIX -64",
            "NAXIS 2",
            "NAXIS1 3",
            "NAXIS2 4",
            "NSIDE 1",
            "ORDERING 'RING'",
            "PIXTYPE 'HEALPIX'",
            "BSCALE 2.0",
            "BZERO -1.0",
        ],
        values(),
    )]);
    vec![column, part, image]
}

/// Returns uncompressed archives of points of every layout; `array` has the shape (3, 3).
pub(super) fn archives(array: &[u8]) -> Vec<Vec<u8>> {
    // Its header with another shape, of nine numbers and of the same length.
    let at = |text: &[u8]| array.windows(text.len()).position(|word| word == text);
    let flat = at(b"(3, 3, )").zip(at(b"\n")).map(|(shape, end)| {
        [&array[..shape], b"(9, )", &array[shape + 8..end], b"   ", &array[end..]].concat()
    });
    let flat = flat.unwrap_or_default();
    let stored = |members: &[(&str, &[u8])]| {
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
        let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
        for (name, bytes) in members {
            archive.start_file(format!("{name}.npy"), options).ok()?;
            archive.write_all(bytes).ok()?;
        }
        archive.finish().ok().map(Cursor::into_inner)
    };
    let archives = [
        stored(&[("points", array)]),
        stored(&[("lon", &flat), ("lat", &flat), ("w", &flat)]),
        stored(&[("arr_0", array), ("meta", b"no array")]),
    ];
    archives.into_iter().flatten().collect()
}

/// Corrects the checksums of an archive, because otherwise no code after their check would be
/// reached.
pub(super) fn with_checksums(mut archive: Vec<u8>) -> Vec<u8> {
    let number = |bytes: &[u8], at: usize, width: usize| -> Option<usize> {
        Some(bytes.get(at..at + width)?.iter().rev().fold(0, |sum, &b| (sum << 8) | usize::from(b)))
    };
    let entries: Vec<usize> = (0..archive.len().saturating_sub(4))
        .filter(|&at| archive[at..].starts_with(b"PK\x01\x02"))
        .collect();
    for entry in entries {
        let data = || {
            let local = number(&archive, entry + 42, 4)?;
            let start =
                local + 30 + number(&archive, local + 26, 2)? + number(&archive, local + 28, 2)?;
            let end = start.checked_add(number(&archive, entry + 20, 4)?)?;
            let is_stored = number(&archive, entry + 10, 2)? == 0;
            archive
                .get(start..end)
                .filter(|_| is_stored)
                .map(|bytes| (local, crc32fast::hash(bytes)))
        };
        let Some((local, checksum)) = data() else { continue };
        for place in [entry + 16, local + 14] {
            if let Some(field) = archive.get_mut(place..place + 4) {
                field.copy_from_slice(&checksum.to_le_bytes());
            }
        }
    }
    archive
}

/// Returns pictures of small numbers, in single and half precision.
pub(super) fn exr_pictures() -> Vec<Vec<u8>> {
    let bytes = |encoding| {
        let channels = SpecificChannels::rgb(|at: exr::math::Vec2<usize>| {
            #[expect(clippy::cast_precision_loss, reason = "below 32")]
            let grey = (at.x() + 8 * at.y()) as f32;
            (grey, 0.5_f32, exr::prelude::f16::from_f32(grey))
        });
        let mut file = Cursor::new(Vec::new());
        let image = Image::from_encoded_channels((8, 4), encoding, channels);
        image.write().to_buffered(&mut file).ok().map(|()| file.into_inner())
    };
    [bytes(Encoding::UNCOMPRESSED), bytes(Encoding::FAST_LOSSLESS)].into_iter().flatten().collect()
}

/// Returns Radiance pictures without and with both compressions.
pub(super) fn radiance_pictures() -> Vec<Vec<u8>> {
    let head = |format: &str, size: &str| {
        format!("#?RADIANCE\n# a comment\nFORMAT={format}\nEXPOSURE=2.0\n\n{size}\n").into_bytes()
    };
    let texels: Vec<u8> = (10..34).flat_map(|c| [c, c + 1, c + 2, 130]).collect();
    let runs = [
        2, 2, 0, 8, 136, 20, 136, 30, 4, 1, 2, 3, 4, 132, 5, 136, 136, 50, 51, 52, 136, 1, 1, 1, 7,
    ];
    vec![
        [head("32-bit_rle_rgbe", "-Y 4 +X 6"), texels.clone()].concat(),
        [head("32-bit_rle_xyze", "+X 3 -Y 8"), texels].concat(),
        [head("32-bit_rle_rgbe", "-Y 2 +X 8"), runs.to_vec()].concat(),
    ]
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use zip::ZipArchive;

    use super::{archives, with_checksums};
    use crate::fuzzing::TARGETS;

    /// Otherwise their mutations would be rejected for the defect of the seed.
    #[test]
    fn seeds_of_binary_formats_are_accepted() {
        let folder = tempfile::tempdir().unwrap();
        for target in TARGETS.iter().filter(|target| !target.is_text) {
            let scratch = folder.path().join(format!("{}.{}", target.name, target.extension));
            for (i, seed) in target.seeds(&scratch).iter().enumerate() {
                let read = (target.read)(seed, &scratch);
                assert!(read.is_ok(), "{} {i}: {read:?}", target.name);
                assert!(seed.len() <= 1 << 14, "{} {i}: {} bytes", target.name, seed.len());
            }
        }
    }

    #[test]
    fn checksums_follow_the_members() {
        let array = b"\x93NUMPY\x01\0 (3, 3, )\nabc".to_vec();
        for archive in archives(&array) {
            assert_eq!(with_checksums(archive.clone()), archive);
            let mut changed = archive.clone();
            let at = changed.windows(3).position(|word| word == b"abc").unwrap();
            changed[at] = b'x';
            let member = |bytes: &[u8]| {
                let mut archive = ZipArchive::new(std::io::Cursor::new(bytes.to_vec())).unwrap();
                let mut text = Vec::new();
                let read = archive.by_index(0).unwrap().read_to_end(&mut text);
                read.map(|_| text)
            };
            assert!(member(&changed).is_err());
            assert!(member(&with_checksums(changed)).unwrap().ends_with(b"xbc"));
        }
    }
}
