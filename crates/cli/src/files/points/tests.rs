//! Round trips of every format and its variants; errors are tested in `messages`.

mod choices;
mod dialects;
mod messages;
mod square;
mod tables;

use std::fs;
use std::path::PathBuf;

use glam::DVec3;
use sphvar_samplers::PointSet;
use tempfile::TempDir;

use super::{PointFile, ReadOptions, read_points, write_points};

/// Returns a folder with one file of the given content.
fn file(name: &str, content: impl AsRef<[u8]>) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, content).unwrap();
    (folder, path)
}

fn read(name: &str, content: impl AsRef<[u8]>) -> PointFile {
    read_with(name, content, &ReadOptions::default()).unwrap()
}

fn read_as(name: &str, content: impl AsRef<[u8]>, columns: &str) -> Result<PointFile, String> {
    let columns = Some(columns.parse()?);
    read_with(name, content, &ReadOptions { columns, ..ReadOptions::default() })
}

/// Returns the file read with these options, or the message of the error without the name of the
/// folder.
fn read_with(
    name: &str,
    content: impl AsRef<[u8]>,
    options: &ReadOptions,
) -> Result<PointFile, String> {
    let (folder, path) = file(name, content);
    let shown = |text: &String| text.replace(&format!("{}/", folder.path().display()), "");
    let mut read = read_points(&path, options).map_err(|error| shown(&error.to_string()))?;
    read.warnings = read.warnings.iter().map(shown).collect();
    read.remarks = read.remarks.iter().map(shown).collect();
    Ok(read)
}

/// Returns the message of the error, without the name of the folder.
fn error(name: &str, content: impl AsRef<[u8]>) -> String {
    let (folder, path) = file(name, content);
    let message = read_points::<DVec3>(&path, &ReadOptions::default()).unwrap_err().to_string();
    message.replace(&format!("{}/", folder.path().display()), "")
}

/// Unit vectors that lose bits if they are handled carelessly.
fn hostile() -> Vec<DVec3> {
    let tiny = f64::from_bits(1);
    vec![
        DVec3::Z,
        DVec3::NEG_Z,
        DVec3::new(-0.0, -0.0, 1.0),
        DVec3::new(0.0, -0.0, -1.0),
        DVec3::new(1.0, tiny, -tiny),
        DVec3::new(-1.0, f64::MIN_POSITIVE, -0.0),
        DVec3::new(1e-300, -1e-17, 1.0),
        DVec3::new(1.0, 2.0, 3.0).normalize(),
        DVec3::new(-0.1, 1e-9, 0.3).normalize(),
        DVec3::splat(1.0).normalize(),
    ]
}

fn bits(points: &[DVec3]) -> Vec<[u64; 3]> {
    points.iter().map(|p| p.to_array().map(f64::to_bits)).collect()
}

/// Returns an NPY file of version 1 with this header dictionary and these data.
fn npy(dictionary: &str, data: &[u8]) -> Vec<u8> {
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    let text = format!("{dictionary}\n");
    bytes.extend(u16::try_from(text.len()).unwrap().to_le_bytes());
    bytes.extend(text.as_bytes());
    bytes.extend(data);
    bytes
}

fn doubles(numbers: &[f64]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
}

#[test]
fn every_format_keeps_every_bit() {
    let weights = vec![1.0, -1.0, 0.1, 1e300, 5e-324, -0.0, 1.0 / 3.0, 2.0, 1e-9];
    let weighted = |points: Vec<DVec3>| {
        let weights = weights.iter().cycle().take(points.len()).copied().collect();
        PointSet { points, weights }
    };
    let backwards: Vec<DVec3> = hostile().into_iter().rev().collect();
    let one = [PointSet::new(hostile())];
    let two = [PointSet::new(hostile()), PointSet::new(backwards.clone())];
    let weighted = [weighted(hostile()), weighted(backwards)];
    let all = [&one[..], &two[..], &weighted[..1], &weighted[..]];
    for extension in ["csv", "npy", "npz", "ply"] {
        for sets in all {
            if extension == "npy" && !sets[0].weights.is_empty() {
                continue;
            }
            for provenance in [None, Some("sphvar sample jittered\nseed 0\tand \u{7}a bell")] {
                let folder = tempfile::tempdir().unwrap();
                let path = folder.path().join(format!("points.{extension}"));
                write_points(&path, None, sets, provenance).unwrap();
                let back = read_points::<DVec3>(&path, &ReadOptions::default()).unwrap();
                assert!(back.warnings.is_empty(), "{extension}: {:?}", back.warnings);
                assert_eq!(back.sets.len(), sets.len(), "{extension}");
                for (set, expected) in back.sets.iter().zip(sets) {
                    assert_eq!(bits(&set.points), bits(&expected.points), "{extension}");
                    let bits = |weights: &[f64]| -> Vec<u64> {
                        weights.iter().map(|w| w.to_bits()).collect()
                    };
                    assert_eq!(bits(&set.weights), bits(&expected.weights), "{extension}");
                }
            }
        }
    }
}

