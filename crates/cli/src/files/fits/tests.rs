use std::path::Path;

use super::Reader;

/// Maps that healpy 1.20.1 wrote; `benches/peers/healpix_maps.py`.
const RING: &[u8] = include_bytes!("../../../tests/data/ring.fits");
const NESTED: &[u8] = include_bytes!("../../../tests/data/nested.fits");
const TWO_FIELDS: &[u8] = include_bytes!("../../../tests/data/two_fields.fits");
const PARTIAL: &[u8] = include_bytes!("../../../tests/data/partial.fits");
const SMOOTH: &[u8] = include_bytes!("../../../tests/data/smooth.fits");

fn read(bytes: &[u8], field: usize) -> Result<super::FitsMap, String> {
    Reader { path: Path::new("m.fits"), bytes }.read(field).map_err(|e| e.to_string())
}

/// The file with the first card of a name replaced; 80 characters to a card.
fn with_card(bytes: &[u8], name: &str, card: &str) -> Vec<u8> {
    let mut copy = bytes.to_vec();
    let keyword = format!("{name:<8}");
    // The primary header takes the first block.
    let at = (2880..copy.len()).step_by(80).find(|&i| copy[i..].starts_with(keyword.as_bytes()));
    let at = at.unwrap_or_else(|| panic!("no card {name}"));
    copy[at..at + 80].copy_from_slice(format!("{card:<80}").as_bytes());
    copy
}

#[test]
#[expect(clippy::float_cmp, reason = "small integers, exact in both widths")]
fn maps_are_read_in_the_order_that_they_state() {
    let ring = read(RING, 0).unwrap();
    assert_eq!((ring.nside, ring.nested, ring.coordinates.as_deref()), (4, false, Some("G")));
    assert!(ring.values.iter().copied().eq((0..192).map(f64::from)), "{ring:?}");
    let nested = read(NESTED, 0).unwrap();
    assert!(nested.nested && nested.coordinates.is_none());
    // The first nested pixel is the southernmost of base pixel 0: nest2ring(4, 0) of healpy.
    assert_eq!(nested.values[0], 74.0);
    let second = read(TWO_FIELDS, 1).unwrap();
    assert_eq!(second.values[191], -191.0);
    // 1024 values in a row.
    let smooth = read(SMOOTH, 0).unwrap();
    assert_eq!((smooth.nside, smooth.values.len()), (16, 3072));
    assert!((smooth.values[0] - smooth.values[3]).abs() < 0.1);
}

#[test]
fn headers_that_leave_a_doubt_are_refused() {
    for (card, text, parts) in [
        (
            "ORDERING",
            "COMMENT no order",
            &["keyword ORDERING", "'RING' or 'NESTED'", "no such"][..],
        ),
        ("ORDERING", "ORDERING= 'SPIRAL  '", &["ORDERING", "'SPIRAL'"]),
        ("ORDERING", "ORDERING=                    1", &["ORDERING"]),
        ("NSIDE", "COMMENT none", &["keyword NSIDE", "no such keyword"]),
        ("NSIDE", "NSIDE   =                    0", &["NSIDE", "from 1 to 8192", "got 0"]),
        ("NSIDE", "NSIDE   =                   -4", &["NSIDE", "-4"]),
        ("NSIDE", "NSIDE   =                    5", &["LASTPIX", "expected 299"]),
        ("TFORM1", "TFORM1  = '2D      '", &["NAXIS1 and TFORMS"]),
        ("NSIDE", "NSIDE   = 'four    '", &["NSIDE", "another type"]),
        ("FIRSTPIX", "FIRSTPIX=                    1", &["FIRSTPIX", "expected 0", "got 1"]),
        ("LASTPIX", "LASTPIX =                   95", &["LASTPIX", "expected 191", "got 95"]),
        ("INDXSCHM", "INDXSCHM= 'EXPLICIT'", &["INDXSCHM", "IMPLICIT"]),
        ("PIXTYPE", "PIXTYPE = 'CAR     '", &["PIXTYPE", "'HEALPIX'", "'CAR'"]),
        ("TFORM1", "TFORM1  = 'K       '", &["TFORM1", "E or D", "'K'"]),
        ("TFORM1", "TFORM1  = '99999999999999999999D'", &[]),
    ] {
        let message = read(&with_card(RING, card, text), 0).unwrap_err();
        for part in parts.iter().chain(&["m.fits"]) {
            assert!(message.contains(part), "{text}: {message}");
        }
    }
    let message = read(PARTIAL, 1).unwrap_err();
    assert!(message.contains("INDXSCHM") && message.contains("'EXPLICIT'"), "{message}");
    let message = read(RING, 1).unwrap_err();
    assert!(message.contains("below TFIELDS = 1"), "{message}");
    assert!(read(b"x,y,z\n", 0).unwrap_err().contains("a FITS file"));
    // Without the table.
    assert!(read(&RING[..2880], 0).unwrap_err().contains("binary table"));
}

/// A file that ends anywhere, or has another byte anywhere in its headers, is read or refused, never more.
#[test]
fn damaged_files_are_no_surprise() {
    for end in (0..RING.len()).step_by(97) {
        let cut = read(&RING[..end], 0);
        // The table has 1536 bytes; what fills up the block may be missing.
        assert_eq!(cut.is_ok(), end >= 5760 + 1536, "{end}: {cut:?}");
    }
    for at in (0..5760).filter(|&at| RING[at] != b' ') {
        let mut bytes = RING.to_vec();
        bytes[at] ^= 0x15;
        if let Ok(map) = read(&bytes, 0) {
            assert_eq!(map.values.len() as u64, 12 * u64::from(map.nside).pow(2));
        }
    }
}
