//! One case for every message: the defect, its place, and the expected content.

use std::fs;

use glam::DVec3;
use sphvar_samplers::PointSet;

use super::super::{PointFormat, ReadOptions, read_points, write_points};
use super::{doubles, error, hostile, npy, read_as};

/// Returns fifteen valid rows after the header, so that the next row is line 17.
fn seventeen(header: &str, good: &str, bad: &str) -> String {
    format!("{header}\n{}{bad}\n", format!("{good}\n").repeat(15))
}

#[test]
fn bad_values_are_named_with_file_line_and_field() {
    let cases = [
        ("x,y,z", "1,0,0", "NaN,0,1", "x: expected a finite number, got \"NaN\""),
        ("x,y,z", "1,0,0", "0,-inf,1", "y: expected a finite number, got \"-inf\""),
        ("x,y,z", "1,0,0", "0,0,one", "z: expected a finite number, got \"one\""),
        ("x,y,z", "1,0,0", "0,,1", "y: expected a finite number, got \"\""),
        ("x,y,z", "1,0,0", "0,1e999,1", "y: expected a finite number, got \"1e999\""),
        (
            "x y z",
            "1 0 0",
            "0 0 -0",
            "x, y, z: expected a vector that has a direction, got the zero vector",
        ),
        ("x,y,z", "1,0,0", "0,1", " expected 3 fields (x, y, z), got 2"),
        ("x,y,z,w", "1,0,0,1", "0,1,0,nan", "w: expected a finite number, got \"nan\""),
        ("x,y,z,weight", "1,0,0,1", "0,1,0,inf", "w: expected a finite number, got \"inf\""),
        ("theta,phi", "1,0", "3.2,0", "theta: expected a colatitude in [0, pi] radians"),
        ("theta,phi", "1,0", "-0.1,0", "theta: expected a colatitude in [0, pi] radians"),
        ("theta,phi", "1,0", "1,nan", "phi: expected a finite number, got \"nan\""),
        ("lon,lat", "1,0", "0,90.5", "lat: expected an angle in [-90, 90] degrees, got \"90.5\""),
        ("ra,dec", "1,0", "0,-91", "dec: expected an angle in [-90, 90] degrees, got \"-91\""),
        ("ra,dec", "1,0", "inf,1", "ra: expected a finite number, got \"inf\""),
    ];
    for (header, good, bad, expected) in cases {
        let message = error("stars.csv", seventeen(header, good, bad));
        let (place, rest) = message.split_at("stars.csv:17:".len());
        assert_eq!(place, "stars.csv:17:", "{message}");
        assert!(rest.trim_start().starts_with(expected.trim_start()), "{message}\n{expected}");
    }
}

#[test]
fn errors_of_layouts_state_the_expected_content() {
    let cases: [(&str, &[u8], &str); 16] = [
        ("p.csv", b"", "p.csv: no points"),
        ("p.csv", b"x,y,z\n# nothing\n", "p.csv: no points"),
        ("p.npy", b"", "p.npy: no points"),
        ("p.ply", b"", "p.ply: no points"),
        ("p.csv", b"1 2\n", "p.csv:1: expected 3 fields (x y z), or a header, or names by the option --columns such as --columns theta,phi"),
        ("p.csv", b"1 2 3 4\n", "--columns x,y,z,w, got 4 fields without a header"),
        ("p.csv", b"x,y,magnitude\n1,2,3\n", "p.csv:1: expected the column z beside the others of x,y,z, got the columns x,y,magnitude"),
        ("p.csv", b"theta\n1\n", "expected the column phi"),
        ("p.csv", b"a,b,c\n1,2,3\n", "expected columns named x,y,z or theta,phi"),
        ("p.csv", b"x,y,z,x\n1,2,3,4\n", "expected the column x once"),
        ("p.csv", b"x,y,z,w,weight\n1,2,3,4,5\n", "expected the column w once"),
        ("p.csv", b"x,y,z,lon,lat\n1,2,3,4,5\n", "expected one way to name the point, chosen by the option --columns"),
        ("p.csv", b"x,y,z\n1,0,0\n\xff\xfe,0,0\n", "p.csv:3: expected UTF-8 text"),
        ("p.npy", b"x,y,z\n1,0,0\n", "expected the magic bytes of an NPY file"),
        ("p.ply", b"x,y,z\n1,0,0\n", "expected a PLY header"),
        ("p.ply", b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float z\nend_header\n1 0\n", "expected the column y beside the others of x,y,z, got the columns x,z"),
    ];
    for (name, content, expected) in cases {
        let message = error(name, content);
        assert!(message.contains(expected), "{message}\n{expected}");
    }
    let message = read_as("p.csv", "x,y,z\n1,0,0\n", "lon,lat").unwrap_err();
    assert!(
        message.contains("the column lon named in --columns, got the header x,y,z"),
        "{message}"
    );
    let message = read_as("p.txt", "1 2 3\n", "lon,lat").unwrap_err();
    assert!(message.contains("expected 2 fields for --columns lon,lat, got 3"), "{message}");
}

#[test]
fn errors_of_arrays_state_the_expected_content() {
    let shape = |descr: &str, shape: &str| {
        format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}")
    };
    let numbers = doubles(&[1.0, 0.0, 0.0, 0.0, f64::NAN, 0.0]);
    let cases = [
        (npy(&shape("<f8", "(2, 3)"), &numbers), "p.npy[1]: y: expected a finite number, got NaN"),
        (npy(&shape("<f8", "(2, 1, 3)"), &numbers), "p.npy[1, 0]: y: expected a finite number"),
        (npy(&shape("<f8", "(2, 3)"), &[0; 48]), "p.npy[0]: x, y, z: expected a vector"),
        (npy(&shape("<f8", "(3, 2)"), &numbers), "shape (N, 3) or (M, N, 3), got the shape (3, 2)"),
        (npy(&shape("<f8", "(6,)"), &numbers), "got the shape (6,)"),
        (npy(&shape("<c8", "(2, 3)"), &numbers), "float32, or integers, got the type '<c8'"),
        (npy(&shape("|O", "(2, 3)"), &numbers), "float64 or float32"),
        (npy(&shape("<f8", "(0, 3)"), &[]), "p.npy: no points"),
        (npy(&shape("<f8", "(99999999999999, 0, 3)"), &[]), "p.npy: no points"),
        (npy(&shape("<f8", "(99999999999, 99999999999, 3)"), &[]), "plain decimal shape"),
        (npy(&shape("<f8", "(0xffffffffffff, 0xffffffffffff, 3)"), &[]), "plain decimal shape"),
        (npy(&"(".repeat(2000), &[]), "expected an NPY header"),
        (npy("{'descr': '<f8'}", &[]), "expected an NPY header"),
        (b"\x93NUMPY\x07\x00".to_vec(), "version 1, 2 or 3, got version 7"),
        (
            b"\x93NUMPY\x02\x00\xff\xff\xff\xff".to_vec(),
            "a header of at most 65536 bytes, got 4294967295",
        ),
    ];
    for (content, expected) in cases {
        let message = error("p.npy", content);
        assert!(message.contains(expected), "{message}\n{expected}");
    }
}