#[test]
fn random_unit_vectors_keep_their_bits_as_text() {
    // A Weyl sequence suffices: it varies the bits of the mantissa.
    let points: Vec<DVec3> = (1..4000)
        .map(|k| {
            let t = f64::from(k);
            let fraction = |a: f64| (t * a).fract() - 0.5;
            DVec3::new(fraction(0.754877666), fraction(0.569840290), fraction(0.3819660113))
                .normalize()
        })
        .collect();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.csv");
    write_points(&path, None, &[PointSet::new(points.clone())], None).unwrap();
    let back = read_points::<DVec3>(&path, &ReadOptions::default()).unwrap();
    assert_eq!(bits(&back.sets[0].points), bits(&points));
}

#[test]
fn written_forms_are_those_that_scripts_rely_on() {
    let folder = tempfile::tempdir().unwrap();
    let sets = [vec![DVec3::X, DVec3::Y], vec![DVec3::Z, DVec3::NEG_X]].map(PointSet::new);
    let path = folder.path().join("p.csv");
    write_points(&path, None, &sets[..1], None).unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "x,y,z\n1.0,0.0,0.0\n0.0,1.0,0.0\n");
    write_points(&path, None, &sets, Some("seed 0")).unwrap();
    assert!(fs::read_to_string(&path).unwrap().starts_with("x,y,z,set\n1.0,0.0,0.0,0\n"));

    // A plain CSV reader that supports comments reads the same numbers.
    let mut plain = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(&path).unwrap();
    assert_eq!(plain.headers().unwrap(), vec!["x", "y", "z", "set"]);
    let last = plain.records().last().unwrap().unwrap();
    assert_eq!(last, vec!["-1.0", "0.0", "0.0", "1"]);

    let weighted = PointSet { weights: vec![0.5, -2.0], ..sets[0].clone() };
    write_points(&path, None, std::slice::from_ref(&weighted), None).unwrap();
    let text = fs::read_to_string(&path).unwrap();
    assert_eq!(text, "x,y,z,w\n1.0,0.0,0.0,0.5\n0.0,1.0,0.0,-2.0\n");
    write_points(&path, None, &[weighted.clone(), sets[1].clone()], None).unwrap();
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.starts_with("x,y,z,w,set\n1.0,0.0,0.0,0.5,0\n"), "{text}");
    assert!(text.ends_with("-1.0,0.0,0.0,1.0,1\n"), "{text}");
    let path = folder.path().join("p.npz");
    write_points(&path, None, &[weighted.clone(), weighted.clone()], None).unwrap();
    let mut archive = zip::ZipArchive::new(fs::File::open(&path).unwrap()).unwrap();
    for (name, shape) in [("points.npy", &[2, 2, 3][..]), ("weights.npy", &[2, 2])] {
        let array = npyz::NpyFile::new(archive.by_name(name).unwrap()).unwrap();
        assert_eq!(array.shape(), shape, "{name}");
    }
    let path = folder.path().join("p.npy");
    let message = write_points(&path, None, &[weighted], None).unwrap_err().to_string();
    assert!(message.contains("has no weights; write .npz"), "{message}");

    let path = folder.path().join("p.NPY");
    write_points(&path, None, &sets[..1], None).unwrap();
    let header = npyz::NpyFile::new(fs::File::open(&path).unwrap()).unwrap();
    assert_eq!((header.shape(), header.dtype().descr()), (&[2, 3][..], "'<f8'".to_owned()));
    write_points(&path, None, &sets, None).unwrap();
    let array = npyz::NpyFile::new(fs::File::open(&path).unwrap()).unwrap();
    assert_eq!(array.shape(), &[2, 2, 3]);
    assert_eq!(array.into_vec::<f64>().unwrap()[6..9], [0.0, 0.0, 1.0]);
}

