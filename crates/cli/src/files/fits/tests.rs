use super::map::read_fits_map;
use super::{FitsField, FitsMap, HduChoice};

/// Maps that healpy 1.20.1 wrote.
const RING: &[u8] = include_bytes!("../../../tests/data/ring.fits");
const NESTED: &[u8] = include_bytes!("../../../tests/data/nested.fits");
const TWO_FIELDS: &[u8] = include_bytes!("../../../tests/data/two_fields.fits");
const PARTIAL: &[u8] = include_bytes!("../../../tests/data/partial.fits");
const SMOOTH: &[u8] = include_bytes!("../../../tests/data/smooth.fits");

/// Written by healpy 1.20.1 and astropy 8.0.2, which printed the sums.
const MIXED: &[u8] = include_bytes!("../../../tests/data/mixed.fits");
const EXPLICIT: &[u8] = include_bytes!("../../../tests/data/explicit.fits");
const IMPLICIT_PART: &[u8] = include_bytes!("../../../tests/data/implicit_part.fits");
const ODD: &[u8] = include_bytes!("../../../tests/data/odd.fits.gz");
const IMAGES: &[u8] = include_bytes!("../../../tests/data/images.fits");
const DIGITS: &[u8] = include_bytes!("../../../tests/data/digits.fits");

fn read(bytes: &[u8], field: usize) -> Result<FitsMap, String> {
    choose(bytes, &HduChoice::First, &FitsField::Number(field))
}

fn choose(bytes: &[u8], hdu: &HduChoice, field: &FitsField) -> Result<FitsMap, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.fits");
    std::fs::write(&path, bytes).unwrap();
    read_fits_map(&path, hdu, field).map_err(|e| e.to_string())
}

fn named(name: &str) -> FitsField {
    FitsField::Name(name.to_owned())
}