#[test]
fn truncated_files_count_their_bytes() {
    let folder = tempfile::tempdir().unwrap();
    for extension in ["npy", "ply"] {
        let path = folder.path().join(format!("p.{extension}"));
        write_points(&path, None, &[PointSet::new(hostile())], None).unwrap();
        let whole = fs::read(&path).unwrap();
        let mut in_data = 0;
        for length in 1..whole.len() {
            fs::write(&path, &whole[..length]).unwrap();
            let message =
                read_points::<DVec3>(&path, &ReadOptions::default()).unwrap_err().to_string();
            assert!(message.contains("expected"), "{extension} cut to {length}: {message}");
            if message.contains(&format!("expected {} bytes, got {length} (", whole.len())) {
                in_data += 1;
            }
        }
        // Ten points of three doubles; the reader may see only complete elements of a truncated
        // file.
        assert!(in_data >= 30, "{extension}: {in_data} messages with both counts");
    }
    let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                property float z\nend_header\n1 0 0\n0 1 0\n";
    let message = error("p.ply", text);
    assert!(message.contains("expected 3 rows of vertex"), "{message}");
    assert!(message.contains("got 2"), "{message}");
}

#[test]
fn hostile_meshes_terminate_quickly() {
    let header =
        |elements: &str| format!("ply\nformat binary_little_endian 1.0\n{elements}end_header\n");
    let xyz = "property double x\nproperty double y\nproperty double z\n";
    let cases = [
        (format!("element vertex 999999999999999999\n{xyz}"), "truncated"),
        (format!("element void 999999999999999999\nelement vertex 1\n{xyz}"), "void without any"),
        (
            format!("element vertex 1\n{xyz}property list uint double value\n"),
            "expected 1 rows of vertex",
        ),
        ("element face 1\nproperty int a\n".to_owned(), "expected the element vertex"),
    ];
    for (elements, expected) in cases {
        let message = error("p.ply", header(&elements));
        assert!(message.contains(expected), "{message}\n{expected}");
    }
    let mut bytes = header(&format!("element vertex 1\n{xyz}")).into_bytes();
    bytes.extend(doubles(&[0.0, 1.0, f64::INFINITY]));
    let message = error("p.ply", bytes);
    assert!(message.contains("p.ply: vertex 0: z: expected a finite number, got inf"), "{message}");
}

#[test]
fn outputs_that_cannot_be() {
    let folder = tempfile::tempdir().unwrap();
    let sets = [vec![DVec3::X], vec![DVec3::Y, DVec3::Z]].map(PointSet::new);
    let cases = [
        ("p.xls", &sets[..1], "expected a name that ends in one of .csv, .npy, .npz, .ply"),
        ("p", &sets[..1], "expected a name that ends in one of .csv, .npy, .npz, .ply"),
        ("p.csv", &sets[..0], "there is no set of points to write"),
        ("p.npy", &sets[..], "the sets differ in size"),
        ("no/p.npy", &sets[..1], "does not exist; create it first"),
    ];
    for (name, sets, expected) in cases {
        let path = folder.path().join(name);
        let message = write_points(&path, None, sets, None).unwrap_err().to_string();
        assert!(message.contains(expected), "{message}\n{expected}");
        assert!(message.contains(&path.display().to_string()), "{message}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "something was left behind");

    // The same sets are valid as a table, and a format may be forced.
    let path = folder.path().join("p.list");
    write_points(&path, Some(PointFormat::Csv), &sets, None).unwrap();
    let back = read_points::<DVec3>(&path, &ReadOptions::default()).unwrap();
    assert_eq!(back.sets[1].points, [DVec3::Y, DVec3::Z]);
}

#[test]
fn missing_file_and_folder_are_named() {
    let folder = tempfile::tempdir().unwrap();
    for path in [folder.path().join("none.csv"), folder.path().to_path_buf()] {
        let message = read_points::<DVec3>(&path, &ReadOptions::default()).unwrap_err().to_string();
        assert!(message.starts_with(&format!("cannot open {}", path.display())), "{message}");
    }
}