#[test]
fn text_in_every_dialect() {
    let expected = [DVec3::X, DVec3::Y, DVec3::NEG_Z];
    let dialects = [
        ("x,y,z\n1,0,0\n0,1,0\n0,0,-1\n", "comma"),
        ("x y z\n1 0 0\n0   1 0\n 0 0 -1 \n", "blank"),
        ("1 0 0\n0 1 0\n0 0 -1", "no header"),
        ("\u{feff}X, Y, Z\r\n1, 0, 0\r\n\r\n0, 1, 0\r\n0, 0, -1\r\n", "windows"),
        ("# a comment\n1,0,0\n0,1,0\n0,0,-1e0\n", "comment, no header"),
        ("name,z,y,x,note\n\"a, b\",0,0,1,\nb,0,1,0,\"say \"\"b\"\"\"\nc,-1,0,0,\n", "quotes"),
        ("lon,lat\n0,0\n-270,0\n33,-90\n", "degrees"),
        ("RA,Dec,magnitude\n360,0,1\n90,0,NaN\n-33,-90,-\n", "astronomer"),
    ];
    for (content, dialect) in dialects {
        for name in ["p.csv", "p.00003", "p.txt"] {
            let back = read(name, content);
            assert_eq!(back.sets.len(), 1, "{dialect}");
            assert_eq!(back.sets[0].points, expected, "{dialect}");
            assert!(back.warnings.is_empty(), "{dialect}: {:?}", back.warnings);
        }
    }
}

#[test]
fn radians_are_colatitudes() {
    let back =
        read("p.csv", "phi,theta\n0,0\n1.5707963267948966,1.5707963267948966\n0,3.1415927\n");
    let expected = [DVec3::Z, DVec3::Y, DVec3::NEG_Z];
    for (got, expected) in back.sets[0].points.iter().zip(expected) {
        // The double nearest to pi differs from it by up to half its last digit, 2^-52.
        assert!(got.distance(expected) <= 2.0 * f64::EPSILON, "{got} against {expected}");
    }
}

#[test]
fn columns_name_the_fields_of_bare_files() {
    let back = read_as("p.txt", "0 90 5\n0 -90 6\n", "lon,lat,value").unwrap();
    assert_eq!(back.sets[0].points, [DVec3::Z, DVec3::NEG_Z]);
    assert_eq!(back.remarks, ["p.txt: column not used: value"]);

    let back = read_as("p.txt", "9 0 0 1 0.5\n9 1 0 0 0.25\n", "_,x,y,z,weight").unwrap();
    assert_eq!(back.sets[0].points, [DVec3::Z, DVec3::X]);
    assert_eq!(back.sets[0].weights, [0.5, 0.25]);

    // With a header the option selects columns, and for unknown names it assigns roles.
    let both = "x,y,z,ra,dec\n1,0,0,90,0\n";
    assert_eq!(read_as("p.csv", both, "ra,dec").unwrap().sets[0].points, [DVec3::Y]);
    let foreign = "azimuth,elevation\n90,0\n";
    assert_eq!(read_as("p.csv", foreign, "lon,lat").unwrap().sets[0].points, [DVec3::Y]);
}

#[test]
fn sets_by_column_by_hash_and_by_array() {
    let by_column = read("p.csv", "set,x,y,z,w\n7,1,0,0,1\n3,0,1,0,2\n7,0,0,1,3\n");
    assert_eq!(by_column.sets.len(), 2);
    assert_eq!(by_column.sets[0].points, [DVec3::X, DVec3::Z]);
    assert_eq!(by_column.sets[0].weights, [1.0, 3.0]);
    assert_eq!(by_column.sets[1].points, [DVec3::Y]);

    let by_hash = read("p.txt", "#\n1 0 0\n0 1 0\n#\n#\n0 0 1\n#\n");
    let counts: Vec<usize> = by_hash.sets.iter().map(|set| set.points.len()).collect();
    assert_eq!(counts, [2, 1]);
    assert!(by_hash.warnings.is_empty());

    let by_words = read("p.txt", "# one\n1 0 0\n# two\n0 0 1\n# end\n");
    assert_eq!(by_words.sets.len(), 1);
    assert!(by_words.warnings[0].contains("line 3 is a comment between points"), "{by_words:?}");

    let dictionary = "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 1, 3), }";
    let array = read("p.npy", npy(dictionary, &doubles(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0])));
    assert_eq!(array.sets.len(), 2);
    assert_eq!(array.sets[1].points, [DVec3::Y]);
}

