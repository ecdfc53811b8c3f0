//! Catalogues of points: columns, tables, compression, parts and weights.

use std::path::Path;

use crate::outcome::numbers;
use crate::workplace::Workplace;

/// Path of a file of `tests/data`; `benches/peers/point_catalogues.py` wrote these.
fn catalogue(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name);
    path.to_str().unwrap().to_owned()
}

/// Returns the power of the catalogue for l = 0, 1, ...: a direct sum over its points with the
/// harmonics of scipy.
fn reference() -> Vec<f64> {
    let text = std::fs::read_to_string(catalogue("catalogue_spectrum.csv")).unwrap();
    text.lines().skip(1).map(|line| line.split_once(',').unwrap().1.parse().unwrap()).collect()
}

#[test]
fn text_tables_and_their_compressed_copies_have_one_spectrum() {
    let place = Workplace::new();
    let names = "--columns ra=RAJ2000,dec=DEJ2000,w=WEIGHT";
    let mut first = None;
    for (file, columns) in [
        ("catalogue.csv", names),
        ("catalogue.csv", "--columns ra,dec,w"),
        ("catalogue.fits", names),
        ("catalogue.fits[1]", ""),
        ("catalogue.fits", "--hdu 1"),
        ("catalogue.fits.gz", names),
        ("catalogue.fits.gz", "--columns ra,dec,w,_"),
    ] {
        let file = catalogue(file);
        let run = place.run(&format!("spectrum --points {file} {columns} --lmax 24 --json"));
        assert!(run.stderr.contains("column not used: Z"), "{}", run.stderr);
        let document = run.json();
        let power = numbers(&document["power"]);
        for (l, (got, expected)) in power.iter().zip(reference()).enumerate() {
            assert!((got - expected).abs() < 1e-12 * expected.max(1.0), "{l}: {got}, {expected}");
        }
        assert_eq!(power.len(), 25);
        assert_eq!(*first.get_or_insert_with(|| power.clone()), power, "{file} {columns}");
        assert_eq!(document["n"], 120);
        // P(0) is the effective number of points.
        let n_effective = document["n_effective"].as_f64().unwrap();
        assert!((n_effective - power[0]).abs() < 1e-12 * n_effective, "{document}");
        assert!(document["sum_w"].is_number() && document["sum_w2"].is_number());
        assert!(document["stderr"].as_array().unwrap().iter().all(serde_json::Value::is_null));
    }
    let text =
        place.run(&format!("spectrum --points {} --lmax 3", catalogue("catalogue.csv"))).ok();
    assert!(text.stdout.contains("N_eff = 109.2 "), "{}", text.stdout);
    assert!(text.stdout.lines().nth(1).unwrap().ends_with('-'), "no error: {}", text.stdout);
    // Without weights, no remark mentions them.
    let plain = place.run(&format!(
        "spectrum --points {} --columns ra,dec,_,_ --lmax 3 --json",
        catalogue("catalogue.fits")
    ));
    assert!(plain.json().get("n_effective").is_none());
}

#[test]
fn parts_are_joined_or_are_realizations() {
    let place = Workplace::new();
    let text = std::fs::read_to_string(catalogue("catalogue.csv")).unwrap();
    let (header, rows) = text.split_once('\n').unwrap();
    let rows: Vec<&str> = rows.lines().collect();
    for (name, part) in [("a.csv", &rows[..50]), ("b.csv", &rows[50..])] {
        place.write(name, format!("{header}\n{}\n", part.join("\n")));
    }
    let joined = place.run("spectrum --points a.csv b.csv --join --lmax 24 --json").json();
    assert_eq!((&joined["n"], &joined["realizations"]), (&120.into(), &1.into()));
    for (got, expected) in numbers(&joined["power"]).iter().zip(reference()) {
        assert!((got - expected).abs() < 1e-12 * expected.max(1.0), "{got}, {expected}");
    }
    let apart = place.run("spectrum --points a.csv b.csv --lmax 4 --json");
    assert!(
        apart.stderr.contains("2 realizations read, 50 to 70 points")
            && apart.stderr.contains("--join"),
        "{}",
        apart.stderr
    );
    let document = apart.json();
    assert_eq!(document["realizations"], 2);
    assert!(document["stderr"][1].is_number());
    place.write("c.csv", "ra,dec\n1,2\n");
    place
        .run("spectrum --points a.csv c.csv --join --lmax 4")
        .fails(1, &["--join", "c.csv has no weights"]);
}

#[test]
fn rows_that_cannot_be_used() {
    let place = Workplace::new();
    place.write("p.csv", "ra,dec,w\n0,0,1\n,,\n120,5,2\n7,NaN,1\n");
    place.run("spectrum --points p.csv --lmax 4").fails(1, &["p.csv:3", "ra", "--skip-invalid"]);
    let run = place.run("spectrum --points p.csv --lmax 4 --skip-invalid --json");
    assert!(
        run.stderr.contains("2 of 4 rows skipped as invalid: p.csv:3, p.csv:5"),
        "{}",
        run.stderr
    );
    assert_eq!(run.json()["n"], 2);
}

#[test]
fn columns_are_checked_before_files_are_read() {
    let place = Workplace::new();
    for (columns, part) in [
        ("ra,dec,wieght", "unknown \"wieght\"; expected x, y, z,"),
        ("ra,w", "expected all of x,y,z"),
        ("ra,dec,w=W", "not both"),
    ] {
        place
            .run(&format!("spectrum --points none.csv --columns {columns}"))
            .fails(2, &["--columns", part]);
    }
    for flag in ["--join", "--normalize", "--skip-invalid", "--hdu 1", "--columns x,y,z"] {
        let name = flag.split(' ').next().unwrap();
        let parts = [name, "cannot be used with", "SAMPLER"];
        place.run(&format!("spectrum jittered -n 12 {flag}")).fails(2, &parts);
    }
    for (flag, name) in
        [("-n 12", "--count"), ("-m 50", "--realizations"), ("--nearest", "--nearest")]
    {
        let parts = [name, "cannot be used with", "--points"];
        for command in ["spectrum", "audit"] {
            place.run(&format!("{command} --points none.csv {flag}")).fails(2, &parts);
        }
    }
}
