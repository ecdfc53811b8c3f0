//! Tables of every format with columns by position and by name.

use std::io::{Cursor, Write};

use flate2::Compression;
use flate2::write::GzEncoder;
use glam::DVec3;

use super::super::{ColumnChoice, ReadOptions};
use super::{PointFile, doubles, npy, read, read_as, read_with};
use crate::files::fits::HduChoice;

/// Written by astropy.
const CATALOGUE: &[u8] = include_bytes!("../../../../tests/data/catalogue.fits");
const CATALOGUE_GZ: &[u8] = include_bytes!("../../../../tests/data/catalogue.fits.gz");
const CATALOGUE_CSV: &[u8] = include_bytes!("../../../../tests/data/catalogue.csv");
const KINDS: &[u8] = include_bytes!("../../../../tests/data/kinds.fits");

fn gzip(content: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(content).unwrap();
    encoder.finish().unwrap()
}

/// Returns an archive of arrays, stored or deflated.
fn npz(arrays: &[(&str, Vec<u8>)], method: zip::CompressionMethod) -> Vec<u8> {
    let mut writer = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default().compression_method(method);
    for (name, array) in arrays {
        writer.start_file(format!("{name}.npy"), options).unwrap();
        writer.write_all(array).unwrap();
    }
    writer.finish().unwrap().into_inner()
}

fn array(descr: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    npy(&format!("{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}"), data)
}

/// Right ascension, declination, and weight of the directions X, Z and -Y.
const ROWS: [[f64; 3]; 3] = [[0.0, 0.0, 1.0], [77.0, 90.0, 2.0], [-90.0, 0.0, -0.5]];

fn assert_rows(file: &PointFile, name: &str) {
    assert_eq!(file.sets.len(), 1, "{name}");
    assert_eq!(file.sets[0].points, [DVec3::X, DVec3::Z, DVec3::NEG_Y], "{name}");
    assert_eq!(file.sets[0].weights, [1.0, 2.0, -0.5], "{name}");
}

#[test]
fn one_table_in_every_format() {
    let flat: Vec<f64> = ROWS.into_iter().flatten().collect();
    let column = |i: usize| doubles(&ROWS.map(|row| row[i]));
    let fortran = "{'descr': '<f8', 'fortran_order': True, 'shape': (3, 3), }";
    let text = |separator: &str| {
        let row = |row: [f64; 3]| row.map(|x| x.to_string()).join(separator);
        ROWS.map(row).join("\n")
    };
    let mut floats = Vec::new();
    for [ra, dec, w] in ROWS {
        // Big-endian, with an unused item between the others.
        floats.extend(b"pad.");
        floats.extend(ra.to_be_bytes());
        #[expect(clippy::cast_possible_truncation, reason = "small whole numbers and a half")]
        floats.extend([dec as f32, w as f32].map(f32::to_le_bytes).concat());
    }
    let records = "[('note', '|S4'), ('RA', '>f8'), ('Dec', '<f4'), ('wt', '<f4')]";
    let ply = format!(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty double alpha\nproperty double delta\n\
         property double quality\nend_header\n{}\n",
        text(" ")
    );
    let arrays = [
        ("A", array("'<f8'", "(3,)", &column(0))),
        ("B", array("'<f8'", "(3,)", &column(1))),
        ("weights", array("'<f8'", "(3,)", &column(2))),
    ];
    let cases: [(&str, Vec<u8>, &str); 13] = [
        ("p.txt", text(" ").into(), "ra,dec,w"),
        ("p.csv", text(",").into(), "lon,lat,w"),
        ("p.tsv", text("\t").into(), "ra,dec,w"),
        ("p.csv", text(";").into(), "ra,dec,weight"),
        ("p.csv", format!("a;b;c\n{}", text(";")).into(), "ra,dec,w"),
        ("p.csv", format!("c,d,\"w, new\"\n{}", text(",")).into(), "ra=c,dec=D,w=\"w, new\""),
        ("p.npy", array("'<f8'", "(3, 3)", &doubles(&flat)), "ra,dec,w"),
        ("p.npy", npy(fortran, &[column(0), column(1), column(2)].concat()), "ra,dec,w"),
        ("p.npy", array(records, "(3,)", &floats), "_,ra,dec,w"),
        ("p.npy", array(records, "(3,)", &floats), "ra=ra,dec=Dec,w=wt"),
        ("p.ply", ply.clone().into(), "ra,dec,w"),
        ("p.ply", ply.into(), "ra=alpha,dec=delta,w=quality"),
        ("p.npz", npz(&arrays, zip::CompressionMethod::Deflated), "ra=A,dec=B,w=weights"),
    ];
    for (name, content, columns) in cases {
        assert_rows(&read_as(name, &content, columns).unwrap(), &format!("{name} {columns}"));
        // For a compressed file the name is irrelevant, and without a known extension the content
        // decides.
        let compressed = read_as(&format!("{name}.gz"), gzip(&content), columns).unwrap();
        assert_rows(&compressed, name);
        if !["npy", "npz", "ply"].iter().any(|e| name.ends_with(e)) {
            continue;
        }
        assert_rows(&read_as("p.unknown", gzip(&content), columns).unwrap(), name);
    }
}

