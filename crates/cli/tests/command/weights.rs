//! Quadrature weights of points in files, and quadrature rules as samplers.

use serde_json::Value;

use crate::outcome::keys;
use crate::workplace::Workplace;

fn number(document: &Value, key: &str) -> f64 {
    document[key].as_f64().unwrap_or_else(|| panic!("{key}: {document}"))
}

/// Returns the largest power of degrees 1 to `last` of weighted points in a file.
fn largest_power(place: &Workplace, file: &str, last: usize) -> f64 {
    let spectrum = format!("spectrum --points {file} --lmax {last} --method exact --json --quiet");
    let document = place.run(&spectrum).json();
    let powers = document["power"].as_array().unwrap();
    powers[1..].iter().map(|p| p.as_f64().unwrap()).fold(0.0, f64::max)
}

#[test]
fn weights_are_exact_and_read_back() {
    let place = Workplace::new();
    place.run("sample white-noise -n 500 -o points.npy").ok();
    let document = place.run("weights points.npy --degree 15 --json -o rule.npz").json();
    let expected = [
        "points",
        "n",
        "n_distinct",
        "degree",
        "nonnegative",
        "residual",
        "min_weight",
        "max_weight",
        "condition",
        "n_effective",
        "exact_degree",
        "iterations",
        "provenance",
    ];
    assert_eq!(keys(&document), expected);
    assert!(number(&document, "residual") < 1e-13, "{document}");
    assert_eq!((document["n"].as_u64(), document["degree"].as_u64()), (Some(500), Some(15)));
    assert_eq!(document["exact_degree"], 15);
    assert!(number(&document, "min_weight") < 0.0 && number(&document, "condition") > 2.0);
    // Amplitudes of 1e-14 of N.
    assert!(largest_power(&place, "rule.npz", 15) < 1e-24);
    assert!(largest_power(&place, "rule.npz", 16) > 0.01);

    place.run("sample white-noise -n 300 -s 3 -o spread.csv").ok();
    let any = place.run("weights spread.csv --degree 8 --json -o any.csv").json();
    let signed = "weights spread.csv --degree 8 --nonnegative --json -o rule.csv";
    let document = place.run(signed).json();
    assert!(number(&any, "min_weight") < 0.0 && number(&document, "min_weight") >= 0.0);
    assert!(number(&document, "residual") < 1e-13, "{document}");
    assert!(place.text("rule.csv").starts_with("x,y,z,w\n"));
    assert!(largest_power(&place, "rule.csv", 8) < 1e-24);
    // The same bytes for any number of threads.
    place.run("weights spread.csv --degree 8 -o again.csv --threads 3 --quiet").ok();
    assert_eq!(place.bytes("again.csv"), place.bytes("any.csv"));
}

#[test]
fn weights_go_to_standard_output_or_into_the_document() {
    let place = Workplace::new();
    place.run("sample fibonacci -n 40 -o p.csv").ok();
    let text = place.run("weights p.csv --degree 3").ok().stdout;
    assert!(text.starts_with("40 points, weights of least norm exact to degree 3\n"), "{text}");
    let csv = place.run("weights p.csv --degree 3 -o -").ok().stdout;
    assert_eq!(csv.lines().count(), 41);
    let document = place.run("weights p.csv --degree 3 --json -o -").json();
    assert_eq!(document["weights"].as_array().unwrap().len(), 40);
    assert_eq!(place.run("weights p.csv --degree 3 --json").json()["weights"], document["weights"]);
    let sum: f64 = csv.lines().skip(1).map(|l| l.rsplit(',').next().unwrap()).map(float).sum();
    assert!((sum / (4.0 * std::f64::consts::PI) - 1.0).abs() < 1e-14, "{sum}");
    // On the hemisphere the sum is 2 pi, and only even degrees count.
    let half = place.run("weights p.csv --degree 6 --hemisphere --json").json();
    let weights = half["weights"].as_array().unwrap();
    let sum: f64 = weights.iter().map(|w| w.as_f64().unwrap()).sum();
    assert!((sum / (2.0 * std::f64::consts::PI) - 1.0).abs() < 1e-14, "{sum}");
    // Without a degree, the largest that converges.
    let largest = place.run("weights p.csv --json").json();
    assert!((4..=5).contains(&largest["degree"].as_u64().unwrap()), "{largest}");
}

fn float(text: &str) -> f64 {
    text.parse().unwrap()
}

