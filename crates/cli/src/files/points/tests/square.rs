//! Points of the unit square: the same formats with two columns.

use super::super::{PointFile, ReadOptions, read_points, write_points};
use super::{doubles, file, npy, read, read_as};
use sphvar_samplers::PointSet;

/// Returns the file as points of the square, or the message of the error without the folder.
fn square(
    name: &str,
    content: impl AsRef<[u8]>,
    columns: Option<&str>,
) -> Result<PointFile<[f64; 2]>, String> {
    let (folder, path) = file(name, content);
    let columns = columns.map(str::parse).transpose()?;
    read_points(&path, &ReadOptions { columns, ..ReadOptions::default() })
        .map_err(|error| error.to_string().replace(&format!("{}/", folder.path().display()), ""))
}

fn array(shape: &str, numbers: &[f64]) -> Vec<u8> {
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}");
    npy(&header, &doubles(numbers))
}

#[test]
fn every_format_keeps_every_bit_of_the_square() {
    let below = 1.0 - f64::EPSILON / 2.0;
    let points = vec![[0.0, below], [5e-324, 0.5], [1.0 / 3.0, 1e-300], [below, 0.0]];
    let one = [PointSet::new(points.clone())];
    let weighted = PointSet { points, weights: vec![1.0, -0.5, 1e300, 0.0] };
    let (single, two) = ([weighted.clone()], [weighted.clone(), weighted]);
    for extension in ["csv", "npy", "npz", "ply"] {
        for sets in [&one[..], &single[..], &two[..]] {
            if extension == "npy" && !sets[0].weights.is_empty() {
                continue;
            }
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join(format!("points.{extension}"));
            write_points(&path, None, sets, Some("a remark")).unwrap();
            let back = read_points::<[f64; 2]>(&path, &ReadOptions::default()).unwrap();
            assert_eq!(back.sets, sets, "{extension}");
            assert!(back.warnings.is_empty() && back.remarks.is_empty(), "{extension}");
        }
    }
}