#[test]
fn arrays_of_other_layouts() {
    let fortran = "{'descr': '<f8', 'fortran_order': True, 'shape': (2, 3), }";
    let back = read("p.npy", npy(fortran, &doubles(&[1.0, 0.0, 0.0, 1.0, 0.0, 0.0])));
    assert_eq!(back.sets[0].points, [DVec3::X, DVec3::Y]);

    let single = "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 3), }";
    let floats: Vec<u8> = [0.6_f32, 0.8, 0.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let back = read("p.npy", npy(single, &floats));
    assert!(back.warnings.is_empty(), "{:?}", back.warnings);
    let length = back.sets[0].points[0].length();
    assert!((length - 1.0).abs() <= 2.0 * f64::EPSILON, "{length}");

    let big = "{'descr': '>f8', 'fortran_order': False, 'shape': (1, 3), }";
    let numbers: Vec<u8> = [0.0_f64, 0.0, -1.0].iter().flat_map(|x| x.to_be_bytes()).collect();
    assert_eq!(read("p.npy", npy(big, &numbers)).sets[0].points, [DVec3::NEG_Z]);

    let plain = "{'descr': '<f8', 'fortran_order': False, 'shape': (1, 3), }";
    let back = read("p.npy", npy(plain, &doubles(&[1.0, 0.0, 0.0, 9.0])));
    assert!(back.warnings[0].contains("bytes follow the array"), "{:?}", back.warnings);
}

#[test]
fn meshes_of_other_programs() {
    let text = "ply\nformat ascii 1.0\ncomment by hand\nelement camera 1\nproperty float f\n\
                element vertex 2\nproperty uchar red\nproperty float x\nproperty float y\n\
                property float z\nproperty float value\nelement face 1\n\
                property list uchar int vertex_indices\nend_header\n\
                0.5\n255 1 0 0 4\n0 0 0 -1 5\n3 0 1 0\n";
    let back = read("p.ply", text);
    assert_eq!(back.sets[0].points, [DVec3::X, DVec3::NEG_Z]);
    assert_eq!(back.remarks, ["p.ply: columns not used: red,value"]);

    let mut binary = b"ply\nformat binary_big_endian 1.0\nelement vertex 1\nproperty list uchar \
        short tags\nproperty double x\nproperty float y\nproperty int z\nend_header\n"
        .to_vec();
    binary.extend([2, 0, 1, 0, 2]);
    binary.extend(0.0_f64.to_be_bytes());
    binary.extend(0.0_f32.to_be_bytes());
    binary.extend((-3_i32).to_be_bytes());
    let options = ReadOptions { normalize: true, ..ReadOptions::default() };
    let back = read_with("scan.bin", binary, &options).unwrap();
    assert_eq!(back.sets[0].points, [DVec3::NEG_Z]);
    assert!(back.warnings.is_empty(), "{:?}", back.warnings);
}

#[test]
fn lengths_are_mended_and_counted() {
    let content = format!(
        "x,y,z\n3,0,4\n1e-300,0,0\n0,1e200,1e200\n0,0,1.0000001\n5e-324,0,0\n{}",
        "0,1,0\n".repeat(4)
    );
    let back = read("p.csv", content);
    for direction in &back.sets[0].points {
        assert!((direction.length() - 1.0).abs() <= 2.0 * f64::EPSILON, "{direction}");
    }
    assert_eq!(back.warnings.len(), 1);
    assert!(back.warnings[0].contains("4 of 9 vectors"), "{:?}", back.warnings);
    assert!(back.warnings[0].contains("p.csv:6, length"), "{:?}", back.warnings);
}