/// Returns the file with the first card of a name replaced; a card has 80 characters.
fn with_card(bytes: &[u8], name: &str, card: &str) -> Vec<u8> {
    let mut copy = bytes.to_vec();
    let keyword = format!("{name:<8}");
    // The primary header occupies the first block.
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
fn ambiguous_headers_are_rejected() {
    for (card, text, parts) in [
        (
            "ORDERING",
            "COMMENT no order",
            &["keyword ORDERING", "'RING' or 'NESTED'", "no such"][..],
        ),
        ("ORDERING", "ORDERING= 'SPIRAL  '", &["ORDERING", "'SPIRAL'"]),
        ("ORDERING", "ORDERING=                    1", &["ORDERING"]),
        ("ORDERING", "ORDERING= 'NUNIQ   '", &["multi-order", "'NUNIQ'"]),
        ("NSIDE", "COMMENT none", &["keyword NSIDE", "no such keyword"]),
        ("NSIDE", "NSIDE   =                    0", &["NSIDE", "from 1 to 8192", "got 0"]),
        ("NSIDE", "NSIDE   =                   -4", &["NSIDE", "-4"]),
        ("NSIDE", "NSIDE   =                    3", &["LASTPIX", "from 0 to 107", "got 191"]),
        ("TFORM1", "TFORM1  = '2D      '", &["TFORM1", "NAXIS1 = 8", "'2D'"]),
        ("NSIDE", "NSIDE   = 'four    '", &["NSIDE", "'four'"]),
        ("FIRSTPIX", "FIRSTPIX=                    1", &["191 values", "FIRSTPIX = 1", "192 rows"]),
        ("LASTPIX", "LASTPIX =                   95", &["96 values", "LASTPIX = 95", "192 rows"]),
        ("INDXSCHM", "INDXSCHM= 'EXPLICIT'", &["TFIELDS", "pixel numbers"]),
        ("INDXSCHM", "INDXSCHM= 'SPARSE  '", &["INDXSCHM", "'IMPLICIT' or 'EXPLICIT'", "'SPARSE'"]),
        ("PIXTYPE", "PIXTYPE = 'CAR     '", &["PIXTYPE", "'HEALPIX'", "'CAR'"]),
        ("TFORM1", "TFORM1  = 'C       '", &["a field of real numbers", "complex"]),
        ("TFORM1", "TFORM1  = '8A      '", &["a field of real numbers", "texts"]),
        ("TFORM1", "TFORM1  = '7Z      '", &["TFORM1", "'7Z'"]),
        ("TFORM1", "TFORM1  = '99999999999999999999D'", &[]),
    ] {
        let message = read(&with_card(RING, card, text), 0).unwrap_err();
        for part in parts.iter().chain(&["m.fits"]) {
            assert!(message.contains(part), "{text}: {message}");
        }
    }
    let message = read(RING, 1).unwrap_err();
    assert!(message.contains("a field below 1") && message.contains("got field 1"), "{message}");
    let message = choose(MIXED, &HduChoice::First, &named("count")).unwrap_err();
    assert!(
        message.contains("a field count") && message.contains("FLAGS, MASK, COUNTS"),
        "{message}"
    );
    let message = choose(MIXED, &HduChoice::Number(1), &named("RA")).unwrap_err();
    assert!(message.contains("HEALPix map in HDU 1") && message.contains("STARS"), "{message}");
    assert!(read(b"x,y,z\n", 0).unwrap_err().contains("a FITS file"));
    // Without the table.
    assert!(read(&RING[..2880], 0).unwrap_err().contains("binary table"));
}

#[test]
#[expect(clippy::float_cmp, reason = "small integers and halves of them")]
fn maps_of_every_layout_are_read() {
    let absent = |map: &FitsMap| map.values.iter().filter(|value| value.is_nan()).count();
    let sum = |map: &FitsMap| map.values.iter().filter(|value| !value.is_nan()).sum::<f64>();
    // Bits before the map, logicals, scaled integers with a null, bytes; a table of stars is
    // skipped.
    for hdu in [HduChoice::First, HduChoice::Number(2), HduChoice::Name("map".to_owned())] {
        let mask = choose(MIXED, &hdu, &named("mask")).unwrap();
        assert_eq!((sum(&mask), mask.values[0], mask.values[1]), (64.0, 1.0, 0.0));
    }
    let counts = read(MIXED, 2).unwrap();
    assert_eq!((sum(&counts), absent(&counts)), (1963.5, 2));
    assert_eq!(counts.values[..3], [41.0, 26.5, 39.0]);
    assert!(counts.values[5].is_nan() && counts.values[17].is_nan());
    let big = read(MIXED, 4).unwrap();
    assert_eq!(big.values[191], 191.0 * 2f64.powi(40));
    assert_eq!(read(MIXED, 3).unwrap().values[191], 191.0);
    // The column of pixel numbers does not count as a field.
    let signal = read(EXPLICIT, 0).unwrap();
    assert_eq!((signal.nested, absent(&signal), sum(&signal)), (true, 92, 5126.5));
    let first = signal.values.iter().position(|value| !value.is_nan()).unwrap();
    assert_eq!(signal.values[first], 0.5 * first as f64);
    let observations = choose(EXPLICIT, &HduChoice::First, &named("n_obs")).unwrap();
    assert_eq!(sum(&observations), 10353.0);
    // A partial map of healpy, of the upper half of nside 16.
    let half = read(PARTIAL, 0).unwrap();
    assert_eq!((half.nside, absent(&half), sum(&half)), (16, 1536, 1536.0));
    let part = read(IMPLICIT_PART, 0).unwrap();
    assert_eq!((absent(&part), part.values[20], part.values[99]), (112, 20.0, 99.0));
    assert!(part.values[19].is_nan() && part.values[100].is_nan());
    // Compressed, and with an nside that is valid in ring order only.
    let odd = read(ODD, 0).unwrap();
    assert_eq!((odd.nside, sum(&odd)), (3, 107.0 * 54.0));
}

/// The values are those of the script; astropy printed the first of the scaled ones.
#[test]
#[expect(clippy::float_cmp, reason = "small integers and halves of them")]
fn maps_in_images_are_read() {
    let first = read(IMAGES, 0).unwrap();
    assert_eq!((first.nside, first.nested, first.coordinates.as_deref()), (4, false, Some("G")));
    assert_eq!((first.values[0], first.values[191]), (-3.0, 92.5));
    assert!(first.values.iter().enumerate().all(|(i, value)| value.is_nan() == (i == 11)));
    for field in [FitsField::Number(1), named("1")] {
        let second = choose(IMAGES, &HduChoice::First, &field).unwrap();
        assert_eq!(second.values[..3], [665.5, 662.0, 658.5]);
        assert_eq!(second.values[191], -3.0);
    }
    let hdu = |name: &str| choose(IMAGES, &HduChoice::Name(name.to_owned()), &FitsField::Number(0));
    // The values are in the order of the file for any number of axes.
    let squares = hdu("squares").unwrap();
    assert!(squares.nested && (0..192).all(|i| squares.values[i] == (i * i) as f64));
    let upper = hdu("upper").unwrap();
    let has_value = |i: usize| (5..=60).contains(&i);
    assert!((0..192).all(|i| upper.values[i].is_nan() != has_value(i)), "{upper:?}");
    assert_eq!((upper.values[5], upper.values[60]), (5.0, 60.0));
    let bytes = hdu("bytes").unwrap();
    assert!((0..192).all(|i| bytes.values[i] == (i % 251) as f64));
    for (hdu, field, parts) in [
        (HduChoice::Number(4), named("0"), &["compressed image (funpack unpacks it) PACKED"][..]),
        (HduChoice::First, named("2"), &["a field below 2", "field 2", "an image of 2 maps"]),
        (HduChoice::First, named("I"), &["a field I", "an image of 2 maps"]),
        (HduChoice::Number(3), FitsField::Number(1), &["a field below 1", "an image of 1 maps"]),
    ] {
        let message = choose(IMAGES, &hdu, &field).unwrap_err();
        for part in parts {
            assert!(message.contains(part), "{hdu:?} {field:?}: {message}");
        }
    }
    // The primary header again, with an nside that contradicts the number of pixels.
    let card = IMAGES.windows(8).position(|word| word == b"NSIDE   ").unwrap();
    let mut other = IMAGES.to_vec();
    other[card + 29] = b'8';
    let message = read(&other, 0).unwrap_err();
    assert!(message.contains("768 pixels along its first axes") && message.contains("192 x 2"));
    for end in (0..2880 + 768).step_by(191) {
        assert!(read(&IMAGES[..end], 1).is_err(), "{end}");
    }
}

#[test]
#[expect(clippy::float_cmp, reason = "small integers")]
fn names_of_columns_take_precedence_over_numbers() {
    // Columns 1, 3X and 0 in this order.
    for (field, value) in [("1", 5.0), ("0", 7.0), ("3X", 6.0), ("3x", 6.0), ("2", 7.0)] {
        let map = choose(DIGITS, &HduChoice::First, &named(field)).unwrap();
        assert_eq!(map.values[0], value, "{field}");
    }
    for (field, part) in [("3", "a field below 3"), ("03X", "a field 03X"), ("-1", "a field -1")] {
        let message = choose(DIGITS, &HduChoice::First, &named(field)).unwrap_err();
        assert!(message.contains(part) && message.contains("3 fields: 1, 3X, 0"), "{message}");
    }
}

#[test]
fn pixel_numbers_are_checked() {
    // The first row: the 4 bytes of the pixel number after two headers.
    let start = EXPLICIT.len() - 2880;
    for (number, parts) in [
        (192_i32, &["[0]", "from 0 to 191", "got 192"][..]),
        (-1, &["from 0 to 191", "got -1"]),
        (
            i32::from_be_bytes(EXPLICIT[start + 12..start + 16].try_into().unwrap()),
            &["[1]", "once"],
        ),
    ] {
        let mut bytes = EXPLICIT.to_vec();
        bytes[start..start + 4].copy_from_slice(&number.to_be_bytes());
        let message = read(&bytes, 0).unwrap_err();
        for part in parts.iter().chain(&["pixel number"]) {
            assert!(message.contains(part), "{number}: {message}");
        }
    }
}

/// A file that is truncated at any byte, or has a header byte changed, is read or rejected without
/// a panic.
#[test]
fn damaged_files_do_not_panic() {
    for end in (0..RING.len()).step_by(97) {
        let cut = read(&RING[..end], 0);
        // The table has 1536 bytes; the padding of the block may be missing.
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