#[test]
fn archives_of_points_and_weights() {
    let stored = zip::CompressionMethod::Stored;
    let points = doubles(&[1.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    let seed = array("'<i8'", "()", &7_i64.to_le_bytes());
    let with = |weights: Vec<u8>| {
        let points = array("'<f8'", "(2, 3)", &points);
        let arrays = [("points", points), ("weights", weights), ("seed", seed.clone())];
        npz(&arrays, stored)
    };
    let back = read("p.npz", with(array("'<f4'", "(2,)", &[0, 0, 0, 64, 0, 0, 128, 63])));
    assert_eq!(back.sets[0].points, [DVec3::X, DVec3::Z]);
    assert_eq!(back.sets[0].weights, [2.0, 1.0]);
    assert_eq!(back.remarks, ["p.npz: points: column not used: seed"]);

    let several = [
        ("points", array("'<f8'", "(2, 1, 3)", &points)),
        ("w", array("'<f8'", "(2, 1)", &doubles(&[3.0, 4.0]))),
    ];
    let back = read("p.npz", npz(&several, stored));
    assert_eq!(back.sets.len(), 2);
    assert_eq!(back.sets[1].weights, [4.0]);

    let wrong = with(array("'<f8'", "(3,)", &doubles(&[1.0, 2.0, 3.0])));
    let message = read_with("p.npz", wrong, &ReadOptions::default()).unwrap_err();
    assert!(message.contains("expected weights of the shape of points"), "{message}");

    let columns = [
        ("x", array("'<f8'", "(1,)", &doubles(&[0.0]))),
        ("y", array("'<f8'", "(1,)", &doubles(&[1.0]))),
        ("z", array("'|i1'", "(1,)", &[0])),
    ];
    let back = read("p.npz", npz(&columns, stored));
    assert_eq!(back.sets[0].points, [DVec3::Y]);
    let named =
        read_as("p.npz", with(seed.clone()), "x=points[0],y=points[1],z=points[2]").unwrap();
    assert_eq!(named.sets[0].points, [DVec3::X, DVec3::Z]);
    let message = read_as("p.npz", with(seed.clone()), "ra=A,dec=B").unwrap_err();
    assert!(
        message.contains("expected the column A of --columns, got the columns points,weights,seed"),
        "{message}"
    );
}

#[test]
fn archives_of_records_and_of_columns_beside_other_arrays() {
    let stored = zip::CompressionMethod::Stored;
    let records = "[('ra', '<f8'), ('dec', '<f8'), ('q', '<f8')]";
    let table = array(records, "(2,)", &doubles(&[90.0, 0.0, 5.0, 0.0, 90.0, 7.0]));
    let weights = array("'<f8'", "(2,)", &doubles(&[3.0, 4.0]));
    let file = npz(&[("table", table), ("weights", weights)], stored);
    for columns in ["ra,dec,_", "ra=ra,dec=dec"] {
        let back = read_as("p.npz", &file, columns).unwrap();
        assert_eq!(back.sets[0].points, [DVec3::Y, DVec3::Z]);
        assert_eq!(back.sets[0].weights, [3.0, 4.0], "{columns}");
    }
    let back = read_as("p.npz", &file, "ra=ra,dec=dec,w=q").unwrap();
    assert_eq!(back.sets[0].weights, [5.0, 7.0]);
    // Columns with the names of a direction, and an image that is not one.
    let arrays = [
        ("RAJ2000", array("'<f8'", "(2,)", &doubles(&[90.0, 0.0]))),
        ("DEJ2000", array("'<f8'", "(2,)", &doubles(&[0.0, 90.0]))),
        ("picture", array("'<f8'", "(2, 3)", &doubles(&[0.0; 6]))),
    ];
    let back = read("p.npz", npz(&arrays, stored));
    assert_eq!(back.sets[0].points, [DVec3::Y, DVec3::Z]);
    assert_eq!(back.remarks, ["p.npz: column not used: picture"]);
    // If no array can be read, the reason is reported.
    let message =
        read_with("p.npz", npz(&[("a", b"text".to_vec())], stored), &ReadOptions::default());
    let message = message.unwrap_err();
    assert!(message.starts_with("p.npz: a") && !message.contains("got none"), "{message}");
}

/// The padding of aligned records has no name.
#[test]
fn padding_is_not_a_column() {
    let records = "[('x', '|i1'), ('y', '|i1'), ('', '|V6'), ('z', '<f8')]";
    let rows = [&[0_u8; 8][..], &1f64.to_le_bytes()].concat();
    let back = read("p.npy", array(records, "(1,)", &rows));
    assert_eq!(back.sets[0].points, [DVec3::Z]);
    assert!(back.remarks.is_empty(), "{:?}", back.remarks);
}

#[test]
fn wrong_rows_of_ply_texts() {
    let head = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n\
                property uchar z\nend_header\n";
    for (content, part) in [
        (format!("{head}1 0 0\n1 0 1.0\n"), "p.ply:9: expected 2 rows of vertex, got \"1.0\": "),
        (
            format!("{head}1 0 0\n1 one 1\n"),
            "p.ply:9: expected 2 rows of vertex, got \"1 one 1\": ",
        ),
        (format!("{head}1 0 0\n1 0\n"), "p.ply:9: expected 2 rows of vertex, got "),
        (
            head.replace("vertex 2", "vertex 99999999999999999999"),
            "p.ply:3: expected a PLY header, got \"element vertex 99999999999999999999\": ",
        ),
    ] {
        let message = read_with("p.ply", content, &ReadOptions::default()).unwrap_err();
        assert!(message.starts_with(part), "{message}\n{part}");
        assert!(!message.contains(['{', '\n', '\t']) && message.len() < 200, "{message}");
    }
}

#[test]
fn a_catalogue_is_the_same_in_every_format() {
    let names = "ra=RAJ2000,dec=DEJ2000,w=WEIGHT";
    let text = read_as("c.csv", CATALOGUE_CSV, names).unwrap();
    assert_eq!(text.sets[0].points.len(), 120);
    assert_eq!(text.remarks, ["c.csv: column not used: Z"]);
    for (name, content) in [("c.fits", CATALOGUE), ("c.fits.gz", CATALOGUE_GZ)] {
        assert_eq!(read_as(name, content, names).unwrap().sets, text.sets, "{name}");
        // The names of catalogues are recognized, and a list of roles matches them.
        assert_eq!(read(name, content).sets, text.sets, "{name}");
        assert_eq!(read_as(name, content, "ra,dec,w").unwrap().sets, text.sets, "{name}");
        let unweighted = read_as(name, content, "ra,dec,_,_").unwrap();
        assert_eq!(unweighted.sets[0].points, text.sets[0].points);
        assert!(unweighted.sets[0].weights.is_empty());
    }
    let message = read_as("c.fits", CATALOGUE, "ra=RA,dec=DEC").unwrap_err();
    assert!(
        message.contains("expected the column RA of --columns, got the columns RAJ2000,DEJ2000,"),
        "{message}"
    );
}

fn kinds(columns: &str, hdu: &str) -> Result<PointFile, String> {
    let options = ReadOptions {
        columns: Some(columns.parse::<ColumnChoice>()?),
        hdu: hdu.parse::<HduChoice>()?,
        ..ReadOptions::default()
    };
    read_with("k.fits", KINDS, &options)
}

#[test]
fn columns_of_fits_tables() {
    let expected = [DVec3::X, DVec3::Y, DVec3::Z];
    for (hdu, columns) in [
        ("2", "ra,dec,w"),
        ("kinds", "ra=RA,dec=DEC,w=W"),
        ("KINDS", "x=POS[0],y=pos[1],z=POS[2],w=W"),
        ("3", "ra,dec,w"),
        ("Text", "lon=RA,lat=DEC,w=W"),
    ] {
        let back = kinds(columns, hdu).unwrap();
        // Stored in 16 bits, 180 + 0.01 times an integer is an angle to two roundings.
        for (got, expected) in back.sets[0].points.iter().zip(expected) {
            assert!(got.distance(expected) < 1e-15, "{hdu} {columns}: {got}");
        }
        assert_eq!(back.sets[0].weights, [1.0, 2.0, 65535.0], "{hdu} {columns}");
    }
    let bits = kinds("x=FLAGS[0],y=FLAGS[1],z=FLAGS[2],w=OK,set=NAME", "2").unwrap();
    assert_eq!(bits.sets[0].points, [DVec3::X, DVec3::ONE.normalize()]);
    assert_eq!(bits.sets[0].weights, [1.0, 1.0]);
    assert_eq!(bits.sets[1].points, [DVec3::Y]);

    for (hdu, columns, part) in [
        ("0", "ra,dec", "expected a table in HDU 0, got [0] image"),
        ("7", "ra,dec", "expected HDU 7, got a FITS file with [0] image, [1] table NOTES, [2]"),
        ("stars", "ra,dec", "expected the HDU named stars, got a FITS file with"),
        ("1", "ra,dec", "expected 2 fields for --columns ra,dec, got 1"),
        ("1", "ra=RA,dec=DEC", "the column RA of --columns, got the columns REMARK"),
        ("2", "ra=VAR,dec=DEC", "expected numbers in the column VAR"),
        ("2", "ra=C,dec=DEC", "expected numbers in the column C"),
        ("2", "x=POS,y=POS,z=POS", "one of the numbers POS[0] to POS[2]"),
        ("2", "x=POS[3],y=POS[1],z=POS[2]", "one of the numbers POS[0] to POS[2]"),
        ("2", "x=POS[0],y=POS[0],z=POS[2]", "a separate column for y"),
        ("2", "ra=RADIANS,dec=DEC", "ra in degrees, got RADIANS in the unit rad"),
        ("2", "ra=RA,dec=DEC,w=ID", "k.fits: row 2: w (ID): expected a finite number, got nothing"),
        ("2", "ra=NAME,dec=DEC", "row 1: ra (NAME): expected a finite number, got \"one\""),
    ] {
        let message = kinds(columns, hdu).unwrap_err();
        assert!(message.contains(part), "{message}\n{part}");
    }
}

#[test]
fn the_hdu_may_follow_the_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("k.fits.gz");
    std::fs::write(&path, gzip(KINDS)).unwrap();
    for name in ["k.fits.gz[2]", "k.fits.gz[KINDS]", "k.fits.gz[text]"] {
        let path = folder.path().join(name);
        let options = ReadOptions {
            columns: Some("ra=RA,dec=DEC".parse().unwrap()),
            ..ReadOptions::default()
        };
        let back = super::super::read_points::<DVec3>(&path, &options).unwrap();
        assert_eq!(back.sets[0].points.len(), 3, "{name}");
    }
    let path = folder.path().join("p.csv");
    std::fs::write(&path, "x,y,z\n0,0,1\n").unwrap();
    let path = folder.path().join("p.csv[2]");
    let message = super::super::read_points::<DVec3>(&path, &ReadOptions::default()).unwrap_err();
    assert!(message.to_string().contains("a FITS file with HDU 2"), "{message}");
    // A file with exactly that name takes precedence.
    let path = folder.path().join("k.fits.gz[2]");
    std::fs::write(&path, "x,y,z\n0,0,1\n").unwrap();
    let back = super::super::read_points::<DVec3>(&path, &ReadOptions::default()).unwrap();
    assert_eq!(back.sets[0].points, [DVec3::Z]);
}

#[test]
fn every_cut_of_a_table_is_an_error() {
    // The last block is padded to 2880 bytes.
    let end = CATALOGUE.len() - (2880 - 120 * 32 % 2880);
    for length in (1..end).step_by(7).chain([end - 1]) {
        let message =
            read_with("c.fits", &CATALOGUE[..length], &ReadOptions::default()).unwrap_err();
        assert!(message.contains("expected"), "{length}: {message}");
    }
    assert_eq!(read("c.fits", &CATALOGUE[..end]).sets[0].points.len(), 120);
}

#[test]
fn headers_that_promise_too_much() {
    let card = |name: &str, card: &str| {
        let mut copy = CATALOGUE.to_vec();
        let keyword = format!("{name:<8}");
        let at =
            (2880..copy.len()).step_by(80).find(|&i| copy[i..].starts_with(keyword.as_bytes()));
        let at = at.unwrap();
        copy[at..at + 80].copy_from_slice(format!("{card:<80}").as_bytes());
        read_with("c.fits", copy, &ReadOptions::default()).unwrap_err()
    };
    for (name, text, part) in [
        ("NAXIS2", "NAXIS2  =  999999999999999999", "c.fits"),
        ("NAXIS2", "NAXIS2  =         99999999999", "truncated"),
        ("NAXIS2", "NAXIS2  =                   0", "no points"),
        ("NAXIS2", "NAXIS2  =                  -1", "NAXIS2"),
        ("NAXIS1", "NAXIS1  =                   8", "fit in a row of NAXIS1 = 8"),
        ("NAXIS1", "NAXIS1  =        999999999999", "NAXIS1"),
        ("TFIELDS", "TFIELDS =              100000", "TFIELDS"),
        ("TFORM1", "TFORM1  = '99999999999999999999D'", "TFORM1"),
        ("TFORM1", "TFORM1  = 'Y       '", "TFORM1"),
        ("TFORM1", "TFORM1  = '        '", "TFORM1"),
    ] {
        let message = card(name, text);
        assert!(message.contains(part), "{text}: {message}");
    }
}

#[test]
fn two_elements_of_one_name() {
    let vertex = "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
    let twice = format!("ply\nformat ascii 1.0\n{vertex}{vertex}end_header\n1 0 0\n0 1 0\n");
    let message = read_with("p.ply", twice, &ReadOptions::default()).unwrap_err();
    assert!(message.contains("expected each element once, got element vertex twice"), "{message}");
    let twice = format!("ply\nformat ascii 1.0\n{vertex}property float x\nend_header\n1 0 0 0\n");
    let message = read_with("p.ply", twice, &ReadOptions::default()).unwrap_err();
    assert!(message.contains("expected each property once, got property x twice"), "{message}");
}

#[test]
fn formats_that_are_not_supported_are_named() {
    let starts: [(&[u8], &str); 3] =
        [(b"PAR1....", "Parquet"), (b"\x89HDF\r\n", "HDF5"), (b"<?xml version", "VOTable")];
    for (start, name) in starts {
        for file in ["p.parquet", "p.csv"] {
            let message = read_with(file, start, &ReadOptions::default()).unwrap_err();
            assert!(message.contains(name) && message.contains("not supported"), "{message}");
        }
    }
}