#[test]
fn two_columns_in_every_dialect() {
    let flat = [0.25, 0.5, 0.0, 0.75];
    let cases: [(&str, Vec<u8>, Option<&str>, usize); 12] = [
        ("p.csv", "u,v\n0.25,0.5\n0,0.75\n".into(), None, 1),
        ("p.csv", "v;x;U\n0.5;7;0.25\n0.75;7;0\n".into(), None, 1),
        ("p.csv", "X,Y\n0.25,0.5\n0,0.75\n".into(), None, 1),
        ("p.txt", "0.25 0.5\n0 0.75\n".into(), None, 1),
        ("p.txt", "0.25 0.5\n#\n0 0.75\n".into(), None, 2),
        ("p.txt", "0.5 0.25 9\n0.75 0 9\n".into(), Some("v,u,_"), 1),
        ("p.csv", "a,b\n0.25,0.5\n0,0.75\n".into(), Some("u=a,v=b"), 1),
        ("p.npy", array("(2, 2)", &flat), None, 1),
        ("p.npy", array("(2, 1, 2)", &flat), None, 2),
        ("p.npy", array("(2, 3)", &[0.25, 9.0, 0.5, 0.0, 9.0, 0.75]), Some("u,_,v"), 1),
        ("p.json", r#"{"points": [[[0.25, 0.5]], [[0, 0.75]]]}"#.into(), None, 2),
        (
            "p.ply",
            "ply\nformat ascii 1.0\nelement vertex 2\nproperty double u\nproperty double v\n\
             end_header\n0.25 0.5\n0 0.75\n"
                .into(),
            None,
            1,
        ),
    ];
    for (name, content, columns, sets) in cases {
        let text = String::from_utf8_lossy(&content).into_owned();
        let file = square(name, content, columns).unwrap_or_else(|e| panic!("{text}: {e}"));
        assert_eq!(file.sets.len(), sets, "{text}");
        let points: Vec<[f64; 2]> = file.sets.into_iter().flat_map(|set| set.points).collect();
        assert_eq!(points, [[0.25, 0.5], [0.0, 0.75]], "{text}");
    }
    let options = ReadOptions { normalize: true, ..ReadOptions::default() };
    let (_folder, path) = file("p.csv", "u,v\n1,-0.25\n-1e-300,3.5\n");
    let wrapped = read_points::<[f64; 2]>(&path, &options).unwrap();
    assert_eq!(wrapped.sets[0].points, [[0.0, 0.75], [0.0, 0.5]]);
    let weighted = square("p.csv", "u,v,w,set\n0,0,-2,a\n0,0,3,b\n0.5,0,4,a\n", None).unwrap();
    assert_eq!(weighted.sets[0].weights, [-2.0, 4.0]);
    assert_eq!(weighted.sets[1].points, [[0.0, 0.0]]);
}

/// A file, its content, the value of `--columns`, and parts of the message.
type Case<'a> = (&'a str, Vec<u8>, Option<&'a str>, &'a [&'a str]);

#[test]
fn errors_name_the_place_and_the_remedy() {
    let cases: [Case<'_>; 12] = [
        ("p.csv", "u,v\n0,0\n1,0.5\n".into(), None, &["p.csv:3", "u", "excludes 1", "got \"1\""]),
        ("p.csv", "u,v\n0,1.5\n".into(), None, &["p.csv:2", "v", "in [0, 1) (--normalize", "1.5"]),
        ("p.csv", "u,v\n-1e-300,0\n".into(), None, &["p.csv:2", "in [0, 1)"]),
        ("p.csv", "u,v\n0,NaN\n".into(), None, &["p.csv:2", "v", "a finite number", "NaN"]),
        ("p.csv", "u,v\n0,\n".into(), None, &["p.csv:2", "v", "a finite number"]),
        ("p.csv", "x,y,z\n1,0,0\n".into(), None, &["x,y,z", "without --square"]),
        ("p.txt", "1 0 0\n".into(), None, &["2 fields (u v)", "3 fields", "without --square"]),
        ("p.csv", "ra,dec\n10,20\n".into(), None, &["u,v or x,y", "ra,dec"]),
        ("p.csv", "u,w\n0.5,1\n".into(), None, &["the column v", "u,w"]),
        ("p.npy", array("(1, 3)", &[0.0; 3]), None, &["(N, 2) or (M, N, 2)", "without --square"]),
        ("p.npy", array("(2, 5)", &[0.0; 10]), None, &["(N, 2)", "array.T"]),
        (
            "p.csv",
            "u,v\n0,0\n".into(),
            Some("ra,dec"),
            &["--columns with u,v or x,y", "got ra,dec"],
        ),
    ];
    for (name, content, columns, parts) in cases {
        let text = String::from_utf8_lossy(&content).into_owned();
        let message = square(name, content, columns).unwrap_err();
        for part in parts {
            assert!(message.contains(part), "{text}: {part} is not in: {message}");
        }
    }
}

/// Coordinates in a box are not taken modulo 1 by accident.
#[test]
fn coordinates_in_a_larger_box_are_divided_by_its_period() {
    let message = square("p.csv", "u,v\n0.5,0.5\n120.5,33\n", None).unwrap_err();
    assert!(message.contains("p.csv:3") && message.contains("by its period"), "{message}");
    assert!(!message.contains("--normalize"), "{message}");
    let normalized = |text: &str| {
        let (_folder, path) = file("p.csv", text);
        let options = ReadOptions { normalize: true, ..ReadOptions::default() };
        read_points::<[f64; 2]>(&path, &options).unwrap()
    };
    let far = normalized("u,v\n120.5,33\n-0.25,1.5\n0.5,-7\n");
    assert!(far.warnings[0].contains("2 of 3 points"), "{:?}", far.warnings);
    assert!(normalized("u,v\n1,-0.25\n1.75,0\n").warnings.is_empty());
}

/// `u` and `v` are magnitudes in catalogues, possibly twice.
#[test]
fn files_of_directions_may_have_columns_u_and_v() {
    let file = read("p.csv", "ra,dec,u,U,v\n0,90,12.5,12.6,11\n");
    assert_eq!(file.sets[0].points, [glam::DVec3::Z]);
    let error = super::error("p.csv", "u,v\n0.5,0.5\n");
    assert!(error.contains("got the columns u,v; points of the unit square"), "{error}");
    let error = read_as("p.txt", "0.5 0.5\n", "u,v").unwrap_err();
    assert!(error.contains("--square"), "{error}");
    let error = square("p.csv", "u,v,U\n0,0,0\n", None).unwrap_err();
    assert!(error.contains("the column u once"), "{error}");
}
