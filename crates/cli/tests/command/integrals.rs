//! `integrate`: values with their errors, nodes, and tolerances that are not met.

use std::f64::consts::PI;

use crate::outcome::{assert_keys, numbers};
use crate::workplace::Workplace;

#[test]
fn an_integral_has_its_error_and_its_nodes() {
    let place = Workplace::new();
    let arguments = "integrate --integrand cosine --hemisphere --rtol 1e-3 --nodes nodes.csv";
    let document = place.run(&format!("{arguments} --json")).json();
    assert_keys(&document, &["integrand", "value", "error", "exact", "n", "copies", "evaluations"]);
    assert_keys(&document, &["sampler", "converged", "stop", "rtol", "atol", "seconds"]);
    let number = |key: &str| document[key].as_f64().unwrap();
    let (value, error) = (number("value"), number("error"));
    assert!((value - PI).abs() <= error && error <= 1e-3 * value, "{document}");
    assert!((number("exact") - PI).abs() < 1e-14, "{document}");
    assert_eq!(document["converged"], true);

    // The weighted sum of the values at the nodes is the value.
    let nodes = place.text("nodes.csv");
    let rows = nodes.lines().filter(|line| line.starts_with(|c: char| c == '-' || c.is_numeric()));
    let rows: Vec<Vec<f64>> =
        rows.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    let count = |key: &str| document[key].as_u64().unwrap();
    assert_eq!(rows.len() as u64, count("copies") * count("n"));
    let sum: f64 = rows.iter().map(|row| row[2] * row[3]).sum();
    assert!((sum - value).abs() < 1e-13, "{sum}, {value}");

    let text = place.run("integrate --integrand vmf:kappa=20 --rtol 0.1%").ok().stdout;
    for part in ["integral", "+-", "exact", "16 copies of", "fibonacci", "evaluations"] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

/// The result of a tolerance that is not met is printed, and the status is 1.
#[test]
fn a_tolerance_that_is_not_met_fails_with_a_result() {
    let place = Workplace::new();
    let limited = "integrate --integrand cap:degrees=60 --rtol 1e-6 --max-points 10k --json";
    for (arguments, stop, advice) in [
        (limited, "max-points", "--max-points 10000"),
        ("integrate --integrand ylm:l=3 --sampler lebedev --json", "rounding", "give --atol"),
        (
            "integrate --integrand cap:degrees=60 --rtol 1e-6 --sampler lebedev --json",
            "largest-set",
            "no set of more than 5810 points",
        ),
    ] {
        let output = place.command(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{arguments}");
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(message.contains(advice), "{message}");
        let document: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(
            (document["stop"].as_str(), &document["converged"]),
            (Some(stop), &false.into())
        );
        assert!(document["evaluations"].as_f64().unwrap() <= 1e7, "{document}");
    }
}

#[test]
fn seeds_and_samplers_are_options_and_results_do_not_depend_on_threads() {
    let place = Workplace::new();
    let value = |options: &str| {
        let arguments = "integrate --integrand cap:degrees=40 --rtol 1% --json";
        let document = place.run(&format!("{arguments} {options}")).json();
        numbers(&serde_json::json!([document["value"], document["error"], document["n"]]))
    };
    assert_eq!(value("-j 1"), value("-j 4"));
    assert_ne!(value(""), value("--seed 1"));
    assert_ne!(value(""), value("--sampler healpix"));
}

#[test]
fn options_out_of_range_are_usage_errors() {
    let place = Workplace::new();
    for (options, part) in [
        ("", "--integrand"),
        ("--integrand cosine --atol -1", "absolute tolerance"),
        ("--integrand cosine --atol 0", "must be positive"),
        ("--integrand cosine --max-points 15", "smallest set"),
        ("--integrand cosine --rtol 0", "share above 0"),
        ("--integrand cosine --nodes nodes.txt", "written as .csv, .npz or .ply"),
        ("--integrand cosine --sampler fibonacci,healpix", "expected one sampler"),
    ] {
        place.run(&format!("integrate {options}")).fails(2, &[part]);
    }
}