#[test]
fn impossible_degrees_name_the_largest_one() {
    let place = Workplace::new();
    place.run("sample white-noise -n 100 -o p.csv").ok();
    place.run("weights p.csv --degree 10").fails(2, &["121 distinct points", "in general is 9"]);
    place
        .run("weights p.csv --degree 14 --hemisphere")
        .fails(2, &["120 distinct points", "in general is 12"]);
    // All points on a cap of 20 degrees.
    let cap: Vec<String> = (0..100)
        .map(|k| {
            let (sin, cos) = (2.4 * f64::from(k)).sin_cos();
            let z = 1.0 - 6e-4 * f64::from(k);
            let s = (1.0 - z * z).sqrt();
            format!("{},{},{z}\n", s * cos, s * sin)
        })
        .collect();
    place.write("cap.csv", cap.concat());
    place
        .run("weights cap.csv --degree 8")
        .fails(1, &["do not converge", "condition number", "the largest degree that works is"]);
    place.run("weights p.csv --degree 9 --nonnegative").fails(1, &["largest degree that works is"]);
    // Repeated points share their weight, but count once.
    place.write("twice.csv", "0,0,1\n0,0,-1\n1,0,0\n-1,0,0\n0,1,0\n0,-1,0\n0,0,1\n");
    let outcome = place.run("weights twice.csv --degree 1 --json");
    assert!(outcome.stderr.contains("1 of 7 points are repeated"), "{}", outcome.stderr);
    let weights = outcome.json()["weights"].clone();
    assert_eq!(weights[0], weights[6]);
    // The octahedron is a rule of degree 3, with fewer points than harmonics.
    place.run("weights twice.csv --degree 3").ok();
    place.run("weights twice.csv --degree 4").fails(2, &["got 6"]);
}

#[test]
fn inputs_and_outputs_are_checked() {
    let place = Workplace::new();
    place.run("sample white-noise -n 40 -m 2 -o sets.npy").ok();
    place.run("weights sets.npy --degree 2").fails(1, &["one set of points, got 2 sets"]);
    place.run("weights none.csv").fails(1, &["none.csv"]);
    place.run("weights").fails(2, &["FILE"]);
    place.run("sample white-noise -n 40 -o p.csv").ok();
    place.run("weights p.csv --degree 2 -o rule.npy").fails(2, &[".npz"]);
    place.run("weights p.csv --degree -1").fails(2, &["-1"]);
    place.run("weights p.csv --degree 1e9").fails(2, &["--degree"]);
    place.write("weighted.csv", "x,y,z,w\n1,0,0,5\n-1,0,0,1\n");
    let outcome = place.run("weights weighted.csv --degree 0").ok();
    assert!(outcome.stderr.contains("weights in the file are ignored"), "{}", outcome.stderr);
}

/// Gauss-Legendre rules integrate harmonics to degree 2L - 1: the variance is that of rounding.
#[test]
fn harmonics_to_the_exact_degree_of_a_rule_have_no_variance() {
    let place = Workplace::new();
    for (rule, n, exact) in [
        ("gauss-legendre", 32, 7),
        ("gauss-legendre", 512, 31),
        ("gauss-legendre", 8192, 127),
        ("driscoll-healy", 57, 7),
        ("mcewen-wiaux", 466, 15),
        ("lebedev", 74, 13),
        ("lebedev", 5810, 131),
    ] {
        let predicted = |l: usize| {
            let ylm = format!("variance {rule} -n {n} --integrand ylm:l={l},m={} -m 4", l / 2);
            number(
                &place.run(&format!("{ylm} --method exact --json")).json()["rows"][0],
                "predicted",
            )
        };
        for l in [1, exact / 2, exact] {
            assert!(predicted(l) < 1e-25, "{rule} {n}, l = {l}: {:e}", predicted(l));
        }
        assert!(predicted(exact + 1) > 1e-9, "{rule} {n}: {:e}", predicted(exact + 1));
    }
    // Weights are written with the points.
    place.run("sample gauss-legendre -n 32 -o rule.csv").ok();
    assert!(place.text("rule.csv").starts_with("x,y,z,w\n"));
    assert!(largest_power(&place, "rule.csv", 7) < 1e-25);
    place.run("sample lebedev -n 100 -o rule.csv").fails(2, &["nearest valid count is 110"]);
    let sample = place.run("sample lebedev -n 110 -o rule.csv").ok();
    assert!(sample.stderr.contains("no power at degrees 1 to 17"), "{}", sample.stderr);
}
