//! The unit square: `--square` of `sample`, `spectrum`, `quality` and `list`, and its files.

use crate::workplace::Workplace;

/// Returns the rows of a CSV file below its header.
fn rows(text: &str) -> Vec<Vec<f64>> {
    let lines = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    lines.map(|line| line.split(',').map(|x| x.parse().unwrap()).collect()).collect()
}

#[test]
fn sets_are_the_same_in_every_form() {
    let place = Workplace::new();
    let run = "sample jittered-square --square -n 16 -m 3 -s 7";
    place.run(&format!("{run} -o p.csv")).ok();
    let text = place.text("p.csv");
    assert!(text.starts_with("u,v,set\n"), "{text}");
    let points: Vec<[f64; 2]> = rows(&text).iter().map(|row| [row[0], row[1]]).collect();
    assert_eq!(points.len(), 48);
    // One point in each cell of the 4 x 4 grid.
    for set in points.chunks(16) {
        let mut cells: Vec<[u32; 2]> = set
            .iter()
            .map(|p| p.map(|x| (1..4).filter(|&i| 4.0 * x >= f64::from(i)).count() as u32))
            .collect();
        cells.sort_unstable();
        cells.dedup();
        assert_eq!(cells.len(), 16);
    }
    for name in ["p.npy", "p.npz", "p.ply"] {
        place.run(&format!("{run} -o {name}")).ok();
        place.run(&format!("sample file:{name} --square -o back.csv")).ok();
        assert_eq!(place.text("back.csv"), text, "{name}");
    }
    let document = place.run(&format!("{run} --json")).json();
    let set = document["points"][2].as_array().unwrap();
    let last: Vec<f64> = set[15].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
    assert_eq!(last, points[47]);
    assert_eq!(place.run(run).ok().stdout, text);
    place.run(&format!("{run} -o set-{{i}}.csv")).ok();
    assert!(place.text("set-000002.csv").starts_with("u,v\n"));
    for name in ["p.svg", "p.png"] {
        place.run(&format!("{run} -o {name}")).ok();
    }
}

/// A shift moves all points of a set by one vector modulo 1.
#[test]
fn shifts_are_of_whole_sets() {
    let place = Workplace::new();
    place.write("p.csv", "u,v,w\n0,0.5,1\n0.25,0.75,-2\n");
    place.run("sample file:p.csv --square --shift -o s.csv").ok();
    let text = place.text("s.csv");
    assert!(text.starts_with("u,v,w\n"), "{text}");
    let moved = rows(&text);
    for axis in 0..2 {
        let step = (moved[1][axis] - moved[0][axis]).rem_euclid(1.0);
        assert!((step - 0.25).abs() < 1e-15, "{text}");
        assert!((0.0..1.0).contains(&moved[0][axis]));
    }
    assert!(moved[0][0] > 0.0 && (moved[1][2] + 2.0).abs() < 1e-300);
}

#[test]
fn errors_name_the_other_space() {
    let place = Workplace::new();
    place.write("sphere.csv", "x,y,z\n1,0,0\n");
    place.write("edge.csv", "u,v\n0.5,1.0\n");
    let square = "--square -n 16";
    for (arguments, parts) in [
        ("sample jittered-square -n 16", &["jittered-square", "--square"][..]),
        ("bounds white-square -n 16", &["white-square", "--square"]),
        ("audit white-square -n 16 -m 40", &["white-square", "--square"]),
        (
            &format!("sample jittered {square}"),
            &["jittered", "pattern of the sphere", "white-square"],
        ),
        (&format!("sample sobl {square}"), &["sobl", "sobol"]),
        (&format!("sample sobol {square} --hemisphere"), &["--hemisphere", "--square"]),
        (&format!("sample sobol {square} --rotate"), &["--rotate", "shifted"]),
        ("sample sobol -n 16 --shift", &["--square"]),
        (&format!("sample jittered-square {square}5"), &["169", "--nearest"]),
    ] {
        place.run(arguments).fails(2, parts);
    }
    place.run("sample file:sphere.csv --square").fails(1, &["sphere.csv:1", "without --square"]);
    place
        .run("sample file:edge.csv --square")
        .fails(1, &["edge.csv:2", "excludes 1", "normalize=yes"]);
    place.run("sample file:edge.csv,normalize=yes --square").ok();
}
